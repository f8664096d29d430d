/* Extremes of both planar models: each ends with an answer that other solvers confirm, or refused
 * with the right status.
 *
 * The standard scenes shortened to 16 mats and one mat crossed (two in the consistent model), one
 * thing changed at a time. Solvers are held to ten times the two error estimates together; what an
 * extreme must be beyond that comes from closed forms, or from what a wave cannot reach. Units ft,
 * lb, s. */

#include "tests/long.h"
#include "tests/host/sim_case.h"

static const char *const bases[] = {"host/scenes/rstar_fig3_7.json",
                                    "host/scenes/consistent_fig3_7.json"};

static struct sim_scene standard(size_t base)
{
    struct sim_scene scene = load(bases[base]);
    scene.mats = 16;
    scene.mats_crossed = base == 0 ? 1.0 : 2.0;
    sim_scene_set_list(&scene.t_out_s, NULL, 0);
    return scene;
}

static void flatten(struct sim_scene *scene)
{
    sim_scene_set_list(&scene->bump_ft, NULL, 0);
}

static void damped_soil(struct sim_scene *s)
{
    s->cv_lb_s_ft *= 1000.0;
}
static void light(struct sim_scene *s)
{
    s->weight_lb /= 1000.0, s->inertia_slug_ft2 /= 1000.0;
}
static void light_but_inert(struct sim_scene *s)
{
    s->weight_lb /= 1000.0;
}
static void stiff(struct sim_scene *s)
{
    s->kl_lb_ft *= 100.0;
}
static void pushed(struct sim_scene *s)
{
    s->force_lb *= 10.0;
}
static void rough(struct sim_scene *s)
{
    s->friction = 5.0;
}
static void no_free_turn(struct sim_scene *s)
{
    s->tad_deg = 0.0;
}
static void no_free_turn_switched(struct sim_scene *s)
{
    s->tad_deg = 0.0, s->tad_mode = SIM_TAD_SWITCHED;
}
static void some_slack(struct sim_scene *s)
{
    s->slack_ft = 0.005;
}
static void much_slack(struct sim_scene *s)
{
    s->slack_ft = 0.5;
}
static void at_rest(struct sim_scene *s)
{
    s->v0_ft_s = 0.0;
}
static void one_mat(struct sim_scene *s)
{
    s->mats = 1, s->mats_crossed = 0.5, flatten(s);
}

enum solvers { EVENT = 1, IMPLICIT = 2, CVODE = 4, ALL = 7 };
static const char *const names[] = {"event", "implicit", "cvode"};

struct extreme {
    const char *name;
    void (*change)(struct sim_scene *scene);
    unsigned solvers[2];       /* held against auto, by base; others need seconds */
    enum sim_status status[2]; /* of all of them */
};

static const struct extreme extremes[] = {
    {"CV x 1000", damped_soil, {IMPLICIT | CVODE, IMPLICIT | CVODE}, {SIM_OK, SIM_OK}},
    {"mass and inertia / 1000", light, {IMPLICIT | CVODE, IMPLICIT}, {SIM_OK, SIM_FOLDED}},
    {"mass / 1000", light_but_inert, {ALL, EVENT | IMPLICIT}, {SIM_OK, SIM_OK}},
    {"KL x 100", stiff, {EVENT | IMPLICIT, EVENT | IMPLICIT}, {SIM_OK, SIM_OK}},
    {"F x 10", pushed, {ALL, ALL}, {SIM_OK, SIM_OK}},
    {"f 5", rough, {ALL, ALL}, {SIM_OK, SIM_OK}},
    {"TAD 0", no_free_turn, {EVENT | IMPLICIT, ALL}, {SIM_OK, SIM_OK}},
    {"TAD 0, switched", no_free_turn_switched, {EVENT | IMPLICIT, ALL}, {SIM_OK, SIM_OK}},
    {"slack 0.005", some_slack, {ALL, ALL}, {SIM_OK, SIM_OK}},
    {"slack 0.5", much_slack, {ALL, ALL}, {SIM_OK, SIM_OK}},
    {"v0 0", at_rest, {ALL, ALL}, {SIM_OK, SIM_OK}},
    {"one mat", one_mat, {ALL, ALL}, {SIM_OK, SIM_OK}},
    {"flat", flatten, {ALL, ALL}, {SIM_OK, SIM_OK}},
};

static void hold_against(const struct sim_result *a, const struct sim_result *b)
{
    double u = 10.0 * (a->error_u_ft + b->error_u_ft) + 1e-9;
    double lift = 10.0 * (a->error_lift_ft + b->error_lift_ft) + 1e-9;
    assert_true(a->error_u_ft <= 0.01 * a->peak_u_ft);
    for (int n = 1; n <= a->mats; n++)
        near(b->u_ft[n], a->u_ft[n], u);
    near(b->max_lift_ft, a->max_lift_ft, lift);
    near(b->outputs[0].lift_ft, a->outputs[0].lift_ft, lift);
    assert_true(a->bow_wave == b->bow_wave);
}

TEST(each_is_answered_and_confirmed_or_refused)
{
    for (size_t i = 0; i < sizeof extremes / sizeof extremes[0]; i++) {
        const struct extreme *e = &extremes[i];
        for (size_t base = 0; base < 2; base++) {
            struct sim_scene scene = standard(base);
            struct sim_result first, other;
            e->change(&scene);
            attempt(&scene, NULL, 0.0, 0.0, &first);
            if (first.status != e->status[base])
                fail_msg("%s: auto: %s", e->name, error.text);
            for (unsigned k = 0; k < tests_take(2, 3); k++) {
                if (!(e->solvers[base] & (1u << k)))
                    continue;
                attempt(&scene, names[k], 0.0, 0.0, &other);
                if (other.status != e->status[base])
                    fail_msg("%s: %s: %s", e->name, names[k], error.text);
                if (other.status == SIM_OK)
                    hold_against(&first, &other);
                sim_result_free(&other);
            }
            sim_result_free(&first);
            sim_scene_free(&scene);
        }
    }
}

/* With TAD 0 a foot hovers at the edge of contact from 0.4 ms on, and is held there by the solvers
 * that locate switches. A fixed step that looks its switches up knows nothing of holding: it lets
 * the foot bounce. */
TEST(a_held_foot_moves_like_one_that_bounces)
{
    const double times[] = {0.005, 0.01, 0.015, 0.0175, 0.02};
    struct sim_scene scene = standard(0);
    struct sim_options fine = {.solver = "rk4", .dt_s = 1e-6};
    struct sim_result bounces, held;
    scene.tad_deg = 0.0;
    sim_scene_set_list(&scene.t_out_s, times, 5);
    assert_int_equal(sim_run(&scene, &fine, &bounces, &error), MR_OK);
    for (size_t k = 0; k < 2; k++) {
        assert_int_equal(attempt(&scene, names[k], 0.0, 0.0, &held), MR_OK);
        for (size_t i = 0; i < 5; i++)
            near(held.outputs[i].lift_ft, bounces.outputs[i].lift_ft, 3e-7);
        sim_result_free(&held);
    }
    sim_result_free(&bounces);
    sim_scene_free(&scene);
}

/* `sign` leaves open what holds a mat at rest; stick is what that must be for there to be a motion
 * at all. rk4 knows nothing of it: it throws such a mat to and fro, less with shorter steps. */
TEST(friction_sign_is_stick_or_refused_with_advice)
{
    for (size_t base = 0; base < 2; base++) {
        struct sim_scene scene = standard(base);
        struct sim_options thrown = {.solver = "rk4", .dt_s = 2e-6, .is_single_pass = true};
        struct sim_result stick, sign, sampled;
        assert_int_equal(attempt(&scene, NULL, 0.0, 0.0, &stick), MR_OK);
        scene.friction_law = SIM_FRICTION_SIGN;
        assert_int_equal(attempt(&scene, NULL, 0.0, 0.0, &sign), MR_OK);
        assert_int_equal(sim_run(&scene, &thrown, &sampled, &error), MR_OK);
        assert_memory_equal(sign.u_ft, stick.u_ft, 17 * sizeof *sign.u_ft);
        for (int n = 1; n <= 16; n++)
            near(sampled.u_ft[n], sign.u_ft[n], 1e-3 * sign.peak_u_ft);
        sim_result_free(&stick);
        sim_result_free(&sign);
        sim_result_free(&sampled);
        assert_int_equal(attempt(&scene, "event", 0.0, 0.0, &sign), MR_NUMERICS);
        assert_int_equal(sign.status, SIM_STEP_UNDERFLOW);
        assert_true(sign.mat >= 1 && sign.t_s > 0.0 && !sign.outputs);
        assert_non_null(strstr(error.text, "mat 1 at"));
        assert_non_null(strstr(error.text, "give friction stick"));
        sim_result_free(&sign);
        sim_scene_free(&scene);
    }
}
