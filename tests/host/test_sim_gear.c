/* Gear on elastic ground, against closed forms of a mat on a spring, balances of energy, and the
 * other engine. Scenes of one mat have mass 1 slug and ends that pull nothing. Units ft, lb, s. */
#include <float.h>

#include "host/sim/elements/gear.h"
#include "tests/host/sim_case.h"
#include "tests/host/model_mat.h"

#define MATS     110
#define COUNT(a) (sizeof(a) / sizeof(a)[0])

/* One mat of 1 slug, 100 ft long, with one axle of 100 lb on it; k 1000 lb/ft, f 0.5: it holds
 * 66.087 lb. */
static struct sim_scene one_mat(enum sim_model model, const struct sim_path_row *rows, size_t count)
{
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    scene.model = model;
    scene.mats = 1;
    scene.length_ft = 100.0;
    scene.weight_lb = G;
    scene.inertia_slug_ft2 = 1000.0;
    scene.kv_lb_ft = 1e5;
    scene.cv_lb_s_ft = 1e3;
    scene.left_end = scene.right_end = SIM_END_FREE;
    scene.v0_ft_s = 0.0;
    scene.wheel_load_lb = 100.0;
    scene.element_values[ELEMENT_gear_ground] = 1000.0;
    sim_scene_set_path(&scene, rows, count);
    return scene;
}

static struct sim_result good(const struct sim_scene *scene, struct sim_options options)
{
    options.solver = "staggered";
    return run(scene, options);
}

static const enum sim_model models[] = {SIM_MODEL_CHAIN, SIM_MODEL_CONSISTENT};

/* F/k under a slow push: 40 lb an axle on 1000 lb/ft. */
TEST(a_held_mat_gives_way_by_force_over_stiffness)
{
    const struct sim_path_row rows[] = {{0, 50, 0}, {2, 50, 40}, {3, 50, 40}};
    for (size_t i = 0; i < COUNT(models); i++) {
        for (double axles = 1.0; axles < 4.0; axles += 1.0) {
            for (double law = 0.0; law < 1.1; law += 0.5) {
                const double behind = 0.0;
                struct sim_scene scene = one_mat(models[i], rows, 3);
                scene.gear.axle_exponent = law;
                sim_scene_set_list(&scene.gear.line_setbacks_ft, &behind, 1);
                sim_scene_set_list(&scene.gear.axle_counts, &axles, 1);
                struct sim_result result = good(&scene, (struct sim_options){0});
                double expected = 40.0 * axles / (1000.0 * pow(axles, law));
                near(result.u_ft[1], expected, 1e-3 * expected);
                sim_result_free(&result);
                sim_scene_free(&scene);
            }
        }
    }
}

/* When the push goes, (1 - rho) of the way is left; when the aircraft goes instead, as much is
 * left of a mat that nothing else holds: what it had (its spring goes with the gear). */
TEST(what_springs_back_is_rho_of_the_way)
{
    const struct sim_path_row rows[] = {
        {0, 50, 0}, {29, 50, 40}, {30, 50, 40}, {59, 50, 0}, {60, 50, 0}};
    const double rhos[] = {1.0, 0.75, 0.5, 0.1};
    for (size_t i = 0; i < COUNT(models); i++) {
        for (size_t k = 0; k < COUNT(rhos); k++) {
            struct sim_scene scene = one_mat(models[i], rows, 5);
            scene.gear.recovered_share = rhos[k];
            struct sim_result result = good(&scene, (struct sim_options){0});
            near(result.u_ft[1], (1.0 - rhos[k]) * 0.040, 0.040e-3 + 1e-9);
            sim_result_free(&result);
            sim_scene_free(&scene);
        }
    }
}

/* Beyond f (W + P) the ground slides: pushed with 20 lb more than it holds for 0.5 s, the mat goes
 * as one under 20 lb against the damper, m v' = 20 - c v with c = sqrt(k m), from F/k on. */
TEST(beyond_its_load_it_slides)
{
    const double limit = 0.5 * (G + 100.0), t = 0.5, c = sqrt(1000.0);
    const struct sim_path_row rows[] = {{0, 50, 0},
                                        {9, 50, limit},
                                        {10, 50, limit},
                                        {10, 50, limit + 20.0},
                                        {10 + t, 50, limit + 20.0}};
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = one_mat(models[i], rows, 5);
        struct sim_result result = good(&scene, (struct sim_options){.dt_s = 1e-4});
        double expected = limit / 1000.0 + 20.0 / c * (t - (1.0 - exp(-c * t)) / c);
        near(result.u_ft[1], expected, 2e-3 * expected);
        sim_result_free(&result);
        sim_scene_free(&scene);
        struct sim_scene held = one_mat(models[i], rows, 3); /* and at the limit it does not */
        result = good(&held, (struct sim_options){0});
        near(result.u_ft[1], limit / 1000.0, 2e-3 * limit / 1000.0);
        sim_result_free(&result);
        sim_scene_free(&held);
    }
}

static uint64_t dice = 7;
static double throw(double low, double high)
{
    dice = dice * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(dice >> 33) / 2147483648.0;
}

/* What the ground has stored: rho q^2/(2 k), k = gear_k_lb_ft touching^gear_axle_law. */
static double stored_lb_ft(const struct gear *gear)
{
    double sum = 0.0;
    for (int i = 0; i < gear->loaded_count; i++) {
        int mat = gear->loaded_mats[i];
        double k = gear->scene->element_values[ELEMENT_gear_ground] *
                   pow(gear->touching_axles[mat], gear->scene->gear.axle_exponent);
        sum += gear->scene->gear.recovered_share * gear->ground_force_lb[mat] *
               gear->ground_force_lb[mat] / (2.0 * k);
    }
    return sum;
}

/* Whatever comes and goes, kinetic energy and what the ground has stored never grow by more than
 * the work of the push, and the ground never holds more than its limit. */
TEST(its_energy_never_grows)
{
    const struct sim_path_row rows[] = {{0, 50, 0}, {1, 50, 0}};
    for (int round = 0; round < 200; round++) {
        struct sim_scene scene = one_mat(SIM_MODEL_CHAIN, rows, 2);
        struct gear *gear;
        double h = pow(10.0, throw(-5, -1)), v = throw(-5, 5);
        scene.element_values[ELEMENT_gear_ground] = pow(10.0, throw(0, 9));
        scene.gear = (struct sim_gear){throw(0, 2), throw(0.05, 1), throw(0, 2), 0.0, {0}, {0}};
        gear = gear_make(&scene);
        gear_reset(gear, h);
        gear->loaded_mats[0] = gear->loaded_count = 1;
        for (int i = 0; i < 400; i++) {
            double before = 0.5 * v * v + (i > 0 ? stored_lb_ft(gear) : 0.0);
            gear_set_touching_axles(
                gear, 1, throw(0, 1) < 0.2 ? throw(0.1, 3) : fmax(gear->touching_axles[1], 0.1));
            double x = throw(-200, 200), limit = throw(0, 100);
            v = gear_solve_mat_speed_ft_s(gear, 1, v, x, limit, h);
            double after = 0.5 * v * v + stored_lb_ft(gear), work = x * v * h;
            assert_true(fabs(gear->ground_force_lb[1]) <= limit * (1.0 + 1e-12));
            if (!(after <= before + work + 1e-9 * (before + fabs(work))))
                fail_msg("round %d step %d: %.12g after %.12g and work %.12g", round, i, after,
                         before, work);
        }
        gear_free(gear);
        sim_scene_free(&scene);
    }
}

/* A gear of four lines over 110 mats of the rig: 28 ft/s at 4.6 ft/s2 and a stop. */
static struct sim_scene rig(enum sim_model model, double foot_mats)
{
    static struct sim_path_row rows[42];
    const double lines[] = {0, 0.77, 2.62, 3.39}, axles[] = {1, 2, 1, 2};
    const double gap = 0.0015, grit = 8.0, v0 = 8.0, a = 4.6, thrust = 1300.0 / 12.0 * a / G;
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    scene.model = model;
    scene.mats = MATS;
    model_mat_planar(&scene);
    scene.ct_lb_ft_s_rad = 1.57e-4;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.v0_ft_s = 0.0;
    scene.t_dwell_s = 0.3;
    scene.wheel_load_lb = 108.3;
    scene.element_values[ELEMENT_gear_ground] = 7000.0;
    scene.gear.axle_length_ft = foot_mats * scene.length_ft;
    sim_scene_set_list(&scene.gear.line_setbacks_ft, lines, 4);
    sim_scene_set_list(&scene.gear.axle_counts, axles, 4);
    sim_scene_set_list(&scene.gap0_ft, &gap, 1);
    sim_scene_set_list(&scene.grit_lb, &grit, 1);
    for (int i = 0; i <= 40; i++) {
        double t = v0 / a * i / 40.0, on = fmin(1.0, t / 0.1);
        rows[i] = (struct sim_path_row){t, 5.0 + v0 * t - 0.5 * a * t * t, thrust * on};
    }
    rows[41] = (struct sim_path_row){rows[40].t_s, rows[40].x_ft, 0.0};
    sim_scene_set_path(&scene, rows, 42);
    return scene;
}

/* Where nothing heaves, heights and weight change nothing of the movement. Profile low, so that
 * settling does not pull. */
TEST(the_planar_engine_moves_as_the_chain)
{
    struct sim_scene chain = rig(SIM_MODEL_CHAIN, 1.0), planar = rig(SIM_MODEL_CONSISTENT, 1.0);
    struct sim_options options = {.dt_s = 2e-5, .is_single_pass = true};
    struct sim_result a = good(&chain, options), b = good(&planar, options);
    for (int n = 1; n <= MATS; n++)
        near(b.u_ft[n], a.u_ft[n], 1e-9);
    assert_true(a.peak_u_ft > 0.02 / 12.0); /* inches: it does move */
    assert_true(a.integrated_mats_max < MATS);
    sim_result_free(&a);
    sim_result_free(&b);
    sim_scene_free(&chain);
    sim_scene_free(&planar);
}

/* Mats left out: the same movement; with heights, up to what the window neglects. */
TEST(the_window_changes_nothing)
{
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_scene scene = rig(models[i], 0.0);
        struct sim_options options = {.is_single_pass = true};
        struct sim_result few = good(&scene, options);
        options.integrates_all_mats = true;
        struct sim_result all = good(&scene, options);
        for (int n = 1; n <= MATS; n++)
            near(few.u_ft[n], all.u_ft[n], models[i] == SIM_MODEL_CHAIN ? 0.0 : 1e-9);
        sim_result_free(&few);
        sim_result_free(&all);
        sim_scene_free(&scene);
    }
}

/* A ratchet without plasticity: what the gear pushed ahead stays pushed, and no mat behind it is
 * moved by its own ground for good; without weight it goes much farther. */
TEST(weight_holds_what_thrust_alone_pushes)
{
    struct sim_scene with = rig(SIM_MODEL_CHAIN, 1.0);
    struct sim_result heavy = good(&with, (struct sim_options){.is_single_pass = true});
    with.element_values[ELEMENT_gear_ground] =
        1e12; /* Coulomb's law: 14 to 16 lb an axle below 54 lb */
    struct sim_result rigid = good(&with, (struct sim_options){.is_single_pass = true});
    assert_true(rigid.peak_u_ft < 1e-6);
    assert_true(heavy.peak_u_ft > 1e-3);
    sim_result_free(&heavy);
    sim_result_free(&rigid);
    sim_scene_free(&with);
}

/* Stiff ground, none, no load, ten times the load: an answer, or a reason. */
TEST(extremes_end_or_say_why)
{
    for (size_t i = 0; i < COUNT(models); i++) {
        for (int k = 0; k < 5; k++) {
            struct sim_scene scene = rig(models[i], 1.0);
            scene.element_values[ELEMENT_gear_ground] = k == 0 ? 7e7
                                                      : k == 1 ? 1e-9
                                                      : k == 4 ? 1e15
                                                               : 7000.0;
            scene.wheel_load_lb = k == 2 ? 0.0 : k == 3 ? 1083.0 : 108.3;
            struct sim_result result = good(&scene, (struct sim_options){.is_single_pass = true});
            assert_true(isfinite(result.peak_u_ft) && result.peak_u_ft < 5.0);
            sim_result_free(&result);
            sim_scene_free(&scene);
        }
        struct sim_scene none = rig(models[i], 1.0);
        struct sim_result result;
        none.element_values[ELEMENT_gear_ground] = 0.0;
        memset(&error, 0, sizeof error);
        assert_int_equal(sim_run(&none, &(struct sim_options){0}, &result, &error), MR_MALFORMED);
        assert_non_null(strstr(error.text, "without gear_k_lb_ft"));
        sim_result_free(&result);
        sim_scene_free(&none);
    }
}

TEST(who_chooses_its_steps_refuses_it)
{
    for (int k = 0; k < 2; k++) {
        struct sim_scene scene = rig(k ? SIM_MODEL_REPORT : SIM_MODEL_CONSISTENT, 0.0);
        struct sim_result result;
        scene.grit_lb.count = 0;
        memset(&error, 0, sizeof error);
        assert_int_equal(sim_run(&scene, &(struct sim_options){.solver = "event"}, &result, &error),
                         MR_USAGE);
        assert_non_null(strstr(error.text, "gear_k_lb_ft"));
        sim_result_free(&result);
        scene.grit_lb.count = 1;
        sim_scene_free(&scene);
    }
}

/* Defaults of the other keys say nothing: the same bits without the stiffness. */
TEST(absent_it_is_nothing)
{
    for (size_t i = 0; i < COUNT(models); i++) {
        struct sim_result result[2];
        for (int k = 0; k < 2; k++) {
            struct sim_scene scene = rig(models[i], 1.0);
            scene.gear.line_setbacks_ft.count = scene.gear.axle_counts.count = 0;
            scene.element_values[ELEMENT_gear_ground] = 0.0;
            if (k)
                scene.gear.damping = scene.gear.recovered_share = scene.gear.axle_exponent = 0.25;
            result[k] = good(&scene, (struct sim_options){.is_single_pass = true});
            scene.gear.line_setbacks_ft.count = 4;
            sim_scene_free(&scene);
        }
        assert_memory_equal(result[0].u_ft, result[1].u_ft, (MATS + 1) * sizeof(double));
        assert_int_equal(result[0].evaluations, result[1].evaluations);
        sim_result_free(&result[0]);
        sim_result_free(&result[1]);
    }
}

/* The lines' parts add up to all axles, the lead axle's first, each at its station. */
TEST(lines_stand_behind_the_lead)
{
    const struct sim_path_row rows[] = {{0, 10.0, 60}, {1, 20.0, 60}};
    const double lines[] = {0, 2.5, 12.0}, axles[] = {1, 2, 4};
    struct sim_scene scene;
    struct gear *gear;
    struct sim_touch touch[SIM_TOUCH_MAX];
    sim_scene_set_defaults(&scene); /* mats of 2 ft */
    scene.element_values[ELEMENT_gear_ground] = 1.0;
    sim_scene_set_list(&scene.gear.line_setbacks_ft, lines, 3);
    sim_scene_set_list(&scene.gear.axle_counts, axles, 3);
    sim_scene_set_path(&scene, rows, 2);
    gear = gear_make(&scene);
    gear_reset(gear, 0.01);
    /* 11.0 to 11.4 ft, 8.5 to 8.9 ft, and 1 ft before the runway */
    assert_int_equal(gear_compute_action(gear, 0.1, 0.14, touch), 2);
    assert_true(touch[0].mat == 6 && touch[1].mat == 5 && gear->lead_mat == 6);
    near(touch[0].thrust_lb, 60.0, 1e-9);
    near(touch[1].thrust_lb, 120.0, 1e-9);
    near(gear->load_share[5], 2.0, 1e-12);
    /* 15.9 to 16.1 ft: over the joint; 13.4 to 13.6; 3.9 to 4.1: over a joint too */
    assert_int_equal(gear_compute_action(gear, 0.59, 0.61, touch), 5);
    near(gear->load_share[8], 0.5, 1e-9);
    near(gear->load_share[9], 0.5, 1e-9);
    near(gear->load_share[7], 2.0, 1e-9);
    near(gear->load_share[2] + gear->load_share[3], 4.0, 1e-9);
    near(gear->load_share[5] + gear->load_share[6], 0.0, 0.0);
    /* a foot of 3 ft in 11.0 to 11.4 ft: 9.7 to 12.7 ft, and 7.2 to 10.2 */
    scene.gear.axle_length_ft = 3.0;
    gear_reset(gear, 0.01);
    gear_compute_action(gear, 0.06, 0.1, touch);
    assert_int_equal(gear_compute_action(gear, 0.1, 0.14, touch), 6);
    near(gear->load_share[5], (0.3 + 2.0 * 2.0) / 3.0, 1e-9); /* 8 to 10 ft */
    near(gear->touching_axles[5], 3.0, 1e-12);
    near(gear->load_share[7], 0.7 / 3.0, 1e-9);
    near(gear->touching_axles[7], 1.0, 1e-12);
    assert_int_equal(gear->lead_mat, 6);
    gear_free(gear);
    sim_scene_free(&scene);
}
