/* Landing engine: its stated errors hold the true ones. Truth is `event`, which locates every
 * switch and integrates by another method; every pair of ends, profile and law, then what stiff
 * soil does to friction and to neighbours. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/sim/sim.h"
#include "tests/cmocka_all.h"

#define MATS    8
#define OUTPUTS 16

static struct sim_scene small_scene(int bump_first, size_t bumps, double end_s)
{
    static const double bump_ft[] = {0.0099, 0.02, 0.0099};
    struct sim_scene scene;
    double times_s[OUTPUTS];
    sim_scene_defaults(&scene);
    scene.model = SIM_CONSISTENT;
    scene.mats = MATS;
    scene.bump_first = bump_first;
    scene.t_end_s = end_s;
    for (int i = 0; i < OUTPUTS; i++)
        times_s[i] = scene.t_end_s * (i + 1) / OUTPUTS;
    sim_scene_set_list(&scene.bump_ft, bump_ft, bumps);
    sim_scene_set_list(&scene.t_out_s, times_s, OUTPUTS);
    return scene;
}

static struct sim_result run(const struct sim_scene *scene, const char *solver, double rtol)
{
    struct sim_result result;
    struct error error = {0};
    sim_run(scene, &(struct sim_options){.solver = solver, .rtol = rtol}, &result, &error);
    assert_string_equal(error.text, "");
    return result;
}

/* Runs a scene with both and frees it. */
static bool held_against(const char *located, struct sim_scene *scene, const char *what)
{
    struct sim_result fixed = run(scene, "staggered", 0.0), truth = run(scene, located, 1e-11);
    double off_u_ft = 0.0, off_lift_ft = fabs(fixed.max_lift_ft - truth.max_lift_ft);
    for (size_t i = 0; i < OUTPUTS; i++) {
        off_lift_ft = fmax(off_lift_ft, fabs(fixed.outputs[i].lift_ft - truth.outputs[i].lift_ft));
        for (int n = 1; n <= scene->mats; n++)
            off_u_ft = fmax(off_u_ft, fabs(fixed.outputs[i].u_ft[n] - truth.outputs[i].u_ft[n]));
    }
    bool holds = off_u_ft <= fixed.error_u_ft + truth.error_u_ft + 1e-9 &&
                 off_lift_ft <= fixed.error_lift_ft + truth.error_lift_ft + 1e-9;
    if (!holds)
        print_error("%s: u is off by %g ft (stated %g), lift by %g ft (stated %g)\n", what,
                    off_u_ft, fixed.error_u_ft, off_lift_ft, fixed.error_lift_ft);
    assert_true(truth.peak_u_ft > 1e-6 && truth.max_lift_ft > 1e-3);
    assert_true(fixed.error_u_ft < 0.1 * truth.peak_u_ft);
    sim_result_free(&fixed);
    sim_result_free(&truth);
    sim_scene_free(scene);
    return holds;
}

static bool stated_error_holds(struct sim_scene *scene, const char *what)
{
    return held_against("event", scene, what);
}

TEST(every_end_profile_and_law)
{
    static const struct {
        const char *name;
        enum sim_friction law;
        enum sim_normal normal;
    } laws[] = {{"stick", SIM_STICK, SIM_WEIGHT},
                {"stick on soil", SIM_STICK, SIM_SOIL},
                {"none", SIM_NONE, SIM_WEIGHT}};
    int wrong = 0;
    for (int i = 0; i < 4 * 2 * 3; i++) {
        char what[80];
        struct sim_scene scene = small_scene(1, 3, 0.01); /* mat 1 is tilted */
        scene.left = i & 1 ? SIM_FIXED : SIM_FREE;
        scene.right = i & 2 ? SIM_FIXED : SIM_FREE;
        scene.profile = i & 4 ? SIM_FULL : SIM_LOW;
        scene.friction_law = laws[i / 8].law;
        scene.friction_normal = laws[i / 8].normal;
        scene.wheel_load_lb = i % 3 == 0 ? 500.0 : 0.0;
        snprintf(what, sizeof what, "left %s, right %s, profile %s, friction %s",
                 i & 1 ? "fixed" : "free", i & 2 ? "fixed" : "free", i & 4 ? "full" : "low",
                 laws[i / 8].name);
        wrong += !stated_error_holds(&scene, what);
    }
    assert_int_equal(wrong, 0);
}

/* Soil that stops a foot within a small part of a step: friction takes the impulse of that landing,
 * not more. */
TEST(friction_of_a_foot_that_lands_hard)
{
    struct sim_scene scene = small_scene(1, 1, 0.02);
    scene.left = scene.right = SIM_FREE;
    scene.left_torsion = SIM_FIXED;
    scene.friction_normal = SIM_SOIL;
    scene.friction = 0.2;
    scene.weight_lb = scene.wheel_load_lb = 1480.0;
    scene.inertia_slug_ft2 = 18.5;
    scene.kv_lb_ft = 1.15e7;
    scene.cv_lb_s_ft = 1.44e7;
    scene.kl_lb_ft = 3.02e5;
    scene.cl_lb_s_ft = 489.0;
    scene.kt_lb_ft_rad = 1e6;
    scene.slack_ft = 0.005;
    scene.tad_deg = 0.0;
    scene.force_lb = 11100.0;
    scene.vac_ft_s = 60.0;
    scene.thrust = SIM_LINEAR;
    scene.v0_ft_s = 0.0;
    assert_true(stated_error_holds(&scene, "soil friction"));
}

/* A foot that lands lifts its neighbour off at once: the soil does not hold it down for that
 * step. */
TEST(soil_does_not_hold_a_neighbour_down)
{
    struct sim_scene scene = small_scene(3, 1, 0.02);
    scene.left = scene.right = SIM_FREE;
    scene.left_torsion = SIM_FIXED;
    scene.friction_normal = SIM_SOIL;
    scene.friction = 0.2;
    scene.weight_lb = scene.wheel_load_lb = 14600.0;
    scene.inertia_slug_ft2 = 3.52;
    scene.kv_lb_ft = 1.87e8;
    scene.cv_lb_s_ft = 7.57e6;
    scene.kl_lb_ft = 3.6e6;
    scene.cl_lb_s_ft = 9230.0;
    scene.kt_lb_ft_rad = 7.49e6;
    scene.tad_deg = 0.0;
    scene.force_lb = 1200.0;
    scene.vac_ft_s = 60.0;
    scene.s0_ft = 5.0;
    scene.v0_ft_s = 0.0;
    assert_true(stated_error_holds(&scene, "one-sided soil"));
}

/* Two feet of light mats on stiff soil land 13 us after each other, within one step of 20 us. The
 * second one lands on a node that the first has lifted, and mat 1 hops by 0.46e-3 ft; together they
 * lift nobody, and runs at 1, 1.9 and 3.6 times the step said that, to 3e-5 ft. */
TEST(feet_that_land_within_one_step)
{
    static const double bump_ft[] = {0.002475, 0.005, 0.002475};
    static const struct sim_path_row rows[] = {{0.0, 0.0539771, 0.0},
                                               {0.00961035, -0.522644, 72518.4},
                                               {0.00961035, -0.522644, 72518.4},
                                               {0.02, -0.834333, 36259.2}};
    struct sim_scene scene = small_scene(3, 3, 0.02);
    sim_scene_set_list(&scene.bump_ft, bump_ft, 3);
    sim_scene_set_path(&scene, rows, 4);
    scene.mats = 7;
    scene.profile = SIM_FULL;
    scene.left = scene.right = SIM_FIXED;
    scene.thrust = SIM_JUMP;
    scene.weight_lb = 483.456;
    scene.inertia_slug_ft2 = 0.097998;
    scene.kv_lb_ft = 1.07855e6;
    scene.cv_lb_s_ft = 1.8331e7;
    scene.kl_lb_ft = 1.01181e6;
    scene.cl_lb_s_ft = 16.8097;
    scene.kt_lb_ft_rad = 8.50158e7;
    scene.ct_lb_ft_s_rad = 0.508058;
    scene.tad_deg = 1.0;
    scene.slack_ft = 0.25 / 12.0;
    scene.friction = 0.9;
    scene.v0_ft_s = 2.0;
    assert_true(held_against("implicit", &scene, "two feet within a step"));
}

/* A damped joint that closes within a step brakes from there on, not what lay open before: 0.4e-6
 * ft of u, alike at every step that is longer than that. */
TEST(a_damper_does_not_brake_the_slack)
{
    static const double bump_ft[] = {0.002475};
    static const struct sim_path_row rows[] = {{0.002, 5.05659, 0.0},
                                               {0.00716132, 5.77917, 37.2939},
                                               {0.00716132, 5.77917, 18.647},
                                               {0.02, 6.67788, 9.32348}};
    struct sim_scene scene = small_scene(3, 1, 0.02);
    sim_scene_set_list(&scene.bump_ft, bump_ft, 1);
    sim_scene_set_path(&scene, rows, 4);
    scene.mats = 13;
    scene.profile = SIM_FULL;
    scene.left = scene.right = scene.right_torsion = SIM_FIXED;
    scene.thrust = SIM_LINEAR;
    scene.weight_lb = 4.97252;
    scene.inertia_slug_ft2 = 0.0621566;
    scene.kv_lb_ft = 12939.9;
    scene.cv_lb_s_ft = 8.20025e6;
    scene.kl_lb_ft = 2.1068e7;
    scene.cl_lb_s_ft = 35774.6;
    scene.kt_lb_ft_rad = 3.25206e7;
    scene.ct_lb_ft_s_rad = 159.84;
    scene.slack_ft = 0.25 / 12.0;
    scene.wheel_load_lb = 0.497252;
    scene.friction = 0.2;
    scene.v0_ft_s = 2.0;
    assert_true(held_against("implicit", &scene, "a joint that closes"));
}
