#include "host/advise/forecast.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/statistics.h"
#include "host/base/xmalloc.h"

#define STREAM         2u
#define PRIOR_LANDINGS 4.0
#define LEAST_OF       64.0

void advise_plan_met(const double *log_ratio, size_t count, double *bias, double *spread)
{
    const double prior = PRIOR_LANDINGS, n = (double)count;
    double mean = 0.0, squares = 0.0;
    for (size_t i = 0; i < count; i++)
        mean += log_ratio[i] / n;
    for (size_t i = 0; i < count; i++)
        squares += (log_ratio[i] - mean) * (log_ratio[i] - mean);
    /* the prior's squares are such that n = 0 gives ADVISE_PLAN_MET */
    double sum = ADVISE_PLAN_MET * ADVISE_PLAN_MET * (prior - 2.0) / (1.0 + 1.0 / prior) + squares +
                 prior * n / (prior + n) * mean * mean;
    *bias = n * mean / (prior + n);
    *spread = sqrt(sum / (prior + n - 2.0) * (1.0 + 1.0 / (prior + n)));
}

void advise_draw_braking(const struct advise_members *members, const struct advise_plan *plan,
                         double mean_ft_s2, struct advise_braking *braking)
{
    for (size_t m = 0; m < members->count; m++) {
        struct chance chance = chance_from(plan->seed, 1000u * STREAM + m);
        double met = fmin(fmax(plan->spread * chance_normal(&chance), -0.5), 0.4),
               speed = plan->speed_spread * chance_normal(&chance),
               at_ft = plan->touchdown_spread_ft * chance_normal(&chance);
        braking[m] = (struct advise_braking){
            .speed_ft_s = plan->speed_ft_s * fmax(1.0 + speed, 0.5),
            .touchdown_ft = fmax(plan->touchdown_ft + at_ft, 0.0),
            .mean_ft_s2 = mean_ft_s2 * exp(plan->bias) * (1.0 + met),
            .profile = &plan->profile,
        };
    }
}

double advise_odds(double share)
{
    double soft = (LEAST_OF * share + 0.5) / (LEAST_OF + 1.0);
    return log(soft / (1.0 - soft));
}

/* Log odds of the members' share times the former, and the latter more: fitted on series 250 to 309
 * of make score-foresight, none of which is scored (tests/score/README.md, "Before touchdown" and
 * "Perturbed"). Who was never surveyed knows less than the members take for known. */
double advise_calibrated(double share, bool surveyed)
{
    double times = surveyed ? 0.64 : 0.53, more = surveyed ? 0.49 : -0.28;
    return 1.0 / (1.0 + exp(-(more + times * advise_odds(share))));
}

struct advise_chance advise_chance_of(size_t events, size_t count, bool surveyed)
{
    struct wilson share = wilson_of(events, count);
    return (struct advise_chance){.p = advise_calibrated((double)events / (double)count, surveyed),
                                  .low = advise_calibrated(share.low, surveyed),
                                  .high = advise_calibrated(share.high, surveyed)};
}

static int by_size(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

bool advise_row(struct advise_members *members, const struct advise_plan *plan, double mean_ft_s2,
                struct advise_braking *braking, struct advise_met *met, struct advise_row *row)
{
    const struct mr_chain_params *chain = &members->runway.chain;
    double end_ft = (double)chain->mat_length_ft * chain->mats;
    size_t played = 0, off = 0, come = 0, by[ADVISE_STATIONS] = {0};
    float *at_ft = xcalloc(members->count, sizeof *at_ft);
    advise_draw_braking(members, plan, mean_ft_s2, braking);
    if (!advise_play(members, braking, false, met)) {
        free(at_ft);
        return false;
    }
    for (size_t m = 0; m < members->count; m++) {
        if (met[m].ran_away)
            continue;
        played++;
        off += (double)met[m].stop_ft >= end_ft;
        if (isnan(met[m].zone_ft))
            continue;
        at_ft[come++] = met[m].zone_ft;
        for (unsigned s = 0; s < ADVISE_STATIONS; s++)
            by[s] += (double)met[m].zone_ft <= end_ft * (s + 1u) / ADVISE_STATIONS;
    }
    qsort(at_ft, come, sizeof *at_ft, by_size);
    *row = (struct advise_row){.mean_ft_s2 = mean_ft_s2,
                               .half_ft = come ? (double)at_ft[come / 2] : (double)NAN};
    if (played) {
        row->share = (double)come / (double)played;
        row->zone = advise_chance_of(come, played, members->surveyed);
        row->off_runway = (double)off / (double)played;
        for (unsigned s = 0; s < ADVISE_STATIONS; s++)
            row->by_station[s] = advise_chance_of(by[s], played, members->surveyed);
    }
    free(at_ft);
    return played > 0;
}

double advise_least_ft_s2(const struct advise_members *members, const struct advise_plan *plan)
{
    const struct mr_chain_params *chain = &members->runway.chain;
    double left_ft = (double)chain->mat_length_ft * chain->mats - plan->touchdown_ft;
    return plan->speed_ft_s * plan->speed_ft_s / (2.0 * left_ft);
}

double advise_hardest_ft_s2(const struct advise_row *row, size_t rows, double limit, bool *beyond,
                            double *short_ft_s2)
{
    size_t last = rows; /* the last that is not below */
    *beyond = false;
    *short_ft_s2 = (double)NAN;
    while (last > 0 && row[last - 1].zone.p < limit)
        last--;
    if (!last && rows) {
        *beyond = true;
        return row[rows - 1].mean_ft_s2;
    }
    if (last < rows)
        *short_ft_s2 = row[last].mean_ft_s2;
    if (!rows || row[0].zone.p >= limit)
        return (double)NAN;
    size_t i = 1;
    while (row[i].zone.p < limit)
        i++;
    return row[i - 1].mean_ft_s2 + (row[i].mean_ft_s2 - row[i - 1].mean_ft_s2) *
                                       (limit - row[i - 1].zone.p) /
                                       (row[i].zone.p - row[i - 1].zone.p);
}
