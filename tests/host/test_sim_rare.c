/* What happens seldom, late, or at a limit to the last bit: a push after a long rest, a path on the
 * clock of the epoch, a thrust that is just what friction holds, a mat that bounces a hundred
 * times. Each against a closed form, and within what the answer states. Units ft, lb, s. */

#include <float.h>

#include "tests/host/sim_case.h"

#define BRAKE (0.5 * G) /* ft/s2, f = 0.5 */
#define EPOCH 1.7e9

static struct sim_scene mat(enum sim_model model)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    sim_scene_set_defaults(&scene);
    scene.model = model;
    scene.mats = 1;
    scene.left_end = scene.right_end = SIM_END_FREE;
    scene.vac_ft_s = scene.v0_ft_s = scene.force_lb = scene.lift_shear_lb = scene.cl_lb_s_ft = 0.0;
    scene.lift_shear = SIM_SHEAR_NONE;
    scene.start_ft = 1.0;
    return scene;
}

/* Twice what friction holds, 160 lb, from push_s for 0.1 s; the aircraft is there from first_s. */
static void push(struct sim_scene *scene, double first_s, double push_s)
{
    const struct sim_path_row rows[] = {{first_s, 1.0, 0.0},      {push_s, 1.0, 0.0},
                                        {push_s, 1.0, 160.0},     {push_s + 0.1, 1.0, 160.0},
                                        {push_s + 0.1, 1.0, 0.0}, {push_s + 1.0, 1.0, 0.0}};
    sim_scene_set_path(scene, rows, 6);
}

/* It gains f g for 0.1 s and loses it again. */
static const double pushed_ft = BRAKE * 0.1 * 0.1;

static struct sim_result solved(const struct sim_scene *scene, const char *solver)
{
    return run(scene, (struct sim_options){.solver = solver});
}

TEST(a_push_after_a_long_rest_is_not_passed_over)
{
    const double rests_s[] = {1.0, 1e4};
    const enum sim_model models[] = {SIM_MODEL_REPORT, SIM_MODEL_CONSISTENT};
    for (size_t k = 0; k < 3; k++) {
        struct sim_scene scene = mat(models[k / 2]);
        push(&scene, 0.0, rests_s[k % 2]);
        struct sim_result result = solved(&scene, "moreau");
        near(result.outputs[0].u_ft[1], pushed_ft, result.error_u_ft);
        assert_true(result.error_u_ft < 1e-3);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* On soil so soft that a step of the landing engine could be 0.45 s long. */
TEST(a_push_is_longer_than_a_step_on_any_soil)
{
    struct sim_scene scene = mat(SIM_MODEL_CONSISTENT);
    push(&scene, 0.0, 1e3);
    scene.kv_lb_ft = 1.0;
    scene.cv_lb_s_ft = 0.0;
    scene.kl_lb_ft = 1.0;
    struct sim_result result = solved(&scene, "staggered");
    near(result.outputs[0].u_ft[1], pushed_ft, result.error_u_ft);
    assert_true(result.error_u_ft < 0.5 * pushed_ft);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* A double shows 1.7e9 s to 2.4e-7 s; counted from the first row the times are those of a path that
 * begins at 0, and so is the answer, to the bit. */
TEST(an_answer_does_not_depend_on_when_the_clock_began)
{
    const struct {
        enum sim_model model;
        const char *solver;
    } engines[] = {{SIM_MODEL_REPORT, NULL},        {SIM_MODEL_REPORT, "event"},
                   {SIM_MODEL_REPORT, "implicit"},  {SIM_MODEL_REPORT, "moreau"},
                   {SIM_MODEL_REPORT, "rkgs"},      {SIM_MODEL_CONSISTENT, NULL},
                   {SIM_MODEL_CONSISTENT, "event"}, {SIM_MODEL_CHAIN, NULL}};
    const double begins_s[] = {0.0, 1000.0, EPOCH};
    for (size_t e = 0; e < sizeof engines / sizeof engines[0]; e++) {
        double first_u_ft[2] = {0.0, 0.0};
        for (size_t b = 0; b < 3; b++) {
            const double at_s = begins_s[b], times_s[] = {at_s + 0.05, at_s + 1.0};
            struct sim_scene scene = mat(engines[e].model);
            push(&scene, at_s, at_s);
            sim_scene_set_list(&scene.t_out_s, times_s, 2);
            struct sim_result result = solved(&scene, engines[e].solver);
            near(result.outputs[0].u_ft[1], 0.5 * BRAKE * 0.05 * 0.05, result.error_u_ft + 1e-9);
            near(result.outputs[1].u_ft[1], pushed_ft, result.error_u_ft + 1e-9);
            for (size_t k = 0; k < 2; k++) {
                near(result.outputs[k].t_s, times_s[k], 2.0 * DBL_EPSILON * at_s);
                if (b == 0)
                    first_u_ft[k] = result.outputs[k].u_ft[1];
                assert_true(result.outputs[k].u_ft[1] == first_u_ft[k]);
            }
            near(result.t_end_s, at_s + 1.0, 2.0 * DBL_EPSILON * at_s);
            assert_true(result.start_s == at_s);
            sim_result_free(&result);
            sim_scene_free(&scene);
        }
    }
}

/* A mat that is thrown slides v0^2/(2 f g). It is thrown at 0, before the aircraft comes; with a
 * path on the clock of the epoch, with its first row. A time before that has the start, an end
 * before it is refused. */
TEST(a_run_begins_with_the_first_row_on_another_clock)
{
    const double thrown_ft = 2.0 * 2.0 / (2.0 * BRAKE);
    const enum sim_model models[] = {SIM_MODEL_REPORT, SIM_MODEL_CHAIN};
    for (size_t k = 0; k < 4; k++) {
        const double first_s = k < 2 ? 0.5 : EPOCH, push_s = k < 2 ? 0.5 : EPOCH + 0.5;
        const double times_s[] = {k < 2 ? 0.3 : EPOCH + 0.3, push_s + 1.0, 0.0};
        struct sim_scene scene = mat(models[k % 2]);
        scene.v0_ft_s = 2.0;
        push(&scene, first_s, push_s);
        sim_scene_set_list(&scene.t_out_s, times_s, 3);
        struct sim_result result = solved(&scene, NULL);
        near(result.outputs[0].u_ft[1], thrown_ft, result.error_u_ft + 1e-9);
        near(result.outputs[1].u_ft[1], thrown_ft + pushed_ft, result.error_u_ft + 1e-9);
        assert_true(result.outputs[2].u_ft[1] == 0.0);
        sim_result_free(&result);
        sim_scene_set_list(&scene.t_out_s, NULL, 0);
        scene.t_end_s = 0.4;
        assert_int_equal(attempt(&scene, NULL, 0.0, 0.0, &result), k < 2 ? MR_OK : MR_MALFORMED);
        if (k >= 2)
            assert_non_null(strstr(error.text, "0.4 s, but the path begins at 1700000000 s"));
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* A clock that is late is coarse, and what moves is known to a few of its steps: up to 1e10 s. */
TEST(a_late_clock_is_in_the_error)
{
    const char *const solvers[] = {"event", "implicit"};
    for (double at_s = 1e6; at_s < 2e10; at_s *= 10.0) {
        for (size_t s = 0; s < 2; s++) {
            struct sim_scene scene = mat(SIM_MODEL_REPORT);
            push(&scene, 0.0, at_s);
            struct sim_result result = solved(&scene, solvers[s]);
            near(result.outputs[0].u_ft[1], pushed_ft, result.error_u_ft);
            assert_true(result.error_u_ft < 1e-4);
            sim_result_free(&result);
            sim_scene_free(&scene);
        }
    }
}

/* A mat at rest stays while |X| <= C, and a mean of equal thrusts is that thrust. */
TEST(a_thrust_at_the_limit_of_friction_moves_nothing)
{
    const double ends_s[] = {0.1, 0.3, 0.5, 0.7, 1.0, 2.0, 3.0, 10.0};
    const double weights_lb[] = {160.0, 100.0, 0.466, 160.0}, frictions[] = {0.5, 0.5, 0.5, 0.25};
    const int counts[] = {1, 3, 10};
    for (size_t i = 0; i < 3 * 8 * 4; i++) {
        struct sim_scene scene = mat(SIM_MODEL_CHAIN);
        scene.mats = counts[i / 32];
        scene.right_end = scene.mats == 10 ? SIM_END_FIXED : SIM_END_FREE;
        scene.weight_lb = weights_lb[i % 4];
        scene.friction = frictions[i % 4];
        scene.force_lb = scene.friction * scene.weight_lb;
        scene.t_end_s = ends_s[i / 4 % 8];
        for (int engine = 0; engine < 2; engine++) {
            struct sim_result result = solved(&scene, engine == 0 ? NULL : "staggered");
            for (int n = 1; n <= scene.mats; n++)
                assert_true(result.u_ft[n] == 0.0);
            sim_result_free(&result);
        }
        sim_scene_free(&scene);
    }
    /* rows of equal thrust, in the engine of landings */
    struct sim_scene scene = mat(SIM_MODEL_CONSISTENT);
    struct sim_path_row rows[8];
    for (int i = 0; i < 8; i++)
        rows[i] = (struct sim_path_row){0.013 * i, 1.0, 80.0};
    sim_scene_set_path(&scene, rows, 8);
    struct sim_result result = solved(&scene, "staggered");
    assert_true(result.u_ft[1] == 0.0);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

struct bounce {
    double kl_lb_ft, v0_ft_s, left_ft, right_ft, t_s;
    bool pressed; /* the soil holds a load, which makes the scene stiff */
};

/* A mat between two springs with play, without loss: free flight, and half a swing at each side. */
static double bounced_ft(const struct bounce *b)
{
    const double w = sqrt(b->kl_lb_ft * G / 160.0), swing_s = 3.14159265358979323846 / w,
                 high_ft = fmin(b->right_ft, 1.0 - b->left_ft),
                 low_ft = fmax(-b->left_ft, b->right_ft - 1.0),
                 flight_s = (high_ft - low_ft) / b->v0_ft_s;
    double t_s = fmod(b->t_s, 2.0 * (flight_s + swing_s));
    if (t_s <= high_ft / b->v0_ft_s)
        return b->v0_ft_s * t_s;
    t_s -= high_ft / b->v0_ft_s;
    if (t_s <= swing_s)
        return high_ft + b->v0_ft_s / w * sin(w * t_s);
    t_s -= swing_s;
    if (t_s <= flight_s)
        return high_ft - b->v0_ft_s * t_s;
    t_s -= flight_s;
    if (t_s <= swing_s)
        return low_ft - b->v0_ft_s / w * sin(w * t_s);
    return low_ft + b->v0_ft_s * (t_s - swing_s);
}

/* Those of some thousand drawn in which two tolerances agreed on what was 3 to 20 times further
 * off. */
TEST(bounces_in_which_two_runs_agree_by_chance)
{
    static const struct bounce bounces[] = {
        {636584.1097157191, 1.7023920383731026, 0.08453324655897443, 0.15475020197728828,
         9.193225061197627, false},
        {4015174.1501925858, 0.87512678633454311, 0.18358657018581115, 0.16881398055293134,
         81.384059560355198, false},
        {144281.93923083812, 2.2507036089722541, 0.076898999894275788, 0.069066267624297489,
         16.749155165572272, false},
        {247015.82591195102, 1.0207819479114362, 0.16512795698335975, 0.16214264177908849,
         20.708958019015981, false},
        {2076117.3695430919, 0.89150199528247032, 0.14749736342010614, 0.099166860544208688,
         6.1935132025454909, false},
        {20858.072787854162, 1.1736141362596293, 0.10731447968851388, 0.11794687120987339,
         48.281853327823875, true},
        {377169.9209267532, 2.375974197917512, 0.10493824365250416, 0.16395421073630823,
         25.068519465076463, true}};
    for (size_t i = 0; i < sizeof bounces / sizeof bounces[0]; i++) {
        const struct bounce *b = &bounces[i];
        struct sim_scene scene = mat(SIM_MODEL_REPORT);
        const double gaps_ft[] = {b->left_ft, b->right_ft};
        scene.left_end = scene.right_end = SIM_END_FIXED;
        scene.kl_lb_ft = b->kl_lb_ft;
        scene.slack_ft = 1.0;
        sim_scene_set_list(&scene.gap0_ft, gaps_ft, 2);
        scene.v0_ft_s = b->v0_ft_s;
        scene.friction_law = SIM_FRICTION_NONE;
        scene.t_end_s = b->t_s;
        if (b->pressed) {
            scene.q1_lb = 100.0;
            scene.cv_lb_s_ft = 2e5;
        }
        struct sim_result result = solved(&scene, "implicit");
        near(result.u_ft[1], bounced_ft(b), result.error_u_ft);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* At 1e12 s implicit has no step left that the clock can show. */
TEST(auto_says_why_it_left_a_method)
{
    struct sim_scene scene = mat(SIM_MODEL_REPORT);
    bool said = false;
    push(&scene, 0.0, 1e12);
    struct sim_result result = solved(&scene, NULL);
    assert_string_equal(result.solver, "event");
    near(result.outputs[0].u_ft[1], pushed_ft, result.error_u_ft);
    for (size_t i = 0; result.notes[i][0]; i++)
        said = said || strcmp(result.notes[i], "auto: implicit reached only 1e+12 s, because the "
                                               "step became too small; event is used instead") == 0;
    assert_true(said);
    sim_result_free(&result);
    sim_scene_free(&scene);
}
