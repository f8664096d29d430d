/* Solver moreau against closed forms (a block that slides, one that bounces, mats that catch each
 * other), against event at 1e-11, and where a foot hovers. Each answer has to be within what it
 * states. Units ft, lb, s. */

#include "tests/host/sim_case.h"

/* Mats of the consistent model with free ends on which nothing acts. */
static struct sim_scene mats(int count, const double *times, size_t number)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = count;
    scene.left_end = scene.right_end = SIM_END_FREE;
    scene.vac_ft_s = scene.v0_ft_s = scene.force_lb = 0.0;
    scene.start_ft = 1.0;
    scene.t_end_s = times[number - 1];
    sim_scene_set_list(&scene.t_out_s, times, number);
    return scene;
}

static void solve(const struct sim_scene *scene, const char *solver, double dt_s,
                  struct sim_result *result)
{
    struct sim_options options = {.solver = solver, .dt_s = dt_s};
    memset(&error, 0, sizeof error);
    if (sim_run(scene, &options, result, &error) != MR_OK)
        fail_msg("%s: %s", scene->name, error.text);
}

/* W = 160 and f = 0.5 brake with f g. Twice the friction of all mats for 0.1 s, then none. Joints
 * of 1e12 lb/ft are rigid: eight mats go as one, and the last stops with the first. */
TEST(a_block_and_a_rigid_chain_slide_to_rest)
{
    const double times[] = {0.1, 0.2, 0.3};
    const double brake = 0.5 * 32.174,
                 expected[] = {0.5 * brake * 0.01, brake * 0.01, brake * 0.01};
    for (int count = 1; count <= 8; count += 7) {
        struct sim_scene scene = mats(count, times, 3);
        struct sim_result result;
        scene.force_lb = 160.0 * count;
        scene.force_stop_s = 0.1;
        scene.kl_lb_ft = 1e12;
        scene.cl_lb_s_ft = 1e6;
        solve(&scene, "moreau", 1e-4, &result);
        assert_string_equal(result.solver, "moreau");
        for (size_t i = 0; i < 3; i++) {
            for (int n = 1; n <= count; n++)
                near(result.outputs[i].u_ft[n], expected[i], result.error_u_ft + 1e-6);
        }
        assert_true(result.error_u_ft < 1e-3 && result.speed_end_ft_s < 1e-9);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* Height of a mat of mass m that falls flat from `high` on soil k, c that does not pull, seen `t`
 * after it leaves the soil again: free fall, damped oscillation, free fall. `*left_s` is when it
 * leaves. */
static double bounced_ft(double m, double g, double k, double c, double high, double t,
                         double *left_s)
{
    double v = sqrt(2.0 * g * high), fall_s = v / g, decay = 0.5 * c / m,
           w = sqrt(k / m - decay * decay), rest = m * g / k, y = 0.0, rate = 0.0;
    double a = -rest, b = (v + decay * a) / w, low = 0.01 / w, up = 4.5 / w;
    for (int i = 0; i < 100; i++) { /* where the soil's force is 0 */
        double at = 0.5 * (low + up), fade = exp(-decay * at);
        y = rest + fade * (a * cos(w * at) + b * sin(w * at));
        rate = fade * ((w * b - decay * a) * cos(w * at) - (w * a + decay * b) * sin(w * at));
        if (k * y + c * rate > 0.0)
            low = at;
        else
            up = at;
    }
    *left_s = fall_s + low;
    return -(y + rate * t + 0.5 * g * t * t);
}

TEST(a_mat_bounces_as_the_closed_form_says)
{
    const double damping[] = {0.0, 300.0, 1000.0}, kv = 1e6, bump[] = {0.02, 0.02};
    for (size_t i = 0; i < 3; i++) {
        double left_s, m = 160.0 / 32.174, high = 0.02 - 80.0 / kv;
        double lift = bounced_ft(m, 32.174, 2.0 * kv, 2.0 * damping[i], high, 0.01, &left_s);
        const double times[] = {left_s + 0.01};
        struct sim_scene scene = mats(1, times, 1);
        struct sim_result result;
        scene.kv_lb_ft = kv;
        scene.cv_lb_s_ft = damping[i];
        scene.bump_first = 1;
        sim_scene_set_list(&scene.bump_ft, bump, 2);
        solve(&scene, "moreau", 2e-6, &result);
        near(result.outputs[0].lift_ft, lift, result.error_lift_ft + 1e-9);
        assert_true(lift > 1e-3 && result.error_lift_ft < 0.01 * lift);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* Mat 5 runs away at 2 ft/s. Each joint hooks after 0.01 ft and damps so much that the mats go on
 * as one: k mats at 2/k ft/s, the next hooked 0.01 k/2 s later. */
TEST(mats_with_slack_catch_each_other)
{
    const double times[] = {0.0025, 0.0125, 0.025, 0.045, 0.08};
    const double expected[] = {0.005, 0.005 * 2 + (0.0125 - 0.005) * 1.0,
                               0.02 + (0.025 - 0.015) * 2.0 / 3.0, 0.03 + (0.045 - 0.03) * 0.5,
                               0.04 + (0.08 - 0.05) * 0.4};
    struct sim_scene scene = mats(5, times, 5);
    struct sim_result result;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.slack_ft = 0.01;
    scene.cl_lb_s_ft = 1e8;
    scene.v0_ft_s = 2.0;
    scene.v0_mat = 5;
    solve(&scene, "moreau", 1e-5, &result);
    for (size_t i = 0; i < 5; i++)
        near(result.outputs[i].u_ft[5], expected[i], result.error_u_ft + 1e-6);
    assert_true(result.error_u_ft < 2e-4);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

static struct sim_scene standard(const char *path)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    if (sim_scene_load(&scene, path, &error) != MR_OK)
        fail_msg("%s", error.text);
    scene.mats = 12;
    scene.mats_crossed = 1.0;
    sim_scene_set_list(&scene.t_out_s, NULL, 0);
    return scene;
}

static double apart_u_ft(const struct sim_result *a, const struct sim_result *b)
{
    double most = 0.0;
    for (int n = 1; n <= a->mats; n++)
        most = fmax(most, fabs(a->u_ft[n] - b->u_ft[n]));
    return most;
}

/* Both models with all their switches, against event; a quarter of the step has at most 0.4 of the
 * error, and the stated one is never below the true one. */
TEST(errors_fall_with_the_step_and_are_stated)
{
    static const char *const paths[] = {"host/scenes/rstar_fig3_7.json",
                                        "host/scenes/consistent_fig3_7.json"};
    for (size_t k = 0; k < 2; k++) {
        struct sim_scene scene = standard(paths[k]);
        struct sim_options exact = {.solver = "event", .rtol = 1e-11};
        struct sim_result truth;
        double before = 0.0;
        assert_int_equal(sim_run(&scene, &exact, &truth, &error), MR_OK);
        for (double dt_s = 1.6e-5; dt_s > 0.9e-6; dt_s *= 0.25) {
            struct sim_result result;
            solve(&scene, "moreau", dt_s, &result);
            double u_ft = apart_u_ft(&result, &truth),
                   lift_ft = fabs(result.max_lift_ft - truth.max_lift_ft);
            assert_true(u_ft <= result.error_u_ft && lift_ft <= result.error_lift_ft);
            assert_true(before == 0.0 || u_ft <= 0.4 * before);
            before = u_ft;
            sim_result_free(&result);
        }
        assert_true(before < 1e-4 * truth.peak_u_ft);
        sim_result_free(&truth);
        sim_scene_free(&scene);
    }
}

/* With TAD 0 a foot hovers from 0.4 ms on: a share of the step, not a switch in every step. */
TEST(a_foot_hovers_as_where_it_is_held)
{
    struct sim_scene scene = standard("host/scenes/rstar_fig3_7.json");
    struct sim_result held, shared;
    scene.tad_deg = 0.0;
    solve(&scene, "event", 0.0, &held);
    solve(&scene, "moreau", 2e-6, &shared);
    near(shared.max_lift_ft, held.max_lift_ft, shared.error_lift_ft);
    assert_true(apart_u_ft(&shared, &held) <= shared.error_u_ft + held.error_u_ft);
    assert_true(shared.error_lift_ft < 1e-3 * held.max_lift_ft);
    sim_result_free(&held);
    sim_result_free(&shared);
    sim_scene_free(&scene);
}

/* Soil so stiff that the longest explicit step is a thousandth of this one. */
TEST(no_step_is_too_long_to_be_stable)
{
    struct sim_scene scene = standard("host/scenes/consistent_fig3_7.json");
    struct sim_result result;
    scene.kv_lb_ft *= 1e5;
    scene.cv_lb_s_ft *= 1e5;
    solve(&scene, "moreau", 1e-6, &result);
    assert_true(result.dt_limit_s < 1e-8 && result.max_lift_ft < 0.5 && result.peak_u_ft < 0.5);
    sim_result_free(&result);
    sim_scene_free(&scene);
}
