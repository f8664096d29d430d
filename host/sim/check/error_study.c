#include "host/sim/check/error_study.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/base/steady.h"
#include "host/sim/check/error_work.h"
#include "host/sim/solvers/pass.h"

#define TARGET_FT           1e-10 /* agreement that needs no further tightening, */
/* at a tolerance well below those that are judged: two errors can be alike by luck */
#define TARGET_RTOL         1e-12
#define LOOSEST_EXPONENT    3
#define TIGHTEST_EXPONENT   9
#define REPEAT_MS           25.0 /* runs shorter than this are repeated */
#define REPEATS             5
/* steps times mats beyond which the reference is not tightened further */
#define REFERENCE_MAT_STEPS 2e7
#define TABLE_MAT_STEPS     6e7   /* the same of a run in the table, */
#define TABLE_STEPS         30000 /* and these and */
#define TABLE_STEPS_PER_MAT 700   /* these per mat */
#define EXPLICIT_REACH      6.0 /* steps of `event` are at most about this over the fastest rate */
/* where the negative real axis leaves the classical method's stability region */
#define RK4_REAL            2.785
#define RK4_RUNGS           24 /* below the limit: */
/* a fifth of an octave apart, close enough to see which of them hit by luck, then half of one */
#define RK4_CLOSE           15
#define RK4_FIRST           0.97             /* of the limit */
#define MAT_STEPS           6e7              /* steps times mats of the longest fixed-step run */
static const double beyond[] = {1.12, 1.05}; /* of the limit */

void error_note(struct error_study *study, const char *format, ...)
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

struct error_run *error_add(struct error_study *study)
{
    if (study->run_count == ERROR_RUNS_MAX)
        return NULL;
    struct error_run *run = &study->runs[study->run_count++];
    if (study->told)
        study->told(study->told_ctx, study->run_count);
    *run = (struct error_run){.u_ft = (double)NAN,
                              .rms_u_ft = (double)NAN,
                              .lift_ft = (double)NAN,
                              .max_lift_ft = (double)NAN};
    return run;
}

/* outcome->ms becomes processor time. */
static enum mr_status one_pass(struct pass_outcome *outcome, const struct sim_scene *scene,
                               const struct pass_request *request, struct error *error)
{
    struct model model;
    const struct sim_options options = {0};
    *outcome = (struct pass_outcome){0};
    if (model_make(&model, scene, false, error) != MR_OK)
        return error->status;
    double begin_ms = processor_ms();
    pass_run(outcome, &model, request, &options, error);
    outcome->ms = processor_ms() - begin_ms;
    model_free(&model);
    return error->status;
}

double error_rms_ft(const struct sim_record *a, const struct sim_record *b)
{
    double sum = 0.0;
    for (size_t i = 0; i < a->snapshot_count; i++) {
        for (int n = 1; n <= a->mats; n++) {
            double difference = a->snapshots[i].u_ft[n] - b->snapshots[i].u_ft[n];
            sum += difference * difference;
        }
    }
    return sqrt(sum / ((double)a->snapshot_count * a->mats));
}

static double lift_difference_ft(const struct pass_outcome *a, const struct sim_record *record,
                                 double max_lift_ft)
{
    return fmax(sim_record_lift_difference(&a->record, record), fabs(a->max_lift_ft - max_lift_ft));
}

/* Fastest rate of the linearised equations at the start. */
static enum mr_status fastest_rate(const struct sim_scene *scene, double *rate, struct error *error)
{
    struct model model;
    if (model_make(&model, scene, false, error) != MR_OK)
        return error->status;
    double *z = calloc(2 * (size_t)model.size, sizeof *z);
    if (!z) {
        error_set(error, MR_FULL, "out of memory: %d mats; use a smaller N", scene->mats);
    } else {
        model_start(&model, z);
        *rate = model_fastest_rate(&model, z, MODEL_EXPLICIT);
    }
    free(z);
    model_free(&model);
    return error->status;
}

/* ---- reference ---- */

static uint64_t reference_steps(const struct sim_scene *scene)
{
    if (scene->friction_law == SIM_SIGN && scene->friction > 0.0)
        return 50000; /* it chatters: no method gets through */
    return 200000 + 20000 * (uint64_t)scene->mats;
}

/* One pair of methods, tightened until they agree; the best pair stays in the reference. `failed`
 * says which method did not get through when no pair came about. */
static enum mr_status tighten(struct error_reference *reference,
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
            const struct pass_request request = {pair[i], rtol, 0.0, reference_steps(scene),
                                                 0,       0.0};
            both[i] = (struct pass_outcome){0};
            if (one_pass(&both[i], scene, &request, error) != MR_OK || both[i].status != SIM_OK) {
                *failed = both[i];
                *failed_name = pair[i]->name;
                pass_free(&both[i]);
                if (i == 1)
                    pass_free(&both[0]);
                return error->status;
            }
        }
        double u = sim_record_difference(&both[0].record, &both[1].record).u_ft;
        double lift = lift_difference_ft(&both[1], &both[0].record, both[0].max_lift_ft);
        double mat_steps = (double)(both[0].steps > both[1].steps ? both[0].steps : both[1].steps) *
                           scene->mats;
        /* the tighter pair, unless it is clearly worse */
        if (!reference->found ||
            fmax(u, lift) <= fmax(TARGET_FT, 2.0 * fmax(reference->u_ft, reference->lift_ft))) {
            double rms = error_rms_ft(&both[0].record, &both[1].record);
            sim_record_free(&reference->record);
            *reference = (struct error_reference){
                true, rtol, u, lift, rms, both[0].max_lift_ft, both[0].record};
            both[0].record = (struct sim_record){0};
        }
        pass_free(&both[0]);
        pass_free(&both[1]);
        if ((fmax(u, lift) <= TARGET_FT && rtol <= 1.01 * TARGET_RTOL) ||
            mat_steps > REFERENCE_MAT_STEPS)
            break;
    }
    return MR_OK;
}

static enum mr_status refuse_failed(const struct sim_scene *scene, const char *name,
                                    const struct pass_outcome *failed, struct error *error)
{
    return error_set(error, MR_NUMERICS,
                     "no reference: %s: %s ends %s at a tight tolerance, mat %d at %.9g s; give an "
                     "earlier tend or "
                     "another scene",
                     scene->name[0] ? scene->name : "scene", name, sim_status_name(failed->status),
                     failed->mat, failed->t_s);
}

enum mr_status error_reference_planar(struct error_reference *reference, struct error_study *study,
                                      const struct sim_scene *scene, struct error *error)
{
    const struct stepper_kind *const explicit_first[2] = {&stepper_event, &stepper_implicit};
    const struct stepper_kind *const both_implicit[2] = {&stepper_implicit, &stepper_cvode};
    const struct stepper_kind *const *pair = explicit_first;
    struct pass_outcome failed = {0};
    const char *name = NULL;
    double rate = 0.0;
    *reference = (struct error_reference){0};
    if (fastest_rate(scene, &rate, error) != MR_OK)
        return error->status;
    bool hopeless = rate * sim_scene_end_s(scene) / EXPLICIT_REACH > (double)reference_steps(scene);
    if (hopeless || tighten(reference, pair, scene, &failed, &name, error) != MR_OK ||
        (!reference->found && name == stepper_event.name && failed.status == SIM_STEP_UNDERFLOW)) {
        pair = both_implicit;
        if (error->status == MR_OK && !(scene->friction_law == SIM_SIGN && scene->friction > 0.0))
            tighten(reference, pair, scene, &failed, &name, error);
    }
    if (error->status != MR_OK)
        return error->status;
    if (!reference->found)
        return refuse_failed(scene, name ? name : "event", &failed, error);
    if (reference->u_ft > ERROR_LIMIT_U_FT || reference->lift_ft > ERROR_LIMIT_LIFT_FT)
        return error_set(error, MR_NUMERICS,
                         "no reference: %s: %s and %s still differ by %.2g ft (u) and %.2g ft "
                         "(lift) at rtol %g; give "
                         "an earlier tend or another scene",
                         scene->name[0] ? scene->name : "scene", pair[0]->name, pair[1]->name,
                         reference->u_ft, reference->lift_ft, reference->rtol);
    snprintf(study->method, sizeof study->method, "%s (%s) at rtol %g; agrees with %s (%s)",
             pair[0]->name, pair[0]->method, reference->rtol, pair[1]->name, pair[1]->method);
    return MR_OK;
}

/* ---- runs of the planar models ---- */

static enum mr_status measure(struct error_study *study, const struct error_reference *reference,
                              const struct sim_scene *scene, const struct pass_request *request,
                              struct error *error)
{
    struct pass_outcome outcome;
    struct error_run *run = error_add(study);
    if (!run || one_pass(&outcome, scene, request, error) != MR_OK)
        return error->status;
    run->solver = request->kind->name;
    run->rtol = request->rtol;
    run->dt_s = request->dt_s;
    run->steps = outcome.steps;
    run->rhs = outcome.rhs;
    run->ms = outcome.ms;
    run->status = outcome.status;
    run->mat = outcome.mat;
    run->t_s = outcome.t_s;
    run->beyond = request->kind->fixed && request->dt_s > study->dt_limit_s;
    if (outcome.status == SIM_OK) {
        run->u_ft = sim_record_difference(&outcome.record, &reference->record).u_ft;
        run->rms_u_ft = error_rms_ft(&outcome.record, &reference->record);
        run->lift_ft = lift_difference_ft(&outcome, &reference->record, reference->max_lift_ft);
        run->max_lift_ft = outcome.max_lift_ft;
    } else if (outcome.steps > request->most_steps / 2) {
        error_note(study, "%s at rtol %g was given up after %llu steps, at %.4g s", run->solver,
                   run->rtol, (unsigned long long)outcome.steps, outcome.t_s);
    }
    pass_free(&outcome);
    for (int i = 1; i < REPEATS && run->ms < REPEAT_MS && run->status == SIM_OK; i++) {
        if (one_pass(&outcome, scene, request, error) == MR_OK)
            run->ms = fmin(run->ms, outcome.ms);
        pass_free(&outcome);
    }
    return error->status;
}

static enum mr_status over_tolerances(struct error_study *study,
                                      const struct error_reference *reference,
                                      const struct sim_scene *scene,
                                      const struct stepper_kind *kind, struct error *error)
{
    double most = fmin(TABLE_STEPS + TABLE_STEPS_PER_MAT * scene->mats,
                       fmax(20000.0, TABLE_MAT_STEPS / scene->mats));
    for (int e = LOOSEST_EXPONENT; e <= TIGHTEST_EXPONENT; e++) {
        const struct pass_request request = {kind, pow(10.0, -e), 0.0, (uint64_t)most, 0, 0.0};
        if (measure(study, reference, scene, &request, error) != MR_OK)
            return error->status;
        const struct error_run *run = &study->runs[study->run_count - 1];
        if (e > LOOSEST_EXPONENT && run->status != SIM_OK && run[-1].status == SIM_OK &&
            run->steps > request.most_steps / 2 && e < TIGHTEST_EXPONENT) {
            error_note(study, "%s: tolerances below %g left out: they need more steps still",
                       kind->name, run->rtol);
            break;
        }
    }
    return MR_OK;
}

static double octaves(int rung)
{
    return rung < RK4_CLOSE ? 0.2 * rung : 0.2 * RK4_CLOSE + 0.5 * (rung - RK4_CLOSE);
}

static enum mr_status over_steps(struct error_study *study, const struct error_reference *reference,
                                 const struct sim_scene *scene, struct error *error)
{
    double end_s = study->end_s, limit_s = study->dt_limit_s;
    double least_s = end_s * scene->mats / MAT_STEPS;
    double first_s = RK4_FIRST * fmin(limit_s, end_s / 20.0);
    if (first_s < least_s) {
        error_note(study, "rk4 left out: its stability limit of %.3g s asks for %.3g steps",
                   limit_s, end_s / limit_s);
        return MR_OK;
    }
    for (size_t i = 0; i < sizeof beyond / sizeof beyond[0] && limit_s < end_s / 20.0; i++) {
        const struct pass_request request = {&stepper_rk4, 0.0, beyond[i] * limit_s,
                                             UINT64_MAX,   0,   0.0};
        if (measure(study, reference, scene, &request, error) != MR_OK)
            return error->status;
    }
    for (int k = 0; k < RK4_RUNGS; k++) {
        const struct pass_request request = {&stepper_rk4, 0.0, first_s * pow(2.0, -octaves(k)),
                                             UINT64_MAX,   0,   0.0};
        if (request.dt_s < least_s) {
            error_note(study, "rk4: steps below %.3g s left out", least_s);
            break;
        }
        if (measure(study, reference, scene, &request, error) != MR_OK)
            return error->status;
    }
    return MR_OK;
}

static enum mr_status planar(struct error_study *study, const struct sim_scene *scene,
                             struct error *error)
{
    static const struct stepper_kind *const kinds[] = {
        &stepper_event, &stepper_implicit, &stepper_cvode, &stepper_rkgs, &stepper_hamming};
    struct error_reference reference;
    double rate = 0.0;
    if (error_reference_planar(&reference, study, scene, error) == MR_OK &&
        fastest_rate(scene, &rate, error) == MR_OK) {
        error_study_take(study, &reference);
        study->dt_limit_s = rate > 0.0 ? RK4_REAL / rate : HUGE_VAL;
        for (size_t i = 0; i < sizeof kinds / sizeof kinds[0] && error->status == MR_OK; i++)
            over_tolerances(study, &reference, scene, kinds[i], error);
        if (error->status == MR_OK)
            over_steps(study, &reference, scene, error);
    }
    sim_record_free(&reference.record);
    return error->status;
}

void error_study_take(struct error_study *study, const struct error_reference *reference)
{
    study->agreement_u_ft = reference->u_ft;
    study->agreement_lift_ft = reference->lift_ft;
    study->agreement_rms_u_ft = reference->rms_u_ft;
    study->peak_u_ft = sim_record_peak(&reference->record).u_ft;
    study->max_lift_ft = reference->max_lift_ft;
}

enum mr_status error_study_run(struct error_study *study, const struct sim_scene *scene,
                               error_told *told, void *told_ctx, struct error *error)
{
    *study = (struct error_study){
        .lifts = scene->model != SIM_CHAIN, .told = told, .told_ctx = told_ctx};
    if (told)
        told(told_ctx, 0);
    if (sim_scene_check(scene, scene->name[0] ? scene->name : "scene", error) != MR_OK)
        return error->status;
    study->end_s = sim_scene_end_s(scene);
    if (scene->model == SIM_CHAIN)
        error_study_chain(study, scene, error);
    else
        planar(study, scene, error);
    if (error->status == MR_OK)
        error_study_fit(study);
    return error->status;
}
