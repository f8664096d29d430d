#include "host/sim/check/error_study.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/sim.h"
#include "host/sim/solvers/pass.h"

/* In ft. The reference is accurate enough if its two methods agree within this. */
#define REFERENCE_AGREEMENT_FT  1e-10
/* Largest tolerance of the reference. The runs of the study use far larger tolerances: with equal
 * tolerances, two errors can agree by chance. */
#define REFERENCE_RTOL_MAX      1e-12
#define LOOSEST_RTOL_EXPONENT   3
#define TIGHTEST_RTOL_EXPONENT  9
#define REPEATED_RUN_MAX_MS     25.0 /* In ms. Shorter runs are repeated to measure their time. */
#define REPEATS_MAX             5
/* Largest product of steps and mats of a reference run for which it is repeated with a smaller
 * tolerance. */
#define REFERENCE_MAT_STEPS_MAX 2e7
#define TABLE_MAT_STEPS_MAX     6e7   /* largest product of steps and mats of a run in the table */
#define MAX_RUN_STEPS           30000 /* limit of every run, steps */
#define TABLE_STEPS_PER_MAT     700   /* further allowed steps for each mat */
/* Largest stable step of `event` / shortest time constant, approximately */
#define EVENT_STABILITY         6.0
/* End of the stability region of the classical method on the negative real axis. */
#define RK4_STABILITY           2.785
#define FIXED_STEP_RUNS         24 /* number of fixed steps below the stability limit */
/* Number of first runs, whose steps are a fifth of an octave apart, to show which runs are accurate
 * by chance. The steps of the others are half an octave apart. */
#define CLOSE_STEP_RUNS         15
#define FIRST_STEP_FRACTION     0.97 /* first step / stability limit */
#define MIN_STEPS               20.0
#define RK4_MAT_STEPS_MAX       6e7 /* largest product of steps and mats of a run of rk4 */
/* Steps beyond the stability limit, divided by the limit. */
static const double unstable_step_ratios[] = {1.12, 1.05};

/* The slope of the error is fitted to errors that are at least SLOPE_ERROR_MIN_RATIO times the
 * difference of the references and at most SLOPE_ERROR_MAX_SHARE times the peak. The largest of
 * them must be at least SLOPE_ERROR_RANGE_MIN times the smallest. */
#define SLOPE_ERROR_MIN_RATIO 10.0
#define SLOPE_ERROR_MAX_SHARE 0.1
/* possible sum of rounding errors over 1e5 steps, as a fraction of the largest value */
#define ROUNDING_ERROR        3e-12
#define SLOPE_ERROR_RANGE_MIN 3.0

const double error_levels_ft[] = {1e-3, 1e-5, 5e-6, 1e-7};
const size_t error_level_count = sizeof error_levels_ft / sizeof error_levels_ft[0];

struct reference {
    bool is_found;
    double rtol;
    double u_ft, lift_ft; /* differences between the two methods */
    double max_lift_ft;
    struct sim_record record; /* samples of the run of the first method */
};

static __attribute__((format(printf, 2, 3))) void add_note(struct error_study *study,
                                                           const char *format, ...)
{
    for (size_t i = 0; i + 1 < ERROR_NOTES_MAX; i++) {
        if (study->notes[i][0] != '\0')
            continue;
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(study->notes[i], sizeof study->notes[i], format, arguments);
        va_end(arguments);
        return;
    }
}

/* Adds a run and returns it. The run counts as failed until its results are set. NULL: the table is
 * full. */
static struct error_run *add_run(struct error_study *study)
{
    if (study->run_count == ERROR_RUNS_MAX)
        return NULL;
    struct error_run *run = &study->runs[study->run_count++];
    if (study->progress)
        study->progress(study->progress_ctx, study->run_count);
    *run =
        (struct error_run){.u_ft = (double)NAN, .lift_ft = (double)NAN, .max_lift_ft = (double)NAN};
    return run;
}

/* ---- one run ---- */

/* Runs one pass. Sets outcome->ms to its processor time. */
static enum mr_status run_one_pass(struct pass_outcome *outcome, const struct sim_scene *scene,
                                   const struct pass_request *request, struct error *error)
{
    struct model model;
    const struct sim_options options = {0};
    *outcome = (struct pass_outcome){0};
    if (model_make(&model, scene, false, error) != MR_OK)
        return error->status;
    double begin_ms = processor_time_ms();
    pass_run(outcome, &model, request, &options);
    outcome->ms = processor_time_ms() - begin_ms;
    model_free(&model);
    return error->status;
}

static double lift_difference_ft(const struct pass_outcome *a, const struct sim_record *record,
                                 double max_lift_ft)
{
    return fmax(sim_record_lift_difference(&a->record, record), fabs(a->max_lift_ft - max_lift_ft));
}

/* Fastest rate of the linearised equations at the start. */
static enum mr_status compute_fastest_rate(const struct sim_scene *scene, double *rate,
                                           struct error *error)
{
    struct model model;
    if (model_make(&model, scene, false, error) != MR_OK)
        return error->status;
    double *z = xcalloc(2 * (size_t)model.coordinate_count, sizeof *z);
    model_start(&model, z);
    *rate = model_fastest_rate(&model, z, MODEL_RATE_EXPLICIT);
    free(z);
    model_free(&model);
    return error->status;
}

static enum mr_status measure_run(struct error_study *study, const struct reference *reference,
                                  const struct sim_scene *scene, const struct pass_request *request,
                                  struct error *error)
{
    struct pass_outcome outcome;
    struct error_run *run = add_run(study);
    if (!run || run_one_pass(&outcome, scene, request, error) != MR_OK)
        return error->status;
    run->solver = request->kind->name;
    run->rtol = request->rtol;
    run->dt_s = request->dt_s;
    run->steps = outcome.steps;
    run->evaluations = outcome.evaluations;
    run->ms = outcome.ms;
    run->status = outcome.status;
    run->mat = outcome.mat;
    run->t_s = outcome.t_s;
    run->is_unstable = request->dt_s > study->dt_limit_s;
    if (outcome.status == SIM_OK) {
        run->u_ft = sim_record_difference(&outcome.record, &reference->record).u_ft;
        run->lift_ft = lift_difference_ft(&outcome, &reference->record, reference->max_lift_ft);
        run->max_lift_ft = outcome.max_lift_ft;
    } else if (outcome.steps > request->max_steps / 2) {
        add_note(study, "%s at rtol %g was stopped after %llu steps, at %.4g s", run->solver,
                 run->rtol, (unsigned long long)outcome.steps, outcome.t_s);
    }
    pass_outcome_free(&outcome);
    for (int i = 1; i < REPEATS_MAX && run->ms < REPEATED_RUN_MAX_MS && run->status == SIM_OK;
         i++) {
        if (run_one_pass(&outcome, scene, request, error) == MR_OK)
            run->ms = fmin(run->ms, outcome.ms);
        pass_outcome_free(&outcome);
    }
    return error->status;
}

/* ---- reference ---- */

static uint64_t reference_steps_max(const struct sim_scene *scene)
{
    if (scene->friction_law == SIM_FRICTION_SIGN && scene->friction > 0.0)
        return 50000; /* no method can finish, because the modes chatter */
    return 200000 + 20000 * (uint64_t)scene->mats;
}

/* Reduces the tolerances of two methods until the methods agree. `reference` keeps the best pair of
 * runs. If no pair completes, *failed_name is the name of the method that failed. */
static enum mr_status find_reference(struct reference *reference,
                                     const struct stepper_kind *const pair[2],
                                     const struct sim_scene *scene, struct pass_outcome *failed,
                                     const char **failed_name, struct error *error)
{
    static const double rtols[] = {1e-9, 1e-12, 1e-13};
    struct pass_outcome both[2];
    *failed_name = NULL;
    for (size_t k = 0; k < sizeof rtols / sizeof rtols[0]; k++) {
        double rtol = rtols[k];
        for (size_t i = 0; i < 2; i++) {
            const struct pass_request request = {pair[i], rtol, 0.0, reference_steps_max(scene),
                                                 0,       0.0};
            both[i] = (struct pass_outcome){0};
            if (run_one_pass(&both[i], scene, &request, error) != MR_OK ||
                both[i].status != SIM_OK) {
                *failed = both[i];
                *failed_name = pair[i]->name;
                pass_outcome_free(&both[i]);
                if (i == 1)
                    pass_outcome_free(&both[0]);
                return error->status;
            }
        }
        double u = sim_record_difference(&both[0].record, &both[1].record).u_ft;
        double lift = lift_difference_ft(&both[1], &both[0].record, both[0].max_lift_ft);
        double mat_steps = (double)(both[0].steps > both[1].steps ? both[0].steps : both[1].steps) *
                           scene->mats;
        /* keep the runs with the smaller tolerance, unless their difference is much larger */
        if (!reference->is_found ||
            fmax(u, lift) <=
                fmax(REFERENCE_AGREEMENT_FT, 2.0 * fmax(reference->u_ft, reference->lift_ft))) {
            sim_record_free(&reference->record);
            *reference = (struct reference){true,          rtol, u, lift, both[0].max_lift_ft,
                                            both[0].record};
            both[0].record = (struct sim_record){0};
        }
        pass_outcome_free(&both[0]);
        pass_outcome_free(&both[1]);
        if ((fmax(u, lift) <= REFERENCE_AGREEMENT_FT && rtol <= 1.01 * REFERENCE_RTOL_MAX) ||
            mat_steps > REFERENCE_MAT_STEPS_MAX)
            break;
    }
    return MR_OK;
}

static enum mr_status refuse_failed_reference(const struct sim_scene *scene, const char *name,
                                              const struct pass_outcome *failed,
                                              struct error *error)
{
    return error_set(error, MR_NUMERICS,
                     "no reference: %s: %s fails at a tight tolerance: %s, mat %d at %.9g s; give "
                     "a smaller tend or a different scene",
                     sim_scene_name(scene), name, sim_status_name(failed->status), failed->mat,
                     failed->t_s);
}

static enum mr_status find_planar_reference(struct reference *reference, struct error_study *study,
                                            const struct sim_scene *scene, struct error *error)
{
    const struct stepper_kind *const explicit_first[2] = {&stepper_event, &stepper_implicit};
    const struct stepper_kind *const both_implicit[2] = {&stepper_implicit, &stepper_cvode};
    const struct stepper_kind *const *pair = explicit_first;
    struct pass_outcome failed = {0};
    const char *name = NULL;
    double rate = 0.0;
    *reference = (struct reference){0};
    if (compute_fastest_rate(scene, &rate, error) != MR_OK)
        return error->status;
    bool hopeless = rate * sim_scene_end_s(scene) / EVENT_STABILITY >
                    (double)reference_steps_max(scene);
    if (hopeless || find_reference(reference, pair, scene, &failed, &name, error) != MR_OK ||
        (!reference->is_found && name == stepper_event.name &&
         failed.status == SIM_STEP_UNDERFLOW)) {
        pair = both_implicit;
        if (error->status == MR_OK &&
            !(scene->friction_law == SIM_FRICTION_SIGN && scene->friction > 0.0))
            find_reference(reference, pair, scene, &failed, &name, error);
    }
    if (error->status != MR_OK)
        return error->status;
    if (!reference->is_found)
        return refuse_failed_reference(scene, name ? name : "event", &failed, error);
    if (reference->u_ft > ERROR_LIMIT_U_FT || reference->lift_ft > ERROR_LIMIT_LIFT_FT)
        return error_set(error, MR_NUMERICS,
                         "no reference: %s: %s and %s still differ by %.2g ft (u) and %.2g ft "
                         "(lift) at rtol %g; give a smaller tend or a different scene",
                         sim_scene_name(scene), pair[0]->name, pair[1]->name, reference->u_ft,
                         reference->lift_ft, reference->rtol);
    snprintf(study->reference_method, sizeof study->reference_method,
             "%s (%s) at rtol %g, in agreement with %s (%s)", pair[0]->name, pair[0]->description,
             reference->rtol, pair[1]->name, pair[1]->description);
    return MR_OK;
}

/* ---- the runs ---- */

static enum mr_status run_tolerances(struct error_study *study, const struct reference *reference,
                                     const struct sim_scene *scene, const struct stepper_kind *kind,
                                     struct error *error)
{
    double most = fmin(MAX_RUN_STEPS + TABLE_STEPS_PER_MAT * scene->mats,
                       fmax(20000.0, TABLE_MAT_STEPS_MAX / scene->mats));
    for (int e = LOOSEST_RTOL_EXPONENT; e <= TIGHTEST_RTOL_EXPONENT; e++) {
        const struct pass_request request = {kind, pow(10.0, -e), 0.0, (uint64_t)most, 0, 0.0};
        if (measure_run(study, reference, scene, &request, error) != MR_OK)
            return error->status;
        const struct error_run *run = &study->runs[study->run_count - 1];
        if (e > LOOSEST_RTOL_EXPONENT && run->status != SIM_OK && run[-1].status == SIM_OK &&
            run->steps > request.max_steps / 2 && e < TIGHTEST_RTOL_EXPONENT) {
            add_note(study,
                     "%s: tolerances below %g are left out, because they need too many steps",
                     kind->name, run->rtol);
            break;
        }
    }
    return MR_OK;
}

static double step_size_octaves(int rung)
{
    return rung < CLOSE_STEP_RUNS ? 0.2 * rung
                                  : 0.2 * CLOSE_STEP_RUNS + 0.5 * (rung - CLOSE_STEP_RUNS);
}

/* Adds runs of rk4 with fixed steps. */
static enum mr_status run_fixed_steps(struct error_study *study, const struct reference *reference,
                                      const struct sim_scene *scene, struct error *error)
{
    struct pass_request request = {.kind = &stepper_rk4, .max_steps = UINT64_MAX};
    double end_s = study->end_s, limit_s = study->dt_limit_s;
    double least_s = end_s * scene->mats / RK4_MAT_STEPS_MAX;
    double first_s = FIRST_STEP_FRACTION * fmin(limit_s, end_s / MIN_STEPS);
    if (first_s < least_s) {
        add_note(study,
                 "rk4 is left out, because its stability limit of %.3g s requires %.3g steps",
                 limit_s, end_s / limit_s);
        return MR_OK;
    }
    for (size_t i = 0; i < sizeof unstable_step_ratios / sizeof unstable_step_ratios[0] &&
                       limit_s < end_s / MIN_STEPS;
         i++) {
        request.dt_s = unstable_step_ratios[i] * limit_s;
        if (measure_run(study, reference, scene, &request, error) != MR_OK)
            return error->status;
    }
    for (int k = 0; k < FIXED_STEP_RUNS; k++) {
        request.dt_s = first_s * pow(2.0, -step_size_octaves(k));
        if (request.dt_s < least_s) {
            add_note(study, "rk4: steps below %.3g s are left out", least_s);
            break;
        }
        if (measure_run(study, reference, scene, &request, error) != MR_OK)
            return error->status;
    }
    return MR_OK;
}

/* ---- the chain ---- */

#define CHAIN_COMPARED_TIMES  64
/* Error / tolerance. Small errors grow over thousands of switches. */
#define CHAIN_TOLERANCE_RATIO 10.0
/* Number of runs of solver event. The tolerance of each is a tenth of the previous one. */
#define CHAIN_RUNS            10
/* Number of runs of solver staggered. Their steps are half an octave apart. */
#define CHAIN_STEP_RUNS       16

/* Makes one run and stores u at equally spaced times in u_ft. Returns the longest stable step. */
static double run_chain_pass(struct error_run *run, const struct sim_scene *scene,
                             const struct sim_options *options, double *u_ft, struct error *error)
{
    struct sim_result result;
    size_t row = (size_t)scene->mats + 1;
    double begin_ms = processor_time_ms();
    enum mr_status status = sim_run(scene, options, &result, error);
    run->solver = options->solver;
    run->rtol = options->rtol;
    run->dt_s = options->dt_s;
    run->ms = processor_time_ms() - begin_ms;
    run->steps = result.steps;
    run->evaluations = result.evaluations;
    run->status = result.status;
    run->mat = result.mat;
    run->t_s = result.t_s;
    if (status == MR_NUMERICS)
        /* a failed run is a row of the table, not an error of the study */
        error->status = MR_OK;
    for (size_t k = 0; status == MR_OK && k < CHAIN_COMPARED_TIMES; k++)
        memcpy(u_ft + k * row, result.outputs[k].u_ft, row * sizeof *u_ft);
    double limit_s = result.dt_limit_s;
    sim_result_free(&result);
    return limit_s;
}

static double chain_difference_ft(const struct sim_scene *scene, const double *a, const double *b)
{
    size_t row = (size_t)scene->mats + 1;
    double most = 0.0;
    for (size_t i = 0; i < CHAIN_COMPARED_TIMES * row; i++)
        most = i % row == 0 ? most : fmax(most, fabs(a[i] - b[i]));
    return most;
}

/* Compares the two solvers of the chain with a run of `event` at the smallest tolerance. A second
 * run of `event` confirms this reference. tests/stability compares with an independent method. */
static enum mr_status run_chain_study(struct error_study *study, const struct sim_scene *whole,
                                      struct error *error)
{
    struct sim_scene timed = *whole, *scene = &timed;
    size_t size = CHAIN_COMPARED_TIMES * ((size_t)scene->mats + 1);
    double *reference = xcalloc(size, sizeof *reference), *u = xcalloc(size, sizeof *u);
    struct error_run run = {0}, check = {0};
    struct sim_options options = {.solver = "event", .is_single_pass = true, .rtol = 1e-12};
    double times_s[CHAIN_COMPARED_TIMES];
    for (int k = 0; k < CHAIN_COMPARED_TIMES; k++)
        times_s[k] = study->end_s * (k + 1) / CHAIN_COMPARED_TIMES;
    timed.t_out_s = (struct sim_list){times_s, CHAIN_COMPARED_TIMES};
    study->dt_limit_s = run_chain_pass(&check, scene, &options, u, error);
    options.rtol = 1e-13;
    run_chain_pass(&run, scene, &options, reference, error);
    study->disagreement_u_ft = chain_difference_ft(scene, u, reference);
    for (size_t i = 0; i < size; i++)
        study->peak_u_ft = fmax(study->peak_u_ft, fabs(reference[i]));
    snprintf(study->reference_method, sizeof study->reference_method,
             "event (every event located) at rtol 1e-13, in agreement with rtol 1e-12");
    if (error->status == MR_OK &&
        (run.status != SIM_OK || check.status != SIM_OK ||
         study->disagreement_u_ft > ERROR_LIMIT_U_FT * CHAIN_TOLERANCE_RATIO))
        error_set(error, MR_NUMERICS,
                  "no reference: %s: two runs of event differ by %.2g ft (u); give a smaller tend "
                  "or a different scene",
                  sim_scene_name(scene), study->disagreement_u_ft);
    for (int i = 0; i < CHAIN_RUNS + CHAIN_STEP_RUNS && error->status == MR_OK; i++) {
        options = i < CHAIN_RUNS
                    ? (struct sim_options){.solver = "event",
                                           .is_single_pass = true,
                                           .rtol = pow(10, -3 - i)}
                    : (struct sim_options){.solver = "staggered",
                                           .is_single_pass = true,
                                           .dt_s = study->dt_limit_s * FIRST_STEP_FRACTION *
                                                   pow(2.0, -0.5 * (i - CHAIN_RUNS))};
        /* cannot fail: the size of the table was checked above */
        struct error_run *row = add_run(study);
        run_chain_pass(row, scene, &options, u, error);
        row->u_ft = row->status == SIM_OK ? chain_difference_ft(scene, u, reference) : (double)NAN;
        for (int k = 1; k < REPEATS_MAX && row->ms < REPEATED_RUN_MAX_MS && row->status == SIM_OK;
             k++) {
            run_chain_pass(&run, scene, &options, u, error);
            row->ms = fmin(row->ms, run.ms);
        }
    }
    free(reference);
    free(u);
    return error->status;
}

enum mr_status error_study_run(struct error_study *study, const struct sim_scene *scene,
                               error_study_progress *told, void *told_ctx, struct error *error)
{
    static const struct stepper_kind *const kinds[] = {
        &stepper_event, &stepper_implicit, &stepper_cvode, &stepper_rkgs, &stepper_hamming};
    struct reference reference = {0};
    double rate = 0.0;
    *study = (struct error_study){.progress = told, .progress_ctx = told_ctx};
    if (told)
        told(told_ctx, 0);
    if (sim_scene_check(scene, sim_scene_name(scene), error) != MR_OK)
        return error->status;
    struct sim_scene counted;
    sim_scene_shift_times(&counted, scene);
    study->end_s = sim_scene_end_s(&counted);
    study->has_lift = scene->model != SIM_MODEL_CHAIN;
    if (!study->has_lift) {
        run_chain_study(study, &counted, error);
    } else if (find_planar_reference(&reference, study, &counted, error) == MR_OK &&
               compute_fastest_rate(&counted, &rate, error) == MR_OK) {
        study->disagreement_u_ft = reference.u_ft;
        study->disagreement_lift_ft = reference.lift_ft;
        study->peak_u_ft = sim_record_peak(&reference.record).u_ft;
        study->max_lift_ft = reference.max_lift_ft;
        study->dt_limit_s = rate > 0.0 ? RK4_STABILITY / rate : HUGE_VAL;
        for (size_t i = 0; i < sizeof kinds / sizeof kinds[0] && error->status == MR_OK; i++)
            run_tolerances(study, &reference, &counted, kinds[i], error);
        if (error->status == MR_OK)
            run_fixed_steps(study, &reference, &counted, error);
    }
    sim_record_free(&reference.record);
    sim_scene_shift_times_free(&counted, scene);
    if (error->status == MR_OK)
        error_study_fit_slopes(study);
    return error->status;
}

/* ---- slopes, and the cheapest solver ---- */

size_t error_study_solvers(const struct error_study *study, const char **names, size_t room)
{
    size_t count = 0;
    for (size_t i = 0; i < study->run_count; i++) {
        bool known = false;
        for (size_t k = 0; k < count; k++)
            known = known || strcmp(names[k], study->runs[i].solver) == 0;
        if (!known && count < room)
            names[count++] = study->runs[i].solver;
    }
    return count;
}

static bool is_run_usable(const struct error_run *run)
{
    return run->status == SIM_OK && !run->is_unstable;
}

static struct error_slope fit_slope(const struct error_study *study, const char *solver, bool lift)
{
    struct error_slope s = {.fit_min = HUGE_VAL, .fit_max = 0.0};
    double least = fmax(SLOPE_ERROR_MIN_RATIO *
                            (lift ? study->disagreement_lift_ft : study->disagreement_u_ft),
                        ROUNDING_ERROR * (lift ? study->max_lift_ft : study->peak_u_ft));
    double most = SLOPE_ERROR_MAX_SHARE * (lift ? study->max_lift_ft : study->peak_u_ft);
    double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        double error = lift ? run->lift_ft : run->u_ft;
        if (strcmp(run->solver, solver) != 0 || !is_run_usable(run) ||
            !(error > least && error < most))
            continue;
        double at = run->dt_s > 0.0 ? run->dt_s : run->rtol, x = log10(at), y = log10(error);
        s.point_count++;
        s.fit_min = fmin(s.fit_min, at);
        s.fit_max = fmax(s.fit_max, at);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
        syy += y * y;
    }
    double n = s.point_count, width = sxx - sx * sx / n;
    if (s.point_count < 3 || s.fit_max < SLOPE_ERROR_RANGE_MIN * s.fit_min) {
        s.point_count = 0;
        return s;
    }
    s.slope = (sxy - sx * sy / n) / width;
    s.scatter = sqrt(fmax(0.0, (syy - sy * sy / n - s.slope * s.slope * width) / n));
    return s;
}

void error_study_fit_slopes(struct error_study *study)
{
    const char *names[ERROR_ORDERS_MAX];
    study->order_count = error_study_solvers(study, names, ERROR_ORDERS_MAX);
    for (size_t k = 0; k < study->order_count; k++) {
        struct error_order *order = &study->orders[k];
        *order = (struct error_order){.solver = names[k],
                                      .u = fit_slope(study, names[k], false),
                                      .lift = fit_slope(study, names[k], true)};
        for (size_t i = 0; i < study->run_count; i++)
            order->is_step_order = order->is_step_order ||
                                   (strcmp(study->runs[i].solver, names[k]) == 0 &&
                                    study->runs[i].dt_s > 0.0);
    }
}

static double get_run_error_ft(const struct error_study *study, const struct error_run *run)
{
    return !is_run_usable(run) ? (double)NAN : study->has_lift ? run->lift_ft : run->u_ft;
}

double error_study_smoothed_error_ft(const struct error_study *study, size_t i)
{
    const struct error_run *run = &study->runs[i];
    double own = get_run_error_ft(study, run);
    if (run->dt_s == 0.0 || isnan(own))
        return own;
    for (int side = 0; side < 2; side++) {
        if (side == 0 ? i == 0 : i + 1 == study->run_count)
            return (double)NAN;
        const struct error_run *next = &study->runs[side == 0 ? i - 1 : i + 1];
        double error = get_run_error_ft(study, next);
        if (strcmp(next->solver, run->solver) != 0 || isnan(error))
            return (double)NAN;
        own = fmax(own, error);
    }
    return own;
}

const struct error_run *error_study_find_cheapest(const struct error_study *study,
                                                  const char *solver, double level_ft)
{
    const struct error_run *best = NULL;
    if (level_ft < ERROR_RESOLUTION_FACTOR *
                       (study->has_lift ? study->disagreement_lift_ft : study->disagreement_u_ft))
        return NULL;
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        if ((solver && strcmp(run->solver, solver) != 0) ||
            !(error_study_smoothed_error_ft(study, i) <= level_ft))
            continue;
        if (!best || run->ms < best->ms)
            best = run;
    }
    return best;
}
