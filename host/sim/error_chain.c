/* Error study of the chain: `fixed` over steps. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/error_work.h"
#include "host/sim/sim.h"

#define EVEN_TIMES 64
#define RUNGS 15        /* a factor sqrt 2 apart */
#define FIRST 0.97      /* of the stability limit */
#define LEAST_STEPS 20.0
#define MAT_STEPS 1.5e9 /* steps times mats of the longest run; it costs half as many again */

static bool has_grit(const struct sim_scene *scene)
{
    for (size_t i = 0; i < scene->grit_lb.count; i++) {
        if (scene->grit_lb.values[i] > 0.0 && scene->slack_ft > 0.0)
            return true;
    }
    return false;
}

/* The report model without bump and shear stays flat: its horizontal equations are the chain's. */
static struct sim_scene as_planar(const struct sim_scene *scene)
{
    struct sim_scene flat = *scene;
    flat.model = SIM_REPORT;
    flat.profile = SIM_LOW;
    flat.bump_ft = (struct sim_list){0};
    flat.grit_lb = (struct sim_list){0};
    flat.shear_lb = 0.0;
    flat.q1_lb = 0.0;
    return flat;
}

/* Largest difference between a result's outputs and the reference's; both have the same t_out. */
static double difference_ft(const struct sim_result *result, const struct sim_record *reference)
{
    double most = 0.0;
    for (size_t i = 0; i < reference->snapshot_count; i++) {
        const struct sim_snapshot *snapshot = &reference->snapshots[i];
        if (snapshot->output < 0)
            continue;
        for (int n = 1; n <= reference->mats; n++)
            most = fmax(most, fabs(result->outputs[snapshot->output].u_ft[n] - snapshot->u_ft[n]));
    }
    return most;
}

static enum mr_status measure(struct error_study *study, const struct sim_record *reference,
                              const struct sim_scene *scene, double dt_s, struct error *error)
{
    const struct sim_options options = {.solver = "fixed", .dt_s = dt_s};
    struct sim_result result;
    struct error failed = {0};
    struct error_run *run = error_add(study);
    if (!run)
        return MR_OK;
    sim_run(scene, &options, &result, &failed);
    if (failed.status != MR_OK && failed.status != MR_NUMERICS) {
        sim_result_free(&result);
        return error_set(error, failed.status, "%s", failed.text);
    }
    run->solver = "fixed";
    run->dt_s = result.dt_s;
    run->steps = run->rhs = result.steps;
    run->ms = result.pass_ms;
    run->status = result.status;
    run->mat = result.mat;
    run->t_s = result.t_s;
    run->beyond = dt_s > study->dt_limit_s;
    if (result.status == SIM_OK) {
        run->u_ft = difference_ft(&result, reference);
        run->lift_ft = run->max_lift_ft = 0.0;
    }
    sim_result_free(&result);
    return MR_OK;
}

static enum mr_status over_steps(struct error_study *study, const struct sim_record *reference,
                                 const struct sim_scene *scene, struct error *error)
{
    double end_s = study->end_s;
    double first_s = fmin(study->dt_limit_s, end_s / LEAST_STEPS);
    double least_s = end_s * scene->mats / MAT_STEPS;
    if (study->dt_limit_s < end_s / LEAST_STEPS)
        measure(study, reference, scene, 1.05 * study->dt_limit_s, error);
    for (int k = 0; k < RUNGS && error->status == MR_OK; k++) {
        double dt_s = FIRST * first_s * pow(2.0, -0.5 * k);
        if (dt_s < least_s) {
            error_note(study, "steps below %.3g s left out", least_s);
            break;
        }
        measure(study, reference, scene, dt_s, error);
    }
    return error->status;
}

/* The step limit is the solver's own word; a run that fails its check has it too. */
static enum mr_status ask_limit(struct error_study *study, const struct sim_scene *scene, struct error *error)
{
    struct sim_scene brief = *scene;
    struct sim_result result;
    struct error failed = {0};
    const struct sim_options options = {.dt_s = 1e6};
    sim_run(&brief, &options, &result, &failed);
    study->dt_limit_s = result.dt_limit_s;
    sim_result_free(&result);
    if (failed.status != MR_OK && failed.status != MR_NUMERICS)
        error_set(error, failed.status, "%s", failed.text);
    return error->status;
}

enum mr_status error_study_chain(struct error_study *study, const struct sim_scene *scene, struct error *error)
{
    struct sim_scene timed = *scene;
    struct error_reference reference = {0};
    size_t asked = scene->t_out_s.count;
    double *times_s = calloc(EVEN_TIMES + asked, sizeof *times_s);
    if (!times_s)
        return error_set(error, MR_FULL, "out of memory: %zu outputs; ask for fewer", EVEN_TIMES + asked);
    for (size_t i = 0; i < EVEN_TIMES; i++)
        times_s[i] = study->end_s * (double)(i + 1) / EVEN_TIMES;
    for (size_t i = 0; i < asked; i++)
        times_s[EVEN_TIMES + i] = scene->t_out_s.values[i];
    timed.t_out_s = (struct sim_list){times_s, EVEN_TIMES + asked};
    if (ask_limit(study, &timed, error) == MR_OK) {
        struct sim_scene flat = as_planar(&timed);
        if (has_grit(scene))
            error_set(error, MR_USAGE, "no second method: %s: grit; leave it out", scene->name);
        else
            error_reference_planar(&reference, study, &flat, error);
    }
    if (error->status == MR_OK) {
        error_study_take(study, &reference);
        over_steps(study, &reference.record, &timed, error);
    }
    sim_record_free(&reference.record);
    free(times_s);
    return error->status;
}
