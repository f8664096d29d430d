#include "host/sim/solvers/planar.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/solvers/landing.h"
#include "host/sim/solvers/pass.h"

#define TIGHTEN          0.01
#define MOST_TIGHTENINGS 2
#define MOST_STEPS       5000000u
#define MOST_CHATTER     50000u /* steps of event before auto tries implicit */
/* of implicit before auto tries event, or its share of event's steps */
#define MOST_IMPLICIT    20000u
#define MOST_AUTO        300000u /* of implicit, when there is nothing else */
#define MOST_SIGN        10000u  /* of friction `sign`, which chatters around rest */
#define MOST_FIXED_STEPS 400000000.0
/* of event for stability; where it would ask for more it has MOST_CHATTER */
#define EXPLICIT_MOST    500000.0
bool planar_has_solver(const char *name)
{
    return strcmp(name, "auto") == 0 || strcmp(name, "staggered") == 0 || stepper_find(name);
}

/* ---- deadline ---- */

static double clock_s(const struct sim_options *options)
{
    return options->clock_s ? options->clock_s(options->clock_ctx) : monotonic_s();
}

static bool in_time(void *ctx, int pass, double part)
{
    struct deadline *w = ctx;
    if (clock_s(w->asked) >= w->until_s) {
        w->late = true;
        return false;
    }
    return !w->asked->may_continue ||
           w->asked->may_continue(w->asked->may_continue_ctx, pass, part);
}

void deadline_begin(struct deadline *w, const struct sim_options *asked, double limit_s)
{
    *w = (struct deadline){.asked = asked, .options = *asked};
    if (limit_s <= 0.0)
        return;
    w->until_s = clock_s(asked) + limit_s;
    w->options.may_continue = in_time;
    w->options.may_continue_ctx = w;
}

/* ---- what an answer is worth: two passes of a solver, and the runs that join them. PLANAR.md,
 * "Error estimate" ---- */

/* Divergence: a scene that no finer step or tolerance decides.
 *
 * Runs that should be alike part: each switch that falls otherwise makes their difference larger,
 * and from some time on it is as large as what is computed. Then runs whose stiffnesses differ by
 * less than anybody knows them, DIVERGENCE_PART, say how far apart the scene's answers can be. The
 * result is SIM_UNPREDICTABLE: t_s and mat are where the first two of all runs part (by more than a
 * fifth of the largest movement or lift), the error estimates the largest difference of any of
 * them to the one whose numbers are given. */
#define DIVERGENCE_PART 1e-9
#define DIVERGENCE_RUNS 4 /* besides those that part */

/* Between the tolerances of two passes. */
#define ESTIMATE_CHECK_FACTOR   30.0
/* Between two fixed steps. Not 2: the shorter steps would end wherever the longer ones do, and
 * every other switch would be sampled at the same moment in both. */
#define ESTIMATE_GRID_RATIO     1.9
#define ESTIMATE_FIRST_PART     0.72 /* the first of steps that are halved and doubled */
#define ESTIMATE_SPAN_PART      0.5  /* of a span, for the longer of two fixed steps */
#define ESTIMATE_LEAST_RTOL     1e-13
/* Where the negative real axis leaves the classical method's stability region, and, about, the
 * order 8 method's. */
#define ESTIMATE_RK4_REAL       2.785
#define ESTIMATE_EXPLICIT_REACH 6.0
#define ESTIMATE_EXPLICIT_STEPS 10000.0 /* more than these for stability alone: implicit */
#define ESTIMATE_STEP_RATIO     4.0     /* a step of implicit costs as much as so many of event */

/* The runs of one scene with one solver: a coarse one and a fine one, complete, and a third. */
struct error_pair {
    struct pass_outcome coarse, fine, third;
    struct pass_request check, request; /* of coarse and fine */
    bool coarse_answers;
};

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

/* Passes that contradict each other, both complete: `given` is the one whose numbers are taken. */
static void divergence_state(const struct model *m, const struct pass_request *request,
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
/* What bounces: one joint or foot flips so often, and is much of all that flips; few steps go to
 * anything else. */
#define REBOUNDS       4
#define REBOUND_STEPS  100.0
#define PACE_AHEAD     0.02 /* of its steps it may have made before it gets anywhere */
/* Runs that are added where no other method answers: steps and tolerances of no simple ratio. */
#define MORE_RUNS      2
#define MORE_GRID      1.37
#define MORE_RTOL      2.2

/* A lift is what differences of the mats' positions leave: tolerances add up in it, and a lift of
 * their size can be missing in both runs. */
#define LIFT_FLOOR  10.0
#define FLOOR_STEPS 0.1 /* of the root of the number of steps, to a tolerance */

static bool solver_is_automatic(const struct sim_options *options)
{
    return !options->solver || strcmp(options->solver, "auto") == 0;
}

/* Steps of event that the stability limit alone asks for. */
static double explicit_steps(const struct model *m, const struct sim_result *result)
{
    return ESTIMATE_RK4_REAL / result->dt_limit_s * sim_scene_end_s(m->scene) /
           ESTIMATE_EXPLICIT_REACH;
}

static void cost_add(struct sim_result *result, const struct pass_outcome *pass)
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
    if (kind->fixed)
        request.first_part = longer ? runs->check.first_part * ESTIMATE_GRID_RATIO
                                    : runs->request.first_part / ESTIMATE_GRID_RATIO;
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
 * runs alike if chance will have it; implicit by what its long steps pass over, and by as much at
 * each bounce of mats that hit each other again and again. What stability asks for is for all that
 * can move; where implicit is judged and little of that moves, event may need far fewer steps, and
 * is tried as long as it gets on (`gets_on`). */
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
    return useful && !tried && (implicit || asked <= most) ? (uint64_t)most : 0;
}

/* A run that is stopped when it falls behind what its steps are meant to cover. */
struct pace {
    const struct sim_options *asked;
    double asks, most; /* may_continue is asked every so many steps */
};

static bool gets_on(void *ctx, int pass, double part)
{
    struct pace *pace = ctx;
    pace->asks++;
    return PASS_STEPS_BETWEEN_ASKING * pace->asks <= (part + PACE_AHEAD) * pace->most &&
           (!pace->asked->may_continue ||
            pace->asked->may_continue(pace->asked->may_continue_ctx, pass, part));
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
    struct pace pace = {options, 0.0, (double)request.most_steps};
    struct sim_options paced = *options;
    if (request.most_steps == 0)
        return false;
    paced.may_continue = gets_on;
    paced.may_continue_ctx = &pace;
    again(&pass, m, &request, &paced, result);
    bool done = pass.status == SIM_OK;
    if (done) {
        sim_result_note(
            result,
            "the error estimate includes a run of solver event, which locates its switches");
        const struct pass_outcome *answer = runs->coarse_answers ? &runs->coarse : &runs->fine;
        widen(result, pass_difference(answer, &pass), OTHERS_CAUTION);
    }
    pass_free(&pass);
    return done;
}

static bool bounces(const struct model *m, const struct pass_outcome *pass)
{
    return pass->flips_most >= REBOUNDS &&
           4.0 * m->mats * pass->flips_most >= (double)pass->events &&
           (double)pass->steps <= REBOUND_STEPS * (double)pass->events;
}

/* Implicit's error at a bounce is the same at every bounce of a run, and all that comes of it: two
 * runs in which it is alike by chance agree at all times. Without a run of event a finer one says:
 * it takes energy mostly, so that a third run between the two can be alike as well. */
static void rebound(struct model *m, const struct sim_options *options, struct error_pair *runs,
                    struct sim_result *result)
{
    struct pass_request request = runs->request;
    if (request.kind != &stepper_implicit || !bounces(m, &runs->fine) || runs->third.z)
        return;
    request.rtol = fmax(ESTIMATE_LEAST_RTOL, request.rtol / sqrt(ESTIMATE_CHECK_FACTOR));
    again(&runs->third, m, &request, options, result);
    if (runs->third.status == SIM_OK)
        widen(result, pass_difference(&runs->fine, &runs->third), CAUTION);
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
    sim_result_note(result, "switches are sampled, and no run of another method locates them: the "
                            "error estimate includes two more runs");
    for (int i = 0; i < MORE_RUNS; i++) {
        struct pass_outcome pass = {0};
        request.dt_s /= MORE_GRID;
        request.rtol *= MORE_RTOL;
        request.first_part = request.kind->fixed ? request.first_part / MORE_GRID
                                                 : (i == 0 ? 1.0 : ESTIMATE_FIRST_PART) / MORE_GRID;
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
                    "sensitive: errors grow %s; the error estimate includes a finer run and %d "
                    "runs with stiffnesses that differ by %g",
                    fixed ? "to more than a twentieth of the movement" : "more than 1000-fold",
                    DIVERGENCE_RUNS, DIVERGENCE_PART);
    const struct pass_outcome *answer = runs->coarse_answers ? &runs->coarse : &runs->fine;
    struct pass_request finer = runs->request;
    finer.rtol = fmax(ESTIMATE_LEAST_RTOL, finer.rtol / ESTIMATE_CHECK_FACTOR);
    finer.dt_s /= ESTIMATE_GRID_RATIO;
    finer.first_part /= ESTIMATE_GRID_RATIO; /* of a fixed step; else 0 */
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

/* The error estimate of the result, with more runs where it needs them; false when the two passes
 * contradict each other. `where`: their largest difference. */
static bool error_estimate(struct model *m, const struct sim_options *options,
                           struct error_pair *runs, struct sim_result *result,
                           struct sim_difference *where)
{
    const struct stepper_kind *kind = runs->request.kind;
    const struct pass_outcome *a = &runs->coarse, *b = &runs->fine;
    struct pass_difference apart = pass_difference(a, b);
    /* two passes can agree more closely than either is right, and what each step may err adds up at
     * random */
    double grown = fmax(1.0, FLOOR_STEPS * sqrt((double)b->steps));
    double least_ft = kind->fixed ? 0.0 : runs->request.rtol * m->length_ft;
    *where = apart.u;
    result->error_u_ft = result->error_lift_ft = 0.0;
    widen(result, apart, !samples(kind) ? 1.0 : runs->coarse_answers ? LONGER_CAUTION : CAUTION);
    if (!passes_agree(m->scene, a, b, apart))
        return false;
    doubt(m, options, runs, result);
    if (!cross(m, options, runs, result)) {
        rebound(m, options, runs, result);
        linger(m, options, runs, result);
    }
    feel(m, options, runs, result);
    result->error_u_ft += b->clock_ft;
    if (sim_record_peak(&a->record).u_ft > 0.0 && sim_record_peak(&b->record).u_ft > 0.0) {
        result->error_u_ft = fmax(result->error_u_ft, grown * least_ft);
        result->error_lift_ft = fmax(result->error_lift_ft, LIFT_FLOOR * least_ft);
    }
    return true;
}

/* ---- moreau's runs ----
 *
 * The method is in moreau.c.
 *
 * A scene is run with steps 1.9 times shorter each time, until the stated error is below a
 * ten-thousandth of what moves and of what lifts, or the work is done that MOREAU_WORK allows. The
 * answer is the run with the shortest steps. Its method is of order 1 where anything switches, so
 * the shortest steps' error is 1.1 times the last difference, 2.6 times for order 1/2: stated is
 * three times the larger of the last difference and of the one before divided by 1.9, so that runs
 * that are close by chance are not believed. Runs that contradict each other with the shortest
 * steps are `unpredictable` (above). With a given step: that, 1.9 and 3.6 times it. */
#define MOREAU_WORK 1.5e7 /* evaluations times mats: some 10 s */

#define MOREAU_CAUTION 3.0
#define FIRST_STEPS    500.0
#define CLOSE          1e-4
#define RUNS_MOST      16
#define RUNS           3

/* The last runs, the one with the shortest steps last. */
struct ladder {
    struct pass_outcome runs[RUNS];
    int count; /* of those that are complete */
    struct pass_difference last, before;
};

static void climb(struct ladder *l, const struct pass_outcome *run)
{
    if (l->count == RUNS) {
        pass_free(&l->runs[0]);
        l->runs[0] = l->runs[1];
        l->runs[1] = l->runs[2];
        l->count--;
    }
    l->runs[l->count++] = *run;
    l->before = l->last;
    if (l->count > 1)
        l->last = pass_difference(&l->runs[l->count - 2], &l->runs[l->count - 1]);
}

static void restart(struct ladder *l)
{
    for (int i = 0; i < l->count; i++)
        pass_free(&l->runs[i]);
    l->count = 0;
}

static bool agrees(const struct ladder *l, const struct sim_scene *scene)
{
    return l->count == RUNS && passes_agree(scene, &l->runs[1], &l->runs[2], l->last);
}

static void state(const struct ladder *l, struct sim_result *result)
{
    double before = l->count == RUNS ? 1.0 / ESTIMATE_GRID_RATIO : 0.0;
    result->error_u_ft = MOREAU_CAUTION * fmax(l->last.u.u_ft, before * l->before.u.u_ft) +
                         l->runs[l->count - 1].clock_ft;
    result->error_lift_ft = MOREAU_CAUTION * fmax(l->last.lift_ft, before * l->before.lift_ft);
}

static bool close_enough(const struct ladder *l, const struct sim_scene *scene,
                         const struct sim_result *result)
{
    const struct pass_outcome *best = &l->runs[l->count - 1];
    double lift_ft = fmax(best->max_lift_ft, pass_bow_threshold_ft(scene));
    return agrees(l, scene) && result->error_u_ft <= CLOSE * sim_record_peak(&best->record).u_ft &&
           result->error_lift_ft <= CLOSE * lift_ft;
}

static void report(struct model *m, const struct sim_options *options,
                   const struct pass_request *request, struct ladder *l, bool given,
                   struct sim_result *result)
{
    struct pass_outcome *best = &l->runs[l->count - 1], *other = &l->runs[l->count - 2];
    if (!agrees(l, m->scene)) {
        sim_result_end(result, SIM_UNSTABLE, l->last.u.mat, l->last.u.t_s);
        if (!given)
            divergence_state(m, request, options, best, other, result);
    }
    pass_answer(m, best, other, result);
}

static void moreau_run(const struct model *model, const struct sim_options *options,
                       struct sim_result *result)
{
    struct model m = *model;
    struct ladder ladder = {0};
    bool given = options->dt_s > 0.0;
    double work = 0.0, end_s = sim_scene_end_s(m.scene);
    struct pass_request request = {&stepper_moreau,
                                   0.0,
                                   given ? options->dt_s * ESTIMATE_GRID_RATIO * ESTIMATE_GRID_RATIO
                                         : end_s / FIRST_STEPS,
                                   UINT64_MAX,
                                   0,
                                   ESTIMATE_SPAN_PART};
    if (m.law == SIM_SIGN) {
        m.law = SIM_STICK;
        sim_result_note(result, "friction sign is replaced by stick, its exact form");
    }
    sim_result_note(result, "error estimate: three times the largest difference to runs with 1.9 "
                            "and 3.6 times the step");
    for (int i = 0; i < RUNS_MOST; i++) {
        struct pass_outcome run = {0};
        request.number = ++result->passes;
        request.most_steps = given ? UINT64_MAX : (uint64_t)(MOREAU_WORK / (double)m.mats);
        pass_run(&run, &m, &request, options);
        double done = (double)run.rhs * m.mats;
        cost_add(result, &run);
        work += done;
        if (run.status == SIM_INTERRUPTED) {
            sim_result_end(result, run.status, run.mat, run.t_s);
            pass_answer(&m, &run, &run, result);
            pass_free(&run);
            restart(&ladder);
            return;
        }
        bool more = given ? i + 1 < RUNS
                          : i + 1 < RUNS_MOST && work + ESTIMATE_GRID_RATIO * done < MOREAU_WORK;
        if (run.status == SIM_OK) {
            climb(&ladder, &run);
            state(&ladder, result);
        } else { /* what longer steps said counts no more */
            sim_result_end(result, run.status, run.mat, run.t_s);
            pass_free(&run);
            restart(&ladder);
        }
        if (!more || (!given && close_enough(&ladder, m.scene, result)))
            break;
        request.dt_s /= ESTIMATE_GRID_RATIO;
        request.first_part /= ESTIMATE_GRID_RATIO;
    }
    if (ladder.count >= 2) {
        result->status = SIM_OK;
        /* its positions are no better than those of event */
        if (sim_record_peak(&ladder.runs[ladder.count - 1].record).u_ft > 0.0)
            result->error_lift_ft = fmax(result->error_lift_ft,
                                         LIFT_FLOOR * stepper_event.rtol * m.length_ft);
        report(&m, options, &request, &ladder, given, result);
    } else if (ladder.count == 1) {
        sim_result_end(result, SIM_UNSTABLE, 1, end_s);
    }
    restart(&ladder);
}

/* ---- auto and the rest ---- */

/* How long auto stays with a solver before it tries the other one. */
static uint64_t patience(const struct model *m, const struct stepper_kind *kind, bool last,
                         const struct sim_result *result)
{
    double steps = explicit_steps(m, result);
    if (kind == &stepper_event)
        return last ? (uint64_t)(2.0 * steps) + MOST_CHATTER : MOST_CHATTER;
    if (last || steps > EXPLICIT_MOST)
        return MOST_AUTO;
    return (uint64_t)fmax(MOST_IMPLICIT, steps / ESTIMATE_STEP_RATIO);
}

static const struct stepper_kind *choose(const struct sim_scene *scene,
                                         const struct sim_options *options, double rate,
                                         struct sim_result *result)
{
    double steps = rate * sim_scene_end_s(scene) / ESTIMATE_EXPLICIT_REACH;
    if (!solver_is_automatic(options))
        return stepper_find(options->solver);
    if (scene->friction_law == SIM_SIGN && scene->friction > 0.0)
        sim_result_note(result, "auto: friction sign does not define the force on a mat at rest; "
                                "replaced by stick, its exact form");
    if (steps <= ESTIMATE_EXPLICIT_STEPS) {
        sim_result_note(
            result, "auto: event; the fastest rate, %.4g /s, requires at most %.0f explicit steps",
            rate, ceil(steps));
        return &stepper_event;
    }
    sim_result_note(result,
                    "auto: implicit; the fastest rate, %.4g /s, would require %.3g explicit steps",
                    rate, steps);
    return &stepper_implicit;
}

/* Run coarse and fine; the answer is `coarse` when coarse_answers. With `last`, what contradicts
 * itself is unpredictable. */
static void run_pair(struct model *m, const struct sim_options *options,
                     struct pass_request request, bool coarse_answers, bool last,
                     bool *contradicted, struct sim_result *result)
{
    struct error_pair runs = {
        .check = request, .request = request, .coarse_answers = coarse_answers};
    struct pass_outcome *coarse = &runs.coarse, *fine = &runs.fine;
    struct sim_difference where;
    runs.check.first_part = request.kind->fixed ? ESTIMATE_SPAN_PART : ESTIMATE_FIRST_PART;
    if (request.kind->fixed)
        runs.request.first_part = ESTIMATE_SPAN_PART / ESTIMATE_GRID_RATIO;
    if (request.kind->fixed && coarse_answers)
        runs.request.dt_s /= ESTIMATE_GRID_RATIO;
    else if (request.kind->fixed)
        runs.check.dt_s = ESTIMATE_GRID_RATIO * (runs.request.dt_s *= 0.5);
    else
        runs.check.rtol = fmin(1e-2, request.rtol * ESTIMATE_CHECK_FACTOR);
    *contradicted = false;
    runs.check.number = ++result->passes;
    pass_run(coarse, m, &runs.check, options);
    cost_add(result, coarse);
    runs.request.number = result->passes + 1;
    if (coarse->status == SIM_INTERRUPTED) {
        sim_result_end(result, coarse->status, coarse->mat, coarse->t_s);
        pass_answer(m, coarse, coarse, result);
    } else {
        result->passes++;
        pass_run(fine, m, &runs.request, options);
        cost_add(result, fine);
        const struct pass_outcome *failed = fine->status != SIM_OK   ? fine
                                          : coarse->status != SIM_OK ? coarse
                                                                     : NULL;
        if (failed) {
            sim_result_end(result, failed->status, failed->mat, failed->t_s);
            result->why = failed->why;
            *contradicted = fine->status == SIM_OK;
        } else if (!error_estimate(m, options, &runs, result, &where)) {
            sim_result_end(result, SIM_UNSTABLE, where.mat, where.t_s);
            *contradicted = true;
            if (last)
                divergence_state(m, &runs.request, options, fine, coarse, result);
        }
        pass_answer(m, coarse_answers ? coarse : fine, coarse_answers ? fine : coarse, result);
    }
    pass_free(coarse);
    pass_free(fine);
    pass_free(&runs.third);
}

static enum mr_status run_fixed(struct model *m, const struct sim_options *options,
                                const struct stepper_kind *kind, struct sim_result *result,
                                struct error *error)
{
    double end = sim_scene_end_s(m->scene);
    bool given = options->dt_s > 0.0, contradicted;
    double dt = given ? options->dt_s : fmin(0.5 * result->dt_limit_s, end / 500.0);
    struct pass_request request = {kind, 0.0, dt, UINT64_MAX, 0, 0.0};
    if (end / dt > MOST_FIXED_STEPS)
        return error_set(
            error, MR_USAGE,
            "too many steps: %s: %g s in steps of %g s; give a shorter tend, a larger dt "
            "or solver implicit",
            sim_scene_name(m->scene), end, dt);
    sim_result_note(
        result, "error estimate: from the largest differences to runs with 1.9 times and, where "
                "that is stable, 3.6 times the step");
    if (dt > result->dt_limit_s) {
        result->dt_s = dt;
        sim_result_end(result, SIM_UNSTABLE, m->span.mat >= 0 ? m->span.mat + 1 : 1, 0.0);
        return MR_OK;
    }
    run_pair(m, options, request, given, false, &contradicted, result);
    return MR_OK;
}

static void run_adaptive(struct model *m, const struct sim_options *options,
                         const struct stepper_kind *kind, bool last, struct sim_result *result)
{
    bool given = options->rtol > 0.0, contradicted;
    uint64_t most = m->law == SIM_SIGN           ? MOST_SIGN
                  : solver_is_automatic(options) ? patience(m, kind, last, result)
                                                 : MOST_STEPS;
    struct pass_request request = {kind, given ? options->rtol : kind->rtol, 0.0, most, 0, 0.0};
    sim_result_note(
        result,
        "error estimate: largest difference to the same run at a 30 times looser tolerance");
    for (int i = 0;; i++) {
        result->status = SIM_OK;
        run_pair(m, options, request, false, !given && i == MOST_TIGHTENINGS, &contradicted,
                 result);
        if (!contradicted || i == MOST_TIGHTENINGS || given)
            break;
        request.rtol = fmax(ESTIMATE_LEAST_RTOL, request.rtol * TIGHTEN);
        sim_result_note(result, "two tolerances disagreed; run again at %.3g", request.rtol);
    }
}

/* Auto leaves a solver that has ended step_underflow. */
static void note_left(struct sim_result *result, const char *left, const char *next)
{
    sim_result_note(result, "auto: %s reached only %.*g s, because %s; %s used instead", left,
                    sim_time_digits(result->start_s, 9), result->start_s + result->t_s,
                    result->why ? result->why : "it makes no progress", next);
    result->why = NULL;
}

/* What is left where both make no progress, as switches pile up: hamming samples them, moreau
 * settles any number of them in a step. */
static void run_left(struct model *m, const struct sim_options *options, struct sim_result *result)
{
    const struct stepper_kind *const kinds[] = {&stepper_hamming, &stepper_moreau};
    for (int i = 0; i < 2 && result->status == SIM_STEP_UNDERFLOW; i++) {
        note_left(result, result->solver, kinds[i]->name);
        result->status = SIM_OK;
        result->solver = kinds[i]->name;
        if (i == 0)
            run_adaptive(m, options, kinds[i], true, result);
        else
            moreau_run(m, options, result);
    }
}

/* The other solver, and what is left. */
static void run_others(struct model *m, const struct sim_options *options,
                       const struct stepper_kind *first, struct sim_result *result)
{
    const struct stepper_kind *other = first == &stepper_event ? &stepper_implicit : &stepper_event;
    /* where too little moves for the fastest rate to matter, event may still get on */
    bool last = other != &stepper_event || explicit_steps(m, result) <= EXPLICIT_MOST;
    note_left(result, first->name, other->name);
    result->status = SIM_OK;
    result->solver = other->name;
    run_adaptive(m, options, other, last, result);
    if (result->status == SIM_STEP_UNDERFLOW && options->rtol == 0.0)
        run_left(m, options, result);
}

/* Auto: others, where the first makes no progress; together they have PLANAR_OTHERS_S. What is not
 * answered then is refused for what the first one said. */
static void run_auto(struct model *m, const struct sim_options *options,
                     const struct stepper_kind *kind, struct sim_result *result)
{
    struct deadline deadline;
    bool last = kind == &stepper_implicit && explicit_steps(m, result) > EXPLICIT_MOST;
    run_adaptive(m, options, kind, last, result);
    if (result->status != SIM_STEP_UNDERFLOW)
        return;
    struct sim_result refused = *result; /* one that holds no arrays */
    deadline_begin(&deadline, options, PLANAR_OTHERS_S);
    run_others(m, &deadline.options, kind, result);
    if (deadline.late) {
        memcpy(refused.notes, result->notes, sizeof refused.notes);
        refused.rhs = result->rhs;
        refused.passes = result->passes;
        sim_result_note(&refused, "auto: the other solvers had a limit of %g s; %s reached %.*g s",
                        PLANAR_OTHERS_S, result->solver, sim_time_digits(result->start_s, 9),
                        result->start_s + result->t_s);
        sim_result_free(result);
        *result = refused;
    }
}

/* Run with the solvers that are not `staggered`. */
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
    if (solver_is_automatic(options) && model.law == SIM_SIGN)
        model.law = SIM_STICK;
    model_start(&model, z);
    double rate = model_fastest_rate(&model, z, MODEL_EXPLICIT);
    const struct stepper_kind *kind = choose(scene, options, rate, result);
    result->solver = kind->name;
    result->mats = scene->mats;
    result->t_end_s = sim_scene_end_s(scene);
    result->dt_limit_s = rate > 0.0 ? ESTIMATE_RK4_REAL / rate : HUGE_VAL;
    model_describe(&model, result);
    if (options->dt_s > 0.0 && !kind->fixed)
        error_set(error, MR_USAGE,
                  "no fixed step: solver %s chooses its step; give --rtol, or --solver rk4",
                  kind->name);
    else if (options->rtol > 0.0 && kind->fixed)
        error_set(error, MR_USAGE,
                  "no tolerance: solver %s has a fixed step; give --dt, or another solver",
                  kind->name);
    else if (kind == &stepper_moreau)
        moreau_run(&model, options, result);
    else if (kind->fixed)
        run_fixed(&model, options, kind, result, error);
    else if (solver_is_automatic(options))
        run_auto(&model, options, kind, result);
    else
        run_adaptive(&model, options, kind, true, result);
    result->run_ms = 1e3 * (monotonic_s() - begin_s);
    model_free(&model);
    free(z);
    return error->status;
}

static bool undecided(const struct sim_result *result)
{
    return result->status == SIM_UNPREDICTABLE || result->status == SIM_STEP_UNDERFLOW;
}

/* A landing that no step of `staggered` decides: solvers that locate their switches may, where they
 * have the scene's laws. The result is theirs if it is an answer. */
static enum mr_status run_located(const struct sim_scene *scene, const struct sim_options *options,
                                  struct sim_result *result, struct error *error)
{
    struct sim_result other = {.start_s = result->start_s};
    struct error not_theirs = {0};
    struct deadline deadline;
    deadline_begin(&deadline, options, PLANAR_OTHERS_S);
    if (run_planar(scene, &deadline.options, &other, &not_theirs) != MR_OK ||
        other.status != SIM_OK) {
        if (deadline.late)
            sim_result_note(result, "auto: the other solvers reached their limit of %g s",
                            PLANAR_OTHERS_S);
        sim_result_free(&other);
        return MR_OK;
    }
    other.run_ms += result->run_ms;
    other.rhs += result->rhs;
    sim_result_note(&other, "auto: staggered failed beyond %.*g s",
                    sim_time_digits(result->start_s, 6), result->start_s + result->t_s);
    sim_result_free(result);
    *result = other;
    return error->status;
}

enum mr_status planar_run(const struct sim_scene *scene, const struct sim_options *options,
                          struct sim_result *result, struct error *error)
{
    bool landing = scene->model == SIM_CONSISTENT && scene->path_count > 0;
    if (options->solver && strcmp(options->solver, "staggered") == 0
            ? scene->model == SIM_CONSISTENT
            : landing && solver_is_automatic(options)) {
        if (solver_is_automatic(options))
            sim_result_note(
                result, "auto: staggered; a whole landing has too many switches to locate each");
        if (landing_run(scene, options, result, error) != MR_OK || !solver_is_automatic(options) ||
            !undecided(result) || options->dt_s > 0.0 || options->single)
            return error->status;
        return run_located(scene, options, result, error);
    }
    return run_planar(scene, options, result, error);
}
