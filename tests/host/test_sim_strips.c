/* Two strips tied in shear: each alone where nothing holds them, closed forms of two mats on a
 * spring, slip, conservation, one strip of double weight where the tie is stiff, an integration of
 * its own, and both engines against each other and against themselves. Units ft, lb, s. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/splitmix.h"
#include "host/sim/elements/mods.h"
#include "host/sim/elements/ties.h"
#include "host/sim/sim.h"
#include "tests/cmocka_all.h"

#define G        32.174
#define MATS     90
#define COUNT(a) (sizeof(a) / sizeof(a)[0])
#define PI       3.14159265358979323846

static struct error error;

static void near_to(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.12g is not %.12g to %g", value, expected, tolerance);
}

static void set(struct sim_list *list, const double *values, size_t count)
{
    assert_int_equal(sim_scene_set_list(list, values, count, &error), MR_OK);
}

static struct sim_result good(const struct sim_scene *scene, struct sim_options options)
{
    struct sim_result result;
    memset(&error, 0, sizeof error);
    options.solver = "fixed";
    if (sim_run(scene, &options, &result, &error) != MR_OK)
        fail_msg("%s", error.text);
    return result;
}

/* The second strip begins as a copy of the first, with lists of its own. */
static struct sim_scene *put_beside(struct sim_scene *scene)
{
    struct sim_scene *beside = calloc(1, sizeof *beside);
    assert_non_null(beside);
    *beside = *scene;
    beside->t_out_s = beside->gap0_ft = beside->grit_lb = beside->ground_ft = (struct sim_list){0};
    beside->gear.lines_ft = beside->gear.axles = beside->u_mats = (struct sim_list){0};
    beside->bump_ft = (struct sim_list){0};
    beside->path = NULL;
    beside->path_count = 0;
    set(&beside->t_out_s, scene->t_out_s.values, scene->t_out_s.count);
    set(&beside->gap0_ft, scene->gap0_ft.values, scene->gap0_ft.count);
    set(&beside->grit_lb, scene->grit_lb.values, scene->grit_lb.count);
    set(&beside->ground_ft, scene->ground_ft.values, scene->ground_ft.count);
    set(&beside->gear.lines_ft, scene->gear.lines_ft.values, scene->gear.lines_ft.count);
    set(&beside->gear.axles, scene->gear.axles.values, scene->gear.axles.count);
    if (scene->path_count > 0)
        assert_int_equal(sim_scene_set_path(beside, scene->path, scene->path_count, &error), MR_OK);
    scene->beside = beside;
    return beside;
}

/* Free mats that nothing rubs: 1 slug each. */
static struct sim_scene floating(enum sim_model model, int mats)
{
    struct sim_scene scene;
    sim_scene_defaults(&scene);
    scene.model = model;
    scene.mats = mats;
    scene.length_ft = 100.0;
    scene.weight_lb = G;
    scene.inertia_slug_ft2 = 1000.0;
    scene.kv_lb_ft = 1e5;
    scene.cv_lb_s_ft = 1e3;
    scene.kl_lb_ft = 400.0;
    scene.cl_lb_s_ft = 0.0;
    scene.left = scene.right = SIM_FREE;
    scene.friction_law = SIM_NONE;
    scene.force_lb = 0.0;
    scene.vac_ft_s = 1.0;
    scene.v0_ft_s = 0.0;
    scene.t_end_s = 1.0;
    return scene;
}

/* The rig's mats, a short runway on which an aircraft stops: seeded openings and dirt. */
static struct sim_scene runway(enum sim_model model, uint64_t seed)
{
    const struct sim_path_row rows[] = {
        {0.0, 2.0, 0.0}, {0.05, 3.4, 22.0}, {0.9, 16.0, 22.0}, {1.2, 17.0, 22.0}, {1.2, 17.0, 0.0}};
    double gap_ft[MATS + 1], grit_lb[MATS + 1];
    struct sim_scene scene;
    sim_scene_defaults(&scene);
    scene.model = model;
    scene.mats = MATS;
    scene.length_ft = 2.0 / 7.0;
    scene.weight_lb = 0.466;
    scene.inertia_slug_ft2 = 1.19e-4;
    scene.kv_lb_ft = 1.3e4;
    scene.cv_lb_s_ft = 60.0;
    scene.kt_lb_ft_rad = 41.6;
    scene.ct_lb_ft_s_rad = 1.57e-4;
    scene.tad_deg = 7.0;
    scene.profile = SIM_FULL;
    scene.kl_lb_ft = 2.9e5;
    scene.cl_lb_s_ft = 5.0;
    scene.slack_ft = 0.0025;
    scene.left = scene.right = SIM_FIXED;
    scene.v0_ft_s = 0.0;
    scene.t_dwell_s = 0.3;
    for (int j = 0; j <= MATS; j++) {
        gap_ft[j] = fmin(0.0025, 0.003 * mr_splitmix64_uniform(&seed));
        grit_lb[j] = 20.0 * mr_splitmix64_uniform(&seed);
    }
    set(&scene.gap0_ft, gap_ft, MATS + 1);
    set(&scene.grit_lb, grit_lb, MATS + 1);
    assert_int_equal(sim_scene_set_path(&scene, rows, COUNT(rows), &error), MR_OK);
    return scene;
}

static void lay_ground(struct sim_scene *scene, uint64_t seed, double most_ft)
{
    double ground_ft[MATS + 1];
    for (int j = 0; j <= MATS; j++)
        ground_ft[j] = most_ft * mr_splitmix64_uniform(&seed);
    set(&scene->ground_ft, ground_ft, MATS + 1);
}

/* Two strips that are alike in nothing: width, openings, dirt, ground, bands on one, cleats on the
 * other, a gear with weight under one alone. */
static struct sim_scene unlike(enum sim_model model)
{
    struct sim_scene scene = runway(model, 1), other = runway(model, 2);
    struct sim_scene *beside = put_beside(&scene);
    set(&beside->gap0_ft, other.gap0_ft.values, MATS + 1);
    set(&beside->grit_lb, other.grit_lb.values, MATS + 1);
    sim_scene_free(&other);
    beside->weight_lb *= 1.4;
    beside->kl_lb_ft *= 1.4;
    beside->mods.band[0].count = 0.5;
    beside->mods.band[0].k_lb_ft = 2000.0;
    scene.mods.cleat_every = 6;
    scene.mods.cleat_hold_lb = 2.0;
    scene.mods.cleat_travel_ft = 0.05;
    beside->wheel_load_lb = 20.0;
    beside->element[1] = 7000.0; /* gear_k_lb_ft */
    if (model == SIM_CONSISTENT) {
        lay_ground(&scene, 3, 0.002);
        lay_ground(beside, 4, 0.003);
    }
    return scene;
}

/* Every bit, but for the sign of a zero: of a joint that never bore anything. */
static void same_values(const double *a, const double *b, int first, int last)
{
    for (int i = first; i <= last; i++) {
        if (!(a[i] == b[i]))
            fail_msg("[%d] is %.17g, not %.17g", i, a[i], b[i]);
    }
}

static void same(const struct sim_result *a, const struct sim_result *b, bool rises)
{
    same_values(a->u_ft, b->u_ft, 1, a->mats);
    same_values(a->gap_ft, b->gap_ft, 1, a->mats + 1);
    same_values(a->push_lb, b->push_lb, 1, a->mats + 1);
    same_values(a->pull_lb, b->pull_lb, 1, a->mats + 1);
    if (rises)
        same_values(a->rise_ft, b->rise_ft, 1, a->mats + 1);
    assert_true(!a->mods == !b->mods);
    for (size_t i = 0; a->mods && i < a->mods->count; i++)
        assert_true(a->mods->values[i] == b->mods->values[i]);
}

static const enum sim_model models[] = {SIM_CHAIN, SIM_CONSISTENT};

static void untied_strips_are_each_alone(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = unlike(models[i]), *beside = scene.beside;
        /* planar: one march; half_the_step_says_the_same has checked ones */
        for (int single = models[i] == SIM_CONSISTENT; single < 2; single++) {
            const struct sim_options options = {.dt_s = 2e-5, .single = single};
            struct sim_result both = good(&scene, options);
            scene.beside = NULL;
            struct sim_result first = good(&scene, options), second = good(beside, options);
            beside->beside = &scene; /* and the other way round */
            struct sim_result round = good(beside, options);
            beside->beside = NULL;
            scene.beside = beside;
            assert_true(first.peak_u_ft > 0.002 && second.peak_u_ft > 0.0005);
            assert_true(first.peak_u_ft != second.peak_u_ft);
            same(&both, &first, models[i] == SIM_CONSISTENT);
            same(both.beside, &second, models[i] == SIM_CONSISTENT);
            same(&round, &second, false);
            same(round.beside, &first, false);
            double error_ft = fmax(first.error_u_ft, second.error_u_ft) * (1.0 - 1e-12);
            assert_true(both.error_u_ft >= error_ft && round.error_u_ft >= error_ft);
            sim_result_free(&round);
            sim_result_free(&both);
            sim_result_free(&first);
            sim_result_free(&second);
        }
        sim_scene_free(&scene);
    }
}

/* Nothing pulls on what moves alike. */
static void twins_do_not_feel_each_other(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = runway(models[i], 5);
        scene.mods.band[0].count = 0.2;
        scene.mods.band[0].k_lb_ft = 2000.0;
        if (models[i] == SIM_CONSISTENT)
            lay_ground(&scene, 6, 0.003);
        const struct sim_options options = {.dt_s = 2e-5, .single = true};
        struct sim_result alone = good(&scene, options);
        put_beside(&scene);
        scene.ties.k_lb_ft = 500.0;
        scene.ties.most_lb = 3.0;
        struct sim_result both = good(&scene, options);
        same(&both, &alone, models[i] == SIM_CONSISTENT);
        same(both.beside, &alone, models[i] == SIM_CONSISTENT);
        for (int n = 1; n <= MATS; n++)
            assert_true(both.tie_ft[n] == 0.0);
        sim_result_free(&alone);
        sim_result_free(&both);
        sim_scene_free(&scene);
    }
}

/* Each mat on a spring to the ground, 400 and 900 lb/ft, 250 lb/ft between them, and 30 lb on the
 * first: 400 a + 250 (a - b) = 30, 900 b = 250 (a - b). */
static void a_slow_push_is_shared_by_stiffness(void **state)
{
    (void)state;
    const struct sim_path_row rows[] = {{0, 50, 0}, {9, 50, 30}, {12, 50, 30}};
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = floating(models[i], 1);
        scene.left = SIM_FIXED;
        scene.cl_lb_s_ft = 20.0;
        scene.t_end_s = 0.0;
        assert_int_equal(sim_scene_set_path(&scene, rows, 3, &error), MR_OK);
        struct sim_scene *beside = put_beside(&scene);
        beside->kl_lb_ft = 900.0;
        for (size_t r = 0; r < 3; r++)
            beside->path[r].force_lb = 0.0;
        scene.ties.k_lb_ft = 250.0;
        struct sim_result result = good(&scene, (struct sim_options){0});
        double b = 30.0 / (400.0 * 1150.0 / 250.0 + 900.0), a = 1150.0 / 250.0 * b;
        near_to(result.u_ft[1], a, 1e-4 * a);
        near_to(result.beside->u_ft[1], b, 1e-4 * b);
        near_to(result.tie_ft[1], a - b, 1e-4 * a);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* Masses 1 and 3 slug on 48 lb/ft: rate sqrt(48 (1 + 1/3)) = 8 rad/s; the first begins at 2 ft/s,
 * so their common centre goes at 0.5 ft/s. */
static void two_free_mats_swing_about_their_centre(void **state)
{
    (void)state;
    const double at_s[] = {0.1, 2.0 * PI / 8.0, 0.9, 1.0};
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = floating(models[i], 1);
        set(&scene.t_out_s, at_s, COUNT(at_s));
        struct sim_scene *beside = put_beside(&scene);
        beside->weight_lb = 3.0 * G;
        scene.v0_ft_s = 2.0;
        scene.ties.k_lb_ft = 48.0;
        struct sim_result result = good(&scene, (struct sim_options){.dt_s = 1e-4});
        for (size_t k = 0; k < COUNT(at_s); k++) {
            double swing = 2.0 / 8.0 * sin(8.0 * at_s[k]);
            near_to(result.outputs[k].u_ft[1], 0.5 * at_s[k] + 0.75 * swing, 2e-5);
            near_to(result.beside->outputs[k].u_ft[1], 0.5 * at_s[k] - 0.25 * swing, 2e-5);
        }
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* 10 lb on the first mat, and the tie holds 4: from when it slips, at 2.5 (1 - 1/2 cos...) it is a
 * constant force. With a stiff tie that is from the start: 6/1 and 4/3 ft/s2. */
static void beyond_what_it_holds_a_tie_slips(void **state)
{
    (void)state;
    const struct sim_path_row rows[] = {{0, 50, 10}, {1, 50, 10}};
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = floating(models[i], 1);
        assert_int_equal(sim_scene_set_path(&scene, rows, 2, &error), MR_OK);
        struct sim_scene *beside = put_beside(&scene);
        beside->weight_lb = 3.0 * G;
        beside->path[0].force_lb = beside->path[1].force_lb = 0.0;
        scene.ties.k_lb_ft = 1e6;
        scene.ties.most_lb = 4.0;
        struct sim_result result = good(&scene, (struct sim_options){0});
        near_to(result.u_ft[1], 0.5 * 6.0, 3e-3);
        near_to(result.beside->u_ft[1], 0.5 * 4.0 / 3.0, 3e-3);
        near_to(result.tie_ft[1], 4e-6, 1e-9);
        sim_result_free(&result);
        scene.ties.most_lb = 8.0; /* and below it does not: they go together */
        result = good(&scene, (struct sim_options){0});
        near_to(result.u_ft[1], 0.5 * 10.0 / 4.0, 3e-3);
        near_to(result.beside->u_ft[1], 0.5 * 10.0 / 4.0, 3e-3);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* Work into a tie is never less than what it stores more, over any way; equal where it is not to
 * slip. A force is linear over a step, so the trapezoid is exact. */
static void a_tie_gives_back_what_it_stored_at_most(void **state)
{
    (void)state;
    struct sim_scene scene = floating(SIM_CHAIN, 4);
    put_beside(&scene);
    scene.ties.k_lb_ft = 300.0;
    uint64_t seed = 7;
    for (int slips = 0; slips < 2; slips++) {
        struct ties *ties;
        double u[2][5] = {{0}}, before_lb[5] = {0}, work = 0.0, most = 0.0;
        scene.ties.most_lb = slips ? 2.0 : HUGE_VAL;
        assert_int_equal(ties_make(&ties, &scene, &error), MR_OK);
        ties_reset(ties);
        for (int step = 0; step < 20000; step++) {
            double moved[5];
            for (int n = 1; n <= 4; n++) {
                double a = 0.002 * (mr_splitmix64_uniform(&seed) - 0.5),
                       b = 0.002 * (mr_splitmix64_uniform(&seed) - 0.5);
                u[0][n] += a;
                u[1][n] += b;
                moved[n] = a - b;
                before_lb[n] = ties->lb[n];
            }
            ties_pull(ties, (struct ties_view){u[0], 1, 0}, (struct ties_view){u[1], 1, 0}, 1, 4);
            for (int n = 1; n <= 4; n++) {
                assert_true(fabs(ties->lb[n]) <= scene.ties.most_lb * (1 + 1e-12));
                work += 0.5 * (before_lb[n] + ties->lb[n]) * moved[n];
            }
            most = fmax(most, fabs(work - ties_energy_lb_ft(ties)));
            assert_true(work >= ties_energy_lb_ft(ties) - 1e-9);
        }
        assert_true(slips ? most > 1.0 : most < 1e-9);
        ties_free(ties);
    }
    sim_scene_free(&scene);
}

/* Two free runways of 20 mats that hang together by springs and ties alone: what one mat has at the
 * start, all have together for ever, and no more energy. */
static void what_is_pushed_on_one_side_is_not_lost(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = floating(models[i], 20);
        struct sim_scene *beside = put_beside(&scene);
        beside->weight_lb = 2.0 * G;
        scene.v0_ft_s = 3.0;
        scene.v0_mat = 7;
        scene.ties.k_lb_ft = 120.0;
        scene.ties.most_lb = 5.0;
        struct sim_result result = good(&scene, (struct sim_options){.dt_s = 2e-4});
        double sum = 0.0, moved = 0.0;
        for (int n = 1; n <= 20; n++) {
            sum += result.u_ft[n] + 2.0 * result.beside->u_ft[n];
            moved += fabs(result.beside->u_ft[n]);
        }
        near_to(sum, 3.0, 1e-9); /* 3 slug ft/s for 1 s */
        assert_true(moved > 0.1);
        /* 9/2 lb ft: no mat of 1 slug is ever faster than 3 ft/s */
        assert_true(result.speed_end_ft_s < 3.0 && result.beside->speed_end_ft_s < 3.0 / sqrt(2.0));
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* Held together stiffly, two strips are one of the sum of their weights, springs and thrusts. */
static void a_stiff_tie_makes_one_strip_of_two(void **state)
{
    (void)state;
    const struct sim_path_row rows[] = {
        {0.0, 1.0, 0.0}, {0.1, 1.5, 24.0}, {0.5, 4.0, 24.0}, {0.6, 4.0, 0.0}};
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = runway(models[i], 1);
        set(&scene.gap0_ft, NULL, 0);
        set(&scene.grit_lb, NULL, 0);
        scene.slack_ft = 0.0;
        scene.kl_lb_ft = 3000.0;
        scene.profile = SIM_LOW;
        assert_int_equal(sim_scene_set_path(&scene, rows, COUNT(rows), &error), MR_OK);
        struct sim_scene *beside = put_beside(&scene);
        for (size_t r = 0; r < COUNT(rows); r++)
            beside->path[r].force_lb = 0.25 * rows[r].force_lb;
        beside->weight_lb *= 1.5;
        beside->kl_lb_ft *= 1.5;
        beside->cl_lb_s_ft *= 1.5;
        scene.ties.k_lb_ft = 2e6;
        struct sim_result two = good(&scene, (struct sim_options){.single = true});
        struct sim_scene one = runway(models[i], 1);
        set(&one.gap0_ft, NULL, 0);
        set(&one.grit_lb, NULL, 0);
        one.slack_ft = 0.0;
        one.profile = SIM_LOW;
        one.weight_lb *= 2.5;
        one.kl_lb_ft = 2.5 * 3000.0;
        one.cl_lb_s_ft *= 2.5;
        one.kv_lb_ft *= 2.5;
        one.cv_lb_s_ft *= 2.5;
        assert_int_equal(sim_scene_set_path(&one, rows, COUNT(rows), &error), MR_OK);
        for (size_t r = 0; r < COUNT(rows); r++)
            one.path[r].force_lb = 1.25 * rows[r].force_lb;
        struct sim_result alone = good(&one,
                                       (struct sim_options){.dt_s = two.dt_s, .single = true});
        assert_true(alone.peak_u_ft > 0.005);
        for (int n = 1; n <= MATS; n++) {
            near_to(two.u_ft[n], alone.u_ft[n], 5e-3 * alone.peak_u_ft);
            near_to(two.beside->u_ft[n], two.u_ft[n], 1e-3 * alone.peak_u_ft);
        }
        sim_result_free(&two);
        sim_result_free(&alone);
        sim_scene_free(&scene);
        sim_scene_free(&one);
    }
}

/* With ties of every kind: none, soft ones that slip, stiff ones. */
static void the_window_leaves_nothing_out(void **state)
{
    (void)state;
    static const double ties[][2] = {{0.0, 1.0}, {48.0, 0.3}, {48.0, HUGE_VAL}, {2e4, 5.0}};
    for (size_t i = 0; i < COUNT(models); i++) {
        for (size_t k = 0; k < COUNT(ties); k++) {
            struct sim_scene scene = unlike(models[i]);
            scene.ties.k_lb_ft = ties[k][0];
            scene.ties.most_lb = ties[k][1];
            set(&scene.ground_ft, NULL, 0); /* what heaves leaves 1e-13 of a mat out */
            set(&scene.beside->ground_ft, NULL, 0);
            if (models[i] == SIM_CONSISTENT)
                scene.beside->element[1] = scene.beside->wheel_load_lb = 0.0;
            struct sim_options options = {.dt_s = 2e-5, .single = true};
            struct sim_result some = good(&scene, options);
            options.no_prune = true;
            struct sim_result all = good(&scene, options);
            assert_true(some.mats_mean < 0.9 * all.mats_mean);
            same_values(some.u_ft, all.u_ft, 1, MATS);
            same_values(some.beside->u_ft, all.beside->u_ft, 1, MATS);
            if (ties[k][0] > 0.0)
                same_values(some.tie_ft, all.tie_ft, 1, MATS);
            sim_result_free(&some);
            sim_result_free(&all);
            sim_scene_free(&scene);
        }
    }
}

/* Flat mats in the planar engine are the chain's; tied ones too. */
static void flat_strips_are_the_chains(void **state)
{
    (void)state;
    struct sim_scene chain = runway(SIM_CHAIN, 8), planar = runway(SIM_CONSISTENT, 8);
    struct sim_scene *const scenes[] = {&chain, &planar};
    struct sim_result results[2];
    for (size_t i = 0; i < 2; i++) {
        struct sim_scene *beside = put_beside(scenes[i]);
        beside->weight_lb *= 1.5;
        beside->mods.band[0].count = 0.5;
        scenes[i]->ties.k_lb_ft = 30.0;
        scenes[i]->ties.most_lb = 0.5;
        results[i] = good(scenes[i], (struct sim_options){.dt_s = 2e-5, .single = true});
    }
    assert_true(results[0].peak_u_ft > 0.002);
    for (int n = 1; n <= MATS; n++) {
        near_to(results[1].u_ft[n], results[0].u_ft[n], 1e-9);
        near_to(results[1].beside->u_ft[n], results[0].beside->u_ft[n], 1e-9);
        near_to(results[1].tie_ft[n], results[0].tie_ft[n], 1e-9);
    }
    for (size_t i = 0; i < 2; i++) {
        sim_result_free(&results[i]);
        sim_scene_free(scenes[i]);
    }
}

/* A landing ends at rest; what its ties still pull with does not move the runway when the next one
 * begins with it. */
static void what_a_tie_still_holds_is_carried_over(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = runway(models[i], 9);
        put_beside(&scene)->weight_lb *= 1.5;
        scene.ties.k_lb_ft = 10.0;
        scene.ties.most_lb = 0.4;
        const struct sim_options options = {.dt_s = 2e-5, .single = true};
        struct sim_result landing = good(&scene, options);
        double held = 0.0;
        for (int n = 1; n <= MATS; n++)
            held = fmax(held, fabs(10.0 * landing.tie_ft[n]));
        assert_true(held > 0.02 && held <= 0.4 * (1 + 1e-12));
        assert_true(landing.speed_end_ft_s == 0.0 && landing.beside->speed_end_ft_s == 0.0);
        set(&scene.ties.stretch_ft, landing.tie_ft + 1, MATS);
        set(&scene.gap0_ft, landing.gap_ft + 1, MATS + 1);
        set(&scene.beside->gap0_ft, landing.beside->gap_ft + 1, MATS + 1);
        for (size_t r = 0; r < scene.path_count; r++)
            scene.path[r].force_lb = scene.beside->path[r].force_lb = 0.0;
        scene.cl_lb_s_ft = scene.beside->cl_lb_s_ft = 5.0;
        struct sim_result rest = good(&scene, options);
        near_to(rest.peak_u_ft, 0.0, 1e-4);
        for (int n = 1; n <= MATS; n++)
            near_to(rest.tie_ft[n], landing.tie_ft[n], 2e-4);
        sim_result_free(&landing);
        sim_result_free(&rest);
        sim_scene_free(&scene);
    }
}

/* Three mats a strip, held at the left, by classical Runge-Kutta of the rates: the ties' forces are
 * unknowns of their own, q' = k (v - v') unless that goes beyond what they hold. */
#define SMALL   3
#define UNKNOWN (2 * 2 * SMALL + SMALL)
struct small {
    double mass[2], kl[2], cl, veps, rub[2], k, most, force_lb;
};

static void rates(const struct small *s, double t_s, const double *y, double *d)
{
    const double *q = y + 4 * SMALL;
    for (int b = 0; b < 2; b++) {
        const double *u = y + 2 * SMALL * b, *v = u + SMALL;
        for (int n = 0; n < SMALL; n++) {
            double left = s->kl[b] * (u[n] - (n > 0 ? u[n - 1] : 0.0)) +
                          s->cl * (v[n] - (n > 0 ? v[n - 1] : 0.0));
            double right = n + 1 < SMALL ? s->kl[b] * (u[n + 1] - u[n]) + s->cl * (v[n + 1] - v[n])
                                         : 0.0;
            double push = b == 0 && n == 1 ? s->force_lb * sin(6.0 * t_s) : 0.0;
            d[2 * SMALL * b + n] = v[n];
            d[2 * SMALL * b + SMALL + n] =
                (right - left + push + (b == 0 ? -q[n] : q[n]) - s->rub[b] * tanh(v[n] / s->veps)) /
                s->mass[b];
        }
    }
    for (int n = 0; n < SMALL; n++) {
        double rate = s->k * (y[SMALL + n] - y[3 * SMALL + n]);
        bool slips = fabs(q[n]) >= s->most && q[n] * rate > 0.0;
        d[4 * SMALL + n] = slips ? 0.0 : rate;
    }
}

static void march(const struct small *s, double end_s, double h, double *y)
{
    size_t steps = (size_t)round(end_s / h);
    for (size_t i = 0; i < steps; i++) {
        double d[4][UNKNOWN], at[UNKNOWN], t = (double)i * h;
        static const double share[] = {0.0, 0.5, 0.5, 1.0};
        for (int stage = 0; stage < 4; stage++) {
            for (int k = 0; k < UNKNOWN; k++)
                at[k] = y[k] + (stage > 0 ? share[stage] * h * d[stage - 1][k] : 0.0);
            rates(s, t + share[stage] * h, at, d[stage]);
        }
        for (int k = 0; k < UNKNOWN; k++)
            y[k] += h / 6.0 * (d[0][k] + 2.0 * d[1][k] + 2.0 * d[2][k] + d[3][k]);
        for (int k = 4 * SMALL; k < UNKNOWN; k++)
            y[k] = fmax(-s->most, fmin(s->most, y[k]));
    }
}

static void an_integration_of_its_own_says_the_same(void **state)
{
    (void)state;
    static const double most_lb[] = {1e9, 3.0, 1.0};
    const struct small small = {
        .mass = {1.0, 1.7}, .kl = {400.0, 700.0}, .cl = 3.0, .veps = 0.05, .k = 150.0};
    struct sim_path_row rows[4001];
    for (size_t r = 0; r < COUNT(rows); r++) {
        double t = 2.0 * (double)r / 4000.0;
        rows[r] = (struct sim_path_row){t, 150.0, 40.0 * sin(6.0 * t)};
    }
    for (size_t i = 0; i < COUNT(most_lb); i++) {
        struct small s = small;
        double y[UNKNOWN] = {0};
        struct sim_scene scene = floating(SIM_CHAIN, SMALL);
        scene.left = SIM_FIXED;
        scene.t_end_s = 2.0;
        scene.cl_lb_s_ft = 3.0;
        scene.friction_law = SIM_TANH;
        scene.friction = 0.05;
        scene.veps_ft_s = 0.05;
        assert_int_equal(sim_scene_set_path(&scene, rows, COUNT(rows), &error), MR_OK);
        struct sim_scene *beside = put_beside(&scene);
        beside->weight_lb = 1.7 * G;
        beside->kl_lb_ft = 700.0;
        for (size_t r = 0; r < COUNT(rows); r++)
            beside->path[r].force_lb = 0.0;
        scene.ties.k_lb_ft = 150.0;
        scene.ties.most_lb = most_lb[i];
        s.most = most_lb[i];
        s.force_lb = 40.0;
        s.rub[0] = 0.05 * G;
        s.rub[1] = 0.05 * 1.7 * G;
        march(&s, 2.0, 2e-5, y);
        struct sim_result result = good(&scene, (struct sim_options){.dt_s = 2e-5});
        for (int n = 0; n < SMALL; n++) {
            near_to(result.u_ft[n + 1], y[n], 2e-5);
            near_to(result.beside->u_ft[n + 1], y[2 * SMALL + n], 2e-5);
            near_to(result.tie_ft[n + 1] * 150.0, y[4 * SMALL + n], 2e-3);
        }
        assert_true(fabs(y[2]) > 0.01 && fabs(y[2 * SMALL + 2]) > 0.002);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* First order where things rub: half the step, half the error; and every run is checked itself. */
static void half_the_step_says_the_same(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = unlike(models[i]);
        scene.ties.k_lb_ft = 48.0;
        scene.ties.most_lb = 1.0;
        struct sim_result whole = good(&scene, (struct sim_options){.dt_s = 2e-5, .single = true});
        struct sim_result half = good(&scene, (struct sim_options){.dt_s = 1e-5, .single = true});
        struct sim_result checked = good(&scene, (struct sim_options){0});
        double sum = 0.0, peak = fmax(half.peak_u_ft, half.beside->peak_u_ft);
        for (int n = 1; n <= MATS; n++)
            sum += pow(whole.u_ft[n] - half.u_ft[n], 2.0) +
                   pow(whole.beside->u_ft[n] - half.beside->u_ft[n], 2.0);
        near_to(sqrt(sum / (2.0 * MATS)), 0.0, 0.03 * peak);
        for (int n = 1; n <= MATS; n++) {
            near_to(checked.u_ft[n], half.u_ft[n], fmax(checked.error_u_ft, 0.05 * peak));
            near_to(checked.beside->u_ft[n], half.beside->u_ft[n],
                    fmax(checked.error_u_ft, 0.05 * peak));
        }
        sim_result_free(&whole);
        sim_result_free(&half);
        sim_result_free(&checked);
        sim_scene_free(&scene);
    }
}

/* The step limit knows the ties: at nine tenths of it nothing grows. */
static void stiff_ties_are_stable(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(models); i++) {
        for (double k = 1e3; k < 2e7; k *= 10.0) {
            struct sim_scene scene = runway(models[i], 10);
            scene.t_end_s = 0.25;
            put_beside(&scene)->weight_lb *= 0.5;
            scene.ties.k_lb_ft = k;
            struct sim_result found = good(&scene, (struct sim_options){.single = true});
            struct sim_result result =
                good(&scene, (struct sim_options){.dt_s = 0.9 * found.dt_limit_s, .single = true});
            assert_true(result.peak_u_ft < 0.1 && result.speed_end_ft_s < 5.0);
            sim_result_free(&found);
            sim_result_free(&result);
            sim_scene_free(&scene);
        }
    }
}

/* One strip is thrown up and folds; the other is told as interrupted, by what it had come to. */
static void a_fold_is_of_one_strip(void **state)
{
    (void)state;
    static const double bump_ft[] = {0.16, 0.33, 0.16};
    for (int right = 0; right < 2; right++) {
        struct sim_scene scene, *beside;
        struct sim_result result;
        sim_scene_defaults(&scene);
        scene.model = SIM_CONSISTENT;
        scene.bump_first = 5;
        scene.v0_ft_s = 0.0;
        scene.t_end_s = 0.2;
        beside = put_beside(&scene);
        set(right ? &beside->bump_ft : &scene.bump_ft, bump_ft, COUNT(bump_ft));
        (right ? beside : &scene)->force_lb = 120000.0;
        memset(&error, 0, sizeof error);
        const struct sim_options options = {.solver = "fixed", .single = true};
        assert_int_equal(sim_run(&scene, &options, &result, &error), MR_NUMERICS);
        assert_int_equal(result.status, SIM_FOLDED);
        assert_int_equal(result.ended_beside, right);
        assert_int_equal(result.beside->status, right ? SIM_FOLDED : SIM_INTERRUPTED);
        assert_true(!result.u_ft && (right ? !result.beside->u_ft : result.beside->u_ft != NULL));
        const double *up = right ? result.beside->rise_ft : result.rise_ft,
                     *flat = right ? result.rise_ft : result.beside->rise_ft;
        double most[2] = {0.0, 0.0};
        for (int j = 1; j <= scene.mats + 1; j++) {
            most[0] = fmax(most[0], up[j]);
            most[1] = fmax(most[1], flat[j]);
        }
        assert_true(most[0] > 0.1 && most[1] < 1e-3);
        assert_true(result.t_s > 0.0 && result.mat >= 1 && result.mat <= scene.mats);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

static void refused(const char *text, const char *says)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    assert_int_equal(sim_scene_parse(&scene, "made", text, strlen(text), &error), MR_MALFORMED);
    if (!strstr(error.text, says))
        fail_msg("%s: does not say: %s", error.text, says);
}

static void a_strip_beside_is_read_and_checked(void **state)
{
    (void)state;
    const char *text =
        "{\"N\": 3, \"W\": 5, \"f\": 0.3, \"gap0\": [0, 1, 2, 3], \"wheel_load\": 2, "
        "\"beside\": {\"W\": 7, \"wheel_load\": 0, \"_why\": \"wider\"}, "
        "\"shear_lb_ft\": \"1 lb/ft\", \"shear_lb\": 8, \"shear_ft\": [1, 2, 3]}";
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    if (sim_scene_parse(&scene, "made", text, strlen(text), &error) != MR_OK)
        fail_msg("%s", error.text);
    assert_true(scene.weight_lb == 5.0 && scene.beside->weight_lb == 7.0);
    assert_true(scene.beside->friction == 0.3 && scene.beside->gap0_ft.values[3] == 3.0);
    assert_true(scene.wheel_load_lb == 2.0 && scene.beside->wheel_load_lb == 0.0);
    assert_true(scene.ties.k_lb_ft == 1.0 && scene.ties.most_lb == 8.0);
    assert_true(scene.ties.stretch_ft.values[2] == 3.0 && !scene.beside->beside);
    assert_true(scene.beside->ties.k_lb_ft == 0.0);
    scene.beside->mats = 4;
    assert_int_equal(sim_scene_check(&scene, "made", &error), MR_MALFORMED);
    sim_scene_free(&scene);
    refused("{\"beside\": 3}", "beside is a number; give an object of scene keys");
    refused("{\"beside\": {\"w\": 3}}", "made: beside: \"w\"; write \"W\"");
    refused("{\"beside\": {\"W\": -1}}", "made: beside: W is -1");
    refused("{\"beside\": {\"N\": 3}}", "beside has N otherwise");
    refused("{\"beside\": {\"Vac\": 3}}", "beside has the aircraft's way otherwise");
    refused("{\"beside\": {\"tend\": 3}}", "beside has its end or t_out otherwise");
    refused("{\"beside\": {\"model\": \"chain\"}}", "beside has model otherwise");
    refused("{\"beside\": {\"beside\": {}}}", "beside has beside");
    refused("{\"beside\": {\"shear_lb\": 3}}", "beside has shear_lb");
    refused("{\"shear_lb_ft\": 3}", "shear_lb_ft or shear_ft without beside");
    refused("{\"N\": 3, \"beside\": {}, \"shear_ft\": [1, 2]}", "shear_ft has 2 values");
    static const struct {
        enum sim_model model;
        const char *solver, *says;
    } others[] = {
        {SIM_REPORT, "auto", "beside in model report"},
        {SIM_CONSISTENT, "event", "beside with a solver that chooses its step"},
    };
    for (size_t i = 0; i < COUNT(others); i++) {
        struct sim_result result;
        struct sim_scene two = floating(others[i].model, 3);
        put_beside(&two);
        memset(&error, 0, sizeof error);
        assert_int_equal(
            sim_run(&two, &(struct sim_options){.solver = others[i].solver}, &result, &error),
            MR_USAGE);
        assert_non_null(strstr(error.text, others[i].says));
        sim_result_free(&result);
        sim_scene_free(&two);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(untied_strips_are_each_alone),
        cmocka_unit_test(twins_do_not_feel_each_other),
        cmocka_unit_test(a_slow_push_is_shared_by_stiffness),
        cmocka_unit_test(two_free_mats_swing_about_their_centre),
        cmocka_unit_test(beyond_what_it_holds_a_tie_slips),
        cmocka_unit_test(a_tie_gives_back_what_it_stored_at_most),
        cmocka_unit_test(what_is_pushed_on_one_side_is_not_lost),
        cmocka_unit_test(a_stiff_tie_makes_one_strip_of_two),
        cmocka_unit_test(the_window_leaves_nothing_out),
        cmocka_unit_test(flat_strips_are_the_chains),
        cmocka_unit_test(what_a_tie_still_holds_is_carried_over),
        cmocka_unit_test(an_integration_of_its_own_says_the_same),
        cmocka_unit_test(half_the_step_says_the_same),
        cmocka_unit_test(stiff_ties_are_stable),
        cmocka_unit_test(a_fold_is_of_one_strip),
        cmocka_unit_test(a_strip_beside_is_read_and_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
