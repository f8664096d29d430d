#include "host/advise/waves.h"

#include <math.h>
#include <stdlib.h>

#define USUAL_FT_S 32.0
#define STOOD_MOST 4u /* the same mats on the same ground: more of them are not as many witnesses */
/* the plan's error, from -3 to 3 of its spread */
#define PARTS      31
#define PARTS_FROM (-3.0)
#define PARTS_STEP 0.2
/* hardest deceleration over the mean where only the mean is told, as the law's landings had it */
#define PEAK       1.136
/* so few landings have made the law that it foretells nothing surer */
#define SUREST     0.005
/* log odds of the members' mean times this, and this more: of planar series 250 to 309 and 540 to
 * 599, by a plan that is 10 % off */
#define ODDS_TIMES 0.84
#define ODDS_MORE  (-0.13)

/* Of planar series 0 to 309 and 540 to 599 of make score, none of which is scored
 * (build/tests/score/waves build/score fit), and their covariance. */
static const double law[ADVISE_WAVE_INPUTS] = {-2.147, 11.676, 1.543};
static const double covariance[ADVISE_WAVE_INPUTS][ADVISE_WAVE_INPUTS] = {
    {0.0516, -0.1864, -0.0099}, {-0.1864, 1.2342, -0.3836}, {-0.0099, -0.3836, 1.7173}};

void advise_wave_inputs(double thrust_lb, double critical_lb, double speed_ft_s,
                        double input[ADVISE_WAVE_INPUTS])
{
    input[0] = 1.0;
    input[1] = log(thrust_lb / critical_lb);
    input[2] = log(speed_ft_s / USUAL_FT_S);
}

double advise_wave_critical_lb(const struct advise_runway *runway)
{
    return (double)runway->chain.mass_slug * ADVISE_G_FT_S2 * (double)runway->chain.mat_length_ft /
           (2.0 * runway->bump_ft);
}

/* Log odds of a member whose strip bears all of the thrust; its own are slope times log(share)
 * more. */
static double odds_at(const struct advise_runway *runway, double speed_ft_s, double mean_ft_s2,
                      double input[ADVISE_WAVE_INPUTS])
{
    double odds = 0.0;
    advise_wave_inputs(runway->thrust_lb_per_g * mean_ft_s2 / ADVISE_G_FT_S2,
                       advise_wave_critical_lb(runway), speed_ft_s, input);
    for (unsigned i = 0; i < ADVISE_WAVE_INPUTS; i++)
        odds += law[i] * input[i];
    return odds;
}

static double chance_at(double odds)
{
    return 1.0 / (1.0 + exp(-odds));
}

/* Log odds of the landings that had the greatest; how many. */
static size_t keep_hardest(const struct advise_runway *runway, const struct advise_braking *stood,
                           size_t count, double odds[STOOD_MOST])
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        double input[ADVISE_WAVE_INPUTS],
            at = odds_at(runway, stood[i].speed_ft_s, stood[i].mean_ft_s2, input);
        size_t least = 0;
        for (size_t k = 1; k < kept; k++)
            least = odds[k] < odds[least] ? k : least;
        if (kept < STOOD_MOST)
            odds[kept++] = at;
        else
            odds[least] = fmax(odds[least], at);
    }
    return kept;
}

/* The members' weights, of sum 1. */
static void weigh(const struct advise_members *members, const struct advise_braking *stood,
                  size_t count, double *weight)
{
    double odds[STOOD_MOST], best = -(double)INFINITY, sum = 0.0;
    size_t kept = keep_hardest(&members->runway, stood, count, odds);
    for (size_t m = 0; m < members->count; m++) {
        double own = law[1] * members->member[m].unknown[ADVISE_SHARE];
        weight[m] = 0.0;
        /* log(1 - p), without a difference of what is nearly the same */
        for (size_t i = 0; i < kept; i++)
            weight[m] -= fmax(odds[i] + own, 0.0) + log1p(exp(-fabs(odds[i] + own)));
        best = fmax(best, weight[m]);
    }
    for (size_t m = 0; m < members->count; m++)
        sum += weight[m] = exp(weight[m] - best);
    for (size_t m = 0; m < members->count; m++)
        weight[m] /= sum;
}

static double hardest(const struct advise_profile *profile)
{
    double most = 0.0;
    for (size_t i = 0; i < profile->count; i++)
        most = fmax(most, profile->factor[i]);
    return profile->count ? most / PEAK : 1.0;
}

static struct advise_chance said(double p, double variance)
{
    const double odds = log(p / (1.0 - p)), half = 1.96 * sqrt(variance) / (p * (1.0 - p)),
                 at[3] = {odds, odds - half, odds + half};
    double out[3];
    for (unsigned i = 0; i < 3; i++)
        out[i] = fmin(fmax(chance_at(ODDS_MORE + ODDS_TIMES * at[i]), SUREST), 1.0 - SUREST);
    return (struct advise_chance){out[0], out[1], out[2]};
}

/* A deceleration as it may be met: its weight, and what the law makes of it. */
struct part {
    double weight, odds, input[ADVISE_WAVE_INPUTS];
};

/* What stops on the runway alone: of a plan that hardly does, the harder half. */
static void part_out(const struct advise_members *members, const struct advise_plan *plan,
                     double mean_ft_s2, struct part part[PARTS])
{
    double least_ft_s2 = advise_least_ft_s2(members, plan), sum = 0.0;
    for (unsigned i = 0; i < PARTS; i++) {
        double off = PARTS_FROM + PARTS_STEP * i,
               met_ft_s2 = mean_ft_s2 * exp(plan->bias + plan->spread * off);
        part[i].weight = met_ft_s2 >= least_ft_s2 ? exp(-0.5 * off * off) : 0.0;
        sum += part[i].weight;
        part[i].odds = odds_at(&members->runway, plan->speed_ft_s,
                               fmax(met_ft_s2, least_ft_s2) * hardest(&plan->profile),
                               part[i].input);
    }
    for (unsigned i = 0; i < PARTS; i++)
        part[i].weight = sum > 0.0 ? part[i].weight / sum : 1.0 / PARTS;
}

static struct advise_chance foretell(const struct advise_members *members,
                                     const struct part part[PARTS], const double *weight,
                                     double *own)
{
    double p = 0.0, variance = 0.0, slope[ADVISE_WAVE_INPUTS] = {0.0};
    for (size_t m = 0; m < members->count; m++) {
        double share = members->member[m].unknown[ADVISE_SHARE];
        own[m] = 0.0;
        for (unsigned i = 0; i < PARTS; i++) {
            double at = chance_at(part[i].odds + law[1] * share),
                   by = weight[m] * part[i].weight * at * (1.0 - at);
            own[m] += part[i].weight * at;
            for (unsigned k = 0; k < ADVISE_WAVE_INPUTS; k++)
                slope[k] += by * (part[i].input[k] + (k == 1 ? share : 0.0));
        }
        p += weight[m] * own[m];
    }
    p = fmin(fmax(p, 1e-6), 1.0 - 1e-6);
    for (size_t m = 0; m < members->count; m++)
        variance += weight[m] * weight[m] * (own[m] - p) * (own[m] - p);
    for (unsigned i = 0; i < ADVISE_WAVE_INPUTS; i++) {
        for (unsigned j = 0; j < ADVISE_WAVE_INPUTS; j++)
            variance += slope[i] * covariance[i][j] * slope[j];
    }
    return said(p, variance);
}

bool advise_waves(const struct advise_members *members, const struct advise_plan *plan,
                  const struct advise_braking *stood, size_t count, struct advise_row *row,
                  size_t rows)
{
    struct part part[PARTS];
    double *weight = calloc(2 * members->count, sizeof *weight);
    bool told = members->runway.bump_ft > 0.0;
    if (weight && told)
        weigh(members, stood, count, weight);
    for (size_t i = 0; weight && told && i < rows; i++) {
        part_out(members, plan, row[i].mean_ft_s2, part);
        row[i].wave = foretell(members, part, weight, weight + members->count);
    }
    free(weight);
    return weight != NULL;
}
