/* What is left out of a planar scene: that it changes nothing, and that it is left out. */

#include "host/sim/elements/element.h"
#include "tests/host/sim_case.h"

/* Fig 3.7 with more mats than the wave reaches; outputs on the way. */
static struct sim_scene long_strip(enum sim_model model, int mats)
{
    struct sim_scene scene;
    const double bump[] = {0.0099, 0.02, 0.0099}, times[] = {0.01, 0.02, 0.03, 0.04};
    sim_scene_set_defaults(&scene);
    scene.model = model;
    scene.mats = mats;
    scene.mats_crossed = 2.0;
    sim_scene_set_list(&scene.bump_ft, bump, 3);
    sim_scene_set_list(&scene.t_out_s, times, 4);
    return scene;
}

static struct sim_result good(const struct sim_scene *scene, const char *solver, bool no_prune)
{
    return run(scene, (struct sim_options){.solver = solver, .integrates_all_mats = no_prune});
}

static void same(const struct sim_result *a, const struct sim_result *b, double apart_ft)
{
    assert_int_equal(a->output_count, b->output_count);
    for (size_t i = 0; i < a->output_count; i++) {
        assert_true(fabs(a->outputs[i].lift_ft - b->outputs[i].lift_ft) <= apart_ft);
        for (int n = 1; n <= a->mats; n++)
            assert_true(fabs(a->outputs[i].u_ft[n] - b->outputs[i].u_ft[n]) <= apart_ft);
    }
    for (int j = 1; j <= a->mats + 1; j++)
        assert_true(fabs(a->gap_ft[j] - b->gap_ft[j]) <= 2.0 * apart_ft);
    assert_true(fabs(a->max_lift_ft - b->max_lift_ft) <= apart_ft);
}

/* 1e-9: what the issue of leaving mats out may cost; what is found is below 1e-10. */
TEST(leaving_mats_out_changes_nothing)
{
    for (int variant = 0; variant < 12; variant++) {
        struct sim_scene scene = long_strip(variant % 2 ? SIM_MODEL_CONSISTENT : SIM_MODEL_REPORT,
                                            160);
        const char *solver = "event";
        double prestress[161] = {0};
        if (variant == 2 || variant == 3) {
            scene.friction_law = SIM_FRICTION_TANH;
            scene.veps_ft_s = 1e-2;
        }
        if (variant == 4)
            solver = "implicit";
        if (variant == 5) {
            /* pressed down, pushed from afar, jumping thrust replaced by a shared one */
            scene.wheel_load_lb = 2000.0;
            scene.thrust = SIM_THRUST_LINEAR;
            scene.start_ft = 90.0;
            scene.friction_normal = SIM_NORMAL_SOIL;
        }
        if (variant == 6) { /* torsion acts at any angle: mats do not stay flat by themselves */
            scene.tad_deg = 0.0;
            scene.lift_shear = SIM_SHEAR_NONE;
            scene.kt_lb_ft_rad = 2e4;
        }
        if (variant == 7) { /* slack, and a joint far away that starts under load */
            scene.slack_ft = 0.02;
            prestress[120] = -1e-4;
            sim_scene_set_list(&scene.gap0_ft, prestress, 161);
            scene.bump_first = 40;
        }
        if (variant == 8) { /* the bump is far from the wheel, both start moving */
            scene.bump_first = 100;
            scene.v0_mat = 60;
            scene.start_ft = 119.0;
        }
        if (variant >= 9) { /* damped ground: event, implicit */
            scene.element_values[ELEMENT_ground_damping] = 100.0;
            solver = variant == 11 ? "implicit" : "event";
        }
        struct sim_result pruned = good(&scene, solver, false), whole = good(&scene, solver, true);
        same(&pruned, &whole, 1e-9);
        assert_int_equal(whole.integrated_mats_max, 160);
        assert_true(whole.integrated_mats_mean > 159.99);
        if (variant != 7)
            assert_true(pruned.integrated_mats_mean < 130.0);
        assert_true(pruned.peak_u_ft > 1e-3);
        sim_result_free(&pruned);
        sim_result_free(&whole);
        sim_scene_free(&scene);
    }
}

/* The consistent model's mass matrix carries a load to all nodes at once, far when mats are short
 * and heavy to turn. Samples before the load comes, and after. */
TEST(a_load_is_felt_as_far_as_the_mass_matrix_carries_it)
{
    static const struct {
        const char *solver;
        double length_ft, inertia, apart_ft;
    } cases[] = {
        {"event", 0.5, 2.0, 1e-13}, {"event", 0.3, 20.0, 1e-12}, {"staggered", 0.5, 2.0, 1e-13}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct sim_scene scene = long_strip(SIM_MODEL_CONSISTENT, 160);
        double stations[160];
        scene.length_ft = cases[i].length_ft;
        scene.inertia_slug_ft2 = cases[i].inertia;
        scene.bump_ft.count = 0;
        scene.t_out_s.count = 0;
        scene.wheel_load_lb = 2000.0;
        scene.start_ft = 80.2 * scene.length_ft;
        scene.t_end_s = 0.01;
        for (int n = 0; n < 160; n++)
            stations[n] = n * scene.length_ft;
        struct sim_result results[2];
        for (int whole = 0; whole < 2; whole++) {
            struct sim_options options = {.solver = cases[i].solver,
                                          .integrates_all_mats = whole,
                                          .sample_dt_s = 1e-3,
                                          .station_ft = stations,
                                          .station_count = 160};
            memset(&error, 0, sizeof error);
            sim_run(&scene, &options, &results[whole], &error);
            assert_string_equal(error.text, "");
        }
        double deepest = 0.0;
        for (size_t k = 0; k < results[0].sample_count * 160; k++) {
            assert_true(fabs(results[0].sample_y_ft[k] - results[1].sample_y_ft[k]) <=
                        cases[i].apart_ft);
            deepest = fmin(deepest, results[1].sample_y_ft[k]);
        }
        assert_true(deepest < -1e-5); /* W/(2 KV) is 8e-6 */
        sim_result_free(&results[0]);
        sim_result_free(&results[1]);
        sim_scene_free(&scene);
    }
}

/* A wave front needs N L / c; one that is frozen at the first window would not arrive. */
TEST(the_window_grows_with_the_motion)
{
    struct sim_scene scene = long_strip(SIM_MODEL_REPORT, 160);
    scene.friction = 0.0;
    scene.bump_ft.count = 0;
    struct sim_result result = good(&scene, "event", false);
    double c_ft_s = 2.0 * sqrt(8e6 / (160.0 / 32.174));
    for (size_t i = 0; i < result.output_count; i++) {
        int front = (int)(c_ft_s * result.outputs[i].t_s / 2.0);
        assert_true(result.outputs[i].u_ft[front - 3] > 1e-4);
        assert_true(fabs(result.outputs[i].u_ft[front + 15]) < 1e-6);
    }
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* The cost of a scene is that of its motion: what is at rest beyond does not count. */
TEST(mats_beyond_the_reach_cost_nothing)
{
    struct sim_scene a = long_strip(SIM_MODEL_REPORT, 200), b = long_strip(SIM_MODEL_REPORT, 4096);
    struct sim_result few = good(&a, "event", false), many = good(&b, "event", false);
    assert_int_equal(few.integrated_mats_max, many.integrated_mats_max);
    assert_true(few.integrated_mats_max < 90);
    assert_int_equal(few.steps, many.steps);
    for (int n = 1; n <= 200; n++)
        assert_true(few.u_ft[n] == many.u_ft[n]);
    for (int n = 201; n <= 4096; n++)
        assert_true(many.u_ft[n] == 0.0);
    sim_result_free(&few);
    sim_result_free(&many);
    sim_scene_free(&a);
    sim_scene_free(&b);
}

/* A flat strip at rest: only the mats under the wheel are looked at, and none of them lifts. */
TEST(a_flat_strip_stays_flat)
{
    for (int model = 0; model < 2; model++) {
        struct sim_scene scene = long_strip(model ? SIM_MODEL_CONSISTENT : SIM_MODEL_REPORT, 300);
        scene.bump_ft.count = 0;
        scene.force_lb = 60.0; /* below f W = 80 */
        scene.v0_ft_s = 0.0;
        struct sim_result result = good(&scene, "event", false);
        assert_true(result.peak_u_ft == 0.0 && result.max_lift_ft == 0.0);
        assert_true(result.integrated_mats_max < 30);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}
