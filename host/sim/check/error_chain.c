/* Error study of the chain: `fixed` over steps. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/check/error_march.h"
#include "host/sim/check/error_work.h"
#include "host/sim/sim.h"

/* mats times steps at the limit: more take the planar methods minutes */
#define PLANAR_WORK     1e6
#define MARCH_EXPONENTS 3
#define TARGET_FT       1e-7
#define MARCH_MAT_STEPS 1.2e9 /* mats times steps of `fixed`: no finer */
#define REPEATS         5
#define REPEAT_MS       25.0 /* runs shorter than this are repeated */
#define EVEN_TIMES      64
#define RUNGS           15   /* a factor sqrt 2 apart */
#define FIRST           0.97 /* of the stability limit */
#define LEAST_STEPS     20.0
#define MAT_STEPS       7e8 /* steps times mats of the longest run; it costs half as many again */

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

/* A result's outputs as a record. The scene's t_out are the even times and then what was asked for;
 * the record brings its own even times, which are the same. */
static enum mr_status as_record(struct sim_record *record, const struct sim_result *result,
                                const struct sim_scene *scene, struct error *error)
{
    const struct sim_options options = {0};
    size_t row = (size_t)scene->mats + 1;
    int even = 0;
    if (sim_record_make(record, scene, &options, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < record->snapshot_count; i++) {
        struct sim_snapshot *snapshot = &record->snapshots[i];
        int output = snapshot->output >= 0 ? snapshot->output : even++;
        memcpy(snapshot->u_ft, result->outputs[output].u_ft, row * sizeof *snapshot->u_ft);
    }
    return MR_OK;
}

/* One answer of `fixed`. A run that fails its own check is no error: result->status says it. */
static enum mr_status run_fixed(struct sim_result *result, const struct sim_scene *scene,
                                double dt_s, struct error *error)
{
    const struct sim_options options = {.solver = "fixed", .dt_s = dt_s};
    struct error failed = {0};
    sim_run(scene, &options, result, &failed);
    if (failed.status != MR_OK && failed.status != MR_NUMERICS)
        error_set(error, failed.status, "%s", failed.text);
    return error->status;
}

static enum mr_status measure(struct error_study *study, const struct sim_record *reference,
                              const struct sim_scene *scene, double dt_s, struct error *error)
{
    struct sim_result result;
    struct sim_record record = {0};
    struct error_run *run = error_add(study);
    if (!run || run_fixed(&result, scene, dt_s, error) != MR_OK)
        return error->status;
    run->solver = "fixed";
    run->dt_s = result.dt_s;
    run->steps = run->rhs = result.steps;
    run->ms = result.pass_ms;
    run->status = result.status;
    run->mat = result.mat;
    run->t_s = result.t_s;
    run->beyond = dt_s > study->dt_limit_s;
    if (result.status == SIM_OK && as_record(&record, &result, scene, error) == MR_OK) {
        run->u_ft = sim_record_difference(&record, reference).u_ft;
        run->rms_u_ft = error_rms_ft(&record, reference);
        run->lift_ft = run->max_lift_ft = 0.0;
    }
    sim_record_free(&record);
    sim_result_free(&result);
    for (int i = 1;
         i < REPEATS && run->ms < REPEAT_MS && run->status == SIM_OK && error->status == MR_OK;
         i++) {
        run_fixed(&result, scene, dt_s, error);
        run->ms = fmin(run->ms, result.pass_ms);
        sim_result_free(&result);
    }
    return error->status;
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

/* The step limit is the solver's own word; an answer that is refused has it too. */
static enum mr_status ask_limit(struct error_study *study, const struct sim_scene *scene,
                                struct error *error)
{
    struct sim_result result;
    if (run_fixed(&result, scene, 1e6, error) == MR_OK)
        study->dt_limit_s = result.dt_limit_s;
    sim_result_free(&result);
    return error->status;
}

/* `fixed` and the march, at ever finer steps. */
static enum mr_status march(struct error_reference *reference, struct error_study *study,
                            const struct sim_scene *scene, struct error *error)
{
    static const double parts[MARCH_EXPONENTS] = {16.0, 64.0, 256.0};
    const char *name = scene->name[0] ? scene->name : "scene";
    double limit_s = fmin(study->dt_limit_s, study->end_s / LEAST_STEPS), dt_s = 0.0;
    for (int k = 0; k < MARCH_EXPONENTS; k++) {
        struct sim_record record = {0}, other = {0};
        struct sim_result result = {0};
        struct march_cost cost = {0};
        if (k > 0 && study->end_s / limit_s * parts[k] * scene->mats > MARCH_MAT_STEPS)
            break;
        dt_s = limit_s / parts[k];
        if (march_run(&record, &cost, scene, 2.0 * dt_s, error) == MR_OK && !cost.stalled &&
            run_fixed(&result, scene, dt_s, error) == MR_OK && result.status == SIM_OK)
            as_record(&other, &result, scene, error);
        if (error->status == MR_OK && cost.stalled)
            error_set(error, MR_NUMERICS,
                      "no reference: %s: switches without end at %.9g s; give an earlier tend",
                      name, cost.t_s);
        if (error->status == MR_OK && result.status != SIM_OK)
            error_set(error, MR_NUMERICS,
                      "no reference: %s: fixed ends %s with steps of %.3g s; give an earlier tend",
                      name, sim_status_name(result.status), dt_s);
        if (error->status == MR_OK) {
            sim_record_free(&reference->record);
            *reference =
                (struct error_reference){.found = true,
                                         .u_ft = sim_record_difference(&record, &other).u_ft,
                                         .rms_u_ft = error_rms_ft(&record, &other),
                                         .record = record};
            record = (struct sim_record){0};
        }
        sim_record_free(&record);
        sim_record_free(&other);
        sim_result_free(&result);
        if (error->status != MR_OK || reference->u_ft <= TARGET_FT)
            break;
    }
    if (error->status == MR_OK && reference->rms_u_ft > ERROR_LIMIT_RMS_FT)
        error_set(error, MR_NUMERICS,
                  "no reference: %s: fixed and Runge-Kutta with located switches still differ by "
                  "%.2g ft (rms) with "
                  "steps of %.3g s; give an earlier tend",
                  name, reference->rms_u_ft, dt_s);
    snprintf(study->method, sizeof study->method,
             "classical Runge-Kutta with every switch located, steps of at most %.3g s; agrees "
             "with fixed at %.3g s",
             2.0 * dt_s, dt_s);
    return error->status;
}

enum mr_status error_study_chain(struct error_study *study, const struct sim_scene *scene,
                                 struct error *error)
{
    struct sim_scene timed = *scene;
    struct error_reference reference = {0};
    size_t asked = scene->t_out_s.count;
    double *times_s = calloc(EVEN_TIMES + asked, sizeof *times_s);
    if (!times_s)
        return error_set(error, MR_FULL, "out of memory: %zu outputs; ask for fewer",
                         EVEN_TIMES + asked);
    for (size_t i = 0; i < EVEN_TIMES; i++)
        times_s[i] = study->end_s * (double)(i + 1) / EVEN_TIMES;
    for (size_t i = 0; i < asked; i++)
        times_s[EVEN_TIMES + i] = scene->t_out_s.values[i];
    timed.t_out_s = (struct sim_list){times_s, EVEN_TIMES + asked};
    if (ask_limit(study, &timed, error) == MR_OK) {
        struct sim_scene flat = as_planar(&timed);
        bool smooth = scene->friction > 0.0 && scene->friction_law == SIM_TANH;
        bool heavy = study->end_s / study->dt_limit_s * scene->mats > PLANAR_WORK;
        if (has_grit(scene) || (heavy && !smooth))
            march(&reference, study, &timed, error);
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
