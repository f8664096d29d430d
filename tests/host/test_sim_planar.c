/* The planar models through sim_run: the cases the report describes, three solvers against each
 * other, and every way in which a run is refused. Units ft, lb, s.
 *
 * Expected values of the cases: an independent implementation of the same reading (report model,
 * profile low, left end free, right end fixed, stick, V 120 rising), agreed to six digits by two
 * programs; given here to three or four. */

#include "tests/long.h"
#include "host/sim/solvers/stepper.h"
#include "tests/host/sim_case.h"

static const char *const solvers[] = {"event", "implicit", "cvode"};
/* For verdicts and two digits; at 1e-6 cvode gives up on fig 3.6. */
static const double rough_rtol[] = {0.0, 0.0, 1e-7};

static const double bump_20[] = {0.0099, 0.0200, 0.0099};
static const double bump_16[] = {0.0078125, 0.015625, 0.0078125};

static struct sim_scene scene_with(const double *bump, size_t count)
{
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    sim_scene_set_list(&scene.bump_ft, bump, count);
    return scene;
}

static struct sim_result good(const struct sim_scene *scene, const char *solver, double rtol)
{
    return run(scene, (struct sim_options){.solver = solver, .rtol = rtol});
}

/* The figures of the 1973 report, by their scenes. cvode costs most of this program's time: 10 s
 * for fig 3.12, never; all others in make long, two always. */
enum cvode { NEVER, LONG, ALWAYS };
struct figure {
    const char *scene;
    int mat, at; /* whose movement, at which output of the scene; 0: none */
    double u_ft;
    double end_lift_ft, max_lift_ft; /* negative: not given */
    bool bow;
    enum cvode cvode;
};

static const struct figure figures[] = {
    {"rstar_fig3_7", 4, 2, 0.1038, -1, -1, true, ALWAYS},
    {"rstar_fig3_6", 4, 2, 0.0567, -1, -1, true, LONG},
    {"rstar_fig3_8_stiff", 0, 0, 0, 0.40, -1, true, LONG},
    {"rstar_fig3_8_middle", 12, 0, 0.0087, 0.26, -1, true, LONG},
    {"rstar_fig3_8_soft", 0, 0, 0, 0.0, -1, false, LONG},
    {"rstar_fig3_9_f05", 4, 2, 0.104, -1, 0.259, true, LONG},
    {"rstar_fig3_9_f09", 4, 2, 0.089, -1, 0.258, true, LONG},
    {"rstar_fig3_10_f05", 0, 0, 0, -1, 0.260, true, LONG},
    {"rstar_fig3_10_f09", 0, 0, 0, -1, 0.259, true, LONG},
    {"rstar_fig3_11_6000", 0, 0, 0, 0.0, -1, false, LONG},
    {"rstar_fig3_11_12000", 0, 0, 0, 0.245, -1, true, LONG},
    {"rstar_fig3_11_24000", 0, 0, 0, 1.75, -1, true, ALWAYS},
    {"rstar_flat", 0, 0, 0, 0.0, 0.0, false, LONG},
    {"full_width_144000", 0, 0, 0, -1, 0.295, true, LONG},
    {"full_width_40000", 0, 0, 0, -1, -1, false, LONG},
    {"full_width_36000", 0, 0, 0, -1, -1, false, LONG},
    {"rstar_fig3_12_tad10", 4, 3, 0.0500, -1, 0.286, true, NEVER},
    {"rstar_fig3_12_tad1", 4, 3, 0.0500, -1, 0.022, false, NEVER},
};

TEST(the_figures_come_out)
{
    for (size_t i = 0; i < sizeof figures / sizeof figures[0]; i++) {
        const struct figure *f = &figures[i];
        char path[80];
        snprintf(path, sizeof path, "host/scenes/%s.json", f->scene);
        struct sim_scene scene = load(path);
        for (size_t s = 0; s < (f->cvode == ALWAYS ? 3 : f->cvode ? tests_take(2, 3) : 2); s++) {
            struct sim_result result = good(&scene, solvers[s], rough_rtol[s]);
            double lift = result.outputs[result.output_count - 1].lift_ft;
            /* as many digits as are given: half of the last one, and 1 % (u) or 2 % (lift) */
            if (f->mat > 0)
                near(result.outputs[f->at].u_ft[f->mat], f->u_ft, fmax(0.01 * f->u_ft, 5e-5));
            if (f->end_lift_ft >= 0.0)
                near(lift, f->end_lift_ft, 0.02 * f->end_lift_ft);
            if (f->max_lift_ft >= 0.0)
                near(result.max_lift_ft, f->max_lift_ft, 0.02 * f->max_lift_ft);
            if (result.bow_wave != f->bow)
                fail_msg("%s, %s: wrong verdict, lift %g", f->scene, solvers[s],
                         result.max_lift_ft);
            assert_true(result.error_u_ft < 1e-4 && result.error_lift_ft < 2e-3);
            sim_result_free(&result);
        }
        sim_scene_free(&scene);
    }
}

TEST(three_solvers_agree)
{
    const double times[] = {0.02, 0.04, 0.06}, tolerances[] = {1e-9, 1e-8, 1e-9};
    for (int i = 0; i < 8; i++) {
        if (i == 5 || i == 6)
            continue; /* consistent: one law with 30 mats, the other with 100 */
        struct sim_scene scene = scene_with(bump_20, 3);
        struct sim_result results[3];
        /* make test: cvode with 30 mats, once for each law and model */
        size_t count = i & 1 ? tests_take(2, 3) : 3;
        scene.mats = i & 1 ? 100 : 30;
        scene.friction_law = i & 2 ? SIM_FRICTION_TANH : SIM_FRICTION_STICK;
        scene.veps_ft_s = 1e-2;
        if (i & 4) {
            scene.model = SIM_MODEL_CONSISTENT;
            scene.profile = SIM_PROFILE_FULL;
        }
        sim_scene_set_list(&scene.t_out_s, times, 3);
        for (size_t s = 0; s < count; s++)
            results[s] = good(&scene, solvers[s], tolerances[s]);
        for (size_t s = 1; s < count; s++) {
            near(results[s].max_lift_ft, results[0].max_lift_ft, 1e-5);
            for (size_t k = 0; k < 3; k++) {
                near(results[s].outputs[k].lift_ft, results[0].outputs[k].lift_ft, 1e-5);
                for (int n = 1; n <= scene.mats; n++)
                    near(results[s].outputs[k].u_ft[n], results[0].outputs[k].u_ft[n], 1e-6);
            }
        }
        for (size_t s = 0; s < count; s++)
            sim_result_free(&results[s]);
        sim_scene_free(&scene);
    }
}

/* At these steps the classical method says "no bow wave", and u is right to four digits. */
TEST(a_step_too_long_is_unstable)
{
    const double steps[] = {1.45e-4, 1.5e-4, 1.6e-4, 3e-4};
    struct sim_scene scene = scene_with(bump_20, 3);
    struct sim_result result;
    scene.mats = 30;
    for (size_t i = 0; i < 4; i++) {
        assert_int_equal(attempt(&scene, "rk4", 0.0, steps[i], &result), MR_NUMERICS);
        assert_int_equal(result.status, SIM_UNSTABLE);
        near(result.dt_limit_s, 1.429e-4, 2e-7);
        assert_non_null(strstr(error.text, "mat 1"));
        assert_null(result.outputs);
        sim_result_free(&result);
    }
    assert_int_equal(attempt(&scene, "rk4", 0.0, 2e-5, &result), MR_OK);
    near(result.outputs[0].lift_ft, 0.193, 0.001);
    assert_true(result.bow_wave);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* 1, 2: the fourth order of the method shows where nothing switches. */
TEST(estimates_follow_the_error)
{
    struct sim_scene scene = scene_with(NULL, 0);
    struct sim_result fine, result;
    scene.mats = 10;
    scene.mats_crossed = 1; /* no hop within */
    scene.friction_law = SIM_FRICTION_NONE;
    scene.tad_deg = 90;
    fine = good(&scene, "event", 1e-12);
    double errors[3];
    for (int i = 0; i < 3; i++) {
        assert_int_equal(attempt(&scene, "rk4", 0.0, 1e-4 / (1 << i), &result), MR_OK);
        errors[i] = fabs(result.u_ft[3] - fine.u_ft[3]);
        assert_true(result.error_u_ft > 0.5 * errors[i]);
        sim_result_free(&result);
    }
    near(log2(errors[0] / errors[1]), 4.0, 0.4);
    near(log2(errors[1] / errors[2]), 4.0, 0.4);
    for (size_t s = 0; s < 3; s++) {
        result = good(&scene, solvers[s], 1e-7);
        assert_true(fabs(result.u_ft[3] - fine.u_ft[3]) <= 2.0 * result.error_u_ft + 1e-12);
        sim_result_free(&result);
    }
    sim_result_free(&fine);
}

TEST(the_authors_solvers_answer_too)
{
    struct sim_scene scene = scene_with(bump_20, 3);
    struct sim_result fine, result;
    scene.mats = 30;
    scene.friction_law = SIM_FRICTION_TANH;
    scene.veps_ft_s = 1e-2;
    fine = good(&scene, "event", 1e-10);
    static const char *const names[] = {"rkgs", "hamming"};
    for (size_t i = 0; i < 2; i++) {
        double last = (double)INFINITY;
        for (double rtol = 1e-5; rtol > 5e-9; rtol *= 0.03) {
            result = good(&scene, names[i], rtol);
            double apart = fabs(result.outputs[0].lift_ft - fine.outputs[0].lift_ft);
            assert_true(apart < last);
            last = apart;
            sim_result_free(&result);
        }
        assert_true(last < 1e-6);
    }
    sim_result_free(&fine);
    sim_scene_free(&scene);
}

TEST(a_fold_is_refused)
{
    struct sim_scene scene = scene_with(bump_16, 3);
    struct sim_result result;
    scene.force_lb = 120000.0;
    for (size_t s = 0; s < 3; s++) {
        assert_int_equal(attempt(&scene, solvers[s], 0.0, 0.0, &result), MR_NUMERICS);
        assert_int_equal(result.status, SIM_FOLDED);
        assert_true(result.t_s > 0.0 && result.mat >= 1);
        assert_non_null(strstr(error.text, "folded"));
        sim_result_free(&result);
    }
    sim_scene_free(&scene);
}

TEST(what_does_not_fit_is_refused)
{
    struct sim_scene scene = scene_with(bump_20, 3);
    struct sim_result result;
    assert_int_equal(attempt(&scene, "rk8", 0.0, 0.0, &result), MR_USAGE);
    assert_non_null(strstr(error.text, "rk8"));
    assert_int_equal(attempt(&scene, "staggered", 0.0, 1e-5, &result), MR_USAGE);
    assert_int_equal(attempt(&scene, "event", 0.0, 1e-5, &result), MR_USAGE);
    assert_int_equal(attempt(&scene, "rk4", 1e-6, 0.0, &result), MR_USAGE);
    assert_int_equal(attempt(&scene, "event", 1e-14, 0.0, &result), MR_USAGE);
    scene.friction_normal = SIM_NORMAL_SOIL;
    assert_int_equal(attempt(&scene, NULL, 0.0, 0.0, &result), MR_USAGE);
    scene.friction_normal = SIM_NORMAL_WEIGHT;
    const double steep[] = {2.5};
    sim_scene_set_list(&scene.bump_ft, steep, 1);
    assert_int_equal(attempt(&scene, NULL, 0.0, 0.0, &result), MR_USAGE);
    sim_scene_free(&scene);
}

/* --- Waves and growth against closed forms: how fast a push runs along the joints, and how fast
 * a zigzag under compression rises. --- */

/* A step of force on the first mat of a chain of masses and springs: the speed behind the front is
 * F/sqrt(KL m), and at the front (n = c t / L) a third of it, as the Airy integral has it. */
TEST(a_push_runs_at_L_sqrt_KL_over_m)
{
    const double dt_s = 2e-5, length = 2.0, station[] = {100.0, 300.0};
    for (unsigned variant = 0; variant < tests_take(4, 6); variant++) {
        struct sim_scene scene;
        double arrival_s[2] = {0.0, 0.0};
        sim_scene_set_defaults(&scene);
        scene.model = variant % 2 ? SIM_MODEL_CONSISTENT : SIM_MODEL_REPORT;
        scene.mats = 250;
        scene.v0_ft_s = 0.0;
        scene.cl_lb_s_ft = 0.0;
        scene.friction = 0.0;
        scene.vac_ft_s = 1e-3; /* the push stays on mat 1 */
        scene.t_end_s = 0.16;
        struct sim_options options = {.solver = solvers[variant / 2],
                                      .sample_dt_s = dt_s,
                                      .station_ft = station,
                                      .station_count = 2,
                                      .rtol = 1e-6};
        struct sim_result result = run(&scene, options);
        double mass = 160.0 / 32.174, behind = 12000.0 / sqrt(8e6 * mass),
               c_ft_s = length * sqrt(8e6 / mass);
        for (int s = 0; s < 2; s++) {
            for (size_t k = 1; k + 1 < result.sample_count && arrival_s[s] == 0.0; k++) {
                double v = (result.sample_u_ft[(k + 1) * 2 + (size_t)s] -
                            result.sample_u_ft[(k - 1) * 2 + (size_t)s]) /
                           (2.0 * dt_s);
                if (v > behind / 3.0)
                    arrival_s[s] = (double)k * dt_s;
            }
            assert_true(arrival_s[s] > 0.0);
        }
        assert_true(fabs((station[1] - station[0]) / (arrival_s[1] - arrival_s[0]) / c_ft_s - 1.0) <
                    0.01);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* Four mats well above the ground, without weight, in the shape of the chain's own third mode
 * (heights as the cosine of 3 pi/4 per node), under 12,000 lb from joints that start pressed: the
 * shape keeps and grows as cosh r t. */
TEST(a_small_zigzag_grows_at_its_rate)
{
    const double rate_s[2] = {109.5, 91.7}; /* report model, consistent model */
    for (int variant = 0; variant < 6; variant++) {
        struct sim_scene scene;
        double heights[5];
        int model = variant % 2;
        for (int j = 0; j < 5; j++)
            heights[j] = 0.1 + 1e-4 * cos(0.75 * 3.14159265358979 * j);
        sim_scene_set_defaults(&scene);
        scene.model = model ? SIM_MODEL_CONSISTENT : SIM_MODEL_REPORT;
        scene.mats = 4;
        scene.g_ft_s2 = 32.174e-6; /* the mass stays, the weight goes */
        scene.weight_lb = 160e-6;
        scene.friction = 0.0;
        scene.force_lb = 0.0;
        scene.v0_ft_s = 0.0;
        scene.left_end = SIM_END_FIXED;
        scene.lift_shear = SIM_SHEAR_NONE;
        scene.bump_first = 1;
        scene.t_end_s = 0.02;
        double pressed_ft = -12000.0 / 8e6;
        sim_scene_set_list(&scene.bump_ft, heights, 5);
        sim_scene_set_list(&scene.gap0_ft, &pressed_ft, 1);
        struct sim_result result = run(&scene,
                                       (struct sim_options){.solver = solvers[variant / 2]});
        /* of the highest node; the report model's nodes are a sum */
        double grown = (result.max_lift_ft - 0.1) / 1e-4;
        /* q1, the middle of mat 1, stays: node 1 rises by half of the first mat's slope */
        if (!model)
            grown =
                (result.outputs[0].lift_ft - 0.1 - 0.5e-4 * (1.0 + cos(0.75 * 3.14159265358979))) /
                (0.5e-4 * (1.0 - cos(0.75 * 3.14159265358979)));
        double rate = acosh(grown) / 0.02;
        assert_true(fabs(rate / rate_s[model] - 1.0) < 0.01);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* --- Collisions against what mechanics says of them: two equal mats on a joint with slack throw
 * each other to and fro without loss. Units ft, lb, s. --- */

#define OUTPUTS 16

/* Mat 1 moves at v0 and finds mat 2 at rest; nothing rubs, nothing damps. */
static void two_mats(struct sim_scene *scene)
{
    double times_s[OUTPUTS];
    sim_scene_set_defaults(scene);
    scene->model = SIM_MODEL_CONSISTENT;
    scene->mats = 2;
    scene->left_end = scene->right_end = scene->left_torsion = scene->right_torsion = SIM_END_FREE;
    scene->profile = SIM_PROFILE_LOW;
    scene->friction_law = SIM_FRICTION_NONE;
    scene->friction = 0.0;
    scene->force_lb = 0.0;
    scene->v0_mat = 1;
    scene->v0_ft_s = 2.0;
    scene->slack_ft = 0.005;
    scene->kl_lb_ft = 5e12;
    scene->cl_lb_s_ft = 0.0;
    scene->t_end_s = 0.02;
    for (int i = 0; i < OUTPUTS; i++)
        times_s[i] = scene->t_end_s * (i + 1) / OUTPUTS;
    sim_scene_set_list(&scene->t_out_s, times_s, OUTPUTS);
}

/* Opening of the joint: half a swing pressed, the slack at v0, half a swing hooked, back. */
static double opening_ft(const struct sim_scene *scene, double t_s)
{
    double mass_slug = scene->weight_lb / scene->g_ft_s2,
           swing = sqrt(2.0 * scene->kl_lb_ft / mass_slug), hit_s = M_PI / swing,
           flight_s = scene->slack_ft / scene->v0_ft_s, half_s = hit_s + flight_s;
    double halves = floor(t_s / half_s), in_s = t_s - halves * half_s;
    double out_ft = in_s < hit_s ? -scene->v0_ft_s / swing * sin(swing * in_s)
                                 : scene->v0_ft_s * (in_s - hit_s);
    return fmod(halves, 2.0) < 0.5 ? out_ft : scene->slack_ft - out_ft;
}

/* A step many swings long took the joint's push for a thing of the past, and the mats stayed
 * together: at one tolerance and at another alike, and each said that it was right. */
TEST(mats_that_collide_part_again)
{
    static const struct {
        const char *solver;
        double rtol;
    } runs[] = {{"implicit", 0.0},  {"implicit", 1e-5}, {"implicit", 1e-6}, {"implicit", 1e-8},
                {"implicit", 1e-9}, {"event", 0.0},     {NULL, 0.0}};
    struct sim_scene scene;
    two_mats(&scene);
    for (size_t k = 0; k < sizeof runs / sizeof runs[0]; k++) {
        struct sim_result result =
            run(&scene, (struct sim_options){.solver = runs[k].solver, .rtol = runs[k].rtol});
        assert_true(result.error_u_ft < 0.01 * scene.slack_ft);
        for (int i = 0; i < OUTPUTS; i++) {
            double t_s = scene.t_out_s.values[i], gap_ft = opening_ft(&scene, t_s),
                   middle_ft = 0.5 * scene.v0_ft_s * t_s;
            const double *u_ft = result.outputs[i].u_ft;
            assert_true(fabs(u_ft[1] - (middle_ft - 0.5 * gap_ft)) <= result.error_u_ft + 1e-12);
            assert_true(fabs(u_ft[2] - (middle_ft + 0.5 * gap_ft)) <= result.error_u_ft + 1e-12);
        }
        sim_result_free(&result);
    }
    sim_scene_free(&scene);
}

/* --- Where friction tanh turns over: the steps of solver event are cut so that none goes over
 * it from far on one side to far on the other. Units ft, lb, s. * Expected steps: by hand, from a
 * speed and a rate. Expected answers: solver implicit, another method, which is not cut, at 1e-11.
 * --- */

#define MATS 2
#define SIZE (2 * MATS + 1)

/* Two mats of which the second moves at v with rate a; veps 0.01, edge at 4 veps, a step of 1 ms.
 * Returns how long the step may be. */
static double step_s(enum sim_friction law, double turn_veps, double v_ft_s, double a_ft_s2)
{
    const struct stepper_kind kind = {.reversal_speed_veps = turn_veps};
    struct model model = {.friction_law = law,
                          .veps_ft_s = 0.01,
                          .mats = MATS,
                          .coordinate_count = SIZE,
                          .last_mat = 1};
    double z[2 * SIZE] = {0.0}, rate[2 * SIZE] = {0.0};
    z[SIZE + 3] = v_ft_s;
    rate[SIZE + 3] = a_ft_s2;
    struct stepper stepper = {.kind = &kind, .model = &model, .min_step_s = 1e-14, .z = z};
    double h_s = 1e-3, before_s = h_s;
    bool cut = stepper_end_at_reversal(&stepper, rate, &h_s);
    assert_int_equal(cut, h_s < before_s);
    return h_s;
}

TEST(a_step_ends_before_and_within)
{
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        /* at 0.1 ft/s, slowed by 400 ft/s^2: 0.04 ft/s is reached after 0.15 ms */
        near(step_s(SIM_FRICTION_TANH, 4.0, way * 0.1, way * -400.0), 1.5e-4, 1e-15);
        /* from there to rest, and from rest to the other edge: 0.1 ms each */
        near(step_s(SIM_FRICTION_TANH, 4.0, way * 0.04, way * -400.0), 1e-4, 1e-15);
        near(step_s(SIM_FRICTION_TANH, 4.0, 0.0, way * -400.0), 1e-4, 1e-15);
        /* twice as narrow: 0.02 ft/s after 0.2 ms */
        near(step_s(SIM_FRICTION_TANH, 2.0, way * 0.1, way * -400.0), 2e-4, 1e-15);
    }
}

TEST(other_steps_are_left_alone)
{
    assert_true(step_s(SIM_FRICTION_TANH, 4.0, 0.1, 400.0) == 1e-3); /* it goes faster */
    assert_true(step_s(SIM_FRICTION_TANH, 4.0, 0.5, -400.0) ==
                1e-3); /* it slows down to 0.1 ft/s */
    assert_true(step_s(SIM_FRICTION_TANH, 4.0, -0.05, -400.0) == 1e-3); /* it has turned */
    assert_true(step_s(SIM_FRICTION_TANH, 4.0, 0.005, -9.0) ==
                1e-3); /* less than veps: it is smooth */
    assert_true(step_s(SIM_FRICTION_TANH, 4.0, 0.1, -(double)INFINITY) ==
                1e-3);                                                 /* the step will fail */
    assert_true(step_s(SIM_FRICTION_STICK, 4.0, 0.1, -400.0) == 1e-3); /* it stops there, located */
    assert_true(step_s(SIM_FRICTION_TANH, 4.0, 0.0, 0.0) == 1e-3);
}

/* Not cut, tolerances from 1e-3 to 1e-5 end 9e-6 to 6e-5 ft from the truth: the jump is within the
 * tolerance of each step, and finer steps meet it by chance. */
TEST(loose_tolerances_do_not_lie)
{
    const double bump[] = {0.0099, 0.02, 0.0099};
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    sim_scene_set_list(&scene.bump_ft, bump, 3);
    scene.mats = 30;
    scene.mats_crossed = 3.0;
    scene.friction_law = SIM_FRICTION_TANH;
    scene.veps_ft_s = 1e-2;
    struct sim_result truth, result;
    struct sim_options fine = {.solver = "implicit", .rtol = 1e-11};
    if (sim_run(&scene, &fine, &truth, &error) != MR_OK)
        fail_msg("%s", error.text);
    for (double rtol = 1e-3; rtol > 5e-6; rtol *= sqrt(0.1)) {
        struct sim_options options = {.solver = "event", .rtol = rtol};
        if (sim_run(&scene, &options, &result, &error) != MR_OK)
            fail_msg("%s", error.text);
        near(result.max_lift_ft, truth.max_lift_ft, 3e-6);
        for (int n = 1; n <= scene.mats; n++)
            near(result.u_ft[n], truth.u_ft[n], 3e-6);
        sim_result_free(&result);
    }
    sim_result_free(&truth);
    sim_scene_free(&scene);
}
