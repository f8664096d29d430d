#include "tests/score/advised.h"

#include <math.h>
#include <string.h>

#define SPEED_ERROR     0.01
#define TOUCHDOWN       3.0
#define TOUCHDOWN_ERROR 0.5
#define READING_IN      0.003
#define SURVEY_IN       0.005

double advised_mean_ft_s2(const struct score_landing *landing, double touchdown_ft)
{
    return landing->speed_ft_s * landing->speed_ft_s / 2.0 / (landing->stop_ft - touchdown_ft);
}

void advised_read(const struct score_landing *landing, uint64_t *facts, struct advised_known *known)
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        known->sum_in[s] = SURVEY_IN * score_normal(facts);
        for (unsigned j = 0; j < MR_MATS_PER_SEGMENT; j++)
            known->sum_in[s] += (double)landing->gap_in[s * MR_MATS_PER_SEGMENT + j];
    }
    for (unsigned s = 0; s < ADVISED_STATIONS; s++)
        known->read_in[s] = (double)landing->u_in[landing->rows - 1][3 + s] +
                            READING_IN * score_normal(facts);
}

bool advised_begin(struct advise_members *members, const struct score_series *series)
{
    struct advise_runway runway = {
        .chain = {.mats = SCORE_MATS,
                  .mat_length_ft = (float)SCORE_MAT_FT,
                  .mass_slug = 0.466f / 32.174f,
                  .friction_lb = (float)(0.466 * series->told_friction),
                  .kl_lb_ft = 2.9e5f,
                  .cl_lb_s_ft = 5.0f,
                  .slack_ft = 0.0025f},
        .grit_lb = 10.0,
        .thrust_lb_per_g = 1300.0 / 12.0,
    };
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        runway.station_ft[i] = i < ADVISED_STATIONS ? 40.0f + 10.0f * (float)i : NAN;
    return advise_members_draw(members, &runway, ADVISED_MEMBERS, 0xd2a30000u + series->number) ==
           MR_OK;
}

void advised_plan(struct advise_plan *plan, const struct score_landing *landing,
                  const struct advised_known *known, const double *log_ratio, size_t landings)
{
    *plan = (struct advise_plan){.speed_ft_s = landing->speed_ft_s,
                                 .speed_spread = SPEED_ERROR,
                                 .mean_ft_s2 = known->plan_ft_s2,
                                 .touchdown_ft = TOUCHDOWN,
                                 .touchdown_spread_ft = TOUCHDOWN_ERROR,
                                 .profile = known->profile,
                                 .seed = landing->number};
    advise_plan_met(log_ratio, landings, &plan->bias, &plan->spread);
}

bool advised_say(struct advise_members *members, const struct advise_plan *plan,
                 const struct advised_known *known, double mean_ft_s2, struct advise_row *row)
{
    static struct advise_braking braking[ADVISED_MEMBERS];
    static struct advise_met met[ADVISED_MEMBERS];
    advise_survey(members, known->sum_in, SURVEY_IN);
    return advise_row(members, plan, mean_ft_s2, braking, met, row);
}

bool advised_teach(struct advise_members *members, const struct score_landing *landing,
                   const struct advised_known *known, const struct advised_known *next)
{
    struct advise_seen seen = {
        .braking = {.speed_ft_s = landing->speed_ft_s,
                    .touchdown_ft = TOUCHDOWN,
                    .mean_ft_s2 = known->true_ft_s2,
                    .profile = known->profile.count ? &known->profile : NULL},
        .moved_error_in = READING_IN,
        .survey_error_in = SURVEY_IN};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        seen.moved_in[i] = i < ADVISED_STATIONS ? known->read_in[i] : (double)NAN;
    memcpy(seen.before_in, known->sum_in, sizeof seen.before_in);
    memcpy(seen.after_in, next->sum_in, sizeof seen.after_in);
    return advise_learn(members, &seen);
}
