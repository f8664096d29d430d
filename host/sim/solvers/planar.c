#include "host/sim/solvers/planar.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/solvers/landing.h"
#include "host/sim/solvers/pass.h"

#define TIGHTENED_RTOL_FACTOR 0.01
#define MAX_TIGHTENINGS       2
#define MAX_STEPS             5000000u
/* number of steps of solver event after which `auto` tries implicit */
#define MAX_EVENT_STEPS       50000u
/* smallest number of steps of solver implicit after which `auto` tries event; larger if event
 * itself would need many steps */
#define MAX_IMPLICIT_STEPS    20000u
/* largest number of steps of solver implicit if there is no other solver to try */
#define MAX_AUTO_STEPS        300000u
/* largest number of steps with friction `sign`, which changes direction at every step near rest */
#define MAX_SIGN_STEPS        10000u
#define MAX_FIXED_STEPS       400000000.0
/* Largest number of steps that event may need for stability. If it would need more, it is stopped
 * after MAX_EVENT_STEPS. */
#define MAX_STABILITY_STEPS   500000.0
bool planar_has_solver(const char *name)
{
    return strcmp(name, "auto") == 0 || strcmp(name, "staggered") == 0 || stepper_find(name);
}

/* ---- deadline ---- */

static double read_clock_s(const struct sim_options *options)
{
    return options->clock_s ? options->clock_s(options->clock_ctx) : monotonic_s();
}

static bool is_before_deadline(void *ctx, int pass, double part)
{
    struct deadline *w = ctx;
    if (read_clock_s(w->caller_options) >= w->until_s) {
        w->is_exceeded = true;
        return false;
    }
    return !w->caller_options->may_continue ||
           w->caller_options->may_continue(w->caller_options->may_continue_ctx, pass, part);
}

void deadline_begin(struct deadline *w, const struct sim_options *caller_options, double limit_s)
{
    *w = (struct deadline){.caller_options = caller_options, .options = *caller_options};
    if (limit_s <= 0.0)
        return;
    w->until_s = read_clock_s(caller_options) + limit_s;
    w->options.may_continue = is_before_deadline;
    w->options.may_continue_ctx = w;
}

/* ---- error estimate (PLANAR.md): two passes of a solver, and further runs ---- */

/* Divergence: finer steps or tolerances do not lead to a definite result.
 *
 * Runs that should agree diverge: each switch that differs increases their difference, until it is
 * as large as the result. Further runs then show how different the results of the scene can be.
 * Their stiffnesses differ by the factor STIFFNESS_NUDGE, which is less than the accuracy of any
 * known stiffness. The result is SIM_UNPREDICTABLE. Its t_s and mat are the time and the mat of the
 * first difference between any two runs that exceeds a fifth of the largest movement or lift. Its
 * error estimates are twice the largest difference between any run and the reported run. */
#define STIFFNESS_NUDGE      1e-9
#define DIVERGENCE_RUN_COUNT 4 /* number of runs in addition to the two that diverge */

/* Ratio of the tolerances of the two passes of a check. */
#define ESTIMATE_RTOL_RATIO        30.0
/* Ratio of two fixed steps. With the ratio 2, every second short step would end together with a
 * long one, and both runs would sample these switches at the same moment. */
#define ESTIMATE_FIXED_STEP_RATIO  1.9
/* Ratio of the first steps of two runs, for solvers that halve and double their step. */
#define ESTIMATE_FIRST_STEP_FACTOR 0.72
/* for the longer of two fixed steps: largest step / duration of a span */
#define ESTIMATE_STEP_SPAN_SHARE   0.5
#define ESTIMATE_MIN_RTOL          1e-13
/* Ends of the stability regions on the negative real axis: of the classical method and,
 * approximately, of the method of order 8. */
#define ESTIMATE_RK4_STABILITY     2.785
#define ESTIMATE_EVENT_STABILITY   6.0
/* If event needs more steps than this for stability, implicit is used instead. */
#define ESTIMATE_EVENT_STEPS_MAX   10000.0
#define ESTIMATE_STEP_COST_RATIO   4.0 /* cost of a step of implicit / cost of a step of event */

/* Error estimate / difference of two passes that sample their switches. Sampling makes the method
 * one of order 1, so the error of the finer pass is about as large as the difference. The spread of
 * runs that diverge is larger than that of the few runs that show it by about this factor, too. */
#define ERROR_FACTOR 2.0

static void widen_error(struct sim_result *result, struct pass_difference difference, double factor)
{
    result->error_u_ft = fmax(result->error_u_ft, factor * difference.u.u_ft);
    result->error_lift_ft = fmax(result->error_lift_ft, factor * difference.lift_ft);
}

/* The runs of one scene with one solver. `coarse` and `fine` are complete. `third` is optional. */
struct solver_passes {
    struct pass_outcome coarse, fine, third;
    struct pass_request coarse_request, fine_request; /* requests of `coarse` and `fine` */
    bool is_result_coarse;
};

/* Makes the model with slightly different stiffnesses. The bits of `run` select the signs of the
 * differences. */
static struct model make_nudged_model(const struct model *m, int run)
{
    struct model other = *m;
    other.kl_lb_ft *= 1.0 + (run & 1 ? STIFFNESS_NUDGE : -STIFFNESS_NUDGE);
    other.kv_lb_ft *= 1.0 + (run & 2 ? STIFFNESS_NUDGE : -STIFFNESS_NUDGE);
    return other;
}

/* Runs one pass of the model with slightly different stiffnesses. `run`: 0 to DIVERGENCE_RUN_COUNT
 * - 1. */
static void run_nudged_pass(const struct model *m, const struct pass_request *request,
                            const struct sim_options *options, int run, struct pass_outcome *pass,
                            struct sim_result *result)
{
    struct model near = make_nudged_model(m, run);
    struct pass_request again = *request;
    again.pass_number = ++result->pass_count;
    pass_run(pass, &near, &again, options);
    result->evaluations += pass->evaluations;
}

/* Sets the divergence after two complete passes contradict each other. `given` is the pass that is
 * reported. */
static void set_run_divergence(const struct model *m, const struct pass_request *request,
                               const struct sim_options *options, const struct pass_outcome *given,
                               const struct pass_outcome *other, struct sim_result *result)
{
    double threshold = pass_bow_threshold_ft(m->scene);
    double most_u_ft = PASS_DISAGREEMENT_MAX * sim_record_peak(&given->record).u_ft,
           most_lift_ft = PASS_DISAGREEMENT_MAX * given->max_lift_ft + 0.01 * threshold;
    result->status = SIM_OK;
    result->diverging_run_count = 1;
    result->diverging_wave_count = given->max_lift_ft > threshold;
    for (int run = -1; run < DIVERGENCE_RUN_COUNT; run++) {
        struct pass_outcome pass = {0};
        if (run >= 0)
            run_nudged_pass(m, request, options, run, &pass, result);
        const struct pass_outcome *next = run < 0 ? other : &pass;
        if (next->status == SIM_OK) {
            result->diverging_run_count++;
            result->diverging_wave_count += next->max_lift_ft > threshold;
            pass_find_divergence(result, &given->record, &next->record, most_u_ft, most_lift_ft);
            widen_error(result, pass_compare(given, next), ERROR_FACTOR);
        }
        pass_outcome_free(&pass);
    }
}

/* ---- the estimate ---- */

/* The result is sensitive if the error estimate exceeds the tolerance by this factor, because
 * errors then grow. */
#define SENSITIVE_TOLERANCE_RATIO  1000.0
/* For a fixed step the result is sensitive above this ratio: estimate / largest movement. */
#define SENSITIVE_ERROR_MIN        0.05
#define FINER_ERROR_FACTOR         1.2 /* error estimate / difference from a finer pass */
/* error estimate / difference from a finer pass, if the coarser pass is the result */
#define COARSER_ERROR_FACTOR       4.0
/* error estimate / difference from a pass of another method */
#define OTHER_METHOD_ERROR_FACTOR  1.5
/* a run of another method may always take at least this number of steps */
#define OTHER_METHOD_MIN_STEPS     5000.0
#define EVENT_EVALUATIONS_PER_STEP 12.0 /* number of evaluations in one step of event */
/* Smallest number of mode changes of a bouncing joint or foot. It also must have a large part of
 * all changes, and few steps per change. */
#define BOUNCE_FLIPS_MIN           4
#define STEPS_PER_BOUNCE_MAX       100.0
/* largest fraction of the allowed steps that may pass without progress */
#define STALLED_SHARE_MAX          0.02
/* Number of runs that are added if no other method gives an answer. The ratios of their steps and
 * tolerances are not simple numbers, so that their switches do not coincide. */
#define EXTRA_RUN_COUNT            2
#define EXTRA_STEP_RATIO           1.37
#define EXTRA_RTOL_RATIO           2.2

/* Smallest error of a lift / error of a position. A lift is a difference of positions, whose errors
 * add up, and both runs can miss a lift of that size. */
#define LIFT_ERROR_RATIO_MIN 10.0
#define ERROR_GROWTH_PER_ROOT_STEP \
    0.1 /* growth of the error with the square root of the number of steps, in tolerances */

static bool is_solver_automatic(const struct sim_options *options)
{
    return !options->solver || strcmp(options->solver, "auto") == 0;
}

/* Number of steps that event needs for stability alone. */
static double event_stability_steps(const struct model *m, const struct sim_result *result)
{
    return ESTIMATE_RK4_STABILITY / result->dt_limit_s * sim_scene_end_s(m->scene) /
           ESTIMATE_EVENT_STABILITY;
}

static void add_pass_cost(struct sim_result *result, const struct pass_outcome *pass)
{
    result->evaluations += pass->evaluations;
    result->other_steps += pass->rejected_steps;
}

static bool is_sampling_kind(const struct stepper_kind *kind)
{
    return kind->samples_switches || kind->samples_shape_switches;
}

/* Runs one more pass, which may end early. */
static void run_additional_pass(struct pass_outcome *pass, struct model *m,
                                const struct pass_request *request,
                                const struct sim_options *options, struct sim_result *result)
{
    struct pass_request numbered = *request;
    numbered.pass_number = ++result->pass_count;
    pass_run(pass, m, &numbered, options);
    add_pass_cost(result, pass);
}

/* Increases the error estimate by a third pass, because two passes can agree by chance if they
 * sample switches or had different switches. With a fixed step, the third step is longer than the
 * others if that is stable, otherwise shorter; with a tolerance, it is between the other two. If
 * the third pass fails, nothing changes. */
static void widen_error_by_third_pass(struct model *m, const struct sim_options *options,
                                      struct solver_passes *runs, struct sim_result *result)
{
    const struct stepper_kind *kind = runs->fine_request.kind;
    struct pass_request request = runs->fine_request;
    if (!is_sampling_kind(kind) && runs->coarse.switch_hash_sum == runs->fine.switch_hash_sum)
        return;
    request.rtol *= sqrt(ESTIMATE_RTOL_RATIO);
    request.first_step_factor = ESTIMATE_FIRST_STEP_FACTOR * ESTIMATE_FIRST_STEP_FACTOR;
    request.dt_s = ESTIMATE_FIXED_STEP_RATIO * runs->coarse_request.dt_s;
    bool longer = request.dt_s <= result->dt_limit_s;
    if (!longer)
        request.dt_s = runs->fine_request.dt_s / ESTIMATE_FIXED_STEP_RATIO;
    if (kind->has_fixed_step)
        request.first_step_factor =
            longer ? runs->coarse_request.first_step_factor * ESTIMATE_FIXED_STEP_RATIO
                   : runs->fine_request.first_step_factor / ESTIMATE_FIXED_STEP_RATIO;
    run_additional_pass(&runs->third, m, &request, options, result);
    if (runs->third.status != SIM_OK)
        return;
    double share = ERROR_FACTOR;
    widen_error(result, pass_compare(&runs->coarse, &runs->fine), share);
    struct pass_difference coarse = pass_compare(&runs->coarse, &runs->third),
                           fine = pass_compare(&runs->fine, &runs->third);
    if (!kind->has_fixed_step) {
        widen_error(result, coarse, share);
        widen_error(result, fine, share);
    } else if (!longer) {
        widen_error(result, fine, share);
        widen_error(result, coarse, runs->is_result_coarse ? share : 1.0);
    } else if (passes_agree(m->scene, &runs->coarse, &runs->third, coarse)) {
        widen_error(result, coarse, share / ESTIMATE_FIXED_STEP_RATIO);
    }
}

/* Largest number of steps of event for a check: the number that costs as much as the runs so far.
 * 0: no check is made.
 *
 * A solver that samples switches makes an error that depends on their positions within the steps;
 * by chance all its runs can have the same error. The long steps of implicit skip events, and it
 * makes the same error at each bounce of mats that collide repeatedly. The stability limit assumes
 * that every part moves. If implicit is checked and few parts move, event may need far fewer steps
 * than this limit implies, so it runs as long as it makes progress (is_within_step_budget). */
static uint64_t max_check_steps(const struct model *m, const struct sim_options *options,
                                const struct solver_passes *runs, const struct sim_result *result)
{
    const struct pass_outcome *coarse = &runs->coarse, *fine = &runs->fine;
    bool implicit = runs->fine_request.kind == &stepper_implicit,
         automatic = is_solver_automatic(options);
    double needed_steps = event_stability_steps(m, result);
    double most = implicit ? ESTIMATE_STEP_COST_RATIO * (double)(coarse->steps + fine->steps)
                           : (double)(coarse->evaluations + fine->evaluations) /
                                 EVENT_EVALUATIONS_PER_STEP;
    /* `auto` has already tried event, unless it began with implicit */
    bool tried = automatic && (!implicit || needed_steps <= ESTIMATE_EVENT_STEPS_MAX);
    bool useful = is_sampling_kind(runs->fine_request.kind) ||
                  (runs->fine_request.kind != &stepper_event && fine->events > 0);
    most = fmax(most, OTHER_METHOD_MIN_STEPS);
    return useful && !tried && (implicit || needed_steps <= most) ? (uint64_t)most : 0;
}

/* Progress of a run that is stopped if it needs more steps than planned. */
struct step_budget {
    const struct sim_options *options;
    /* number of calls of is_within_step_budget so far, and number of planned steps */
    double call_count, planned_steps;
};

static bool is_within_step_budget(void *ctx, int pass, double part)
{
    struct step_budget *step_budget = ctx;
    step_budget->call_count++;
    return PASS_STEPS_PER_CALLBACK * step_budget->call_count <=
               (part + STALLED_SHARE_MAX) * step_budget->planned_steps &&
           (!step_budget->options->may_continue ||
            step_budget->options->may_continue(step_budget->options->may_continue_ctx, pass, part));
}

/* Adds a run of event, which locates every switch. All runs of one solver have the same systematic
 * errors, so another method is needed. Returns true if the run of event is complete. */
static bool add_event_run(struct model *m, const struct sim_options *options,
                          struct solver_passes *runs, struct sim_result *result)
{
    struct pass_outcome pass = {0};
    struct pass_request request = {
        .kind = &stepper_event,
        .rtol = stepper_event.rtol,
        .max_steps = max_check_steps(m, options, runs, result),
    };
    struct step_budget step_budget = {options, 0.0, (double)request.max_steps};
    struct sim_options paced = *options;
    if (request.max_steps == 0)
        return false;
    paced.may_continue = is_within_step_budget;
    paced.may_continue_ctx = &step_budget;
    run_additional_pass(&pass, m, &request, &paced, result);
    bool done = pass.status == SIM_OK;
    if (done) {
        sim_result_add_note(result, "the error estimate also uses a run with --solver event, which "
                                    "locates every event (contact, sticking, slipping)");
        const struct pass_outcome *answer = runs->is_result_coarse ? &runs->coarse : &runs->fine;
        widen_error(result, pass_compare(answer, &pass), OTHER_METHOD_ERROR_FACTOR);
    }
    pass_outcome_free(&pass);
    return done;
}

static bool has_repeated_bounces(const struct model *m, const struct pass_outcome *pass)
{
    return pass->max_flips >= BOUNCE_FLIPS_MIN &&
           4.0 * m->mats * pass->max_flips >= (double)pass->events &&
           (double)pass->steps <= STEPS_PER_BOUNCE_MAX * (double)pass->events;
}

/* Adds a finer run if there is no run of event. Implicit makes the same error at every bounce, so
 * two of its runs can agree by chance. The error is mostly a loss of energy, so a run with a step
 * between the two can have it too; the added run must be finer. */
static void add_finer_run_after_bounces(struct model *m, const struct sim_options *options,
                                        struct solver_passes *runs, struct sim_result *result)
{
    struct pass_request request = runs->fine_request;
    if (request.kind != &stepper_implicit || !has_repeated_bounces(m, &runs->fine) ||
        runs->third.end_z)
        return;
    request.rtol = fmax(ESTIMATE_MIN_RTOL, request.rtol / sqrt(ESTIMATE_RTOL_RATIO));
    run_additional_pass(&runs->third, m, &request, options, result);
    if (runs->third.status == SIM_OK)
        widen_error(result, pass_compare(&runs->fine, &runs->third), ERROR_FACTOR);
}

/* Adds runs if switches are sampled and no run with another method has located them. If a part is
 * at the edge of contact, each step size gives a different motion, even if two runs agree by
 * chance. The added runs show how different the results are. */
static void add_runs_if_only_sampled(struct model *m, const struct sim_options *options,
                                     const struct solver_passes *runs, struct sim_result *result)
{
    struct pass_request request = runs->fine_request;
    if (!is_sampling_kind(request.kind))
        return;
    sim_result_add_note(result,
                        "the error estimate includes two more runs, because events (contact, "
                        "sticking, slipping) are sampled and no other method locates them");
    for (int i = 0; i < EXTRA_RUN_COUNT; i++) {
        struct pass_outcome pass = {0};
        request.dt_s /= EXTRA_STEP_RATIO;
        request.rtol *= EXTRA_RTOL_RATIO;
        request.first_step_factor = request.kind->has_fixed_step
                                      ? request.first_step_factor / EXTRA_STEP_RATIO
                                      : (i == 0 ? 1.0 : ESTIMATE_FIRST_STEP_FACTOR) /
                                            EXTRA_STEP_RATIO;
        run_additional_pass(&pass, m, &request, options, result);
        if (pass.status == SIM_OK) {
            widen_error(result, pass_compare(&runs->fine, &pass), ERROR_FACTOR);
            if (runs->is_result_coarse)
                widen_error(result, pass_compare(&runs->coarse, &pass), ERROR_FACTOR);
        }
        pass_outcome_free(&pass);
    }
}

static bool is_result_sensitive(const struct model *m, const struct solver_passes *runs,
                                const struct sim_result *result)
{
    if (!runs->fine_request.kind->has_fixed_step)
        return fmax(result->error_u_ft, result->error_lift_ft) >
               SENSITIVE_TOLERANCE_RATIO * runs->fine_request.rtol * m->length_ft;
    return result->error_u_ft > SENSITIVE_ERROR_MIN * sim_record_peak(&runs->fine.record).u_ft ||
           result->error_lift_ft > SENSITIVE_ERROR_MIN * runs->fine.max_lift_ft;
}

/* If the result is sensitive, adds runs with slightly different stiffnesses to the estimate. */
static void add_runs_if_sensitive(struct model *m, const struct sim_options *options,
                                  const struct solver_passes *runs, struct sim_result *result)
{
    bool fixed = runs->fine_request.kind->has_fixed_step;
    if (!is_result_sensitive(m, runs, result))
        return;
    sim_result_add_note(
        result,
        "sensitive result: errors grow %s; the error estimate also uses one run with a smaller %s "
        "and %d runs with stiffnesses changed by %g of their value",
        fixed ? "to more than a twentieth of the movement" : "more than 1000-fold",
        fixed ? "step" : "tolerance", DIVERGENCE_RUN_COUNT, STIFFNESS_NUDGE);
    const struct pass_outcome *answer = runs->is_result_coarse ? &runs->coarse : &runs->fine;
    struct pass_request finer = runs->fine_request;
    finer.rtol = fmax(ESTIMATE_MIN_RTOL, finer.rtol / ESTIMATE_RTOL_RATIO);
    finer.dt_s /= ESTIMATE_FIXED_STEP_RATIO;
    finer.first_step_factor /=
        ESTIMATE_FIXED_STEP_RATIO; /* first_step_factor is 0 unless the step is fixed */
    for (int run = -1; run < DIVERGENCE_RUN_COUNT; run++) {
        struct pass_outcome pass = {0};
        if (run < 0)
            run_additional_pass(&pass, m, &finer, options, result);
        else
            run_nudged_pass(m, &runs->fine_request, options, run, &pass, result);
        if (pass.status == SIM_OK)
            widen_error(result, pass_compare(answer, &pass),
                        run < 0 && !fixed ? FINER_ERROR_FACTOR : ERROR_FACTOR);
        pass_outcome_free(&pass);
    }
}

/* Computes the error estimate of the result, making additional runs if necessary. Returns false if
 * the two passes contradict each other. `where`: their largest difference. */
static bool estimate_error(struct model *m, const struct sim_options *options,
                           struct solver_passes *runs, struct sim_result *result,
                           struct sim_difference *where)
{
    const struct stepper_kind *kind = runs->fine_request.kind;
    const struct pass_outcome *a = &runs->coarse, *b = &runs->fine;
    struct pass_difference difference = pass_compare(a, b);
    /* Correct for chance: two passes can agree more closely than their errors allow, because errors
     * of single steps add up like random numbers. */
    double grown = fmax(1.0, ERROR_GROWTH_PER_ROOT_STEP * sqrt((double)b->steps));
    double least_ft = kind->has_fixed_step ? 0.0 : runs->fine_request.rtol * m->length_ft;
    *where = difference.u;
    result->error_u_ft = result->error_lift_ft = 0.0;
    widen_error(result, difference,
                !is_sampling_kind(kind)  ? 1.0
                : runs->is_result_coarse ? COARSER_ERROR_FACTOR
                                         : ERROR_FACTOR);
    if (!passes_agree(m->scene, a, b, difference))
        return false;
    widen_error_by_third_pass(m, options, runs, result);
    if (!add_event_run(m, options, runs, result)) {
        add_finer_run_after_bounces(m, options, runs, result);
        add_runs_if_only_sampled(m, options, runs, result);
    }
    add_runs_if_sensitive(m, options, runs, result);
    result->error_u_ft += b->clock_error_ft;
    if (sim_record_peak(&a->record).u_ft > 0.0 && sim_record_peak(&b->record).u_ft > 0.0) {
        result->error_u_ft = fmax(result->error_u_ft, grown * least_ft);
        result->error_lift_ft = fmax(result->error_lift_ft, LIFT_ERROR_RATIO_MIN * least_ft);
    }
    return true;
}

/* ---- moreau's runs ----
 *
 * The method is in moreau.c.
 *
 * A scene is run with steps 1.9 times shorter each time, until the estimated error is below a
 * ten-thousandth of the largest movement and of the largest lift, or until MOREAU_WORK_MAX is used
 * up. The run with the shortest steps is the answer. The method is of order 1 where anything
 * switches: the error of the shortest steps is then 1.1 times the last difference, and 2.6 times
 * for order 1/2. The estimate is three times the larger of the last difference and the previous
 * difference divided by 1.9, so that runs that agree by chance do not make it too small. If the
 * runs with the shortest steps contradict each other, the result is `unpredictable` (above). With a
 * given step, the steps are the given one, 1.9 and 3.6 times as long. */
/* largest product of evaluations and mats of a run, about 10 s of computing time */
#define MOREAU_WORK_MAX 1.5e7

#define MOREAU_ERROR_FACTOR       3.0
#define MOREAU_FIRST_STEPS        500.0
#define MOREAU_ERROR_PER_PEAK_MAX 1e-4
#define MOREAU_MAX_RUNS           16
#define MOREAU_KEPT_RUNS          3

/* The latest runs of moreau. The last one has the shortest steps. */
struct moreau_runs {
    struct pass_outcome runs[MOREAU_KEPT_RUNS];
    int run_count; /* number of runs that are complete */
    struct pass_difference last_difference, previous_difference;
};

static void moreau_runs_add(struct moreau_runs *l, const struct pass_outcome *run)
{
    if (l->run_count == MOREAU_KEPT_RUNS) {
        pass_outcome_free(&l->runs[0]);
        l->runs[0] = l->runs[1];
        l->runs[1] = l->runs[2];
        l->run_count--;
    }
    l->runs[l->run_count++] = *run;
    l->previous_difference = l->last_difference;
    if (l->run_count > 1)
        l->last_difference = pass_compare(&l->runs[l->run_count - 2], &l->runs[l->run_count - 1]);
}

static void moreau_runs_clear(struct moreau_runs *l)
{
    for (int i = 0; i < l->run_count; i++)
        pass_outcome_free(&l->runs[i]);
    l->run_count = 0;
}

static bool moreau_runs_agree(const struct moreau_runs *l, const struct sim_scene *scene)
{
    return l->run_count == MOREAU_KEPT_RUNS &&
           passes_agree(scene, &l->runs[1], &l->runs[2], l->last_difference);
}

static void fill_moreau_error(const struct moreau_runs *l, struct sim_result *result)
{
    double before = l->run_count == MOREAU_KEPT_RUNS ? 1.0 / ESTIMATE_FIXED_STEP_RATIO : 0.0;
    result->error_u_ft = MOREAU_ERROR_FACTOR * fmax(l->last_difference.u.u_ft,
                                                    before * l->previous_difference.u.u_ft) +
                         l->runs[l->run_count - 1].clock_error_ft;
    result->error_lift_ft = MOREAU_ERROR_FACTOR * fmax(l->last_difference.lift_ft,
                                                       before * l->previous_difference.lift_ft);
}

static bool is_moreau_error_small(const struct moreau_runs *l, const struct sim_scene *scene,
                                  const struct sim_result *result)
{
    const struct pass_outcome *best = &l->runs[l->run_count - 1];
    double lift_ft = fmax(best->max_lift_ft, pass_bow_threshold_ft(scene));
    return moreau_runs_agree(l, scene) &&
           result->error_u_ft <= MOREAU_ERROR_PER_PEAK_MAX * sim_record_peak(&best->record).u_ft &&
           result->error_lift_ft <= MOREAU_ERROR_PER_PEAK_MAX * lift_ft;
}

static void fill_moreau_result(struct model *m, const struct sim_options *options,
                               const struct pass_request *request, struct moreau_runs *l,
                               bool given, struct sim_result *result)
{
    struct pass_outcome *best = &l->runs[l->run_count - 1], *other = &l->runs[l->run_count - 2];
    if (!moreau_runs_agree(l, m->scene)) {
        sim_result_set_status(result, SIM_UNSTABLE, l->last_difference.u.mat,
                              l->last_difference.u.t_s);
        if (!given)
            set_run_divergence(m, request, options, best, other, result);
    }
    pass_fill_result(m, best, other, result);
}

static void run_moreau(const struct model *model, const struct sim_options *options,
                       struct sim_result *result)
{
    struct model m = *model;
    struct moreau_runs moreau_runs = {0};
    bool given = options->dt_s > 0.0;
    double work = 0.0, end_s = sim_scene_end_s(m.scene);
    struct pass_request request = {&stepper_moreau,
                                   0.0,
                                   given ? options->dt_s * ESTIMATE_FIXED_STEP_RATIO *
                                               ESTIMATE_FIXED_STEP_RATIO
                                         : end_s / MOREAU_FIRST_STEPS,
                                   UINT64_MAX,
                                   0,
                                   ESTIMATE_STEP_SPAN_SHARE};
    if (m.friction_law == SIM_FRICTION_SIGN) {
        m.friction_law = SIM_FRICTION_STICK;
        sim_result_add_note(result,
                            "friction law 'stick' is used, the exact form of the law 'sign'");
    }
    sim_result_add_note(result, "error estimate: three times the largest difference to runs with "
                                "1.9 and 3.6 times the step");
    for (int i = 0; i < MOREAU_MAX_RUNS; i++) {
        struct pass_outcome run = {0};
        request.pass_number = ++result->pass_count;
        request.max_steps = given ? UINT64_MAX : (uint64_t)(MOREAU_WORK_MAX / (double)m.mats);
        pass_run(&run, &m, &request, options);
        double done = (double)run.evaluations * m.mats;
        add_pass_cost(result, &run);
        work += done;
        if (run.status == SIM_INTERRUPTED) {
            sim_result_set_status(result, run.status, run.mat, run.t_s);
            pass_fill_result(&m, &run, &run, result);
            pass_outcome_free(&run);
            moreau_runs_clear(&moreau_runs);
            return;
        }
        bool more = given ? i + 1 < MOREAU_KEPT_RUNS
                          : i + 1 < MOREAU_MAX_RUNS &&
                                work + ESTIMATE_FIXED_STEP_RATIO * done < MOREAU_WORK_MAX;
        if (run.status == SIM_OK) {
            moreau_runs_add(&moreau_runs, &run);
            fill_moreau_error(&moreau_runs, result);
        } else { /* runs with longer steps are no longer needed */
            sim_result_set_status(result, run.status, run.mat, run.t_s);
            pass_outcome_free(&run);
            moreau_runs_clear(&moreau_runs);
        }
        if (!more || (!given && is_moreau_error_small(&moreau_runs, m.scene, result)))
            break;
        request.dt_s /= ESTIMATE_FIXED_STEP_RATIO;
        request.first_step_factor /= ESTIMATE_FIXED_STEP_RATIO;
    }
    if (moreau_runs.run_count >= 2) {
        result->status = SIM_OK;
        /* the error of positions is at least as large as that of solver event */
        if (sim_record_peak(&moreau_runs.runs[moreau_runs.run_count - 1].record).u_ft > 0.0)
            result->error_lift_ft = fmax(result->error_lift_ft,
                                         LIFT_ERROR_RATIO_MIN * stepper_event.rtol * m.length_ft);
        fill_moreau_result(&m, options, &request, &moreau_runs, given, result);
    } else if (moreau_runs.run_count == 1) {
        sim_result_set_status(result, SIM_UNSTABLE, 1, end_s);
    }
    moreau_runs_clear(&moreau_runs);
}

/* ---- solver auto ---- */

/* Largest number of steps before auto changes to another solver. */
static uint64_t max_steps_before_change(const struct model *m, const struct stepper_kind *kind,
                                        bool last, const struct sim_result *result)
{
    double steps = event_stability_steps(m, result);
    if (kind == &stepper_event)
        return last ? (uint64_t)(2.0 * steps) + MAX_EVENT_STEPS : MAX_EVENT_STEPS;
    if (last || steps > MAX_STABILITY_STEPS)
        return MAX_AUTO_STEPS;
    return (uint64_t)fmax(MAX_IMPLICIT_STEPS, steps / ESTIMATE_STEP_COST_RATIO);
}

static const struct stepper_kind *choose_solver(const struct sim_scene *scene,
                                                const struct sim_options *options, double rate,
                                                struct sim_result *result)
{
    double steps = rate * sim_scene_end_s(scene) / ESTIMATE_EVENT_STABILITY;
    if (!is_solver_automatic(options))
        return stepper_find(options->solver);
    if (scene->friction_law == SIM_FRICTION_SIGN && scene->friction > 0.0)
        sim_result_add_note(result, "auto: law 'stick' is used, the exact form of friction law "
                                    "'sign', which does not define the force on a mat at rest");
    if (steps <= ESTIMATE_EVENT_STEPS_MAX) {
        sim_result_add_note(result,
                            "auto: event is used, because the fastest rate, %.4g /s, requires at "
                            "most %.0f explicit steps",
                            rate, ceil(steps));
        return &stepper_event;
    }
    sim_result_add_note(result,
                        "auto: implicit is used, because the fastest rate, %.4g /s, would require "
                        "%.3g explicit steps",
                        rate, steps);
    return &stepper_implicit;
}

/* Runs `coarse` and `fine`. `is_result_coarse`: the result is that of `coarse`, otherwise that of
 * `fine`. `last`: no other solver is tried, so if the runs contradict each other the result is
 * SIM_UNPREDICTABLE. */
static void run_coarse_and_fine(struct model *m, const struct sim_options *options,
                                struct pass_request request, bool is_result_coarse, bool last,
                                bool *contradicted, struct sim_result *result)
{
    struct solver_passes runs = {
        .coarse_request = request, .fine_request = request, .is_result_coarse = is_result_coarse};
    struct pass_outcome *coarse = &runs.coarse, *fine = &runs.fine;
    struct sim_difference where;
    runs.coarse_request.first_step_factor = request.kind->has_fixed_step
                                              ? ESTIMATE_STEP_SPAN_SHARE
                                              : ESTIMATE_FIRST_STEP_FACTOR;
    if (request.kind->has_fixed_step)
        runs.fine_request.first_step_factor = ESTIMATE_STEP_SPAN_SHARE / ESTIMATE_FIXED_STEP_RATIO;
    if (request.kind->has_fixed_step && is_result_coarse)
        runs.fine_request.dt_s /= ESTIMATE_FIXED_STEP_RATIO;
    else if (request.kind->has_fixed_step)
        runs.coarse_request.dt_s = ESTIMATE_FIXED_STEP_RATIO * (runs.fine_request.dt_s *= 0.5);
    else
        runs.coarse_request.rtol = fmin(1e-2, request.rtol * ESTIMATE_RTOL_RATIO);
    *contradicted = false;
    runs.coarse_request.pass_number = ++result->pass_count;
    pass_run(coarse, m, &runs.coarse_request, options);
    add_pass_cost(result, coarse);
    runs.fine_request.pass_number = result->pass_count + 1;
    if (coarse->status == SIM_INTERRUPTED) {
        sim_result_set_status(result, coarse->status, coarse->mat, coarse->t_s);
        pass_fill_result(m, coarse, coarse, result);
    } else {
        result->pass_count++;
        pass_run(fine, m, &runs.fine_request, options);
        add_pass_cost(result, fine);
        const struct pass_outcome *failed = fine->status != SIM_OK   ? fine
                                          : coarse->status != SIM_OK ? coarse
                                                                     : NULL;
        if (failed) {
            sim_result_set_status(result, failed->status, failed->mat, failed->t_s);
            result->reason = failed->reason;
            *contradicted = fine->status == SIM_OK;
        } else if (!estimate_error(m, options, &runs, result, &where)) {
            sim_result_set_status(result, SIM_UNSTABLE, where.mat, where.t_s);
            *contradicted = true;
            if (last)
                set_run_divergence(m, &runs.fine_request, options, fine, coarse, result);
        }
        pass_fill_result(m, is_result_coarse ? coarse : fine, is_result_coarse ? fine : coarse,
                         result);
    }
    pass_outcome_free(coarse);
    pass_outcome_free(fine);
    pass_outcome_free(&runs.third);
}

static enum mr_status run_fixed_step_solver(struct model *m, const struct sim_options *options,
                                            const struct stepper_kind *kind,
                                            struct sim_result *result, struct error *error)
{
    double end = sim_scene_end_s(m->scene);
    bool given = options->dt_s > 0.0, contradicted;
    double dt = given ? options->dt_s : fmin(0.5 * result->dt_limit_s, end / 500.0);
    struct pass_request request = {kind, 0.0, dt, UINT64_MAX, 0, 0.0};
    if (end / dt > MAX_FIXED_STEPS)
        return error_set(error, MR_USAGE,
                         "too many steps: %s: tend is %g s and the step is %g s; give a smaller "
                         "tend, a larger dt or --solver implicit",
                         sim_scene_name(m->scene), end, dt);
    sim_result_add_note(
        result, given ? "error estimate: from the largest difference to runs with a smaller step "
                        "(1/1.9) and, where needed and stable, a larger step (1.9 times)"
                      : "error estimate: from the largest difference to runs with larger steps "
                        "(1.9 times and, where needed and stable, 3.6 times)");
    if (dt > result->dt_limit_s) {
        result->dt_s = dt;
        sim_result_set_status(result, SIM_UNSTABLE, m->span.mat >= 0 ? m->span.mat + 1 : 1, 0.0);
        return MR_OK;
    }
    run_coarse_and_fine(m, options, request, given, false, &contradicted, result);
    return MR_OK;
}

static void run_adaptive_solver(struct model *m, const struct sim_options *options,
                                const struct stepper_kind *kind, bool last,
                                struct sim_result *result)
{
    bool given = options->rtol > 0.0, contradicted;
    uint64_t most = m->friction_law == SIM_FRICTION_SIGN ? MAX_SIGN_STEPS
                  : is_solver_automatic(options) ? max_steps_before_change(m, kind, last, result)
                                                 : MAX_STEPS;
    struct pass_request request = {kind, given ? options->rtol : kind->rtol, 0.0, most, 0, 0.0};
    sim_result_add_note(
        result,
        "error estimate: largest difference to the same run at a 30 times looser tolerance");
    for (int i = 0;; i++) {
        result->status = SIM_OK;
        run_coarse_and_fine(m, options, request, false, !given && i == MAX_TIGHTENINGS,
                            &contradicted, result);
        if (!contradicted || i == MAX_TIGHTENINGS || given)
            break;
        request.rtol = fmax(ESTIMATE_MIN_RTOL, request.rtol * TIGHTENED_RTOL_FACTOR);
        sim_result_add_note(
            result,
            "the run was repeated at rtol %.3g, because the results at two tolerances disagreed",
            request.rtol);
    }
}

/* Adds a note that `auto` has changed the solver, because the first one ended with
 * SIM_STEP_UNDERFLOW. */
static void note_solver_change(struct sim_result *result, const char *left, const char *next)
{
    sim_result_add_note(result, "auto: %s reached only %.*g s, because %s; %s is used instead",
                        left, sim_time_digits(result->start_s, 9), result->start_s + result->t_s,
                        result->reason ? result->reason : "the run makes no progress", next);
    result->reason = NULL;
}

/* Runs the remaining solvers if the first two made no progress because there are too many switches:
 * hamming samples them; moreau solves any number of them in one step. */
static void run_fallback_solvers(struct model *m, const struct sim_options *options,
                                 struct sim_result *result)
{
    const struct stepper_kind *const kinds[] = {&stepper_hamming, &stepper_moreau};
    for (int i = 0; i < 2 && result->status == SIM_STEP_UNDERFLOW; i++) {
        note_solver_change(result, result->solver, kinds[i]->name);
        result->status = SIM_OK;
        result->solver = kinds[i]->name;
        if (i == 0)
            run_adaptive_solver(m, options, kinds[i], true, result);
        else
            run_moreau(m, options, result);
    }
}

/* Runs the second solver of auto, then the remaining ones. */
static void run_second_solver(struct model *m, const struct sim_options *options,
                              const struct stepper_kind *first, struct sim_result *result)
{
    const struct stepper_kind *other = first == &stepper_event ? &stepper_implicit : &stepper_event;
    /* if few parts move, the fastest rate does not matter, and event may still make progress */
    bool last = other != &stepper_event || event_stability_steps(m, result) <= MAX_STABILITY_STEPS;
    note_solver_change(result, first->name, other->name);
    result->status = SIM_OK;
    result->solver = other->name;
    run_adaptive_solver(m, options, other, last, result);
    if (result->status == SIM_STEP_UNDERFLOW && options->rtol == 0.0)
        run_fallback_solvers(m, options, result);
}

/* Runs solver auto: if the first solver makes no progress, runs the others, for at most
 * PLANAR_OTHER_SOLVERS_S in total. If none succeeds, the error of the first solver is reported. */
static void run_auto(struct model *m, const struct sim_options *options,
                     const struct stepper_kind *kind, struct sim_result *result)
{
    struct deadline deadline;
    bool last = kind == &stepper_implicit && event_stability_steps(m, result) > MAX_STABILITY_STEPS;
    run_adaptive_solver(m, options, kind, last, result);
    if (result->status != SIM_STEP_UNDERFLOW)
        return;
    /* copying the struct is safe, because a failed result has no arrays */
    struct sim_result refused = *result;
    deadline_begin(&deadline, options, PLANAR_OTHER_SOLVERS_S);
    run_second_solver(m, &deadline.options, kind, result);
    if (deadline.is_exceeded) {
        memcpy(refused.notes, result->notes, sizeof refused.notes);
        refused.evaluations = result->evaluations;
        refused.pass_count = result->pass_count;
        sim_result_add_note(&refused,
                            "auto: within the computing limit of %g s of each solver, %s reached "
                            "%.*g s of simulated time",
                            PLANAR_OTHER_SOLVERS_S, result->solver,
                            sim_time_digits(result->start_s, 9), result->start_s + result->t_s);
        sim_result_free(result);
        *result = refused;
    }
}

/* Runs a scene with any solver except `staggered`. */
static enum mr_status run_planar(const struct sim_scene *scene, const struct sim_options *options,
                                 struct sim_result *result, struct error *error)
{
    struct model model;
    double begin_s = monotonic_s();
    if (options->solver && strcmp(options->solver, "staggered") == 0)
        return error_set(
            error, MR_USAGE,
            "solver not available: staggered for model %s; give rk4, or model consistent",
            sim_model_name(scene->model));
    double *z = xcalloc(2 * (2 * (size_t)scene->mats + 1), sizeof *z);
    if (model_make(&model, scene, false, error) != MR_OK) {
        free(z);
        return error->status;
    }
    if (is_solver_automatic(options) && model.friction_law == SIM_FRICTION_SIGN)
        model.friction_law = SIM_FRICTION_STICK;
    model_start(&model, z);
    double rate = model_fastest_rate(&model, z, MODEL_RATE_EXPLICIT);
    const struct stepper_kind *kind = choose_solver(scene, options, rate, result);
    result->solver = kind->name;
    result->mats = scene->mats;
    result->t_end_s = sim_scene_end_s(scene);
    result->dt_limit_s = rate > 0.0 ? ESTIMATE_RK4_STABILITY / rate : HUGE_VAL;
    model_describe(&model, result);
    if (options->dt_s > 0.0 && !kind->has_fixed_step)
        error_set(error, MR_USAGE,
                  "solver %s chooses its step and ignores --dt; give --rtol, or --solver rk4",
                  kind->name);
    else if (options->rtol > 0.0 && kind->has_fixed_step)
        error_set(error, MR_USAGE,
                  "solver %s has a fixed step and ignores --rtol; give --dt, or another solver",
                  kind->name);
    else if (kind == &stepper_moreau)
        run_moreau(&model, options, result);
    else if (kind->has_fixed_step)
        run_fixed_step_solver(&model, options, kind, result, error);
    else if (is_solver_automatic(options))
        run_auto(&model, options, kind, result);
    else
        run_adaptive_solver(&model, options, kind, true, result);
    result->run_ms = 1e3 * (monotonic_s() - begin_s);
    model_free(&model);
    free(z);
    return error->status;
}

static bool is_result_undecided(const struct sim_result *result)
{
    return result->status == SIM_UNPREDICTABLE || result->status == SIM_STEP_UNDERFLOW;
}

/* Retries a landing for which no step of `staggered` gives a result. Uses solvers that locate
 * switches, if they support the laws of the scene. Replaces the result if they succeed. */
static enum mr_status retry_with_located_switches(const struct sim_scene *scene,
                                                  const struct sim_options *options,
                                                  struct sim_result *result, struct error *error)
{
    struct sim_result other = {.start_s = result->start_s};
    struct error not_theirs = {0};
    struct deadline deadline;
    deadline_begin(&deadline, options, PLANAR_OTHER_SOLVERS_S);
    if (run_planar(scene, &deadline.options, &other, &not_theirs) != MR_OK ||
        other.status != SIM_OK) {
        if (deadline.is_exceeded)
            sim_result_add_note(result,
                                "auto: the other solvers reached their computing limit of %g s",
                                PLANAR_OTHER_SOLVERS_S);
        sim_result_free(&other);
        return MR_OK;
    }
    other.run_ms += result->run_ms;
    other.evaluations += result->evaluations;
    sim_result_add_note(&other, "auto: staggered failed beyond %.*g s",
                        sim_time_digits(result->start_s, 6), result->start_s + result->t_s);
    sim_result_free(result);
    *result = other;
    return error->status;
}

enum mr_status planar_run(const struct sim_scene *scene, const struct sim_options *options,
                          struct sim_result *result, struct error *error)
{
    bool landing = scene->model == SIM_MODEL_CONSISTENT && scene->path_count > 0;
    if (options->solver && strcmp(options->solver, "staggered") == 0
            ? scene->model == SIM_MODEL_CONSISTENT
            : landing && is_solver_automatic(options)) {
        if (is_solver_automatic(options))
            sim_result_add_note(result,
                                "auto: staggered is used, because a whole landing has too many "
                                "events (contact, sticking, slipping) to locate each event");
        if (landing_run(scene, options, result, error) != MR_OK || !is_solver_automatic(options) ||
            !is_result_undecided(result) || options->dt_s > 0.0 || options->is_single_pass)
            return error->status;
        return retry_with_located_switches(scene, options, result, error);
    }
    return run_planar(scene, options, result, error);
}
