#include "host/sim/solvers/planar.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/steady.h"
#include "host/sim/solvers/apart.h"
#include "host/sim/solvers/landing.h"
#include "host/sim/solvers/moreau.h"
#include "host/sim/solvers/pass.h"
#include "host/sim/solvers/spread.h"
#include "host/sim/solvers/deadline.h"
#include "host/sim/solvers/weigh.h"

#define TIGHTEN          0.01
#define MOST_TIGHTENINGS 2
#define MOST_STEPS       5000000u
#define MOST_CHATTER     50000u /* steps of event before auto tries implicit */
/* of implicit before auto tries event, or its share of event's steps */
#define MOST_IMPLICIT    20000u
#define MOST_AUTO        300000u /* of implicit, when there is nothing else */
#define MOST_SIGN        10000u  /* of friction `sign`, which chatters around rest */
#define MOST_FIXED_STEPS 400000000.0
#define EXPLICIT_MOST    500000.0 /* more are not tried */
#define BOW_WAVE_FT      0.05

bool planar_has_solver(const char *name)
{
    return strcmp(name, "auto") == 0 || strcmp(name, "fixed") == 0 || stepper_find(name);
}

double planar_bow_threshold_ft(const struct sim_scene *scene)
{
    double bump = 0.0;
    for (size_t i = 0; i < scene->bump_ft.count; i++)
        bump = fmax(bump, scene->bump_ft.values[i]);
    return fmax(BOW_WAVE_FT, 2.0 * bump);
}

/* How long auto stays with a solver before it tries the other one. */
static uint64_t patience(const struct model *m, const struct stepper_kind *kind, bool last,
                         const struct sim_result *result)
{
    double steps = weigh_explicit_steps(m, result);
    if (kind == &stepper_event)
        return last ? (uint64_t)(2.0 * steps) + MOST_CHATTER : MOST_CHATTER;
    if (last || steps > EXPLICIT_MOST)
        return MOST_AUTO;
    return (uint64_t)fmax(MOST_IMPLICIT, steps / WEIGH_STEP_RATIO);
}

static const struct stepper_kind *choose(const struct sim_scene *scene,
                                         const struct sim_options *options, double rate,
                                         struct sim_result *result)
{
    double steps = rate * sim_scene_end_s(scene) / WEIGH_EXPLICIT_REACH;
    if (!weigh_automatic(options))
        return stepper_find(options->solver);
    if (scene->friction_law == SIM_SIGN && scene->friction > 0.0)
        sim_result_note(
            result, "auto: friction sign leaves open what holds a mat at rest; taken as stick, its "
                    "exact form");
    if (steps <= WEIGH_EXPLICIT_STEPS) {
        sim_result_note(
            result,
            "auto: event; the fastest rate, %.4g /s, asks for no more than %.0f explicit steps",
            rate, ceil(steps));
        return &stepper_event;
    }
    sim_result_note(result,
                    "auto: implicit; the fastest rate, %.4g /s, would ask for %.3g explicit steps",
                    rate, steps);
    return &stepper_implicit;
}

static void refuse(struct sim_result *result, enum sim_status status, int mat, double t_s)
{
    result->status = status;
    result->mat = mat;
    result->t_s = t_s;
}

static void final_shape(const struct model *m, const double *z, struct sim_result *result)
{
    for (int n = 1; n <= m->mats; n++)
        result->u_ft[n] = z[2 * n - 1];
    double left = 0.0;
    for (int j = 1; j <= m->mats + 1; j++) {
        double right = j <= m->mats ? result->u_ft[j] : 0.0;
        double shortened = 0.0;
        if (m->full) {
            for (int n = j - 1; n <= j; n++) {
                bool there = n >= 1 && n <= m->mats;
                double tilt = there && m->tilt_ft ? m->tilt_ft[n - 1] / m->length_ft : 0.0;
                double s = there ? (z[2 * n] - z[2 * n - 2]) / m->length_ft + tilt : 0.0;
                shortened += m->half_ft * (sqrt(1.0 - tilt * tilt) - sqrt(1.0 - s * s));
            }
        }
        result->gap_ft[j] = sim_scene_joint(&m->scene->gap0_ft, j) + right - left + shortened;
        left = right;
    }
}

enum mr_status planar_deliver(const struct model *m, const double *z, struct sim_record *record,
                              double max_lift_ft, double speed_end_ft_s, struct sim_result *result,
                              struct error *error)
{
    size_t mats = (size_t)m->mats;
    if (result->status != SIM_OK && result->status != SIM_INTERRUPTED &&
        result->status != SIM_UNPREDICTABLE)
        return MR_OK;
    struct sim_difference peak = sim_record_peak(record);
    result->peak_u_ft = peak.u_ft;
    result->peak_mat = peak.mat;
    result->speed_end_ft_s = speed_end_ft_s;
    result->max_lift_ft = max_lift_ft;
    result->bow_wave = max_lift_ft > planar_bow_threshold_ft(m->scene);
    result->u_ft = calloc(mats + 1, sizeof *result->u_ft);
    result->gap_ft = calloc(mats + 2, sizeof *result->gap_ft);
    if (!result->u_ft || !result->gap_ft)
        return error_set(error, MR_FULL, "out of memory: the result of %zu mats; use a smaller N",
                         mats);
    final_shape(m, z, result);
    return sim_record_deliver(record, result, error);
}

enum mr_status planar_answer(const struct model *m, struct pass_outcome *pass,
                             const struct pass_outcome *other, struct sim_result *result,
                             struct error *error)
{
    result->pass_ms = pass->ms;
    result->steps = pass->steps;
    result->events = pass->events;
    result->dt_s = pass->longest_s;
    result->checked_dt_s = other->longest_s;
    result->mats_max = pass->mats_max;
    result->mats_mean = pass->mats_mean;
    return planar_deliver(m, pass->z, &pass->record, pass->max_lift_ft, pass->speed_end_ft_s,
                          result, error);
}

/* Run coarse and fine; the answer is `coarse` when coarse_answers. With `last`, what contradicts
 * itself is unpredictable. */
static enum mr_status run_pair(struct model *m, const struct sim_options *options,
                               struct pass_request request, bool coarse_answers, bool last,
                               bool *contradicted, struct sim_result *result, struct error *error)
{
    struct weigh_pair runs = {
        .check = request, .request = request, .coarse_answers = coarse_answers};
    struct pass_outcome *coarse = &runs.coarse, *fine = &runs.fine;
    struct sim_difference where;
    runs.check.first_part = WEIGH_FIRST_PART;
    if (request.kind->fixed && coarse_answers)
        runs.request.dt_s /= WEIGH_GRID_RATIO;
    else if (request.kind->fixed)
        runs.check.dt_s = WEIGH_GRID_RATIO * (runs.request.dt_s *= 0.5);
    else
        runs.check.rtol = fmin(1e-2, request.rtol * WEIGH_CHECK_FACTOR);
    *contradicted = false;
    runs.check.number = ++result->passes;
    if (pass_run(coarse, m, &runs.check, options, error) == MR_OK) {
        weigh_cost(result, coarse);
        runs.request.number = result->passes + 1;
        if (coarse->status == SIM_INTERRUPTED) {
            refuse(result, coarse->status, coarse->mat, coarse->t_s);
            planar_answer(m, coarse, coarse, result, error);
        } else if (result->passes++, pass_run(fine, m, &runs.request, options, error) == MR_OK) {
            weigh_cost(result, fine);
            const struct pass_outcome *failed = fine->status != SIM_OK   ? fine
                                              : coarse->status != SIM_OK ? coarse
                                                                         : NULL;
            if (failed) {
                refuse(result, failed->status, failed->mat, failed->t_s);
                *contradicted = fine->status == SIM_OK;
            } else if (!weigh_runs(m, options, &runs, result, &where, error)) {
                refuse(result, SIM_UNSTABLE, where.mat, where.t_s);
                *contradicted = true;
                if (last && error->status == MR_OK)
                    spread_run(m, &runs.request, options, fine, coarse, result, error);
            }
            if (error->status != MR_OK)
                ;
            else if (coarse_answers)
                planar_answer(m, coarse, fine, result, error);
            else
                planar_answer(m, fine, coarse, result, error);
        }
    }
    pass_free(coarse);
    pass_free(fine);
    pass_free(&runs.third);
    return error->status;
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
            m->scene->name[0] ? m->scene->name : "scene", end, dt);
    sim_result_note(
        result, "error estimate: from the largest differences to runs with 1.9 times and, where "
                "that is stable, 3.6 times the step");
    if (dt > result->dt_limit_s) {
        result->dt_s = dt;
        refuse(result, SIM_UNSTABLE, m->span.mat >= 0 ? m->span.mat + 1 : 1, 0.0);
        return MR_OK;
    }
    return run_pair(m, options, request, given, false, &contradicted, result, error);
}

static enum mr_status run_adaptive(struct model *m, const struct sim_options *options,
                                   const struct stepper_kind *kind, bool last,
                                   struct sim_result *result, struct error *error)
{
    bool given = options->rtol > 0.0, contradicted;
    uint64_t most = m->law == SIM_SIGN       ? MOST_SIGN
                  : weigh_automatic(options) ? patience(m, kind, last, result)
                                             : MOST_STEPS;
    struct pass_request request = {kind, given ? options->rtol : kind->rtol, 0.0, most, 0, 0.0};
    sim_result_note(
        result,
        "error estimate: largest difference to the same run at a 30 times looser tolerance");
    for (int i = 0;; i++) {
        result->status = SIM_OK;
        if (run_pair(m, options, request, false, !given && i == MOST_TIGHTENINGS, &contradicted,
                     result, error) != MR_OK)
            break;
        if (!contradicted || i == MOST_TIGHTENINGS || given)
            break;
        request.rtol = fmax(WEIGH_LEAST_RTOL, request.rtol * TIGHTEN);
        sim_result_note(result, "two tolerances disagreed; run again at %.3g", request.rtol);
    }
    return error->status;
}

/* What is left where both make no progress, as switches pile up: hamming samples them, moreau
 * settles any number of them in a step. */
static enum mr_status run_left(struct model *m, const struct sim_options *options,
                               struct sim_result *result, struct error *error)
{
    const struct stepper_kind *const kinds[] = {&stepper_hamming, &stepper_moreau};
    for (int i = 0; i < 2 && result->status == SIM_STEP_UNDERFLOW; i++) {
        sim_result_note(result, "auto: %s came to %.9g s only; %s instead", result->solver,
                        result->t_s, kinds[i]->name);
        result->status = SIM_OK;
        result->solver = kinds[i]->name;
        if (i == 0)
            run_adaptive(m, options, kinds[i], true, result, error);
        else
            moreau_run(m, options, result, error);
        if (error->status != MR_OK)
            return error->status;
    }
    return MR_OK;
}

/* The other solver, and what is left. */
static enum mr_status run_others(struct model *m, const struct sim_options *options,
                                 const struct stepper_kind *first, struct sim_result *result,
                                 struct error *error)
{
    const struct stepper_kind *other = first == &stepper_event ? &stepper_implicit : &stepper_event;
    if (other != &stepper_event || weigh_explicit_steps(m, result) <= EXPLICIT_MOST) {
        result->status = SIM_OK;
        result->solver = other->name;
        sim_result_note(result, "auto: %s came to %.9g s only; %s instead", first->name,
                        result->t_s, other->name);
        if (run_adaptive(m, options, other, true, result, error) != MR_OK ||
            result->status != SIM_STEP_UNDERFLOW)
            return error->status;
    }
    return options->rtol > 0.0 ? MR_OK : run_left(m, options, result, error);
}

/* Auto: others, where the first makes no progress; together they have PLANAR_OTHERS_S. What is not
 * answered then is refused for what the first one said. */
static enum mr_status run_auto(struct model *m, const struct sim_options *options,
                               const struct stepper_kind *kind, struct sim_result *result,
                               struct error *error)
{
    struct deadline deadline;
    bool last = kind == &stepper_implicit && weigh_explicit_steps(m, result) > EXPLICIT_MOST;
    if (run_adaptive(m, options, kind, last, result, error) != MR_OK ||
        result->status != SIM_STEP_UNDERFLOW)
        return error->status;
    struct sim_result refused = *result; /* one that holds no arrays */
    deadline_begin(&deadline, options, PLANAR_OTHERS_S);
    run_others(m, &deadline.options, kind, result, error);
    if (deadline.late) {
        memcpy(refused.notes, result->notes, sizeof refused.notes);
        refused.rhs = result->rhs;
        refused.passes = result->passes;
        sim_result_note(&refused, "auto: others were given %g s; %s came to %.9g s in them",
                        PLANAR_OTHERS_S, result->solver, result->t_s);
        sim_result_free(result);
        *result = refused;
    }
    return error->status;
}

/* Run with the solvers that are not `fixed`. */
static enum mr_status run_planar(const struct sim_scene *scene, const struct sim_options *options,
                                 struct sim_result *result, struct error *error)
{
    struct model model;
    double begin_s = steady_s();
    if (options->solver && strcmp(options->solver, "fixed") == 0)
        return error_set(error, MR_USAGE,
                         "solver not available: fixed for model %s; give rk4, or model consistent",
                         sim_model_name(scene->model));
    double *z = calloc(2 * (2 * (size_t)scene->mats + 1), sizeof *z);
    if (!z)
        return error_set(error, MR_FULL, "out of memory: %d mats; use a smaller N", scene->mats);
    if (model_make(&model, scene, false, error) != MR_OK) {
        free(z);
        return error->status;
    }
    if (weigh_automatic(options) && model.law == SIM_SIGN)
        model.law = SIM_STICK;
    model_start(&model, z);
    double rate = model_fastest_rate(&model, z, MODEL_EXPLICIT);
    const struct stepper_kind *kind = choose(scene, options, rate, result);
    result->solver = kind->name;
    result->mats = scene->mats;
    result->t_end_s = sim_scene_end_s(scene);
    result->dt_limit_s = rate > 0.0 ? WEIGH_RK4_REAL / rate : HUGE_VAL;
    model_describe(&model, result);
    if (options->dt_s > 0.0 && !kind->fixed)
        error_set(error, MR_USAGE,
                  "no fixed step: solver %s chooses its own; give --rtol, or --solver rk4",
                  kind->name);
    else if (options->rtol > 0.0 && kind->fixed)
        error_set(error, MR_USAGE,
                  "no tolerance: solver %s has a fixed step; give --dt, or another solver",
                  kind->name);
    else if (kind == &stepper_moreau)
        moreau_run(&model, options, result, error);
    else if (kind->fixed)
        run_fixed(&model, options, kind, result, error);
    else if (weigh_automatic(options))
        run_auto(&model, options, kind, result, error);
    else
        run_adaptive(&model, options, kind, true, result, error);
    result->run_ms = 1e3 * (steady_s() - begin_s);
    model_free(&model);
    free(z);
    return error->status;
}

static bool undecided(const struct sim_result *result)
{
    return result->status == SIM_UNPREDICTABLE || result->status == SIM_STEP_UNDERFLOW;
}

/* A landing that no step of `fixed` decides: solvers that locate their switches may, where they
 * have the scene's laws. The result is theirs if it is an answer. */
static enum mr_status run_located(const struct sim_scene *scene, const struct sim_options *options,
                                  struct sim_result *result, struct error *error)
{
    struct sim_result other = {0};
    struct error not_theirs = {0};
    struct deadline deadline;
    deadline_begin(&deadline, options, PLANAR_OTHERS_S);
    if (run_planar(scene, &deadline.options, &other, &not_theirs) != MR_OK ||
        other.status != SIM_OK) {
        if (deadline.late)
            sim_result_note(result, "auto: others were given %g s", PLANAR_OTHERS_S);
        sim_result_free(&other);
        return MR_OK;
    }
    other.run_ms += result->run_ms;
    other.rhs += result->rhs;
    sim_result_note(&other, "auto: fixed could not say beyond %.6g s", result->t_s);
    sim_result_free(result);
    *result = other;
    return error->status;
}

enum mr_status planar_run(const struct sim_scene *scene, const struct sim_options *options,
                          struct sim_result *result, struct error *error)
{
    bool landing = scene->model == SIM_CONSISTENT && scene->path_count > 0;
    if (options->solver && strcmp(options->solver, "fixed") == 0
            ? scene->model == SIM_CONSISTENT
            : landing && weigh_automatic(options)) {
        if (weigh_automatic(options))
            sim_result_note(result,
                            "auto: fixed; a whole landing has too many switches to locate each");
        if (landing_run(scene, options, result, error) != MR_OK || !weigh_automatic(options) ||
            !undecided(result) || options->dt_s > 0.0 || options->single)
            return error->status;
        return run_located(scene, options, result, error);
    }
    return run_planar(scene, options, result, error);
}
