#include "host/sim/solvers/moreau.h"

#include <math.h>

#include "host/sim/solvers/apart.h"
#include "host/sim/solvers/planar.h"
#include "host/sim/solvers/spread.h"

#define RATIO       1.9
#define CAUTION     3.0
#define FIRST_STEPS 500.0
#define CLOSE       1e-4
#define RUNS_MOST   16
#define RUNS        3

/* The last runs, the one with the shortest steps last. */
struct ladder {
    struct pass_outcome runs[RUNS];
    int count; /* of those that are complete */
    struct apart last, before;
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
        l->last = apart_of(&l->runs[l->count - 2], &l->runs[l->count - 1]);
}

static void restart(struct ladder *l)
{
    for (int i = 0; i < l->count; i++)
        pass_free(&l->runs[i]);
    l->count = 0;
}

static bool agrees(const struct ladder *l, const struct sim_scene *scene)
{
    return l->count == RUNS && apart_agree(scene, &l->runs[1], &l->runs[2], l->last);
}

static void state(const struct ladder *l, struct sim_result *result)
{
    double before = l->count == RUNS ? 1.0 / RATIO : 0.0;
    result->error_u_ft = CAUTION * fmax(l->last.u.u_ft, before * l->before.u.u_ft);
    result->error_lift_ft = CAUTION * fmax(l->last.lift_ft, before * l->before.lift_ft);
}

static bool close_enough(const struct ladder *l, const struct sim_scene *scene,
                         const struct sim_result *result)
{
    const struct pass_outcome *best = &l->runs[l->count - 1];
    double lift_ft = fmax(best->max_lift_ft, planar_bow_threshold_ft(scene));
    return agrees(l, scene) && result->error_u_ft <= CLOSE * sim_record_peak(&best->record).u_ft &&
           result->error_lift_ft <= CLOSE * lift_ft;
}

static enum mr_status say(struct model *m, const struct sim_options *options,
                          const struct pass_request *request, struct ladder *l, bool given,
                          struct sim_result *result, struct error *error)
{
    struct pass_outcome *best = &l->runs[l->count - 1], *other = &l->runs[l->count - 2];
    if (!agrees(l, m->scene)) {
        sim_result_end(result, SIM_UNSTABLE, l->last.u.mat, l->last.u.t_s);
        if (!given && spread_run(m, request, options, best, other, result, error) != MR_OK)
            return error->status;
    }
    return planar_answer(m, best, other, result, error);
}

enum mr_status moreau_run(const struct model *model, const struct sim_options *options,
                          struct sim_result *result, struct error *error)
{
    struct model m = *model;
    struct ladder ladder = {0};
    bool given = options->dt_s > 0.0;
    double work = 0.0, end_s = sim_scene_end_s(m.scene);
    struct pass_request request = {
        &stepper_moreau, 0.0, given ? options->dt_s * RATIO * RATIO : end_s / FIRST_STEPS,
        UINT64_MAX,      0,   0.0};
    if (m.law == SIM_SIGN) {
        m.law = SIM_STICK;
        sim_result_note(result, "friction sign is taken as stick, its exact form");
    }
    sim_result_note(result, "error estimate: three times the largest difference to runs with 1.9 "
                            "and 3.6 times the step");
    for (int i = 0; i < RUNS_MOST; i++) {
        struct pass_outcome run = {0};
        request.number = ++result->passes;
        request.most_steps = given ? UINT64_MAX : (uint64_t)(MOREAU_WORK / (double)m.mats);
        enum mr_status status = pass_run(&run, &m, &request, options, error);
        double done = (double)run.rhs * m.mats;
        result->rhs += run.rhs;
        result->rejected += run.rejected;
        work += done;
        if (status != MR_OK || run.status == SIM_INTERRUPTED) {
            sim_result_end(result, run.status, run.mat, run.t_s);
            if (status == MR_OK)
                status = planar_answer(&m, &run, &run, result, error);
            pass_free(&run);
            restart(&ladder);
            return status;
        }
        bool more = given ? i + 1 < RUNS : i + 1 < RUNS_MOST && work + RATIO * done < MOREAU_WORK;
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
        request.dt_s /= RATIO;
    }
    if (ladder.count >= 2) {
        result->status = SIM_OK;
        say(&m, options, &request, &ladder, given, result, error);
    } else if (ladder.count == 1) {
        sim_result_end(result, SIM_UNSTABLE, 1, end_s);
    }
    restart(&ladder);
    return error->status;
}
