/* What an answer is worth where switches decide it: runs that part, mats in the air, lifts that are
 * largest when a run ends, sampled stops. Units ft, lb, s. */

#include "tests/host/sim_case.h"
#include "tests/host/beads.h"

#define OUTPUTS 16

static void ask(struct sim_scene *scene)
{
    double times_s[OUTPUTS];
    for (int i = 0; i < OUTPUTS; i++)
        times_s[i] = scene->t_end_s * (i + 1) / OUTPUTS;
    memset(&error, 0, sizeof error);
    sim_scene_set_list(&scene->t_out_s, times_s, OUTPUTS);
}

static struct sim_result answer(const struct sim_scene *scene, const char *solver, double rtol)
{
    struct sim_result result;
    attempt(scene, solver, rtol, 0.0, &result);
    return result;
}

static double apart_u_ft(const struct sim_scene *scene, const struct sim_result *a,
                         const struct sim_result *b, double until_s)
{
    double most_ft = 0.0;
    for (size_t i = 0; i < OUTPUTS && scene->t_out_s.values[i] <= until_s; i++) {
        for (int n = 1; n <= scene->mats; n++)
            most_ft = fmax(most_ft, fabs(a->outputs[i].u_ft[n] - b->outputs[i].u_ft[n]));
    }
    return most_ft;
}

TEST(runs_that_part_say_when_and_how_far)
{
    struct sim_scene scene = beads();
    ask(&scene);
    struct sim_result result = answer(&scene, NULL, 0.0);
    assert_int_equal(error.status, MR_NUMERICS);
    assert_int_equal(result.status, SIM_UNPREDICTABLE);
    assert_non_null(strstr(error.text, "unpredictable"));
    assert_true(result.t_s > 0.0 && result.t_s < scene.t_end_s);
    assert_true(result.diverging_run_count >= 5 && result.diverging_wave_count == 0);
    assert_true(result.error_u_ft > 0.2 * result.peak_u_ft && isfinite(result.error_u_ft));
    assert_int_equal(result.output_count, OUTPUTS);
    /* another run parts from it too, not before that time, and not further than the spread */
    struct sim_result other = answer(&scene, "event", 1e-9);
    if (other.status == SIM_OK) {
        assert_true(apart_u_ft(&scene, &result, &other, 0.99 * result.t_s) <
                    0.2 * result.peak_u_ft);
        assert_true(apart_u_ft(&scene, &result, &other, scene.t_end_s) < 3.0 * result.error_u_ft);
    }
    sim_result_free(&other);
    /* before that time it is answered as ever */
    scene.t_end_s = 0.5 * result.t_s;
    sim_result_free(&result);
    ask(&scene);
    result = answer(&scene, NULL, 0.0);
    assert_int_equal(result.status, SIM_OK);
    assert_true(result.error_u_ft < 0.2 * result.peak_u_ft);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* A mat whose feet are off the ground is held by nothing when the soil's reaction is the normal
 * force: it passes through rest without a stop. It made event and implicit switch without end. */
TEST(mats_in_the_air_pass_through_rest)
{
    static const double bump_ft[] = {0.0099, 0.02, 0.0099};
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    memset(&error, 0, sizeof error);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = 7;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.right_torsion = SIM_END_FIXED;
    scene.thrust = SIM_THRUST_LINEAR;
    scene.kv_lb_ft = 2.26415e6;
    scene.cv_lb_s_ft = 110421.0;
    scene.kl_lb_ft = 3.86604e9;
    scene.cl_lb_s_ft = 363.475;
    scene.kt_lb_ft_rad = 2.78764e6;
    scene.ct_lb_ft_s_rad = 0.0298112;
    scene.weight_lb = 4.62181;
    scene.inertia_slug_ft2 = 0.465073;
    scene.tad_deg = 0.0;
    scene.friction = 0.2;
    scene.friction_normal = SIM_NORMAL_SOIL;
    scene.force_lb = 346.636;
    scene.vac_ft_s = 140.0;
    scene.v0_ft_s = 2.0;
    scene.bump_first = 3;
    scene.t_end_s = 0.005;
    sim_scene_set_list(&scene.bump_ft, bump_ft, 3);
    ask(&scene);
    struct sim_result located = answer(&scene, NULL, 0.0);
    assert_string_equal(error.text, "");
    assert_string_equal(located.solver, "event");
    struct sim_result stepped = answer(&scene, "staggered", 0.0);
    assert_string_equal(error.text, "");
    assert_true(apart_u_ft(&scene, &located, &stepped, scene.t_end_s) <=
                located.error_u_ft + stepped.error_u_ft);
    assert_true(fabs(located.max_lift_ft - stepped.max_lift_ft) <=
                located.error_lift_ft + stepped.error_lift_ft);
    assert_true(located.max_lift_ft > 0.02 && stepped.error_lift_ft < 0.01);
    sim_result_free(&located);
    sim_result_free(&stepped);
    sim_scene_free(&scene);
}

/* The landing engine looks at its lifts every few steps; one that rises until the end is largest
 * there. */
TEST(a_lift_that_rises_to_the_end_is_the_largest)
{
    static const double bump_ft[] = {0.0099, 0.02, 0.0099};
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    memset(&error, 0, sizeof error);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = 8;
    scene.bump_first = 1;
    scene.t_end_s = 0.01;
    scene.left_end = SIM_END_FREE;
    scene.right_end = SIM_END_FIXED;
    sim_scene_set_list(&scene.bump_ft, bump_ft, 3);
    ask(&scene);
    struct sim_result fixed = answer(&scene, "staggered", 0.0),
                      truth = answer(&scene, "event", 1e-11);
    assert_true(truth.max_lift_ft == truth.outputs[OUTPUTS - 1].lift_ft);
    assert_true(fixed.max_lift_ft >= fixed.outputs[OUTPUTS - 1].lift_ft);
    assert_true(fabs(fixed.max_lift_ft - truth.max_lift_ft) <= fixed.error_lift_ft);
    assert_true(fixed.error_lift_ft <= 1e-4 * fixed.max_lift_ft); /* the least that is stated */
    sim_result_free(&fixed);
    sim_result_free(&truth);
    sim_scene_free(&scene);
}

/* The classical method with a fixed step sees a stop at the end of the step that it falls in. Runs
 * at a step and at half of it see every other stop at the same moment, and agree on a wrong answer:
 * here to 6e-9 ft, and wrong by 4e-6. */
TEST(a_sampled_stop_is_within_the_stated_error)
{
    static const double bump_ft[] = {0.0099};
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    memset(&error, 0, sizeof error);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = 9;
    scene.profile = SIM_PROFILE_FULL;
    scene.left_end = scene.right_end = SIM_END_FREE;
    scene.right_torsion = SIM_END_FIXED;
    scene.tad_mode = SIM_TAD_SWITCHED;
    scene.thrust = SIM_THRUST_LINEAR;
    scene.kv_lb_ft = 234000.0;
    scene.cv_lb_s_ft = 113257.0;
    scene.kl_lb_ft = 8.69355e6;
    scene.cl_lb_s_ft = 0.564661;
    scene.kt_lb_ft_rad = 1.84664e6;
    scene.ct_lb_ft_s_rad = 0.0103898;
    scene.weight_lb = 18616.0;
    scene.inertia_slug_ft2 = 1867.98;
    scene.slack_ft = 0.25 / 12.0;
    scene.force_lb = 139620.0;
    scene.start_ft = 5.0;
    scene.v0_ft_s = 2.0;
    scene.bump_first = 3;
    scene.t_end_s = 0.02;
    sim_scene_set_list(&scene.bump_ft, bump_ft, 1);
    ask(&scene);
    struct sim_result sampled = answer(&scene, "rk4", 0.0), truth = answer(&scene, "event", 1e-11);
    double off_ft = apart_u_ft(&scene, &sampled, &truth, scene.t_end_s);
    if (!(off_ft <= sampled.error_u_ft && off_ft > 1e-6))
        fail_msg("off by %g ft, stated %g", off_ft, sampled.error_u_ft);
    assert_true(sampled.error_u_ft < 1e-3 * truth.peak_u_ft);
    sim_result_free(&sampled);
    sim_result_free(&truth);
    sim_scene_free(&scene);
}

/* A foot hovers under the lift shear, and feet and joints switch by hundreds: fixed steps follow
 * each in a way of their own, three runs alike by chance. Scene 552 of seed 81947 of the stability
 * study (wrong by 18.9 stated errors) and scene 1056 of seed 333667 (15.8). */
TEST(sampled_switches_are_within_the_stated_error)
{
    static const double low_ft[] = {0.002475}, high_ft[] = {0.0495, 0.1, 0.0495};
    for (int k = 0; k < 2; k++) {
        struct sim_scene scene;
        sim_scene_set_defaults(&scene);
        memset(&error, 0, sizeof error);
        scene.model = SIM_MODEL_REPORT;
        scene.mats = k ? 9 : 7;
        scene.profile = SIM_PROFILE_FULL;
        scene.left_end = k ? SIM_END_FIXED : SIM_END_FREE;
        scene.right_end = scene.left_torsion = SIM_END_FIXED;
        scene.right_torsion = SIM_END_FREE;
        scene.thrust = k ? SIM_THRUST_JUMP : SIM_THRUST_LINEAR;
        scene.friction_law = k ? SIM_FRICTION_STICK : SIM_FRICTION_TANH;
        scene.lift_shear = SIM_SHEAR_RISING;
        scene.tad_mode = SIM_TAD_SWITCHED;
        scene.kv_lb_ft = k ? 3.91426e8 : 2.56926e6;
        scene.cv_lb_s_ft = k ? 3961.38 : 33.2168;
        scene.kl_lb_ft = k ? 9.54242e7 : 1.24911e6;
        scene.cl_lb_s_ft = k ? 0.192263 : 0.0935142;
        scene.kt_lb_ft_rad = k ? 124.283 : 172.681;
        scene.ct_lb_ft_s_rad = k ? 0.00542694 : 0.0242577;
        scene.weight_lb = k ? 224.787 : 17.0033;
        scene.inertia_slug_ft2 = k ? 2.80984 : 0.341017;
        scene.tad_deg = k ? 1.0 : 0.0;
        scene.friction = 0.5;
        scene.veps_ft_s = k ? 0.001 : 0.01;
        scene.force_lb = k ? 33718.1 : 24000.0;
        scene.lift_shear_lb = k ? 168.59 : 12.7525;
        scene.vac_ft_s = k ? 90.0 : 140.0;
        scene.start_ft = k ? 0.0 : 5.0;
        scene.v0_ft_s = 2.0;
        scene.wheel_load_lb = k ? 0.0 : 170.033;
        scene.slack_ft = 0.005;
        scene.bump_first = 3;
        scene.t_end_s = k ? 0.005 : 0.01;
        sim_scene_set_list(&scene.bump_ft, k ? high_ft : low_ft, k ? 3 : 1);
        ask(&scene);
        struct sim_result sampled = answer(&scene, "rk4", 0.0),
                          truth = answer(&scene, "event", 1e-11);
        double off_ft = fabs(sampled.max_lift_ft - truth.max_lift_ft);
        for (size_t i = 0; i < OUTPUTS; i++)
            off_ft = fmax(off_ft, fabs(sampled.outputs[i].lift_ft - truth.outputs[i].lift_ft));
        if (!(off_ft <= sampled.error_lift_ft && off_ft > 1e-4))
            fail_msg("off by %g ft, stated %g", off_ft, sampled.error_lift_ft);
        assert_true(sampled.error_lift_ft < 2.0 * off_ft);
        sim_result_free(&sampled);
        sim_result_free(&truth);
        sim_scene_free(&scene);
    }
}
