/* Whole runs: time against the number of mats, leaving out mats at rest, and landings. Times are of
 * the whole sim_run, its check included. */
#include "tests/bench/bench.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#define REPETITIONS 3
#define LANDINGS    9
#define STANDARD    "rstar_fig3_7.json"
#define FINE        64.0  /* a landing's fine solution: this part of the stability limit */
#define NEIGHBOURS  8     /* other steps, close by, whose error is shown too */
#define NEIGHBOUR   0.993 /* each is this part of the one before */
#define INCHES      12.0

static double timed_ms(const struct sim_scene *scene, const struct sim_options *options,
                       const char *what)
{
    struct sim_result result;
    double begin_ms = bench_clock_ms();
    bool ok = bench_run(scene, options, &result, what);
    double ms = bench_clock_ms() - begin_ms;
    sim_result_free(&result);
    return ok ? ms : (double)NAN;
}

/* Slope of log time over log N, least squares. */
static double slope(const double *n, const double *ms, int count)
{
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (int i = 0; i < count; i++) {
        x += log(n[i]) / count;
        y += log(ms[i]) / count;
    }
    for (int i = 0; i < count; i++) {
        xx += (log(n[i]) - x) * (log(n[i]) - x);
        xy += (log(n[i]) - x) * (log(ms[i]) - y);
    }
    return xy / xx;
}

/* One mat crossed: how the time grows does not depend on how long the run is. */
void bench_growth(void)
{
    enum { SIZES = 5, WAYS = 3 };
    const double mats[SIZES] = {30, 100, 300, 1000, 4096};
    const char *names[WAYS] = {"auto", "auto, every mat integrated",
                               "implicit, every mat integrated"};
    const struct sim_options ways[WAYS] = {
        {0}, {.no_prune = true}, {.solver = "implicit", .no_prune = true}};
    double ms[WAYS][SIZES][REPETITIONS], median[WAYS][SIZES];
    struct sim_scene scene;
    printf("time against N, %s over one mat:\n", STANDARD);
    if (!bench_load(&scene, STANDARD, false))
        return;
    scene.mats_crossed = 1.0;
    scene.t_out_s.count = 0;
    for (int r = 0; r < REPETITIONS; r++) {
        for (int i = 0; i < SIZES; i++) {
            scene.mats = (int)mats[i];
            for (int w = 0; w < WAYS; w++)
                ms[w][i][r] = timed_ms(&scene, &ways[w], names[w]);
        }
    }
    for (int w = 0; w < WAYS; w++) {
        printf("  %-34s", names[w]);
        for (int i = 0; i < SIZES; i++) {
            median[w][i] = bench_median(ms[w][i], REPETITIONS);
            printf("  N %.0f: %.4g ms", mats[i], median[w][i]);
        }
        printf("\n");
    }
    for (int w = 0; w < WAYS; w++) {
        char what[80];
        snprintf(what, sizeof what, "exponent, %s", names[w]);
        bench_line(what, slope(mats, median[w], SIZES), "", true, 1.1);
    }
    sim_scene_free(&scene);
}

static double largest_difference_ft(const struct sim_result *a, const struct sim_result *b)
{
    double most = fabs(a->max_lift_ft - b->max_lift_ft);
    for (size_t i = 0; i < a->output_count; i++) {
        most = fmax(most, fabs(a->outputs[i].lift_ft - b->outputs[i].lift_ft));
        for (int n = 1; n <= a->mats; n++)
            most = fmax(most, fabs(a->outputs[i].u_ft[n] - b->outputs[i].u_ft[n]));
    }
    return most;
}

void bench_pruning(void)
{
    double ms[2][REPETITIONS];
    struct sim_scene scene;
    struct sim_result result[2] = {{0}, {0}};
    printf("leaving out mats at rest, %s with 1000 mats:\n", STANDARD);
    if (!bench_load(&scene, STANDARD, true))
        return;
    scene.mats = 1000;
    bool ok = true;
    for (int r = 0; r < REPETITIONS && ok; r++) {
        for (int every = 0; every <= 1 && ok; every++) {
            struct sim_options options = {.no_prune = every == 1};
            sim_result_free(&result[every]);
            double begin_ms = bench_clock_ms();
            ok = bench_run(&scene, &options, &result[every], "1000 mats");
            ms[every][r] = bench_clock_ms() - begin_ms;
        }
    }
    if (ok) {
        bench_line("time with every mat over time without",
                   bench_median(ms[1], REPETITIONS) / bench_median(ms[0], REPETITIONS), "x", false,
                   5.0);
        bench_line("largest difference of u and lift",
                   largest_difference_ft(&result[0], &result[1]), "ft", true, 1e-9);
    }
    sim_result_free(&result[0]);
    sim_result_free(&result[1]);
    sim_scene_free(&scene);
}

/* Over all mats and the 64 even times, moved or not. */
static double rms_in(const struct sim_result *a, const struct sim_result *b)
{
    double sum = 0.0;
    for (size_t i = 0; i < a->output_count; i++) {
        for (int n = 1; n <= a->mats; n++) {
            double difference_in = INCHES * (a->outputs[i].u_ft[n] - b->outputs[i].u_ft[n]);
            sum += difference_in * difference_in;
        }
    }
    return sqrt(sum / ((double)a->output_count * a->mats));
}

/* The chain's error is partly chance (joints that just close or just do not), so steps close by are
 * shown too. */
static void print_neighbours(const struct sim_scene *scene, double dt_s,
                             const struct sim_result *fine)
{
    double rms[NEIGHBOURS], worst = 0.0;
    int count = 0;
    for (int i = 0; i < NEIGHBOURS; i++) {
        struct sim_options options = {.rtol = 1.0};
        struct sim_result result;
        dt_s *= NEIGHBOUR;
        options.dt_s = dt_s;
        if (bench_run(scene, &options, &result, "step close by")) {
            rms[count] = rms_in(&result, fine);
            worst = fmax(worst, rms[count++]);
        }
        sim_result_free(&result);
    }
    if (count > 0)
        printf("  at %d steps up to %.0f %% shorter: median %.2g in, worst %.2g in\n", count,
               100.0 * (1.0 - pow(NEIGHBOUR, NEIGHBOURS)), bench_median(rms, (size_t)count), worst);
}

static void chain_landing(void)
{
    double ms[LANDINGS];
    struct sim_scene scene;
    struct sim_result result = {0}, fine = {0};
    printf("a landing, chain of 420 mats, model_runway.json:\n");
    if (!bench_load(&scene, "model_runway.json", false))
        return;
    bool ok = bench_run(&scene, &(struct sim_options){0}, &result, "landing");
    if (ok) {
        struct sim_options options = {.dt_s = result.dt_limit_s / FINE, .rtol = 1.0};
        ok = bench_run(&scene, &options, &fine, "fine solution");
    }
    for (int r = 0; r < LANDINGS && ok; r++)
        ms[r] = timed_ms(&scene, &(struct sim_options){0}, "landing");
    if (ok) {
        double median_ms = bench_median(ms, LANDINGS);
        printf("  %.2f s of landing: %.0f x real time, check included\n", result.t_end_s,
               1e3 * result.t_end_s / median_ms);
        bench_line("time with its check", median_ms, "ms", true, 25.0);
        bench_line("rms error against its fine solution", rms_in(&result, &fine), "in", true,
                   0.002);
        print_neighbours(&scene, result.dt_s, &fine);
    }
    sim_result_free(&result);
    sim_result_free(&fine);
    sim_scene_free(&scene);
}

static void planar_landing(void)
{
    const char *file = "model_runway_planar.json";
    double ms[REPETITIONS];
    struct sim_scene scene;
    if (access("host/scenes/model_runway_planar.json", R_OK) != 0 ||
        !bench_load(&scene, file, false))
        return;
    printf("a landing, planar, %s:\n", file);
    for (int r = 0; r < REPETITIONS; r++)
        ms[r] = timed_ms(&scene, &(struct sim_options){0}, r == 0 ? "landing" : NULL);
    bench_line("time with its check", bench_median(ms, REPETITIONS) / 1e3, "s", true, 0.4);
    sim_scene_free(&scene);
}

void bench_landings(void)
{
    chain_landing();
    planar_landing();
}
