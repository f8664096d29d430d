/* Similitude of campaigns: `matrig scale` to the prototype and back.
 *
 * At n = 4 every ratio of the model law is a power of two (length 4, time 2, force 64, torsion 256,
 * inertia 1024), so scaling commutes with every rounding: the scaled campaign has to give the same
 * bits. Whatever in the engines is not scaled - a tolerance in feet, a step in seconds - shows. At
 * n = 7 round-off differs, and whether single dirty joints close hangs on it (host/sim/README.md,
 * "Chain and landings"), so there tight joints are played. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/landing_series/ensemble.h"
#include "host/commands/commands.h"
#include "tests/cmocka_all.h"

#define STANDARD "host/landing_series/series/standard.json"

static void scale(const char *from, const char *side, const char *n, const char *to)
{
    const char *words[] = {"scale", from, "--to", side, "--n", n, "-o", to};
    const struct cli cli = {.quiet = true};
    assert_int_equal(command_scale.run(8, (char **)words, &cli), 0);
}

struct pair {
    char folder[40], big[64], back[64];
    struct landing_series model, prototype, again;
};

static void make(struct pair *p, const char *from, const char *n)
{
    struct error error = {0};
    strcpy(p->folder, "/tmp/matrig-scale.XXXXXX");
    assert_non_null(mkdtemp(p->folder));
    snprintf(p->big, sizeof p->big, "%s/big.json", p->folder);
    snprintf(p->back, sizeof p->back, "%s/back.json", p->folder);
    scale(from, "prototype", n, p->big);
    scale(p->big, "model", n, p->back);
    assert_int_equal(series_load(&p->model, from, &error), MR_OK);
    assert_int_equal(series_load(&p->prototype, p->big, &error), MR_OK);
    assert_int_equal(series_load(&p->again, p->back, &error), MR_OK);
}

static void drop(struct pair *p)
{
    series_free(&p->model);
    series_free(&p->prototype);
    series_free(&p->again);
    unlink(p->big);
    unlink(p->back);
    rmdir(p->folder);
}

/* Both runways of a seed, and how far they are apart, the second divided by n: in all stations and
 * landings, in inches. */
static double apart_in(const struct landing_series *a, const struct landing_series *b, double n,
                       bool *same_fate)
{
    struct series_run x, y;
    double worst_in = 0.0;
    series_simulate(a, 1, &x);
    series_simulate(b, 1, &y);
    assert_int_equal(x.error.status, MR_OK);
    assert_int_equal(y.error.status, MR_OK);
    *same_fate = x.simulated_landing_count == y.simulated_landing_count &&
                 x.buckled_landing == y.buckled_landing &&
                 x.buckle_station_ft == y.buckle_station_ft / n;
    for (size_t i = 0; i < x.simulated_landing_count && i < y.simulated_landing_count; i++) {
        const struct series_outcome *p = &x.outcomes[i], *q = &y.outcomes[i];
        for (size_t k = 0; k < a->station_count; k++)
            worst_in = fmax(worst_in, fabs(p->total_movement_in[k] - q->total_movement_in[k] / n));
        *same_fate = *same_fate && p->zone_mats == q->zone_mats && p->wave_count == q->wave_count &&
                     p->torn_joint_count == q->torn_joint_count &&
                     p->moved_length_beyond_stop_ft == q->moved_length_beyond_stop_ft / n &&
                     p->compression_lb == q->compression_lb / (n * n * n);
    }
    assert_true(x.simulated_landing_count > 0 &&
                x.outcomes[x.simulated_landing_count - 1].peak_movement_in > 0.003);
    series_run_free(&x);
    series_run_free(&y);
    return worst_in;
}

TEST(standard_series_is_the_same_to_the_last_bit)
{
    struct pair p;
    bool same;
    make(&p, STANDARD, "4");
    assert_true(p.prototype.weight_lb == 64.0 * p.model.weight_lb);
    assert_true(p.model.landings[4].profile_count > 1 &&
                p.prototype.landings[4].profile[1].station_ft ==
                    4.0 * p.model.landings[4].profile[1].station_ft);
    assert_true(apart_in(&p.model, &p.prototype, 4.0, &same) == 0.0);
    assert_true(same);
    assert_true(apart_in(&p.model, &p.again, 1.0, &same) == 0.0);
    assert_true(same);
    drop(&p);
}

/* What elastic ground adds is scaled along: the first landings, on that ground, to the last bit. */
TEST(elastic_ground_is_the_same_to_the_last_bit)
{
    struct error error = {0};
    struct pair p;
    bool same;
    make(&p, STANDARD, "4");
    series_free(&p.model);
    series_free(&p.prototype);
    assert_int_equal(series_load_on_ground(&p.model, STANDARD, "elastic", &error), MR_OK);
    assert_int_equal(series_load_on_ground(&p.prototype, p.big, "elastic", &error), MR_OK);
    assert_true(p.prototype.landings[0].scene.gear.line_setbacks_ft.values[3] == 4.0 * 3.39);
    assert_true(p.prototype.landings[0].scene.wheel_load_lb == 64.0 * 108.3);
    for (struct landing_series *c = &p.model; c; c = c == &p.model ? &p.prototype : NULL) {
        for (size_t i = 2; i < c->landing_count; i++)
            sim_scene_free(&c->landings[i].scene);
        c->landing_count = 2;
    }
    assert_true(apart_in(&p.model, &p.prototype, 4.0, &same) == 0.0);
    assert_true(same);
    drop(&p);
}

/* Landings on 90 mats, with what a test adds; the caller unlinks `path`. */
static void write_landings(char *path, const char *slack, const char *runway, const char *apply,
                           const char *then)
{
    char text[1500];
    int length = snprintf(text, sizeof text,
                          "{\"scene\":{\"N\":90,\"L\":0.2857142857142857,\"W\":0.466,\"I\":1.19e-4,"
                          "\"KV\":1.3e4,\"CV\":60,\"KT\":41.6,"
                          "\"CT\":1.57e-4,\"KL\":2.9e5,\"CL\":5,\"slack\":%s,\"left\":\"fixed\","
                          "\"right\":\"free\",\"friction\":\"stick\",\"v0\":0},"
                          "\"runway\":{%s},\"engine\":{\"use\":\"chain\"},\"landings\":[{\"speed_"
                          "ft_s\":15,\"deceleration_ft_s2\":[6,11],"
                          "\"times\":3,\"apply\":{%s}},{\"speed_ft_s\":15,"
                          "\"deceleration_ft_s2\":9%s}],"
                          "\"stations_ft\":[5,10,15,20]}",
                          slack, runway, apply, then);
    int file = mkstemp(path);
    assert_true(file >= 0 && length < (int)sizeof text);
    assert_int_equal(write(file, text, (size_t)length), length);
    close(file);
}

/* Bands on three landings and off again. */
TEST(banded_landings_are_too)
{
    char path[] = "/tmp/matrig-banded.XXXXXX";
    write_landings(
        path, "0.0025", "",
        "\"bands\":0.33,\"band_every\":10,\"band_T0\":100,\"band_K\":2000,\"band_grip\":60,"
        "\"bands2\":0.125,\"band2_every\":20,\"band2_T0\":60,\"band2_wear\":0.5,\"band2_pull\":50",
        ",\"apply\":{\"bands\":0}");
    struct pair p;
    bool same;
    make(&p, path, "4");
    assert_true(apart_in(&p.model, &p.prototype, 4.0, &same) == 0.0);
    assert_true(same);
    drop(&p);
    unlink(path);
}

static bool near(double a, double b)
{
    return fabs(a - b) <= 1e-14 * fmax(fabs(a), fabs(b));
}

/* The file there and back at n = 7. */
TEST(seven_is_the_same_file_within_round_off)
{
    struct pair p;
    make(&p, STANDARD, "7");
    const struct sim_scene *a = &p.model.landings[0].scene, *b = &p.again.landings[0].scene,
                           *c = &p.prototype.landings[0].scene;
    assert_true(near(a->kl_lb_ft, b->kl_lb_ft) && near(a->inertia_slug_ft2, b->inertia_slug_ft2) &&
                near(a->cl_lb_s_ft, b->cl_lb_s_ft) && near(a->slack_ft, b->slack_ft) &&
                near(a->kt_lb_ft_rad, b->kt_lb_ft_rad));
    assert_true(near(c->kl_lb_ft, 49 * a->kl_lb_ft) && near(c->weight_lb, 343 * a->weight_lb) &&
                /* Table 2.2; AM2: 2 ft */
                near(c->inertia_slug_ft2, 16807 * a->inertia_slug_ft2) && near(c->length_ft, 2.0));
    assert_true(near(p.prototype.onset_s, sqrt(7.0) * 0.05) &&
                near(p.prototype.closing_lb.high, 343 * 20.0));
    drop(&p);
}

/* No play in the joints: nothing that is shut or open hangs on a last bit. */
TEST(seven_moves_alike_within_round_off)
{
    char path[] = "/tmp/matrig-tight.XXXXXX";
    write_landings(path, "0", "\"gap_in\":0,\"closing_lb\":0", "\"f\":0.2", "");
    struct pair p;
    bool same;
    make(&p, path, "7");
    double there_in = apart_in(&p.model, &p.prototype, 7.0, &same),
           back_in = apart_in(&p.model, &p.again, 1.0, &same);
    print_message("n 7: %.2g in there, %.2g in back\n", there_in, back_in);
    assert_true(there_in < 1e-9 && back_in < 1e-9);
    drop(&p);
    unlink(path);
}
