/* Error studies: references that agree or are refused, errors that are the true ones, slopes, and
 * who is cheapest.
 *
 * Expected values: closed forms (a damped oscillator; a made-up study of known slope), the textbook
 * order of the methods, and the definition of an error itself. Units ft, lb, s. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/check/error_study.h"
#include "host/sim/solvers/pass.h"
#include "host/sim/sim.h"

static struct error error;
static struct error_study study;

static struct sim_scene plain(enum sim_model model, int mats)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    sim_scene_set_defaults(&scene);
    scene.model = model;
    scene.mats = mats;
    return scene;
}

static void run(const struct sim_scene *scene)
{
    if (error_study_run(&study, scene, NULL, NULL, &error) != MR_OK)
        fail_msg("%s", error.text);
}

static const struct error_run *find(const char *solver, double rtol)
{
    for (size_t i = 0; i < study.run_count; i++) {
        if (strcmp(study.runs[i].solver, solver) == 0 &&
            fabs(study.runs[i].rtol / rtol - 1.0) < 1e-9)
            return &study.runs[i];
    }
    fail_msg("no run of %s at %g", solver, rtol);
    return NULL;
}

static const struct error_slope *slope_of(const char *solver, bool lift)
{
    for (size_t i = 0; i < study.order_count; i++) {
        if (strcmp(study.orders[i].solver, solver) == 0)
            return lift ? &study.orders[i].lift : &study.orders[i].u;
    }
    fail_msg("no slope of %s", solver);
    return NULL;
}

static struct pass_outcome one_pass(const struct sim_scene *scene, const char *solver, double rtol,
                                    double dt_s)
{
    const struct pass_request request = {stepper_find(solver), rtol, dt_s, 1000000, 0, 0.0};
    const struct sim_options options = {0};
    struct pass_outcome outcome = {0};
    struct model model;
    assert_int_equal(model_make(&model, scene, false, &error), MR_OK);
    pass_run(&outcome, &model, &request, &options);
    model_free(&model);
    return outcome;
}

/* An error of lift as it is defined, from two passes. */
static double lift_error_ft(const struct pass_outcome *a, const struct pass_outcome *b)
{
    double worst = fabs(a->max_lift_ft - b->max_lift_ft);
    for (size_t k = 0; k < a->record.snapshot_count; k++)
        worst = fmax(worst, fabs(a->record.snapshots[k].lift_ft - b->record.snapshots[k].lift_ft));
    return worst;
}

/* A short fig 3.7: contact, torsion, lift shear and smooth friction. */
TEST(references_agree_and_errors_fall)
{
    const double bump[] = {0.0099, 0.0200, 0.0099};
    static const char *const solvers[] = {"event", "implicit", "cvode", "rkgs", "hamming"};
    struct sim_scene scene = plain(SIM_MODEL_REPORT, 8);
    scene.friction_law = SIM_FRICTION_TANH;
    scene.t_end_s = 0.01;
    sim_scene_set_list(&scene.bump_ft, bump, 3);
    run(&scene);
    assert_true(study.disagreement_u_ft < 1e-10 && study.disagreement_lift_ft < 1e-10);
    assert_true(study.max_lift_ft > 0.02);
    assert_non_null(strstr(study.reference_method, "event"));
    assert_non_null(strstr(study.reference_method, "implicit"));
    for (size_t i = 0; i < COUNT_OF(solvers); i++) {
        const struct error_run *loose = find(solvers[i], 1e-4), *tight = find(solvers[i], 1e-9);
        assert_int_equal(loose->status, SIM_OK);
        assert_int_equal(tight->status, SIM_OK);
        if (!(tight->u_ft < 0.02 * loose->u_ft && tight->lift_ft < 0.02 * loose->lift_ft))
            fail_msg("%s: errors %g, %g at 1e-4 and %g, %g at 1e-9", solvers[i], loose->u_ft,
                     loose->lift_ft, tight->u_ft, tight->lift_ft);
    }
    struct pass_outcome best = one_pass(&scene, "implicit", 1e-12, 0.0);
    for (size_t i = 0; i < study.run_count; i += 3) {
        struct pass_outcome outcome = one_pass(&scene, study.runs[i].solver, study.runs[i].rtol,
                                               study.runs[i].dt_s);
        assert_near(study.runs[i].lift_ft, lift_error_ft(&outcome, &best), 1e-10);
        pass_outcome_free(&outcome);
    }
    pass_outcome_free(&best);

    /* rk4: some steps beyond the limit, the others within; only the latter may count */
    bool over = false;
    for (size_t i = 0; i < study.run_count; i++) {
        const struct error_run *r = &study.runs[i];
        if (strcmp(r->solver, "rk4") == 0) {
            over = over || r->is_unstable;
            assert_int_equal(r->is_unstable, r->dt_s > study.dt_limit_s);
            if (r->is_unstable)
                assert_true(isnan(error_study_smoothed_error_ft(&study, i)));
        }
    }
    assert_true(over);
    sim_scene_free(&scene);
}

/* One mat between two fixed joints: m u'' + 2 CL u' + 2 KL u = 0, u(0) = 0, u'(0) = v0. */
#define OSCILLATOR_KL 2000.0
#define OSCILLATOR_V0 1.5
static struct sim_scene oscillator(double cl)
{
    struct sim_scene scene = plain(SIM_MODEL_REPORT, 1);
    scene.left_end = SIM_END_FIXED;
    scene.right_end = SIM_END_FIXED;
    scene.kl_lb_ft = OSCILLATOR_KL;
    scene.cl_lb_s_ft = cl;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.force_lb = 0.0;
    scene.vac_ft_s = 0.0;
    scene.start_ft = 1.0;
    scene.v0_ft_s = OSCILLATOR_V0;
    scene.lift_shear_lb = 0.0;
    scene.bump_first = 1;
    scene.t_end_s = 0.5;
    return scene;
}

static double exact_ft(const struct sim_scene *scene, double t_s)
{
    double m = scene->weight_lb / scene->g_ft_s2, damping = scene->cl_lb_s_ft / m;
    double w = sqrt(2.0 * OSCILLATOR_KL / m - damping * damping);
    return OSCILLATOR_V0 / w * exp(-damping * t_s) * sin(w * t_s);
}

TEST(an_error_is_the_true_error)
{
    struct sim_scene scene = oscillator(5.0);
    double floor_ft;
    run(&scene);
    floor_ft = 2.0 * study.disagreement_u_ft + 1e-13;
    assert_true(floor_ft < 1e-10);
    assert_true(study.run_count > 40);
    for (size_t i = 0; i < study.run_count; i++) {
        const struct error_run *r = &study.runs[i];
        struct pass_outcome outcome = one_pass(&scene, r->solver, r->rtol, r->dt_s);
        double worst = 0.0;
        assert_int_equal(r->status, SIM_OK);
        for (size_t k = 0; k < outcome.record.snapshot_count; k++) {
            const struct sim_snapshot *s = &outcome.record.snapshots[k];
            worst = fmax(worst, fabs(s->u_ft[1] - exact_ft(&scene, s->t_s)));
        }
        assert_near(r->u_ft, worst, floor_ft);
        pass_outcome_free(&outcome);
    }
    sim_scene_free(&scene);
}

/* Classical Runge-Kutta is of order 4 where nothing switches. */
TEST(smooth_scenes_show_the_order)
{
    struct sim_scene scene = plain(SIM_MODEL_REPORT, 10);
    scene.friction_law = SIM_FRICTION_NONE;
    scene.lift_shear_lb = 0.0;
    scene.vac_ft_s = 0.0;
    scene.start_ft = 1.0;
    scene.t_end_s = 0.02;
    run(&scene);
    const struct error_slope *rk4 = slope_of("rk4", false);
    assert_true(rk4->point_count >= 6 && rk4->scatter < 0.1);
    assert_near(rk4->slope, 4.0, 0.3);

    sim_scene_free(&scene);
}

TEST(without_a_reference_there_is_no_table)
{
    const double bump[] = {0.0099, 0.0200, 0.0099}, high = 0.3;
    struct sim_scene scene = plain(SIM_MODEL_REPORT, 8);
    scene.friction_law = SIM_FRICTION_SIGN;
    scene.t_end_s = 0.003;
    sim_scene_set_list(&scene.bump_ft, bump, 3);
    assert_int_equal(error_study_run(&study, &scene, NULL, NULL, &error), MR_NUMERICS);
    assert_non_null(strstr(error.text, "no reference"));
    assert_int_equal(study.run_count, 0);
    sim_scene_free(&scene);

    /* Undamped mats that bounce for a second and a half: rounding decides. */
    scene = plain(SIM_MODEL_CONSISTENT, 6);
    scene.kv_lb_ft = 1e6;
    scene.cv_lb_s_ft = scene.cl_lb_s_ft = scene.ct_lb_ft_s_rad = 0.0;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.force_lb = scene.v0_ft_s = scene.vac_ft_s = 0.0;
    scene.start_ft = 1.0;
    scene.bump_first = 4;
    scene.t_end_s = 1.5;
    sim_scene_set_list(&scene.bump_ft, &high, 1);
    assert_int_equal(error_study_run(&study, &scene, NULL, NULL, &error), MR_NUMERICS);
    assert_non_null(strstr(error.text, "still differ"));
    assert_int_equal(study.run_count, 0);
    sim_scene_free(&scene);
}

/* error = 3 dt^1.5 except at one lucky step. */
TEST(slopes_and_cheapest_of_a_known_study)
{
    study = (struct error_study){.has_lift = true,
                                 .disagreement_lift_ft = 1e-9,
                                 .disagreement_u_ft = 1e-9,
                                 .peak_u_ft = 10,
                                 .max_lift_ft = 10,
                                 .dt_limit_s = 0.02};
    for (int k = 0; k < 8; k++) {
        double dt = 0.01 * pow(2.0, -k);
        study.runs[study.run_count++] = (struct error_run){.solver = "rk4",
                                                           .dt_s = dt,
                                                           .ms = pow(2.0, k),
                                                           .evaluations = 100,
                                                           .u_ft = 3.0 * pow(dt, 1.5),
                                                           .lift_ft = 3.0 * pow(dt, 1.5)};
    }
    error_study_fit_slopes(&study);
    assert_near(slope_of("rk4", true)->slope, 1.5, 1e-9);
    assert_int_equal(slope_of("rk4", true)->point_count, 8);
    assert_near(slope_of("rk4", true)->scatter, 0.0, 1e-9);

    /* errors 3e-3, 1.06e-3, 3.75e-4, 1.33e-4 ...; a luck at step 1 must not count */
    study.runs[1].lift_ft = 1e-6;
    assert_near(error_study_smoothed_error_ft(&study, 1), 3e-3, 1e-9);
    assert_true(isnan(error_study_smoothed_error_ft(&study, 0)));
    assert_ptr_equal(error_study_find_cheapest(&study, NULL, 1e-3), &study.runs[2]);
    study.runs[1].lift_ft = study.runs[1].u_ft;
    /* 2 has a neighbour above it */
    assert_ptr_equal(error_study_find_cheapest(&study, NULL, 1e-3), &study.runs[3]);
    assert_ptr_equal(error_study_find_cheapest(&study, NULL, 1.1e-3), &study.runs[2]);
    assert_null(error_study_find_cheapest(&study, "event", 1e-3));
    study.disagreement_lift_ft = 1e-3;
    assert_null(error_study_find_cheapest(&study, NULL, 1.1e-3)); /* the reference cannot tell */

    /* a failed run has no error and does not count */
    study.disagreement_lift_ft = 1e-9;
    study.runs[2].status = SIM_UNSTABLE;
    assert_true(isnan(error_study_smoothed_error_ft(&study, 2)));
    assert_true(isnan(error_study_smoothed_error_ft(&study, 3)));
    error_study_fit_slopes(&study);
    assert_int_equal(slope_of("rk4", true)->point_count, 7);
}
