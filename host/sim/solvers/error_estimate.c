#include "host/sim/solvers/error_estimate.h"

#include <math.h>
#include <string.h>

/* ---- how far two passes differ ---- */

struct pass_difference pass_difference(const struct pass_outcome *a, const struct pass_outcome *b)
{
    return (struct pass_difference){sim_record_difference(&a->record, &b->record),
                                    fmax(sim_record_lift_difference(&a->record, &b->record),
                                         fabs(a->max_lift_ft - b->max_lift_ft))};
}

bool passes_agree(const struct sim_scene *scene, const struct pass_outcome *a,
                  const struct pass_outcome *b, struct pass_difference apart)
{
    double threshold = pass_bow_threshold_ft(scene);
    double peak = fmin(sim_record_peak(&a->record).u_ft, sim_record_peak(&b->record).u_ft);
    double lift = fmin(a->max_lift_ft, b->max_lift_ft);
    return apart.u.u_ft <= PASS_DISAGREEMENT * peak + 1e-9 * scene->length_ft &&
           apart.lift_ft <= PASS_DISAGREEMENT * lift + 0.01 * threshold &&
           (a->max_lift_ft > threshold) == (b->max_lift_ft > threshold);
}

/* ---- runs that diverge ---- */

void divergence_find(struct sim_result *result, const struct sim_record *given,
                     const struct sim_record *other, double most_u_ft, double most_lift_ft)
{
    bool parted = false;
    result->error_u_ft = fmax(result->error_u_ft, sim_record_difference(given, other).u_ft);
    result->error_lift_ft = fmax(result->error_lift_ft, sim_record_lift_difference(given, other));
    for (size_t i = 0; i < given->snapshot_count && !parted; i++) {
        const struct sim_snapshot *a = &given->snapshots[i], *b = &other->snapshots[i];
        double apart_ft = 0.0;
        int mat = 1;
        for (int n = 1; n <= given->mats; n++) {
            if (fabs(a->u_ft[n] - b->u_ft[n]) > apart_ft) {
                apart_ft = fabs(a->u_ft[n] - b->u_ft[n]);
                mat = n;
            }
        }
        parted = apart_ft > most_u_ft || fabs(a->lift_ft - b->lift_ft) > most_lift_ft;
        if (parted && (result->status != SIM_UNPREDICTABLE || a->t_s < result->t_s))
            sim_result_end(result, SIM_UNPREDICTABLE, mat, a->t_s);
    }
    if (!parted && result->status != SIM_UNPREDICTABLE) /* in a lift between those times */
        sim_result_end(result, SIM_UNPREDICTABLE, 1, given->end_s);
}

/* The same scene, known a little otherwise: both stiffnesses up, or one up and one down, ... */
static struct model nudged(const struct model *m, int run)
{
    struct model other = *m;
    other.kl *= 1.0 + (run & 1 ? DIVERGENCE_PART : -DIVERGENCE_PART);
    other.kv *= 1.0 + (run & 2 ? DIVERGENCE_PART : -DIVERGENCE_PART);
    return other;
}

/* One pass of the scene, known a little otherwise: run 0 to DIVERGENCE_RUNS - 1. */
static void divergence_nudged(const struct model *m, const struct pass_request *request,
                              const struct sim_options *options, int run, struct pass_outcome *pass,
                              struct sim_result *result)
{
    struct model near = nudged(m, run);
    struct pass_request again = *request;
    again.number = ++result->passes;
    pass_run(pass, &near, &again, options);
    result->rhs += pass->rhs;
}

void divergence_state(const struct model *m, const struct pass_request *request,
                      const struct sim_options *options, const struct pass_outcome *given,
                      const struct pass_outcome *other, struct sim_result *result)
{
    double threshold = pass_bow_threshold_ft(m->scene);
    double most_u_ft = PASS_DISAGREEMENT * sim_record_peak(&given->record).u_ft,
           most_lift_ft = PASS_DISAGREEMENT * given->max_lift_ft + 0.01 * threshold;
    result->status = SIM_OK;
    result->spread_runs = 1;
    result->spread_waves = given->max_lift_ft > threshold;
    for (int run = -1; run < DIVERGENCE_RUNS; run++) {
        struct pass_outcome pass = {0};
        if (run >= 0)
            divergence_nudged(m, request, options, run, &pass, result);
        const struct pass_outcome *next = run < 0 ? other : &pass;
        if (next->status == SIM_OK) {
            result->spread_runs++;
            result->spread_waves += next->max_lift_ft > threshold;
            divergence_find(result, &given->record, &next->record, most_u_ft, most_lift_ft);
            result->error_lift_ft = fmax(result->error_lift_ft,
                                         fabs(given->max_lift_ft - next->max_lift_ft));
        }
        pass_free(&pass);
    }
}

/* ---- the estimate ---- */

/* An estimate beyond so many tolerances: errors grow on the way, and chance decides how much. */
#define SENSITIVE      1000.0
#define SENSITIVE_PART 0.05 /* without a tolerance: beyond this part of what moves */
/* Times the difference of two passes that sample their switches: of first order the finer one's
 * error is as large as that. */
#define CAUTION        2.0
#define FINER_CAUTION  1.2 /* to a finer one */
#define LONGER_CAUTION 4.0 /* the same where the coarser one answers: twice as far off */
#define OTHERS_CAUTION 1.5 /* to one of another method */
/* Steps that another method may always have. */
#define LEAST_OTHERS   5000.0
#define EVENT_RHS      12.0 /* evaluations in a step of event */
/* Runs that are added where no other method answers: steps and tolerances of no simple ratio. */
#define MORE_RUNS      2
#define MORE_GRID      1.37
#define MORE_RTOL      2.2

bool solver_is_automatic(const struct sim_options *options)
{
    return !options->solver || strcmp(options->solver, "auto") == 0;
}

double explicit_steps(const struct model *m, const struct sim_result *result)
{
    return ESTIMATE_RK4_REAL / result->dt_limit_s * sim_scene_end_s(m->scene) /
           ESTIMATE_EXPLICIT_REACH;
}

void cost_add(struct sim_result *result, const struct pass_outcome *pass)
{
    result->rhs += pass->rhs;
    result->rejected += pass->rejected;
}

static void widen(struct sim_result *result, struct pass_difference apart, double factor)
{
    result->error_u_ft = fmax(result->error_u_ft, factor * apart.u.u_ft);
    result->error_lift_ft = fmax(result->error_lift_ft, factor * apart.lift_ft);
}

static bool samples(const struct stepper_kind *kind)
{
    return kind->samples || kind->samples_shape;
}

/* Another run, complete or not. */
static void again(struct pass_outcome *pass, struct model *m, const struct pass_request *request,
                  const struct sim_options *options, struct sim_result *result)
{
    struct pass_request numbered = *request;
    numbered.number = ++result->passes;
    pass_run(pass, m, &numbered, options);
    cost_add(result, pass);
}

/* Two passes can be as close as they like by chance where their switches are sampled or are not the
 * same: then a third says how far they can be apart. With a fixed step it has a longer one, where
 * that is stable; else a tolerance between the two. One that fails says nothing. */
static void doubt(struct model *m, const struct sim_options *options, struct error_pair *runs,
                  struct sim_result *result)
{
    const struct stepper_kind *kind = runs->request.kind;
    struct pass_request request = runs->request;
    if (!samples(kind) && runs->coarse.switched == runs->fine.switched)
        return;
    request.rtol *= sqrt(ESTIMATE_CHECK_FACTOR);
    request.first_part = ESTIMATE_FIRST_PART * ESTIMATE_FIRST_PART;
    request.dt_s = ESTIMATE_GRID_RATIO * runs->check.dt_s;
    bool longer = request.dt_s <= result->dt_limit_s;
    if (!longer)
        request.dt_s = runs->request.dt_s / ESTIMATE_GRID_RATIO;
    again(&runs->third, m, &request, options, result);
    if (runs->third.status != SIM_OK)
        return;
    double share = CAUTION;
    widen(result, pass_difference(&runs->coarse, &runs->fine), share);
    struct pass_difference coarse = pass_difference(&runs->coarse, &runs->third),
                           fine = pass_difference(&runs->fine, &runs->third);
    if (!kind->fixed) {
        widen(result, coarse, share);
        widen(result, fine, share);
    } else if (!longer) {
        widen(result, fine, share);
        widen(result, coarse, runs->coarse_answers ? share : 1.0);
    } else if (passes_agree(m->scene, &runs->coarse, &runs->third, coarse)) {
        widen(result, coarse, share / ESTIMATE_GRID_RATIO);
    }
}

/* Steps that event may have for a check: so many as cost what the runs have cost. 0: it is of no
 * use. A solver that samples its switches is wrong by where they fall in its steps, in all of its
 * runs alike if chance will have it; implicit by what its long steps pass over. */
static uint64_t others_steps(const struct model *m, const struct sim_options *options,
                             const struct error_pair *runs, const struct sim_result *result)
{
    const struct pass_outcome *coarse = &runs->coarse, *fine = &runs->fine;
    bool implicit = runs->request.kind == &stepper_implicit,
         automatic = solver_is_automatic(options);
    double asked = explicit_steps(m, result);
    double most = implicit ? ESTIMATE_STEP_RATIO * (double)(coarse->steps + fine->steps)
                           : (double)(coarse->rhs + fine->rhs) / EVENT_RHS;
    /* auto has tried event before it came to others, and to implicit where that is not the first */
    bool tried = automatic && (!implicit || asked <= ESTIMATE_EXPLICIT_STEPS);
    bool useful = samples(runs->request.kind) ||
                  (runs->request.kind != &stepper_event && fine->events > 0);
    most = fmax(most, LEAST_OTHERS);
    return useful && !tried && asked <= most ? (uint64_t)most : 0;
}

/* Runs of one solver share its mistakes: a run of event, which locates every switch, joins. Whether
 * it came to an end. */
static bool cross(struct model *m, const struct sim_options *options, struct error_pair *runs,
                  struct sim_result *result)
{
    struct pass_outcome pass = {0};
    struct pass_request request = {
        .kind = &stepper_event,
        .rtol = stepper_event.rtol,
        .most_steps = others_steps(m, options, runs, result),
    };
    if (request.most_steps == 0)
        return false;
    again(&pass, m, &request, options, result);
    bool done = pass.status == SIM_OK;
    if (done) {
        sim_result_note(result, "a run of solver event, which locates its switches, is in the "
                                "error estimate");
        const struct pass_outcome *answer = runs->coarse_answers ? &runs->coarse : &runs->fine;
        widen(result, pass_difference(answer, &pass), OTHERS_CAUTION);
    }
    pass_free(&pass);
    return done;
}

/* Switches that are sampled, and no other method to say where they are: something hovers, and each
 * step follows it in a way of its own, as runs do that are alike by chance. More runs say how far
 * that goes. */
static void linger(struct model *m, const struct sim_options *options,
                   const struct error_pair *runs, struct sim_result *result)
{
    struct pass_request request = runs->request;
    if (!samples(request.kind))
        return;
    sim_result_note(result, "switches are sampled, and no run of another method says where they "
                            "are: two more runs are in the error estimate");
    for (int i = 0; i < MORE_RUNS; i++) {
        struct pass_outcome pass = {0};
        request.dt_s /= MORE_GRID;
        request.rtol *= MORE_RTOL;
        request.first_part = (i == 0 ? 1.0 : ESTIMATE_FIRST_PART) / MORE_GRID;
        again(&pass, m, &request, options, result);
        if (pass.status == SIM_OK) {
            widen(result, pass_difference(&runs->fine, &pass), CAUTION);
            if (runs->coarse_answers)
                widen(result, pass_difference(&runs->coarse, &pass), CAUTION);
        }
        pass_free(&pass);
    }
}

static bool sensitive(const struct model *m, const struct error_pair *runs,
                      const struct sim_result *result)
{
    if (!runs->request.kind->fixed)
        return fmax(result->error_u_ft, result->error_lift_ft) >
               SENSITIVE * runs->request.rtol * m->length_ft;
    return result->error_u_ft > SENSITIVE_PART * sim_record_peak(&runs->fine.record).u_ft ||
           result->error_lift_ft > SENSITIVE_PART * runs->fine.max_lift_ft;
}

/* The answer is sensitive: what becomes of it when the scene is known a little otherwise. */
static void feel(struct model *m, const struct sim_options *options, const struct error_pair *runs,
                 struct sim_result *result)
{
    bool fixed = runs->request.kind->fixed;
    if (!sensitive(m, runs, result))
        return;
    sim_result_note(result,
                    "sensitive: errors grow %s; a finer run and %d with stiffnesses that differ by "
                    "%g are in the error estimate",
                    fixed ? "to more than a twentieth of what moves" : "more than 1000-fold",
                    DIVERGENCE_RUNS, DIVERGENCE_PART);
    const struct pass_outcome *answer = runs->coarse_answers ? &runs->coarse : &runs->fine;
    struct pass_request finer = runs->request;
    finer.rtol = fmax(ESTIMATE_LEAST_RTOL, finer.rtol / ESTIMATE_CHECK_FACTOR);
    finer.dt_s /= ESTIMATE_GRID_RATIO;
    for (int run = -1; run < DIVERGENCE_RUNS; run++) {
        struct pass_outcome pass = {0};
        if (run < 0)
            again(&pass, m, &finer, options, result);
        else
            divergence_nudged(m, &runs->request, options, run, &pass, result);
        if (pass.status == SIM_OK)
            widen(result, pass_difference(answer, &pass),
                  run < 0 && !fixed ? FINER_CAUTION : CAUTION);
        pass_free(&pass);
    }
}

bool error_estimate(struct model *m, const struct sim_options *options, struct error_pair *runs,
                    struct sim_result *result, struct sim_difference *where)
{
    const struct stepper_kind *kind = runs->request.kind;
    const struct pass_outcome *a = &runs->coarse, *b = &runs->fine;
    struct pass_difference apart = pass_difference(a, b);
    /* two passes can agree more closely than either is right */
    double least_ft = kind->fixed ? 0.0 : runs->request.rtol * m->length_ft;
    *where = apart.u;
    result->error_u_ft = result->error_lift_ft = 0.0;
    widen(result, apart, !samples(kind) ? 1.0 : runs->coarse_answers ? LONGER_CAUTION : CAUTION);
    if (!passes_agree(m->scene, a, b, apart))
        return false;
    doubt(m, options, runs, result);
    if (!cross(m, options, runs, result))
        linger(m, options, runs, result);
    feel(m, options, runs, result);
    if (sim_record_peak(&a->record).u_ft > 0.0 && sim_record_peak(&b->record).u_ft > 0.0)
        result->error_u_ft = fmax(result->error_u_ft, least_ft);
    if (fmin(a->max_lift_ft, b->max_lift_ft) > 0.0)
        result->error_lift_ft = fmax(result->error_lift_ft, least_ft);
    return true;
}
