/* matrig scale --lay: joints turned by an angle, against statics of the strip that they make up.
 * With c the cosine:
 *
 * - a vee of two mats of height h rises when its compression exceeds W L/(2 h); rows L/c apart
 * weigh W/c: 1/c2 of that;
 * - a fold of the whole strip, of one angle from joint to joint, is cylindrical: the joints turn by
 * slope/c across them. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "host/commands/commands.h"
#include "host/sim/sim.h"

#define MATS 12
#define SCENE                                                                                \
    "{\"model\":\"consistent\",\"N\":12,\"L\":0.2857142857142857,\"W\":0.466,\"I\":1.19e-4," \
    "\"KV\":13000,\"CV\":60,\"KT\":0,"                                                       \
    "\"CT\":0,\"KL\":2.9e6,\"CL\":20,\"profile\":\"full\",\"friction\":\"none\",\"v0\":0,"   \
    "\"slack\":0.0025,"                                                                      \
    "\"path\":[[0,0.1,0],[0.5,0.1,1],[0.55,0.1,1]]}"

static struct error error;

static struct sim_scene laid(const char *deg)
{
    char folder[] = "/tmp/matrig-lay.XXXXXX", from[60], to[60];
    const struct cli cli = {.quiet = true};
    struct sim_scene scene;
    assert_non_null(mkdtemp(folder));
    snprintf(from, sizeof from, "%s/standard.json", folder);
    snprintf(to, sizeof to, "%s/laid.json", folder);
    FILE *file = fopen(from, "w");
    assert_non_null(file);
    assert_true(fputs(SCENE, file) >= 0);
    assert_int_equal(fclose(file), 0);
    const char *words[] = {"scale", from, "--lay", deg, "-o", to};
    assert_int_equal(command_scale.run(6, (char **)words, &cli), 0);
    error = (struct error){0};
    if (sim_scene_load(&scene, to, &error) != MR_OK)
        fail_msg("%s", error.text);
    unlink(from);
    unlink(to);
    rmdir(folder);
    return scene;
}

/* Largest rise of the middle joint on a high spot, under a slowly growing thrust. */
static double rise_in(const char *deg, double spot_ft, double thrust_lb)
{
    struct sim_scene scene = laid(deg);
    struct sim_result result;
    double ground[MATS + 2] = {0.0}, closed = 0.0;
    const struct sim_path_row rows[] = {
        {0.0, 0.1, 0.0}, {0.5, 0.1, thrust_lb}, {0.55, 0.1, thrust_lb}};
    const struct sim_options options = {.single = true};
    size_t nodes = (size_t)scene.mats + 1, middle = nodes / 2;
    ground[middle] = spot_ft;
    sim_scene_set_list(&scene.gap0_ft, &closed, 1);
    sim_scene_set_list(&scene.ground_ft, ground, nodes);
    sim_scene_set_path(&scene, rows, 3);
    /* one that rises ends by folding */
    if (sim_run(&scene, &options, &result, &error) != MR_OK && !result.rise_ft)
        fail_msg("%s", error.text);
    double rise = result.rise_ft[middle + 1] * 12.0;
    sim_result_free(&result);
    sim_scene_free(&scene);
    return rise;
}

TEST(test_a_fold_lifts_at_1_over_c2_of_the_load)
{
    static const struct {
        const char *deg;
        double times;
    } cases[] = {{"45", 2.0}, {"60", 4.0}};
    double spot_in = 0.08, standard_lb = 0.466 * (2.0 / 7.0) / (2.0 * spot_in / 12.0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_true(rise_in(cases[i].deg, spot_in / 12.0, 0.93 * cases[i].times * standard_lb) <
                    0.002);
        assert_true(rise_in(cases[i].deg, spot_in / 12.0, 1.07 * cases[i].times * standard_lb) >
                    0.5);
    }
}

/* What the strip is per foot along the runway does not change in weight, soil, axial stiffness (KL
 * L) and play; bent into a cylinder whose axis is at the angle, its energy per foot for a curvature
 * q along the runway is KT L q2/2 / c4, and a joint at its dead angle has the curvature TAD/L of
 * its own direction: q = c2 TAD/L. */
TEST(test_the_strip_per_foot)
{
    struct sim_scene scene = laid("60");
    double length_ft = 2.0 / 7.0, c = 0.5;
    assert_int_equal(scene.mats, 6);
    assert_near(scene.mats * scene.length_ft, 12.0 * length_ft, 1e-12);
    assert_near(scene.weight_lb / scene.length_ft, 0.466 / length_ft, 1e-12);
    assert_near(scene.kv_lb_ft / scene.length_ft, 13000.0 / length_ft, 1e-8);
    assert_near(scene.cv_lb_s_ft / scene.length_ft, 60.0 / length_ft, 1e-10);
    assert_near(scene.kl_lb_ft * scene.length_ft, 2.9e6 * length_ft, 1e-6);
    assert_near(scene.cl_lb_s_ft * scene.length_ft, 20.0 * length_ft, 1e-12);
    assert_near(scene.slack_ft / scene.length_ft, 0.0025 / length_ft, 1e-15);
    assert_near(scene.inertia_slug_ft2 * scene.length_ft, 1.19e-4 * length_ft / pow(c, 4), 1e-15);
    /* 10 degrees: the default */
    assert_near(scene.tad_deg / scene.length_ft, c * c * 10.0 / length_ft, 1e-12);
    assert_near(scene.mods.lay_deg, 60.0, 0.0);
    sim_scene_free(&scene);
}
