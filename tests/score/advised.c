#include "tests/score/advised.h"

#include <math.h>
#include <string.h>

#define BUMP_FT         0.0036 /* that the planar truth's ground is uneven by, at most */
#define SHARE_ERROR     0.03
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

bool advised_begin(struct advise_members *members, const struct score_series *series, bool share)
{
    uint64_t off = 0x54a4e000u + series->number;
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
        .ground_irregularity_ft = BUMP_FT,
        .thrust_share = share ? series->thrust_share * (1.0 + SHARE_ERROR * score_normal(&off))
                              : 0.0,
    };
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        runway.transducer_station_ft[i] = i < ADVISED_STATIONS ? 40.0f + 10.0f * (float)i : NAN;
    return advise_members_draw(members, &runway, ADVISED_MEMBERS, 0xd2a30000u + series->number) ==
           MR_OK;
}

void advised_plan(struct advise_plan *plan, const struct score_landing *landing,
                  const struct advised_known *known, const double *log_ratio, size_t landings)
{
    *plan = (struct advise_plan){.speed_ft_s = landing->speed_ft_s,
                                 .speed_spread = SPEED_ERROR,
                                 .mean_braking_ft_s2 = known->plan_ft_s2,
                                 .touchdown_ft = TOUCHDOWN,
                                 .touchdown_spread_ft = TOUCHDOWN_ERROR,
                                 .profile = known->profile,
                                 .seed = landing->number};
    advise_predict_plan_deviation(log_ratio, landings, &plan->braking_log_bias,
                                  &plan->braking_spread);
}

bool advised_say(struct advise_members *members, const struct advise_plan *plan,
                 const struct advised_known *known, double mean_ft_s2, struct advise_row *row)
{
    static struct advise_braking braking[ADVISED_MEMBERS];
    static struct advise_outcome met[ADVISED_MEMBERS];
    advise_apply_survey(members, known->sum_in, SURVEY_IN);
    return advise_compute_row(members, plan, mean_ft_s2, braking, met, row);
}

bool advised_teach(struct advise_members *members, const struct score_landing *landing,
                   const struct advised_known *known, const struct advised_known *next)
{
    struct advise_observation seen = {
        .braking = {.speed_ft_s = landing->speed_ft_s,
                    .touchdown_ft = TOUCHDOWN,
                    .mean_braking_ft_s2 = known->true_ft_s2,
                    .profile = known->profile.point_count ? &known->profile : NULL},
        .movement_error_in = READING_IN,
        .survey_error_in = SURVEY_IN};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        seen.movement_in[i] = i < ADVISED_STATIONS ? known->read_in[i] : (double)NAN;
    memcpy(seen.survey_before_in, known->sum_in, sizeof seen.survey_before_in);
    memcpy(seen.survey_after_in, next->sum_in, sizeof seen.survey_after_in);
    return advise_update(members, &seen);
}

/* --- a whole series --- */

void advised_draw_plan(const struct score_landing *landing, uint32_t series,
                       const struct advised_told *told, struct mr_risk_plan *plan)
{
    uint64_t state = 0x91a40000u + 8u * series + landing->number;
    double factor = fmin(fmax(1.0 + told->plan_error * score_normal(&state), 0.5), 1.6),
           bend = fmin(fmax(1.0 + told->plan_error * score_normal(&state), 0.5), 1.6);
    mr_risk_plan_clear(plan);
    plan->landing_count = (float)(landing->number - 1u);
    plan->speed_ft_s = (float)(landing->speed_ft_s *
                               fmin(fmax(1.0 + SPEED_ERROR * score_normal(&state), 0.9), 1.1));
    for (unsigned i = 0; i < SCORE_KNOTS; i++) {
        plan->plan_time_s[i] = landing->plan_time_s[i] * (float)bend;
        plan->plan_deceleration_ft_s2[i] = landing->plan_deceleration_ft_s2[i] *
                                           (float)(factor / told->harder);
    }
}

static double plan_ft_s2(const struct mr_risk_plan *plan, double t_s)
{
    const float *t = plan->plan_time_s, *a = plan->plan_deceleration_ft_s2;
    if (t_s <= (double)t[0])
        return (double)a[0];
    for (unsigned i = 1; i < SCORE_KNOTS; i++) {
        if (t_s < (double)t[i])
            return (double)a[i - 1] +
                   (double)(a[i] - a[i - 1]) * (t_s - (double)t[i - 1]) / (double)(t[i] - t[i - 1]);
    }
    return (double)a[SCORE_KNOTS - 1];
}

double advised_plan_mean_ft_s2(const struct mr_risk_plan *plan)
{
    double v_ft_s = (double)plan->speed_ft_s, stopping_distance_ft = 0.0;
    for (double t_s = 0.0; v_ft_s > 0.0 && t_s < 60.0; t_s += 1e-3) {
        stopping_distance_ft += v_ft_s * 1e-3;
        v_ft_s -= 1e-3 * plan_ft_s2(plan, t_s);
    }
    return 0.5 * (double)plan->speed_ft_s * (double)plan->speed_ft_s / stopping_distance_ft;
}

double advised_plan_hardest_ft_s2(const struct mr_risk_plan *plan)
{
    double most = 0.0;
    for (unsigned i = 0; i < SCORE_KNOTS; i++)
        most = fmax(most, (double)plan->plan_deceleration_ft_s2[i]);
    return most;
}

/* What is not read is no number. */
static void forget(const struct advised_told *told, unsigned landing, struct advised_known *known)
{
    bool surveyed = told->view & SCORE_SURVEYED && (landing == 0 || !(told->view & SCORE_ONCE));
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        known->sum_in[s] = surveyed ? known->sum_in[s] : (double)NAN;
    for (unsigned s = 0; s < ADVISED_STATIONS; s++) {
        if (told->view & SCORE_BLIND || (told->view & SCORE_HALF && s % 2))
            known->read_in[s] = (double)NAN;
    }
}

bool advised_charts(const struct score_truth *truth, const struct advised_told *told,
                    const double *factors, size_t rows, struct advised_chart *chart)
{
    struct advise_members members = {0};
    struct advised_known known[SCORE_LANDINGS];
    struct score_series series = truth->series;
    double log_ratio[SCORE_LANDINGS];
    uint64_t facts = 0xc4a70000u + series.number;
    memset(known, 0, sizeof known);
    series.told_friction *= told->friction_times;
    for (unsigned i = 0; i < series.landings; i++) {
        struct mr_risk_plan plan;
        advised_draw_plan(&truth->landing[i], series.number, told, &plan);
        known[i].plan_ft_s2 = advised_plan_mean_ft_s2(&plan);
        known[i].true_ft_s2 = advised_mean_ft_s2(&truth->landing[i], series.touchdown_ft);
        known[i].profile.point_count = SCORE_KNOTS;
        for (unsigned k = 0; k < SCORE_KNOTS; k++) {
            known[i].profile.t_s[k] = (double)plan.plan_time_s[k];
            known[i].profile.factor[k] = (double)plan.plan_deceleration_ft_s2[k] /
                                         known[i].plan_ft_s2;
        }
        advised_read(&truth->landing[i], &facts, &known[i]);
        forget(told, i, &known[i]);
        log_ratio[i] = log(known[i].true_ft_s2 / known[i].plan_ft_s2);
    }
    bool good = advised_begin(&members, &series, told->share);
    for (unsigned i = 0; good && i < series.landings; i++) {
        struct advise_plan plan;
        advised_plan(&plan, &truth->landing[i], &known[i], log_ratio, i);
        for (size_t r = 0; good && r < rows; r++) {
            struct advise_row row;
            double mean_ft_s2 = factors[r] * known[i].plan_ft_s2;
            good = advised_say(&members, &plan, &known[i], mean_ft_s2, &row);
            chart[i].mean_ft_s2[r] = mean_ft_s2;
            chart[i].p[r] = row.zone_probability.probability;
            chart[i].share[r] = row.zone_share;
            chart[i].half_ft[r] = row.median_zone_station_ft;
        }
        if (good && i + 1 < series.landings)
            good = advised_teach(&members, &truth->landing[i], &known[i], &known[i + 1]);
    }
    advise_members_free(&members);
    return good;
}

void advised_chart_put(const struct advised_chart *chart, size_t rows, struct mr_risk_plan *plan)
{
    for (size_t r = 0; r < rows; r++) {
        plan->chart_deceleration_ft_s2[r] = (float)chart->mean_ft_s2[r];
        plan->chart_log_odds[r] = (float)log(chart->p[r] / (1.0 - chart->p[r]));
        plan->chart_zone_ft[r] = (float)chart->half_ft[r];
    }
}
