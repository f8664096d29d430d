/* What a finished study says: slopes, and who is cheapest. */
#include <math.h>
#include <string.h>

#include "host/sim/check/error_study.h"

#define LEAST_OF_AGREEMENT 10.0
#define MOST_OF_PEAK       0.1
/* of the largest value: sums of rounding over 1e5 steps come near this */
#define ROUND_OFF          3e-12
#define LEAST_RANGE        3.0 /* of what is fitted over: costs that are alike show no slope */

const double error_levels_ft[] = {1e-3, 1e-5, 5e-6, 1e-7};
const size_t error_level_count = sizeof error_levels_ft / sizeof error_levels_ft[0];

const char *error_against_name(enum error_against against)
{
    static const char *const names[] = {"dt", "rtol", "rhs"};
    return names[against];
}

size_t error_study_solvers(const struct error_study *study, const char **names, size_t room)
{
    size_t count = 0;
    for (size_t i = 0; i < study->run_count; i++) {
        bool known = false;
        for (size_t k = 0; k < count; k++)
            known = known || strcmp(names[k], study->runs[i].solver) == 0;
        if (!known && count < room)
            names[count++] = study->runs[i].solver;
    }
    return count;
}

static bool usable(const struct error_run *run)
{
    return run->status == SIM_OK && !run->beyond;
}

static struct error_slope fit(const struct error_study *study, const char *solver,
                              enum error_against against, bool lift)
{
    struct error_slope s = {.from = HUGE_VAL, .to = 0.0};
    double least =
        fmax(LEAST_OF_AGREEMENT * (lift ? study->agreement_lift_ft : study->agreement_u_ft),
             ROUND_OFF * (lift ? study->max_lift_ft : study->peak_u_ft));
    double most = MOST_OF_PEAK * (lift ? study->max_lift_ft : study->peak_u_ft);
    double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        double error = lift ? run->lift_ft : run->u_ft;
        if (strcmp(run->solver, solver) != 0 || !usable(run) || !(error > least && error < most))
            continue;
        double at = against == ERROR_DT   ? run->dt_s
                  : against == ERROR_RTOL ? run->rtol
                                          : (double)run->rhs;
        double x = log10(at), y = log10(error);
        s.points++;
        s.from = fmin(s.from, at);
        s.to = fmax(s.to, at);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
        syy += y * y;
    }
    double n = s.points, spread = sxx - sx * sx / n;
    if (s.points < 3 || s.to < LEAST_RANGE * s.from) {
        s.points = 0;
        return s;
    }
    double along = (sxy - sx * sy / n) / spread;
    s.slope = against == ERROR_RHS ? -along : along;
    s.scatter = sqrt(fmax(0.0, (syy - sy * sy / n - along * along * spread) / n));
    return s;
}

static void add_order(struct error_study *study, const char *solver, enum error_against against)
{
    if (study->order_count == ERROR_ORDERS_MAX)
        return;
    study->orders[study->order_count++] = (struct error_order){
        solver, against, fit(study, solver, against, false),
        study->lifts ? fit(study, solver, against, true) : (struct error_slope){0}};
}

void error_study_fit(struct error_study *study)
{
    const char *names[ERROR_ORDERS_MAX];
    size_t count = error_study_solvers(study, names, ERROR_ORDERS_MAX);
    study->order_count = 0;
    for (size_t k = 0; k < count; k++) {
        bool fixed = false;
        for (size_t i = 0; i < study->run_count; i++)
            fixed = fixed ||
                    (strcmp(study->runs[i].solver, names[k]) == 0 && study->runs[i].dt_s > 0.0);
        if (fixed) {
            add_order(study, names[k], ERROR_DT);
        } else {
            add_order(study, names[k], ERROR_RTOL);
            add_order(study, names[k], ERROR_RHS);
        }
    }
}

static double own_ft(const struct error_study *study, const struct error_run *run)
{
    if (!usable(run))
        return (double)NAN;
    return study->lifts ? run->lift_ft : run->u_ft;
}

double error_study_judged_ft(const struct error_study *study, size_t i)
{
    const struct error_run *run = &study->runs[i];
    double own = own_ft(study, run);
    if (run->dt_s == 0.0 || isnan(own))
        return own;
    for (int side = 0; side < 2; side++) {
        if (side == 0 ? i == 0 : i + 1 == study->run_count)
            return (double)NAN;
        const struct error_run *next = &study->runs[side == 0 ? i - 1 : i + 1];
        double error = own_ft(study, next);
        if (strcmp(next->solver, run->solver) != 0 || isnan(error))
            return (double)NAN;
        own = fmax(own, error);
    }
    return own;
}

const struct error_run *error_study_cheapest(const struct error_study *study, const char *solver,
                                             double level_ft)
{
    const struct error_run *best = NULL;
    if (level_ft < ERROR_FLOOR * (study->lifts ? study->agreement_lift_ft : study->agreement_u_ft))
        return NULL;
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        if ((solver && strcmp(run->solver, solver) != 0) ||
            !(error_study_judged_ft(study, i) <= level_ft))
            continue;
        if (!best || run->ms < best->ms)
            best = run;
    }
    return best;
}
