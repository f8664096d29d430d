#include "host/sim/sim.h"

#include <stdio.h>
#include <string.h>

#include "host/base/progress.h"
#include "host/sim/solvers/chain.h"
#include "host/sim/solvers/planar.h"

bool sim_solver_elsewhere(const char *solver)
{
    return strcmp(solver, "cvode") == 0 && !planar_has_solver(solver);
}

static enum mr_status check_options(const struct sim_scene *scene,
                                    const struct sim_options *options, struct error *error)
{
    double runway_ft = scene->mats * scene->length_ft;
    bool chain = scene->model == SIM_CHAIN;
    if (chain && options->solver && strcmp(options->solver, "staggered") != 0 &&
        strcmp(options->solver, "auto") != 0)
        return error_set(
            error, MR_USAGE,
            "solver not available: %s for model chain; give staggered, or leave it out",
            options->solver);
    if (!chain && options->solver && !planar_has_solver(options->solver))
        return error_set(error, MR_USAGE,
                         "solver not available: %s for model %s; give auto, event, implicit, "
                         "cvode, rk4, rkgs, hamming or moreau",
                         options->solver, sim_model_name(scene->model));
    if (!(options->dt_s >= 0.0 && options->dt_s <= 1e6))
        return error_set(error, MR_USAGE, "step out of range: dt %g s; give a positive step",
                         options->dt_s);
    if (!(options->limit_s >= 0.0))
        return error_set(error, MR_USAGE, "limit out of range: %g s; give 0, for none, or more",
                         options->limit_s);
    if (options->rtol != 0.0 &&
        !(options->rtol >= (chain ? 1e-9 : 1e-13) && options->rtol <= (chain ? 1.0 : 0.01)))
        return error_set(error, MR_USAGE, "tolerance out of range: rtol %g; give %s", options->rtol,
                         chain ? "1e-9 to 1" : "1e-13 to 0.01");
    if (!(options->sample_dt_s >= 0.0) ||
        (options->sample_dt_s > 0.0 && sim_scene_end_s(scene) / options->sample_dt_s > 1e7))
        return error_set(error, MR_USAGE,
                         "sampling out of range: every %g s; give at most 1e7 samples",
                         options->sample_dt_s);
    for (size_t i = 0; i < options->station_count; i++) {
        if (!(options->station_ft[i] >= 0.0 && options->station_ft[i] <= runway_ft * (1.0 + 1e-9)))
            return error_set(error, MR_USAGE, "no such station: %g ft; the runway is %g ft long",
                             options->station_ft[i], runway_ft);
    }
    return MR_OK;
}

/* Why a run failed at a mat and a time, and what to do. */
static void fail_at(const struct sim_result *result, const struct sim_scene *scene, char *why,
                    size_t size)
{
    bool given = result->solver &&
                 (strcmp(result->solver, "staggered") == 0 || strcmp(result->solver, "rk4") == 0);
    bool underflow = result->status == SIM_STEP_UNDERFLOW;
    if (result->status == SIM_FOLDED)
        snprintf(why, size, "turned beyond 85 degrees; give less thrust or an earlier tend");
    else if (!given && underflow && scene->friction_law == SIM_SIGN && scene->friction > 0.0)
        snprintf(why, size,
                 "friction sign chatters around rest; give friction stick, its exact form");
    else if (!given && underflow)
        snprintf(why, size,
                 "solver %s makes no progress; give another solver, a looser rtol or an earlier "
                 "tend",
                 result->solver);
    else if (!given)
        snprintf(why, size,
                 "solver %s contradicts itself at two tolerances; give a smaller rtol or another "
                 "solver",
                 result->solver);
    else if (underflow)
        snprintf(why, size,
                 "still differs with a step of %g s; give a larger rtol or an earlier tend",
                 result->dt_s);
    else if (result->dt_s > result->dt_limit_s)
        snprintf(why, size,
                 "the step of %g s is beyond the stability limit of %g s; give a smaller dt",
                 result->dt_s, result->dt_limit_s);
    else
        snprintf(why, size, "the step of %g s fails its check; give a smaller dt, or rtol",
                 result->dt_s);
}

static void fail_text(const struct sim_result *result, const struct sim_scene *scene,
                      const struct deadline *deadline, struct error *error)
{
    const char *name = sim_scene_name(scene);
    char why[160];
    if (result->status == SIM_INTERRUPTED && deadline->late) {
        error_set(error, MR_NUMERICS,
                  "interrupted: %s: at %.9g of %.9g s, as the limit of %g s of computing is over; "
                  "what was computed until then is given; give a longer limit, an earlier tend or "
                  "a looser rtol",
                  name, result->t_s, result->t_end_s, deadline->asked->limit_s);
    } else if (result->status == SIM_INTERRUPTED) {
        error_set(error, MR_NUMERICS,
                  "interrupted: %s: at %.9g of %.9g s; what was computed until then is given", name,
                  result->t_s, result->t_end_s);
    } else if (result->status == SIM_UNPREDICTABLE) {
        error_set(error, MR_NUMERICS,
                  "unpredictable: %s: beyond %.6g s, first at mat %d: %d runs that should be alike "
                  "part there, by up to %.2g ft of movement and %.2g ft of lift; no finer step "
                  "helps; give an earlier tend",
                  name, result->t_s, result->mat, result->spread_runs, result->error_u_ft,
                  result->error_lift_ft);
    } else {
        fail_at(result, scene, why, sizeof why);
        error_set(error, MR_NUMERICS, "%s: %s: mat %d at %.9g s: %s",
                  sim_status_name(result->status), name, result->mat, result->t_s, why);
    }
}

/* A run that was stopped while it was checked has an answer, but not what that is worth. */
static enum mr_status conclude(struct sim_result *result, const struct sim_scene *scene,
                               const struct deadline *deadline, struct error *error)
{
    if (error->status != MR_OK)
        return error->status;
    if (deadline->late && result->status == SIM_OK)
        sim_result_end(result, SIM_INTERRUPTED, 1, result->t_end_s);
    if (result->status != SIM_OK)
        fail_text(result, scene, deadline, error);
    return error->status;
}

enum mr_status sim_run(const struct sim_scene *scene, const struct sim_options *options,
                       struct sim_result *result, struct error *error)
{
    const char *where = sim_scene_name(scene);
    struct deadline deadline;
    *result = (struct sim_result){0};
    deadline_begin(&deadline, options, options->limit_s);
    if (sim_scene_check(scene, where, error) != MR_OK ||
        check_options(scene, options, error) != MR_OK)
        return error->status;
    if (scene->model != SIM_CHAIN) {
        planar_run(scene, &deadline.options, result, error);
        return conclude(result, scene, &deadline, error);
    }
    if (scene->friction_law != SIM_NONE && scene->friction_normal == SIM_SOIL)
        return error_set(error, MR_USAGE,
                         "no soil in model chain: %s: friction_normal soil; give weight", where);
    chain_run(scene, &deadline.options, result, error);
    return conclude(result, scene, &deadline, error);
}

bool sim_progress(void *progress, int pass, double part)
{
    progress_at(progress, "run %d is at %.0f %%", pass, 100.0 * part);
    return true;
}
