/* Two groups of bands on one strip, against closed forms. Units ft, lb, s. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <string.h>

#include "host/sim/elements/mods.h"
#include "host/sim/sim.h"

#define G  32.174
#define PI 3.14159265358979323846

static struct error error;

/* Ten free mats far apart (joints never meet) of 1 slug, without friction; a band of A E = 1000 lb
 * riveted to mat 5, at 500 lb. */
static struct sim_scene one_group(void)
{
    struct sim_scene scene;
    const double gap = 5.0, t0 = 500.0;
    sim_scene_defaults(&scene);
    error = (struct error){0};
    scene.model = SIM_CHAIN;
    scene.mats = 10;
    scene.length_ft = 1.0;
    scene.weight_lb = G;
    scene.left = scene.right = SIM_FREE;
    scene.kl_lb_ft = 1e3;
    scene.slack_ft = 10.0;
    scene.force_lb = scene.vac_ft_s = scene.v0_ft_s = 0.0;
    scene.friction_law = SIM_NONE;
    sim_scene_set_list(&scene.gap0_ft, &gap, 1);
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        scene.mods.band[g].count = g == 0 ? 1.0 : 0.0;
        scene.mods.band[g].area_ft2 = 1.0;
        scene.mods.band[g].e_lb_ft2 = 1000.0;
        scene.mods.band[g].every = 10;
        scene.mods.band[g].first = scene.mods.band[g].last = 5;
        sim_scene_set_list(&scene.mods.band[g].t0_lb, &t0, 1);
    }
    return scene;
}

static struct sim_result run(const struct sim_scene *scene, struct sim_options options)
{
    struct sim_result result;
    error = (struct error){0};
    if (sim_run(scene, &options, &result, &error) != MR_OK)
        fail_msg("%s", error.text);
    return result;
}

/* Two of the first group and three of the second, twice as stiff and at another tension, swing mat
 * 5 together: 2 k + 3 (2 k) = 8 k. At a quarter of the period each has changed by its own stiffness
 * times the same amplitude. */
TEST(both_hold_the_same_mat)
{
    struct sim_scene scene = one_group();
    const double other_t0 = 900.0, left = 1000.0 / 4.5, right = 1000.0 / 5.5;
    scene.mods.band[0].count = 2.0;
    scene.mods.band[1].count = 3.0;
    scene.mods.band[1].e_lb_ft2 = 2000.0;
    sim_scene_set_list(&scene.mods.band[1].t0_lb, &other_t0, 1);
    scene.v0_ft_s = 1.0;
    scene.v0_mat = 5;
    double rate = sqrt(8.0 * (left + right));
    scene.t_end_s = 0.5 * PI / rate;
    struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    assert_int_equal(result.mods->segments, 4);
    assert_int_equal(result.mods->connections, 2);
    assert_near(result.u_ft[5], 1.0 / rate, 1e-7);
    assert_near(result.mods->band_lb[0], 500.0 + left / rate, 1e-3);
    assert_near(result.mods->band_lb[1], 500.0 - right / rate, 1e-3);
    assert_near(result.mods->band_lb[2], 900.0 + 2.0 * left / rate, 1e-3);
    assert_near(result.mods->band_lb[3], 900.0 - 2.0 * right / rate, 1e-3);
    assert_near(result.mods->band_load_lb[1], 2.0 * result.mods->band_load_lb[0], 1e-3);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Riveted to other mats, each swings its own: the second mat 3, between 2.5 and 7.5 ft, with half
 * the first's stiffness. */
TEST(each_holds_its_own_mat)
{
    struct sim_scene scene = one_group();
    const double k = 1000.0 / 4.5 + 1000.0 / 5.5, other = 500.0 / 2.5 + 500.0 / 7.5;
    scene.mods.band[1].count = 1.0;
    scene.mods.band[1].first = scene.mods.band[1].last = 3;
    scene.mods.band[1].e_lb_ft2 = 500.0;
    scene.v0_ft_s = 1.0;
    for (int mat = 3; mat <= 5; mat += 2) {
        double rate = sqrt(mat == 3 ? other : k);
        scene.v0_mat = mat;
        scene.t_end_s = 0.5 * PI / rate;
        struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
        assert_near(result.u_ft[mat], 1.0 / rate, 1e-7);
        assert_near(result.u_ft[8 - mat], 0.0, 1e-15); /* the other one stays */
        assert_near(result.mods->band_mat[0], 5.0, 0.0);
        assert_near(result.mods->band_mat[1], 3.0, 0.0);
        sim_result_free(&result);
    }
    sim_scene_free(&scene);
}

/* The first 0.6 s of a landing in the planar model, the mats on uneven ground: bands in two groups
 * are those bands in one. */
static struct sim_scene landing(void)
{
    struct sim_scene scene;
    error = (struct error){0};
    if (sim_scene_load(&scene, "host/scenes/model_runway_planar.json", &error) != MR_OK)
        fail_msg("%s", error.text);
    scene.t_end_s = 0.6;
    scene.t_dwell_s = -1.0;
    return scene;
}

TEST(halves_are_the_whole)
{
    for (int over = 0; over < 2; over++) {
        struct sim_scene scene = landing();
        const double t0 = 100.0;
        struct sim_result result[2];
        for (int g = 0; g < 2; g++) {
            scene.mods.band[g].every = 10;
            scene.mods.band[g].k_lb_ft = 2000.0;
            scene.mods.band[g].grip_lb = 60.0;
            scene.mods.band[g].over = over ? SIM_OVER_RIVETS : SIM_OVER_JOINTS;
            sim_scene_set_list(&scene.mods.band[g].t0_lb, &t0, 1);
        }
        for (int i = 0; i < 2; i++) {
            /* a power of two: halving rounds nothing */
            scene.mods.band[0].count = i == 0 ? 0.5 : 0.25;
            scene.mods.band[1].count = i == 0 ? 0.0 : 0.25;
            result[i] = run(&scene, (struct sim_options){.single = true, .dt_s = 5e-5});
        }
        size_t segments = result[0].mods->segments;
        double apart = 0.0;
        for (int n = 1; n <= scene.mats; n++)
            apart = fmax(apart, fabs(result[0].u_ft[n] - result[1].u_ft[n]));
        assert_true(result[0].peak_u_ft > 0.002);
        assert_near(apart, 0.0, 1e-6 * result[0].peak_u_ft);
        for (size_t i = 0; i < segments; i++) {
            assert_near(result[1].mods->band_lb[i], result[0].mods->band_lb[i], 1e-3);
            assert_near(result[1].mods->band_lb[segments + i], result[0].mods->band_lb[i], 1e-3);
        }
        sim_result_free(&result[0]);
        sim_result_free(&result[1]);
        sim_scene_free(&scene);
    }
}

/* The second group's keys begin with band2_, and errors name them. */
TEST(keys)
{
    static const struct {
        const char *scene, *says;
    } wrong[] = {
        {"{\"model\":\"chain\",\"N\":30,\"bands2\":1,\"band2_first\":31}", "band2_first"},
        {"{\"model\":\"chain\",\"N\":30,\"bands2\":1,\"band2_every\":10,\"band2_T0\":[1,2]}",
         "band2_T0 has 2 values; give one number or 4"},
        {"{\"model\":\"chain\",\"N\":30,\"bands2\":1,\"band2_every\":10,\"band2_pulled\":[5]}",
         "band2_pulled[0] is 5"},
        {"{\"model\":\"chain\",\"N\":30,\"bands3\":1}", "bands3"},
    };
    static const char right[] = "{\"model\":\"chain\",\"N\":30,\"bands\":2,\"band_T0\":125,"
                                "\"bands2\":1,\"band2_every\":15,\"band2_T0\":60}";
    struct sim_scene scene;
    error = (struct error){0};
    assert_int_equal(sim_scene_parse(&scene, "x", right, strlen(right), &error), MR_OK);
    assert_int_equal(mods_connections(&scene, 0), 1);
    assert_int_equal(mods_connections(&scene, 1), 2);
    assert_near(scene.mods.band[1].t0_lb.values[0], 60.0, 0.0);
    sim_scene_free(&scene);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        error = (struct error){0};
        assert_int_equal(
            sim_scene_parse(&scene, "x", wrong[i].scene, strlen(wrong[i].scene), &error),
            MR_MALFORMED);
        if (!strstr(error.text, wrong[i].says))
            fail_msg("'%s' does not say '%s'", error.text, wrong[i].says);
    }
}
