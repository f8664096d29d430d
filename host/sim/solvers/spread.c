#include "host/sim/solvers/spread.h"

#include <math.h>

#include "host/sim/solvers/planar.h"

void spread_part(struct sim_result *result, const struct sim_record *given,
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
    other.kl *= 1.0 + (run & 1 ? SPREAD_PART : -SPREAD_PART);
    other.kv *= 1.0 + (run & 2 ? SPREAD_PART : -SPREAD_PART);
    return other;
}

enum mr_status spread_nudged(const struct model *m, const struct pass_request *request,
                             const struct sim_options *options, int run, struct pass_outcome *pass,
                             struct sim_result *result, struct error *error)
{
    struct model near = nudged(m, run);
    struct pass_request again = *request;
    again.number = ++result->passes;
    if (pass_run(pass, &near, &again, options, error) == MR_OK)
        result->rhs += pass->rhs;
    return error->status;
}

enum mr_status spread_run(const struct model *m, const struct pass_request *request,
                          const struct sim_options *options, const struct pass_outcome *given,
                          const struct pass_outcome *other, struct sim_result *result,
                          struct error *error)
{
    double threshold = planar_bow_threshold_ft(m->scene);
    double most_u_ft = PLANAR_DISAGREEMENT * sim_record_peak(&given->record).u_ft,
           most_lift_ft = PLANAR_DISAGREEMENT * given->max_lift_ft + 0.01 * threshold;
    result->status = SIM_OK;
    result->spread_runs = 1;
    result->spread_waves = given->max_lift_ft > threshold;
    for (int run = -1; run < SPREAD_RUNS; run++) {
        struct pass_outcome pass = {0};
        if (run >= 0 && spread_nudged(m, request, options, run, &pass, result, error) != MR_OK) {
            pass_free(&pass);
            return error->status;
        }
        const struct pass_outcome *next = run < 0 ? other : &pass;
        if (next->status == SIM_OK) {
            result->spread_runs++;
            result->spread_waves += next->max_lift_ft > threshold;
            spread_part(result, &given->record, &next->record, most_u_ft, most_lift_ft);
            result->error_lift_ft = fmax(result->error_lift_ft,
                                         fabs(given->max_lift_ft - next->max_lift_ft));
        }
        pass_free(&pass);
    }
    return MR_OK;
}
