/* Viscous damping by the ground, in every engine: against closed forms (a mat that slides, one on a
 * spring), against CVODE, when it is stiff, and when it is absent. Units ft, lb, s. */

#include "host/sim/elements/element.h"
#include "host/sim/elements/law.h"
#include "host/sim/models/model.h"
#include "tests/host/sim_case.h"

/* Every engine, and how near it comes to a closed form, as a part of the largest value: of its own
 * order and default step. */
static const struct engine {
    enum sim_model model;
    const char *solver;
    double near;
} engines[] = {
    {SIM_MODEL_CHAIN, "staggered", 1e-4},  {SIM_MODEL_CONSISTENT, "staggered", 1e-4},
    {SIM_MODEL_REPORT, "event", 1e-6},     {SIM_MODEL_REPORT, "implicit", 2e-5},
    {SIM_MODEL_REPORT, "cvode", 2e-5},     {SIM_MODEL_REPORT, "rk4", 2e-5},
    {SIM_MODEL_REPORT, "rkgs", 1e-4},      {SIM_MODEL_REPORT, "hamming", 1e-4},
    {SIM_MODEL_CONSISTENT, "event", 1e-6}, {SIM_MODEL_CONSISTENT, "implicit", 2e-5},
    {SIM_MODEL_CONSISTENT, "cvode", 2e-5},
};

/* A single mat on level ground, nothing joined to it, no dry friction; half its weight on either
 * end. */
static struct sim_scene one_mat(double c)
{
    struct sim_scene s;
    sim_scene_set_defaults(&s);
    s.mats = 1;
    s.left_end = s.right_end = SIM_END_FREE;
    s.force_lb = s.vac_ft_s = s.friction = 0.0;
    s.v0_ft_s = 3.0;
    s.t_end_s = 0.5;
    s.element_values[ELEMENT_ground_damping] = c;
    return s;
}

static double mass(const struct sim_scene *s)
{
    return s->weight_lb / s->g_ft_s2;
}

static void times(struct sim_scene *s, const double *at_s, size_t count)
{
    sim_scene_set_list(&s->t_out_s, at_s, count);
}

static struct sim_result good(const struct sim_scene *scene, const char *solver)
{
    return run(scene, (struct sim_options){.solver = solver});
}

/* Run in every engine; u of mat 1 at the scene's times against `expected`. */
static void holds_everywhere(struct sim_scene *scene, const double *at_s, const double *expected,
                             size_t count)
{
    double largest = 0.0;
    times(scene, at_s, count);
    for (size_t k = 0; k < count; k++)
        largest = fmax(largest, fabs(expected[k]));
    for (size_t i = 0; i < COUNT_OF(engines); i++) {
        scene->model = engines[i].model;
        struct sim_result result = good(scene, engines[i].solver);
        for (size_t k = 0; k < count; k++) {
            double off = fabs(result.outputs[k].u_ft[1] - expected[k]);
            if (!(off <= engines[i].near * largest))
                fail_msg("%s %s at %g s: %.10g, closed form %.10g", sim_model_name(scene->model),
                         engines[i].solver, at_s[k], result.outputs[k].u_ft[1], expected[k]);
        }
        sim_result_free(&result);
    }
    sim_scene_free(scene);
}

/* m v' = -c v: u = m v0/c (1 - exp(-c t/m)). */
TEST(a_sliding_mat_slows_exponentially)
{
    struct sim_scene scene = one_mat(20.0);
    const double at_s[] = {0.05, 0.1, 0.25, 0.5}, c = 20.0;
    double expected[4];
    for (size_t k = 0; k < 4; k++)
        expected[k] = mass(&scene) * 3.0 / c * (1.0 - exp(-c * at_s[k] / mass(&scene)));
    holds_everywhere(&scene, at_s, expected, 4);
}

/* With dry friction C beside it: v + C/c falls exponentially until v = 0, at t = m/c ln(1 + c
 * v0/C), after m v0/c - C t/c. */
TEST(dry_friction_stops_it)
{
    struct sim_scene scene = one_mat(20.0);
    scene.friction = 0.1;
    const double c = 20.0, dry = 16.0, m = mass(&scene), stop_s = m / c * log(1.0 + c * 3.0 / dry);
    const double at_s[] = {0.1, 0.2, 0.499};
    double expected[3];
    assert_true(stop_s > 0.2 && stop_s < 0.45);
    for (size_t k = 0; k < 3; k++) {
        double t = fmin(at_s[k], stop_s);
        expected[k] = m / c * (3.0 + dry / c) * (1.0 - exp(-c * t / m)) - dry / c * t;
    }
    holds_everywhere(&scene, at_s, expected, 3);
}

/* A joint is a spring KL: w = sqrt(KL/m - (c/2m)^2), u = v0/w exp(-c t/2m) sin w t; from peak to
 * peak of one sign the logarithm falls by the decrement pi c/(m w). */
TEST(a_mat_on_a_spring_has_its_frequency_and_decrement)
{
    struct sim_scene scene = one_mat(20.0);
    scene.left_end = SIM_END_FIXED;
    scene.kl_lb_ft = 5000.0;
    scene.cl_lb_s_ft = 0.0;
    const double c = 20.0, m = mass(&scene), half = 0.5 * c / m,
                 w = sqrt(scene.kl_lb_ft / m - half * half);
    const double period_s = 2.0 * 3.14159265358979323846 / w;
    double at_s[6], expected[6];
    for (int k = 0; k < 6; k++) { /* zeros and slopes' ends: quarters of the damped period */
        at_s[k] = (k + 1) * 0.25 * period_s;
        expected[k] = 3.0 / w * exp(-half * at_s[k]) * sin(w * at_s[k]);
    }
    assert_true(log(expected[0] / expected[4]) > 0.3); /* a decrement that shows */
    struct sim_scene chain = scene;
    chain.t_out_s = (struct sim_list){0};
    chain.model = SIM_MODEL_CHAIN;
    times(&chain, at_s, 6);
    struct sim_result result = good(&chain, "staggered");
    assert_near(log(result.outputs[0].u_ft[1] / result.outputs[4].u_ft[1]), half * period_s, 1e-4);
    sim_result_free(&result);
    sim_scene_free(&chain);
    scene.t_end_s = 1.6 * period_s;
    holds_everywhere(&scene, at_s, expected, 6);
}

/* A whole strip with a bow wave, friction and damped ground: CVODE's BDF and the others. */
TEST(cvode_agrees)
{
    static const double bump[] = {0.0099, 0.0200, 0.0099};
    for (int model = SIM_MODEL_REPORT; model <= SIM_MODEL_CONSISTENT; model++) {
        struct sim_scene scene;
        sim_scene_set_defaults(&scene);
        scene.model = (enum sim_model)model;
        scene.mats = 12;
        scene.mats_crossed = 2.0;
        scene.friction_law = SIM_FRICTION_TANH;
        scene.veps_ft_s = 0.05;
        sim_scene_set_list(&scene.bump_ft, bump, 3);
        struct sim_result bare = good(&scene, "event");
        scene.element_values[ELEMENT_ground_damping] = 200.0;
        struct sim_result cvode = good(&scene, "cvode"), event = good(&scene, "event"),
                          implicit = good(&scene, "implicit");
        for (int n = 1; n <= 12; n++) {
            assert_near(event.u_ft[n], cvode.u_ft[n], 1e-6);
            assert_near(implicit.u_ft[n], cvode.u_ft[n], 1e-5);
        }
        assert_near(event.max_lift_ft, cvode.max_lift_ft, 1e-5);
        assert_true(fabs(bare.u_ft[1] - event.u_ft[1]) > 1e-3); /* of 0.1 ft: the damping is felt */
        sim_result_free(&bare);
        sim_result_free(&cvode);
        sim_result_free(&event);
        sim_result_free(&implicit);
        sim_scene_free(&scene);
    }
}

/* c/m = 2e6 /s under a thrust of 12000 lb: the mat creeps at F/c, 300 mats in a row no less. */
TEST(stiff_damping_stays_stable)
{
    const double c = 1e7;
    for (size_t i = 0; i < COUNT_OF(engines); i++) {
        const char *solver = engines[i].solver;
        struct sim_scene scene = one_mat(c);
        struct sim_result result;
        scene.model = engines[i].model;
        scene.force_lb = 12000.0;
        scene.v0_ft_s = 0.0;
        scene.t_end_s = 0.01;
        if (strcmp(solver, "event") == 0 || strcmp(solver, "rkgs") == 0 ||
            strcmp(solver, "hamming") == 0 || strcmp(solver, "rk4") == 0)
            scene.t_end_s = 0.001; /* explicit: two thousand steps */
        result = good(&scene, solver);
        double m = mass(&scene), t = scene.t_end_s,
               creep = 12000.0 / c * (t - m / c * (1.0 - exp(-c * t / m)));
        assert_near(result.u_ft[1] / creep, 1.0, 1e-3);
        sim_result_free(&result);
    }
}

/* An explicit step has the limit of the fastest rate, c/m; staggered steps, which are exact in the
 * damping, keep theirs. */
TEST(step_limits_hold)
{
    struct sim_scene scene = one_mat(1e7);
    struct sim_result result;
    double m = mass(&scene);
    scene.model = SIM_MODEL_REPORT;
    assert_int_equal(attempt(&scene, "rk4", 0.0, 1e-5, &result), MR_NUMERICS);
    assert_non_null(strstr(error.text, "beyond the stability limit"));
    assert_near(result.dt_limit_s / (2.785 * m / 1e7), 1.0, 0.02);
    sim_result_free(&result);
    scene.t_end_s = 3600.0;
    assert_int_equal(attempt(&scene, "rk4", 0.0, 0.0, &result), MR_USAGE);
    assert_non_null(strstr(error.text, "too many steps"));
    sim_result_free(&result);
    /* a joined chain with dampers: at 0.98 of the limit without ground damping, any ground damping
     * is stable */
    for (double c = 1e-2; c < 1e9; c *= 100.0) {
        struct sim_scene chain;
        sim_scene_set_defaults(&chain);
        chain.model = SIM_MODEL_CHAIN;
        chain.mats = 40;
        chain.friction = 0.05;
        chain.cl_lb_s_ft = 2000.0;
        chain.t_end_s = 0.05;
        assert_int_equal(attempt(&chain, "staggered", 0.0, 1.0, &result), MR_NUMERICS);
        double limit_s = result.dt_limit_s;
        sim_result_free(&result);
        chain.element_values[ELEMENT_ground_damping] = c;
        const struct sim_options options = {
            .solver = "staggered", .dt_s = 0.98 * limit_s, .is_single_pass = true};
        memset(&error, 0, sizeof error);
        if (sim_run(&chain, &options, &result, &error) != MR_OK)
            fail_msg("c %g: %s", c, error.text);
        assert_true(result.dt_limit_s == limit_s);
        /* nothing moves faster, and further, than the thrust's impulse allows */
        double thrust_lb_s = 12000.0 * 0.05;
        assert_true(result.peak_u_ft > 0.0 &&
                    result.peak_u_ft < 0.05 * (thrust_lb_s + m * 2.0) / m);
        assert_true(result.peak_u_ft < 1.1 * (thrust_lb_s + m * 2.0) / c || c < 1e3);
        sim_result_free(&result);
    }
}

/* The exact step: two halves are the whole, also when the mat stops on the way or is thrown
 * back. */
TEST(half_steps_add_up)
{
    struct sim_scene scene = one_mat(20.0);
    struct element_set set = element_set_from_scene(&scene);
    const double m = mass(&scene), dry = 16.0;
    assert_int_equal(set.count, 1);
    for (double v0 = -3.0; v0 < 3.0; v0 += 0.37) {
        for (double x = -60.0; x <= 60.0; x += 7.0) {
            double v[2] = {v0, v0}, h = 0.4;
            for (int way = 0; way < 2; way++) {
                for (int i = 0; i <= way * 15; i++) {
                    unsigned stops = 0;
                    struct element_step step = element_make_step(
                        &set, (struct element_mat){v[way], true}, way ? h / 16.0 : h, m);
                    v[way] = friction_speed_ft_s(step.speed_factor * v[way], x + step.push_lb, dry,
                                                 step.equivalent_s, m, &stops);
                }
            }
            assert_near(v[0], v[1], 1e-12);
        }
    }
}

/* Whoever has both ends off the ground is not damped, one end is enough; the acceleration alone
 * changes, and by -c v/m. */
TEST(a_lifted_mat_is_not_damped)
{
    for (int which = SIM_MODEL_REPORT; which <= SIM_MODEL_CONSISTENT; which++) {
        struct sim_scene scene;
        struct model model;
        double z[14] = {0}, bare[7], damped[7];
        sim_scene_set_defaults(&scene);
        scene.model = (enum sim_model)which;
        scene.mats = 3;
        scene.friction = 0.0;
        scene.element_values[ELEMENT_ground_damping] = 50.0;
        assert_int_equal(model_make(&model, &scene, false, &error), MR_OK);
        model_start(&model, z);
        z[4] = z[6] = -0.05; /* nodes 3 and 4 are up: mat 3 flies, mat 2 has its left foot down */
        for (int n = 0; n < 3; n++)
            z[7 + 2 * n + 1] = 0.5 * (n + 1);
        model_sample_modes(&model, 0.0, z);
        model_rates(&model, 0.0, z, damped);
        model.elements.count = 0;
        model_rates(&model, 0.0, z, bare);
        for (int n = 0; n < 3; n++)
            assert_near(damped[2 * n + 1] - bare[2 * n + 1],
                        n < 2 ? -50.0 * 0.5 * (n + 1) / mass(&scene) : 0.0, 1e-9);
        for (int j = 0; j <= 3; j++)
            assert_true(damped[2 * j] == bare[2 * j]);
        model_free(&model);
    }
}

/* 0 is the default: nothing is evaluated, said or changed, to the last bit. */
TEST(absent_it_is_nothing)
{
    struct sim_scene with, without;
    const char *text[] = {
        "{\"model\": \"chain\", \"N\": 30, \"tend\": 0.05, \"ground_damping\": 0}",
        "{\"model\": \"chain\", \"N\": 30, \"tend\": 0.05}"};
    assert_int_equal(sim_scene_parse(&with, "with", text[0], strlen(text[0]), &error), MR_OK);
    assert_int_equal(sim_scene_parse(&without, "without", text[1], strlen(text[1]), &error), MR_OK);
    assert_int_equal(element_set_from_scene(&with).count, 0);
    struct sim_result a = good(&with, "staggered"), b = good(&without, "staggered");
    assert_memory_equal(a.u_ft, b.u_ft, 31 * sizeof *a.u_ft);
    assert_int_equal(a.evaluations, b.evaluations);
    for (int i = 0; i < SIM_NOTES_MAX; i++)
        assert_null(strstr(a.notes[i], "ground damping"));
    with.element_values[ELEMENT_ground_damping] = 5.0;
    struct sim_result c = good(&with, "staggered");
    bool said = false;
    for (int i = 0; i < SIM_NOTES_MAX; i++)
        said = said || strstr(c.notes[i], "ground damping: 5 lb s/ft");
    assert_true(said && c.u_ft[1] != a.u_ft[1]);
    sim_result_free(&a);
    sim_result_free(&b);
    sim_result_free(&c);
}

/* 175.126835246476 N s/m are 12 lb s/ft (1 lb = 4.4482216152605 N, 1 ft = 0.3048 m). */
TEST(the_key_has_a_unit)
{
    struct sim_scene scene;
    const char *text = "{\"ground_damping\": \"175.126835246476 N s/m\"}",
               *wrong = "{\"ground_damping\": -1}", *force = "{\"ground_damping\": \"12 lb\"}";
    memset(&error, 0, sizeof error);
    assert_int_equal(sim_scene_parse(&scene, "scene", text, strlen(text), &error), MR_OK);
    assert_near(scene.element_values[ELEMENT_ground_damping], 12.0, 1e-12);
    assert_int_equal(sim_scene_parse(&scene, "scene", wrong, strlen(wrong), &error), MR_MALFORMED);
    assert_non_null(strstr(error.text, "ground_damping is -1"));
    memset(&error, 0, sizeof error);
    assert_int_equal(sim_scene_parse(&scene, "scene", force, strlen(force), &error), MR_MALFORMED);
    assert_non_null(strstr(error.text, "a force instead of a damping"));
    assert_non_null(strstr(error.text, "N s/m"));
    memset(&error, 0, sizeof error);
}
