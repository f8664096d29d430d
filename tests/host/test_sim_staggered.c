/* The fixed step: that it checks itself, that leaving mats out changes nothing, and that another
 * method agrees. */

#include "host/sim/elements/gear.h"
#include "host/sim/elements/wheel.h"
#include "tests/host/sim_case.h"
#include "tests/host/model_mat.h"

static enum mr_status try(const struct sim_scene *scene, const struct sim_options *options,
                          struct sim_result *result)
{
    memset(&error, 0, sizeof error);
    return sim_run(scene, options, result, &error);
}

TEST(leaving_mats_out_changes_nothing)
{
    for (int variant = 0; variant < 7; variant++) {
        struct sim_scene scene = short_runway(SIM_MODEL_CHAIN);
        struct sim_result pruned, whole;
        const double none = 0.0;
        if (variant == 1)
            sim_scene_set_list(&scene.grit_lb, &none, 1);
        if (variant == 2) {
            scene.thrust = SIM_THRUST_LINEAR;
            scene.wheel_load_lb = 3.0;
        }
        if (variant == 3)
            scene.friction_law = SIM_FRICTION_TANH;
        if (variant == 4)
            scene.friction_law = SIM_FRICTION_SIGN;
        if (variant == 6)
            scene.element_values[ELEMENT_ground_damping] = 0.3;
        if (variant == 5) {
            /* starts in motion, at a far mat, and loaded: the window has to find it */
            scene.gap0_ft.values[70] = -1e-5;
            scene.v0_ft_s = 0.5;
            scene.v0_mat = 60;
        }
        assert_int_equal(try(&scene, &(struct sim_options){.solver = "staggered"}, &pruned), MR_OK);
        assert_int_equal(
            try(&scene, &(struct sim_options){.solver = "staggered", .integrates_all_mats = true},
                &whole),
            MR_OK);
        assert_true(whole.integrated_mats_mean == 80.0);
        if (scene.friction_law == SIM_FRICTION_STICK) /* the other laws let mats creep for ever */
            assert_true(pruned.integrated_mats_mean < 60.0);
        assert_true(pruned.peak_u_ft > 0.005 && pruned.peak_u_ft == whole.peak_u_ft);
        assert_true(pruned.events == whole.events && pruned.error_u_ft == whole.error_u_ft);
        assert_memory_equal(pruned.u_ft, whole.u_ft, 81 * sizeof(double));
        assert_memory_equal(pruned.gap_ft, whole.gap_ft, 82 * sizeof(double));
        sim_result_free(&pruned);
        sim_result_free(&whole);
        sim_scene_free(&scene);
    }
}

static bool stop_late(void *asked, int pass, double part)
{
    assert_int_equal(pass, 2); /* the finer one, which the calling thread runs */
    ++*(int *)asked;
    return part < 0.2;
}

TEST(two_passes_side_by_side_have_the_bits_of_one_after_the_other)
{
    struct sim_scene scene = short_runway(SIM_MODEL_CHAIN);
    struct sim_result one, two, stopped;
    int asked = 0;
    scene.mods.tear_lb = 30.0; /* and a third pass */
    assert_int_equal(try(&scene, &(struct sim_options){.solver = "staggered"}, &one), MR_OK);
    assert_int_equal(
        try(&scene, &(struct sim_options){.solver = "staggered", .in_parallel = true}, &two),
        MR_OK);
    assert_true(one.pass_count >= 3 && two.pass_count == one.pass_count && one.peak_u_ft > 0.005);
    assert_true(two.evaluations == one.evaluations && two.events == one.events &&
                two.steps == one.steps);
    assert_true(two.error_u_ft == one.error_u_ft && two.checked_dt_s == one.checked_dt_s);
    assert_memory_equal(two.u_ft, one.u_ft, 81 * sizeof(double));
    assert_memory_equal(two.gap_ft, one.gap_ft, 82 * sizeof(double));
    assert_memory_equal(two.max_compression_lb, one.max_compression_lb, 82 * sizeof(double));
    const struct sim_options stop = {.solver = "staggered",
                                     .in_parallel = true,
                                     .may_continue = stop_late,
                                     .may_continue_ctx = &asked};
    assert_int_equal(try(&scene, &stop, &stopped), MR_NUMERICS);
    assert_true(stopped.status == SIM_INTERRUPTED && asked > 1 && stopped.peak_u_ft > 0.0);
    assert_true(stopped.t_s > 0.2 * one.t_end_s && stopped.t_s < 0.5 * one.t_end_s);
    sim_result_free(&one);
    sim_result_free(&two);
    sim_result_free(&stopped);
    sim_scene_free(&scene);
}

TEST(a_step_beyond_the_limit_is_unstable)
{
    struct sim_scene scene = short_runway(SIM_MODEL_CHAIN);
    struct sim_result result;
    /* undamped 2/w = sqrt(m/KL); with CL it is shorter by sqrt(1 + z^2) - z, z = 2 CL/(m w) */
    const double m = 0.466 / G, w = 2.0 * sqrt(2.9e5 / m), z = 10.0 / (m * w);
    const double limit = 2.0 / w * (sqrt(1.0 + z * z) - z);
    assert_int_equal(try(&scene, &(struct sim_options){.dt_s = 1.001 * limit}, &result),
                     MR_NUMERICS);
    assert_int_equal(result.status, SIM_UNSTABLE);
    assert_null(result.u_ft);
    assert_null(result.outputs);
    assert_non_null(strstr(error.text, "unstable"));
    assert_non_null(strstr(error.text, "mat 4 at 0 s")); /* where the wheel is: 1 ft */
    assert_int_equal(mr_status_exit_code(error.status), 5);
    sim_result_free(&result);

    assert_int_equal(try(&scene, &(struct sim_options){.dt_s = 0.8 * limit}, &result), MR_OK);
    assert_true(result.dt_limit_s > 0.999 * limit && result.dt_limit_s < 1.001 * limit);
    assert_true(result.checked_dt_s < 0.43 * limit); /* a longer step would be beyond the limit */
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Friction `sign` throws a mat at rest to and fro with f g h: more energy than the weak push puts
 * in. */
TEST(energy_from_nowhere_is_unstable)
{
    struct sim_scene scene;
    struct sim_result result;
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.friction_law = SIM_FRICTION_SIGN;
    scene.mats = 1;
    scene.right_end = SIM_END_FREE;
    scene.force_lb = 1e-3;
    scene.v0_ft_s = 0.0;
    assert_int_equal(try(&scene, &(struct sim_options){.solver = "staggered"}, &result),
                     MR_NUMERICS);
    assert_int_equal(result.status, SIM_UNSTABLE);
    assert_int_equal(result.mat, 1);
    assert_true(result.t_s > 0.0 && result.t_s < result.t_end_s);
    assert_non_null(strstr(error.text, "unstable: scene: mat 1 at "));
    assert_null(result.u_ft);
    sim_result_free(&result);
}

/* A mat on a spring for 50 periods: with a long step it stays bounded, keeps its energy, and is out
 * of phase at the end. */
TEST(a_wrong_answer_that_looks_right_is_refused)
{
    struct sim_scene scene;
    struct sim_result result;
    const double w = sqrt(8e6 * G / 160.0);
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.mats = 1;
    scene.cl_lb_s_ft = scene.force_lb = 0.0;
    scene.t_end_s = 300.0 / w;
    assert_int_equal(try(&scene, &(struct sim_options){.dt_s = 0.6 / w}, &result), MR_NUMERICS);
    assert_int_equal(result.status, SIM_UNSTABLE);
    assert_true(result.mat == 1 && result.t_s > 0.0 && result.error_u_ft > 0.2 * 2.0 / w);
    sim_result_free(&result);
    /* left to itself it finds a step that is good enough */
    assert_int_equal(try(&scene, &(struct sim_options){0}, &result), MR_OK);
    assert_true(fabs(result.u_ft[1] - 2.0 / w * sin(300.0)) <= result.error_u_ft);
    assert_true(result.error_u_ft <= 0.2 * 2.0 / w && result.other_steps > result.steps / 2);
    sim_result_free(&result);
}

/* Two mats, no friction: the closed form shows the order and what the error estimate is worth. */
TEST(halving_the_step_quarters_the_error)
{
    struct sim_scene scene;
    const double m = 160.0 / G, k = 8e6, v = 2.0, t = 0.02, w = sqrt(2.0 * k / m);
    const double exact = 0.5 * (v * t + v / w * sin(w * t));
    double last = 0.0;
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = 2;
    scene.right_end = SIM_END_FREE;
    scene.cl_lb_s_ft = scene.force_lb = 0.0;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.t_end_s = t;
    for (int i = 0; i < 4; i++) {
        struct sim_options options = {.dt_s = 1e-4 / (1 << i)};
        struct sim_result result;
        assert_int_equal(try(&scene, &options, &result), MR_OK);
        double wrong = fabs(result.u_ft[1] - exact);
        assert_true(wrong <= result.error_u_ft && result.error_u_ft < 3e-4);
        if (i > 0)
            assert_true(last / wrong > 3.5 && last / wrong < 4.5);
        last = wrong;
        sim_result_free(&result);
    }
}

/* Double the first step is the stability limit: an undamped spring's energy grows there. That pair
 * is not the answer's fault. */
TEST(a_check_at_the_limit_is_made_again_with_half_the_step)
{
    struct sim_scene scene;
    struct sim_result result;
    const double w = sqrt(8e6 * G / 160.0);
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.mats = 1;
    scene.cl_lb_s_ft = scene.force_lb = 0.0;
    scene.t_end_s = 1500.0 / w; /* more than 1000 of the longest steps */
    assert_int_equal(try(&scene, &(struct sim_options){0}, &result), MR_OK);
    assert_true(fabs(result.u_ft[1] - 2.0 / w * sin(1500.0)) <= result.error_u_ft);
    assert_true(result.error_u_ft <= 0.1 * 2.0 / w);
    sim_result_free(&result);
}

/* Mats and joints are computed in blocks: plain loops for chains that end anywhere in one. */
TEST(a_chain_of_any_length_is_complete)
{
    const double m = 160.0 / G, k = 8e6, c = 50.0, force = 1500.0, h = 1e-5;
    for (int mats = 1; mats <= 9; mats++) {
        double u[11] = {0.0}, v[11] = {0.0};
        for (int i = 0; i < 3000; i++) {
            double tension[11] = {0.0};
            for (int j = 2; j <= mats + 1; j++)
                tension[j] = k * (u[j] - u[j - 1]) + c * (v[j] - v[j - 1]);
            for (int n = 1; n <= mats; n++)
                v[n] += (tension[n + 1] - tension[n] + (n == 1 ? force : 0.0)) / m *
                        (i == 0 ? 0.5 * h : h);
            for (int n = 1; n <= mats; n++)
                u[n] += h * v[n];
        }
        struct sim_scene scene;
        struct sim_result result;
        sim_scene_set_defaults(&scene);
        scene.model = SIM_MODEL_CHAIN;
        scene.mats = mats;
        scene.friction_law = SIM_FRICTION_NONE;
        scene.force_lb = force;
        scene.vac_ft_s = scene.v0_ft_s = 0.0;
        scene.t_end_s = 3000 * h;
        assert_int_equal(try(&scene, &(struct sim_options){.dt_s = h}, &result), MR_OK);
        for (int n = 1; n <= mats; n++) {
            if (!(fabs(result.u_ft[n] - u[n]) < 1e-9 * fabs(u[1])))
                fail_msg("%d mats, mat %d: %.12g, plain loops %.12g", mats, n, result.u_ft[n],
                         u[n]);
        }
        assert_true(fabs(u[1]) > 1e-5);
        sim_result_free(&result);
    }
}

TEST(rtol_is_reached_or_refused)
{
    struct sim_scene scene = short_runway(SIM_MODEL_CHAIN);
    struct sim_result result;
    assert_int_equal(
        try(&scene, &(struct sim_options){.solver = "staggered", .rtol = 0.01}, &result), MR_OK);
    assert_true(result.error_u_ft > 0.0 && result.error_u_ft <= 0.01 * result.peak_u_ft);
    assert_true(result.evaluations == result.steps + result.other_steps);
    sim_result_free(&result);
    scene.t_dwell_s = -1.0;
    scene.t_end_s = 0.05;
    assert_int_equal(
        try(&scene, &(struct sim_options){.solver = "staggered", .rtol = 1e-9}, &result),
        MR_NUMERICS);
    assert_int_equal(result.status, SIM_STEP_UNDERFLOW);
    assert_null(result.u_ft);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Five mats by the classical Runge-Kutta method, from the common pieces of host/sim/README.md:
 * joints with slack and damper, friction tanh, left end free, right fixed. y: u 0..4, rates
 * 5..9. */
struct five {
    double m, k, c, s, limit, veps, gap[6], force;
};

static void five_rates(const struct five *p, const double *y, double *rate)
{
    double t[6] = {0.0};
    for (int j = 1; j <= 5; j++) {
        double g = p->gap[j] + (j < 5 ? y[j] : 0.0) - y[j - 1];
        double dg = (j < 5 ? y[j + 5] : 0.0) - y[j + 4];
        if (p->s <= 0.0 || g < 0.0)
            t[j] = p->k * g + p->c * dg;
        else if (g > p->s)
            t[j] = p->k * (g - p->s) + p->c * dg;
    }
    for (int n = 0; n < 5; n++) {
        rate[n] = y[n + 5];
        rate[n + 5] =
            (t[n + 1] - t[n] + (n == 0 ? p->force : 0.0) - p->limit * tanh(y[n + 5] / p->veps)) /
            p->m;
    }
}

static void five_run(const struct five *p, double *y, double end_s, int steps)
{
    double h = end_s / steps;
    for (int i = 0; i < steps; i++) {
        double a[10], b[10], c[10], d[10], z[10];
        five_rates(p, y, a);
        for (int k = 0; k < 10; k++)
            z[k] = y[k] + 0.5 * h * a[k];
        five_rates(p, z, b);
        for (int k = 0; k < 10; k++)
            z[k] = y[k] + 0.5 * h * b[k];
        five_rates(p, z, c);
        for (int k = 0; k < 10; k++)
            z[k] = y[k] + h * c[k];
        five_rates(p, z, d);
        for (int k = 0; k < 10; k++)
            y[k] += h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]);
    }
}

TEST(another_method_agrees)
{
    /* slack off with smooth tanh; slack on with smooth tanh; slack on with stick against a steep
     * tanh */
    const double tolerance[] = {1e-5, 1e-3, 1e-3};
    for (int variant = 0; variant < 3; variant++) {
        struct five p = {
            .m = 160.0 / G, .k = 8e5, .c = 50.0, .limit = 80.0, .veps = 0.05, .force = 1500.0};
        double y[10] = {0.0};
        struct sim_scene scene;
        struct sim_result result;
        sim_scene_set_defaults(&scene);
        if (variant >= 1) {
            p.s = 0.004;
            for (int j = 0; j < 6; j++)
                p.gap[j] = 0.004 * uneven(j);
        }
        if (variant == 2)
            p.veps = 1e-5;
        scene.model = SIM_MODEL_CHAIN;
        scene.mats = 5;
        scene.kl_lb_ft = p.k;
        scene.slack_ft = p.s;
        scene.force_lb = p.force;
        scene.vac_ft_s = scene.v0_ft_s = 0.0;
        scene.t_end_s = 0.03;
        scene.friction_law = variant == 2 ? SIM_FRICTION_STICK : SIM_FRICTION_TANH;
        scene.veps_ft_s = p.veps;
        sim_scene_set_list(&scene.gap0_ft, p.gap, 6);
        five_run(&p, y, 0.03, variant == 2 ? 60000 : 20000);
        assert_int_equal(try(&scene, &(struct sim_options){.dt_s = 1e-6}, &result), MR_OK);
        for (int n = 1; n <= 5; n++) {
            if (!(fabs(result.u_ft[n] - y[n - 1]) < tolerance[variant] * fabs(y[0])))
                fail_msg("variant %d mat %d: %.9g, Runge-Kutta %.9g", variant, n, result.u_ft[n],
                         y[n - 1]);
        }
        assert_true(fabs(y[0]) > 1e-3);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

TEST(samples_are_the_mats_over_their_stations)
{
    struct sim_scene scene = short_runway(SIM_MODEL_CHAIN);
    const double stations[] = {0.0, 5.0 * 2.0 / 7.0, 6.0, 80.0 * 2.0 / 7.0};
    const int mats[] = {1, 6, 22, 80};
    const double times[] = {0.8, 0.1, 0.25};
    struct sim_options options = {.sample_dt_s = 0.05, .station_ft = stations, .station_count = 4};
    struct sim_result result;
    sim_scene_set_list(&scene.t_out_s, times, 3);
    assert_int_equal(try(&scene, &options, &result), MR_OK);
    assert_int_equal(result.sample_count, 17);
    assert_int_equal(result.station_count, 4);
    assert_true(result.t_end_s == 0.8);
    for (size_t i = 0; i < 3; i++) {
        assert_true(result.outputs[i].t_s == times[i]);
        size_t row = (size_t)lround(times[i] / 0.05);
        for (size_t s = 0; s < 4; s++)
            assert_true(fabs(result.sample_u_ft[row * 4 + s] - result.outputs[i].u_ft[mats[s]]) <
                        1e-12);
    }
    for (size_t s = 0; s < 4; s++)
        assert_true(result.sample_u_ft[s] == 0.0);
    assert_true(result.sample_u_ft[16 * 4 + 1] > 1e-3);
    for (int n = 1; n <= 80; n++)
        assert_true(fabs(result.u_ft[n] - result.outputs[0].u_ft[n]) < 1e-12);
    sim_result_free(&result);

    options.station_ft = (const double[]){23.0};
    options.station_count = 1;
    assert_int_equal(try(&scene, &options, &result), MR_USAGE);
    assert_non_null(strstr(error.text, "23 ft"));
    sim_result_free(&result);
    sim_scene_free(&scene);
}

TEST(what_is_not_built_is_refused)
{
    struct sim_scene scene = short_runway(SIM_MODEL_CHAIN);
    struct sim_result result;
    assert_int_equal(try(&scene, &(struct sim_options){.solver = "rk8"}, &result), MR_USAGE);
    assert_non_null(strstr(error.text, "rk8 for model chain; give event or staggered"));
    scene.friction_normal = SIM_NORMAL_SOIL;
    assert_int_equal(try(&scene, &(struct sim_options){0}, &result), MR_USAGE);
    scene.friction_normal = SIM_NORMAL_WEIGHT;
    assert_int_equal(try(&scene, &(struct sim_options){.dt_s = -1.0}, &result), MR_USAGE);
    assert_int_equal(try(&scene, &(struct sim_options){.dt_s = 1e-12}, &result), MR_USAGE);
    assert_int_equal(try(&scene, &(struct sim_options){.rtol = 2.0}, &result), MR_USAGE);
    sim_scene_free(&scene);
}

TEST(the_wheel_shares_its_thrust)
{
    const struct sim_path_row rows[] = {{1, 1.5, 100}, {2, 3.5, 300}, {2, 3.5, 50}, {3, 3.5, 50}};
    struct sim_scene scene;
    struct sim_wheel wheel;
    struct sim_touch touch[SIM_TOUCH_MAX];
    sim_scene_set_defaults(&scene); /* mats of 2 ft */
    scene.mats = 2;
    sim_scene_set_path(&scene, rows, 4);
    sim_wheel_start(&wheel, &scene);
    assert_int_equal(sim_wheel_compute_action(&wheel, 0.5, 0.9, touch), 0);
    /* half of 1.15 s..1.35 s, 1.8 ft to 2.2 ft, on each side of the joint; mean force 150 */
    assert_int_equal(sim_wheel_compute_action(&wheel, 1.15, 1.35, touch), 2);
    assert_true(touch[0].mat == 1 && touch[1].mat == 2);
    assert_true(fabs(touch[0].thrust_lb - 75.0) < 1e-9 && fabs(touch[1].thrust_lb - 75.0) < 1e-9);
    assert_true(fabs(touch[0].load_share - 0.5) < 1e-9);
    /* 1.9 s..2.2 s: 0.1 s at 290 in the mean and 0.2 s at 50 */
    assert_int_equal(sim_wheel_compute_action(&wheel, 1.9, 2.2, touch), 1);
    assert_true(fabs(touch[0].thrust_lb - (29.0 + 10.0) / 0.3) < 1e-9);
    /* after the path: the load stays, the thrust does not */
    assert_int_equal(sim_wheel_compute_action(&wheel, 3.5, 3.6, touch), 1);
    assert_true(touch[0].mat == 2 && touch[0].thrust_lb == 0.0 && touch[0].load_share == 1.0);

    scene.thrust = SIM_THRUST_LINEAR;
    sim_wheel_start(&wheel, &scene);
    double thrust[3] = {0.0};
    int count = sim_wheel_compute_action(&wheel, 1.4, 1.6, touch); /* about 2.5 ft: w = 0.75 */
    for (int i = 0; i < count; i++)
        thrust[touch[i].mat] += touch[i].thrust_lb;
    assert_true(fabs(thrust[1] - 0.25 * 200.0) < 1e-9 && fabs(thrust[2] - 0.75 * 200.0) < 1e-9);

    scene.thrust = SIM_THRUST_JUMP;
    sim_scene_set_path(&scene, NULL, 0);
    scene.force_stop_s = 0.01; /* 90 ft/s: mat 1 until 0.0222 s, off at 0.0444 s */
    sim_wheel_start(&wheel, &scene);
    assert_int_equal(sim_wheel_compute_action(&wheel, 0.0, 0.02, touch), 1);
    assert_true(touch[0].mat == 1 && fabs(touch[0].thrust_lb - 6000.0) < 1e-9);
    assert_int_equal(sim_wheel_compute_action(&wheel, 0.03, 0.031, touch), 1);
    assert_true(touch[0].mat == 2 && touch[0].thrust_lb == 0.0);
    assert_int_equal(sim_wheel_compute_action(&wheel, 0.045, 0.046, touch), 0);
    sim_scene_free(&scene);
}

/* Whether a joint tears hangs on a peak that both steps of the check can see on one side. At 52 us
 * and twice that, one tears which at 1 us does not, and the two agree to a quarter of the error. */
TEST(a_joint_that_tears_by_the_step_is_within_the_stated_error)
{
    static const double gaps[] = {
        0.00031811755210614745, 0.0010629996975792901, 0.0019092269222381805,
        0.0020106231695649823,  0.002420703164994279,  0.001224560905251255,
        0.0001828447057217561,  0.0023255962678571654, 0.0023204017770586385};
    static const double grits[] = {2.639307076314936,  2.3407571007401167, 2.2447520959550618,
                                   3.915535923430547,  1.119002072303682,  0.7603411943601668,
                                   4.8594375953851285, 0.5444520690102334, 4.126976755326066};
    struct sim_scene scene;
    struct sim_result usual, fine;
    error = (struct error){0};
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = 8;
    model_mat_chain(&scene);
    sim_scene_set_list(&scene.gap0_ft, gaps, 9);
    sim_scene_set_list(&scene.grit_lb, grits, 9);
    scene.left_end = SIM_END_FIXED;
    scene.right_end = SIM_END_FREE;
    scene.friction = 0.5;
    scene.v0_ft_s = 0.0;
    scene.vac_ft_s = 10.0;
    scene.force_lb = 27.539106264372236;
    scene.start_ft = 0.3;
    scene.t_end_s = 0.3;
    scene.element_values[ELEMENT_gear_ground] = 7000.0;
    scene.wheel_load_lb = 108.0;
    scene.mods.tear_lb = 20.0;
    if (sim_run(&scene, &(struct sim_options){0}, &usual, &error) != MR_OK)
        fail_msg("%s", error.text);
    assert_int_equal(sim_run(&scene, &(struct sim_options){.dt_s = 1e-6}, &fine, &error), MR_OK);
    for (int n = 1; n <= scene.mats; n++)
        if (!(fabs(usual.u_ft[n] - fine.u_ft[n]) <= usual.error_u_ft + fine.error_u_ft))
            fail_msg("mat %d: %.6g ft, at 1 us %.6g; stated %.2g", n, usual.u_ft[n], fine.u_ft[n],
                     usual.error_u_ft);
    sim_result_free(&usual);
    sim_result_free(&fine);
    sim_scene_free(&scene);
}
