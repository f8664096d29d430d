#include "common/risk.h"

#include "common/crc32.h"
#include "common/wire.h"

#define G_FT_S2                   32.174f
#define BLOCK_S                   1e-3f
#define ZONE_MATS                 50.0f
#define ZONE_RATIO_MAX            3.0f /* longer zones do not increase the risk further */
#define EXCESS_START_MATS         40.0f
#define EXCESS_RANGE_MATS         20.0f
#define STEP_S                    0.05f
#define TIME_STEP_COUNT           240u
#define DECELERATION_MIN_FT_S2    0.1f
#define SLOW_MAX_FT_S             2.0f /* a wheel slower than this reaches no further zone */
/* planned loss of speed from which on the measured loss is compared with the planned one */
#define COMPARED_LOSS_MIN_FT_S    2.0f
#define PLAN_RATIO_MIN            0.6f
#define PLAN_RATIO_MAX            1.6f
#define DEVIATION_MAX_BLOCKS      300u
#define SPEED_TOLERANCE           0.15f
#define HARDER_BRAKING_RATIO      1.05f
#define MUCH_HARDER_BRAKING_RATIO 1.15f
#define LANDINGS_MAX              6.0f
#define EXPECTED_ZONE_MIN_MATS    30u

static const float risk_weights[MR_RISK_WEIGHT_SET_COUNT][MR_RISK_INPUT_COUNT] = {
#include "common/risk_weights.def"
};

static bool is_between(float x, float least, float most)
{
    return x >= least && x <= most;
}

/* --- plan --- */

void mr_risk_plan_clear(struct mr_risk_plan *plan)
{
    for (unsigned i = 0; i < MR_RISK_PLAN_ITEM_COUNT; i++)
        (void)mr_risk_plan_set_item(plan, i, MR_NAN);
}

static float *get_plan_item_address(struct mr_risk_plan *plan, unsigned item)
{
    float *const list[] = {plan->chart_deceleration_ft_s2, plan->chart_log_odds,
                           plan->chart_zone_ft, plan->plan_time_s, plan->plan_deceleration_ft_s2};
    static const unsigned count[] = {MR_RISK_CHART_ROWS, MR_RISK_CHART_ROWS, MR_RISK_CHART_ROWS,
                                     MR_RISK_PLAN_KNOTS, MR_RISK_PLAN_KNOTS};
    if (item < 2u)
        return item ? &plan->speed_ft_s : &plan->landing_count;
    item -= 2u;
    for (unsigned i = 0; i < sizeof count / sizeof count[0]; i++) {
        if (item < count[i])
            return list[i] + item;
        item -= count[i];
    }
    return NULL;
}

float mr_risk_plan_get_item(const struct mr_risk_plan *plan, unsigned item)
{
    struct mr_risk_plan copy = *plan;
    const float *at = get_plan_item_address(&copy, item);
    return at ? *at : MR_NAN;
}

bool mr_risk_plan_set_item(struct mr_risk_plan *plan, unsigned item, float value)
{
    float *at = get_plan_item_address(plan, item);
    if (!at)
        return false;
    *at = __builtin_isnan(value) ? MR_NAN : value;
    return true;
}

uint32_t mr_risk_plan_crc(const struct mr_risk_plan *plan)
{
    uint32_t crc = 0;
    for (unsigned i = 0; i < MR_RISK_PLAN_ITEM_COUNT; i++) {
        uint8_t bytes[4];
        float value = mr_risk_plan_get_item(plan, i);
        mr_put_f32(bytes, __builtin_isnan(value) ? MR_NAN : value);
        crc = mr_crc32(crc, bytes, sizeof bytes);
    }
    return crc;
}

static unsigned count_chart_rows(const struct mr_risk_plan *plan)
{
    unsigned n = 0;
    while (n < MR_RISK_CHART_ROWS && !__builtin_isnan(plan->chart_deceleration_ft_s2[n]))
        n++;
    return n;
}

static unsigned count_plan_knots(const struct mr_risk_plan *plan)
{
    unsigned n = 0;
    while (n < MR_RISK_PLAN_KNOTS && !__builtin_isnan(plan->plan_time_s[n]))
        n++;
    return n;
}

enum mr_status mr_risk_plan_check(const struct mr_risk_plan *plan)
{
    unsigned knots = count_plan_knots(plan), rows = count_chart_rows(plan);
    if (!is_between(plan->speed_ft_s, 1.0f, 300.0f) || knots < 1u)
        return MR_USAGE;
    for (unsigned i = 0; i < knots; i++) {
        if (!is_between(plan->plan_time_s[i], 0.0f, 60.0f) ||
            !is_between(plan->plan_deceleration_ft_s2[i], 0.0f, 64.0f) ||
            (i && !(plan->plan_time_s[i] > plan->plan_time_s[i - 1u])))
            return MR_USAGE;
    }
    /* With too little braking at the end of the plan, the wheel would never stop. */
    if (!(plan->plan_deceleration_ft_s2[knots - 1u] >= DECELERATION_MIN_FT_S2))
        return MR_USAGE;
    if (rows && !is_between(plan->landing_count, 0.0f, 65535.0f))
        return MR_USAGE;
    for (unsigned i = 0; i < rows; i++) {
        if (!is_between(plan->chart_deceleration_ft_s2[i], DECELERATION_MIN_FT_S2, 64.0f) ||
            !is_between(plan->chart_log_odds[i], -20.0f, 20.0f) ||
            (i && !(plan->chart_deceleration_ft_s2[i] > plan->chart_deceleration_ft_s2[i - 1u])) ||
            !(__builtin_isnan(plan->chart_zone_ft[i]) ||
              is_between(plan->chart_zone_ft[i], -100.0f, 1e4f)))
            return MR_USAGE;
    }
    return MR_OK;
}

/* Interpolates linearly between points with ascending `x`; returns the first or last value outside
 * of them. */
static float interpolate(const float *x, const float *y, unsigned count, float at)
{
    if (at <= x[0])
        return y[0];
    for (unsigned i = 1; i < count; i++) {
        if (at < x[i])
            return y[i - 1u] + (y[i] - y[i - 1u]) * ((at - x[i - 1u]) / (x[i] - x[i - 1u]));
    }
    return y[count - 1u];
}

static float get_planned_deceleration_ft_s2(const struct mr_risk_state *risk, float since_s)
{
    return interpolate(risk->plan.plan_time_s, risk->plan.plan_deceleration_ft_s2,
                       count_plan_knots(&risk->plan), since_s);
}

static bool is_following_plan(const struct mr_risk_state *risk)
{
    return risk->has_plan && !risk->has_deviated_from_plan;
}

/* --- look ahead --- */

/* Predicts the stop for the planned braking multiplied by speed_loss_ratio (measured / planned),
 * from this speed. */
static void predict_planned_braking(struct mr_risk_state *risk, float speed_ft_s)
{
    float at_s = risk->since_touchdown_s, stopping_distance_ft = 0.0f, v_ft_s = speed_ft_s;
    for (unsigned i = 0; i < TIME_STEP_COUNT && v_ft_s > 0.0f; i++) {
        float a_ft_s2 = get_planned_deceleration_ft_s2(risk, at_s + 0.5f * STEP_S) *
                        risk->speed_loss_ratio;
        a_ft_s2 = a_ft_s2 < DECELERATION_MIN_FT_S2 ? DECELERATION_MIN_FT_S2 : a_ft_s2;
        if (a_ft_s2 > HARDER_BRAKING_RATIO * risk->hardest_braking_ft_s2) {
            risk->hardest_braking_ft_s2 = a_ft_s2;
            risk->hardest_braking_distance_ft = stopping_distance_ft;
        }
        float step_s = v_ft_s < a_ft_s2 * STEP_S ? v_ft_s / a_ft_s2 : STEP_S;
        stopping_distance_ft += (v_ft_s - 0.5f * a_ft_s2 * step_s) * step_s;
        v_ft_s -= a_ft_s2 * STEP_S;
        at_s += STEP_S;
    }
    /* after TIME_STEP_COUNT steps, assume that the last deceleration continues */
    if (v_ft_s > 0.0f) {
        float last_ft_s2 = get_planned_deceleration_ft_s2(risk, at_s) * risk->speed_loss_ratio;
        stopping_distance_ft += 0.5f * v_ft_s * v_ft_s /
                                (last_ft_s2 < DECELERATION_MIN_FT_S2 ? DECELERATION_MIN_FT_S2
                                                                     : last_ft_s2);
    }
    risk->stopping_distance_ft = stopping_distance_ft;
}

/* Predicts the stop for the case that the present deceleration continues. */
static void predict_present_braking(struct mr_risk_state *risk, const struct mr_predictor *p)
{
    float speed_ft_s = p->speed_ft_s;
    float a_ft_s2 = p->deceleration_ft_s2 > DECELERATION_MIN_FT_S2 ? p->deceleration_ft_s2
                                                                   : DECELERATION_MIN_FT_S2;
    risk->hardest_braking_ft_s2 = a_ft_s2;
    risk->hardest_braking_distance_ft = 0.0f;
    risk->stopping_distance_ft = __builtin_isnan(speed_ft_s)
                                   ? MR_NAN
                                   : 0.5f * speed_ft_s * speed_ft_s / a_ft_s2;
}

static void predict_braking(struct mr_risk_state *risk, const struct mr_predictor *p)
{
    risk->hardest_braking_ft_s2 = risk->hardest_braking_distance_ft = 0.0f;
    if (is_following_plan(risk))
        predict_planned_braking(risk, __builtin_isnan(p->speed_ft_s) ? risk->plan.speed_ft_s
                                                                     : p->speed_ft_s);
    else
        predict_present_braking(risk, p);
}

/* Starts the search for the zone that the hardest planned braking would close. */
static void begin_scan(struct mr_risk_state *risk, const struct mr_predictor *p)
{
    const struct mr_chain *chain = &p->chain;
    float group_ft = p->config.chain.mat_length_ft * (float)chain->mats_per_group,
          end_ft = group_ft * (float)chain->group_count;
    float wheel_ft = __builtin_isnan(p->wheel_ft) || p->wheel_ft < risk->touchdown_ft
                       ? risk->touchdown_ft
                       : p->wheel_ft;
    float from_ft = wheel_ft + risk->hardest_braking_distance_ft,
          to_ft = wheel_ft + risk->stopping_distance_ft;
    risk->scan_group = chain->mats_per_group;
    risk->is_scanning = from_ft >= 0.0f && from_ft < end_ft && to_ft >= from_ft;
    if (!risk->is_scanning) {
        risk->planned_mats = 0;
        return;
    }
    to_ft = to_ft < end_ft ? to_ft : end_ft;
    mr_zonescan_begin(
        &risk->scan, chain,
        &(struct mr_zonescan_range){
            .search_start_joint = (uint16_t)(chain->group_count + 2u),
            .position = (uint16_t)((unsigned)(from_ft / group_ft) + 1u),
            .last_position = (uint16_t)((unsigned)(to_ft / group_ft) + 1u),
            .push_lb = p->config.thrust_lb_per_g * risk->hardest_braking_ft_s2 / G_FT_S2,
            .grit_lb = chain->mats_per_group > 1u ? p->closing_lb : chain->grit_lb});
}

static void continue_scan(struct mr_risk_state *risk, const struct mr_predictor *p)
{
    if (!is_following_plan(risk) || p->level == MR_PREDICTOR_KINEMATIC) {
        risk->is_scanning = false;
        risk->planned_mats = 0;
        return;
    }
    if (!risk->is_scanning || risk->scan_group != p->chain.mats_per_group) {
        predict_braking(risk, p);
        begin_scan(risk, p);
    }
    if (!risk->is_scanning ||
        !mr_zonescan_continue(&risk->scan, &p->chain, MR_RISK_VISITS_PER_BLOCK))
        return;
    risk->planned_mats = risk->scan.result.future_groups * risk->scan_group;
    risk->is_scanning = false;
}

/* --- a landing --- */

void mr_risk_arm(struct mr_risk_state *risk, const struct mr_risk_plan *plan,
                 const struct mr_predictor *p, float touchdown_ft)
{
    *risk = (struct mr_risk_state){
        .touchdown_ft = touchdown_ft, .speed_loss_ratio = 1.0f, .touchdown_ft_s = MR_NAN};
    mr_risk_plan_clear(&risk->plan);
    if (!plan)
        return;
    risk->plan = *plan;
    risk->has_plan = true;
    predict_planned_braking(risk, plan->speed_ft_s);
    risk->planned_mean_deceleration_ft_s2 = 0.5f * plan->speed_ft_s * plan->speed_ft_s /
                                            risk->stopping_distance_ft;
    bool has_chart = count_chart_rows(plan) > 0;
    risk->has_chart = has_chart && plan->landing_count == (float)p->landing_count;
    risk->is_chart_stale = has_chart && !risk->has_chart;
}

/* Compares the measured speed loss with the planned one. */
static void compare_with_plan(struct mr_risk_state *risk, float speed_ft_s)
{
    risk->planned_speed_loss_ft_s += BLOCK_S *
                                     get_planned_deceleration_ft_s2(risk, risk->since_touchdown_s);
    bool off = risk->touchdown_ft_s > (1.0f + SPEED_TOLERANCE) * risk->plan.speed_ft_s ||
               risk->touchdown_ft_s < (1.0f - SPEED_TOLERANCE) * risk->plan.speed_ft_s;
    if (risk->planned_speed_loss_ft_s > COMPARED_LOSS_MIN_FT_S && speed_ft_s > 0.0f) {
        float met = (risk->touchdown_ft_s - speed_ft_s) / risk->planned_speed_loss_ft_s;
        off = off || !is_between(met, PLAN_RATIO_MIN, PLAN_RATIO_MAX);
        risk->speed_loss_ratio = met < PLAN_RATIO_MIN ? PLAN_RATIO_MIN
                               : met > PLAN_RATIO_MAX ? PLAN_RATIO_MAX
                                                      : met;
    }
    risk->deviating_blocks = (uint16_t)(off ? risk->deviating_blocks + 1u : 0u);
    risk->has_deviated_from_plan = risk->has_deviated_from_plan ||
                                   risk->deviating_blocks >= DEVIATION_MAX_BLOCKS;
}

void mr_risk_on_block(struct mr_risk_state *risk, const struct mr_predictor *p,
                      const struct mr_predictor_input *input)
{
    if (input->is_on_runway && p->speed_ft_s > 0.0f && !risk->has_touched_down) {
        risk->has_touched_down = true;
        risk->touchdown_ft_s = p->speed_ft_s;
    }
    if (risk->has_touched_down && is_following_plan(risk))
        compare_with_plan(risk, p->speed_ft_s);
    if (risk->has_touched_down)
        risk->since_touchdown_s += BLOCK_S;
    continue_scan(risk, p);
}

/* --- result --- */

float mr_risk_logistic(float x)
{
    /* e^y = 2^n 2^f with f in -0.5 .. 0.5; Taylor series up to the seventh power */
    float y = (x > 30.0f ? 30.0f : x < -30.0f ? -30.0f : x) * -1.44269504f;
    int n = (int)(y < 0.0f ? y - 0.5f : y + 0.5f);
    float z = (y - (float)n) * 0.69314718f;
    float e = 1.0f +
              z * (1.0f + z * (0.5f + z * (1.0f / 6.0f +
                                           z * (1.0f / 24.0f + z * (1.0f / 120.0f +
                                                                    z * (1.0f / 720.0f +
                                                                         z * (1.0f / 5040.0f)))))));
    for (; n > 0; n--)
        e *= 2.0f;
    for (; n < 0; n++)
        e *= 0.5f;
    return 1.0f / (1.0f + e);
}

static float compute_zone_ratio(unsigned mats)
{
    float x = (float)mats / ZONE_MATS;
    return x < ZONE_RATIO_MAX ? x : ZONE_RATIO_MAX;
}

/* Returns by how much a zone exceeds EXCESS_START_MATS, scaled to 0..1. */
static float compute_excess_share(unsigned mats)
{
    float x = ((float)mats - EXCESS_START_MATS) / EXCESS_RANGE_MATS;
    return x < 0.0f ? 0.0f : x > 1.0f ? 1.0f : x;
}

static float compute_zone_share(unsigned mats)
{
    float x = (float)mats / ZONE_MATS;
    return x < 1.0f ? x : 1.0f;
}

/* Returns the mean opening, in inches, of the joints between the wheel and its predicted stop.
 * Segments with unknown gaps do not count. */
static float compute_mean_opening_in(const struct mr_risk_state *risk, float wheel_ft,
                                     const float *left_in)
{
    float sum_in = 0.0f;
    unsigned joints = 0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float from_ft = MR_SEGMENT_LENGTH_FT * (float)s, to_ft = from_ft + MR_SEGMENT_LENGTH_FT;
        if (to_ft <= wheel_ft || from_ft >= wheel_ft + risk->stopping_distance_ft ||
            __builtin_isnan(left_in[s]))
            continue;
        sum_in += left_in[s];
        joints += MR_MATS_PER_SEGMENT;
    }
    return joints ? sum_in / (float)joints : 0.0f;
}

/* Sets the times at which the wheel reaches the predicted zone and the middle of the range 10 to 15
 * mats inside it. */
static void set_zone_times(const struct mr_predictor *p, const struct mr_predictor_zone *zone,
                           struct mr_risk_report *report)
{
    float start_ft = zone->mats >= MR_PREDICTOR_WARNING_MATS     ? zone->start_ft
                   : zone->future_mats >= EXPECTED_ZONE_MIN_MATS ? zone->future_wheel_ft
                                                                 : MR_NAN;
    report->start_s = report->failure_s = report->failure_ft = MR_NAN;
    if (__builtin_isnan(start_ft) || !(p->speed_ft_s > 0.0f) || __builtin_isnan(p->wheel_ft))
        return;
    float ahead_ft = start_ft - p->wheel_ft;
    report->failure_ft = start_ft + MR_RISK_FAILURE_MATS * p->config.chain.mat_length_ft;
    report->start_s = mr_closure_compute_lead_s(ahead_ft > 0.0f ? ahead_ft : 0.0f, p->speed_ft_s,
                                                p->deceleration_ft_s2);
    report->failure_s = mr_closure_compute_lead_s(report->failure_ft - p->wheel_ft, p->speed_ft_s,
                                                  p->deceleration_ft_s2);
}

static unsigned find_risk_basis(const struct mr_risk_state *risk, const struct mr_predictor *p,
                                const struct mr_predictor_zone *zone)
{
    unsigned basis = is_following_plan(risk) ? MR_RISK_PLAN_USED : 0u;
    basis |= is_following_plan(risk) && risk->has_chart ? MR_RISK_CHART_USED : 0u;
    basis |= risk->has_deviated_from_plan ? MR_RISK_PLAN_NOT_FOLLOWED : 0u;
    basis |= risk->is_chart_stale ? MR_RISK_CHART_OUTDATED : 0u;
    basis |= zone->basis & MR_PREDICTOR_NO_TRANSDUCER ? MR_RISK_NO_TRANSDUCER : 0u;
    basis |= __builtin_isnan(p->wheel_ft) || __builtin_isnan(p->speed_ft_s) ? MR_RISK_NO_MOTION
                                                                            : 0u;
    basis |= p->is_braking_known ? MR_RISK_BRAKING_KNOWN : 0u;
    return basis;
}

static enum mr_risk_reason find_risk_reason(const struct mr_risk_state *risk,
                                            const struct mr_predictor_zone *zone,
                                            const struct mr_risk_report *report)
{
    if (__builtin_isnan(report->risk))
        return MR_RISK_UNKNOWN;
    if (report->basis & MR_RISK_STOPPED)
        return MR_RISK_REASON_NONE;
    if (zone->mats >= MR_PREDICTOR_WARNING_MATS)
        return MR_RISK_ZONE_AHEAD;
    if (zone->future_mats >= MR_PREDICTOR_WARNING_MATS)
        return MR_RISK_ZONE_EXPECTED;
    if (risk->planned_mats >= MR_PREDICTOR_WARNING_MATS)
        return MR_RISK_ZONE_PLANNED;
    return report->basis & MR_RISK_CHART_USED && report->input[MR_RISK_CHART] > 0.0f
             ? MR_RISK_ZONE_PROBABLE
             : MR_RISK_REASON_NONE;
}

/* Without a chart, returns whether the plan is used. It is used before braking, and during braking
 * only if it contains much harder braking; otherwise the measured deceleration is the better
 * input. */
static bool is_plan_used(const struct mr_risk_state *risk, const struct mr_predictor *p)
{
    return is_following_plan(risk) &&
           (risk->has_chart || !p->is_braking_known ||
            risk->hardest_braking_ft_s2 > MUCH_HARDER_BRAKING_RATIO * p->deceleration_ft_s2);
}

static void set_risk_inputs(struct mr_risk_state *risk, const struct mr_predictor *p,
                            const struct mr_predictor_zone *zone, bool by_plan,
                            struct mr_risk_report *report)
{
    struct mr_closure_zone closed;
    float left_in[MR_SEGMENTS], *x = report->input;
    bool blind = report->basis & MR_RISK_NO_TRANSDUCER;
    float wheel_ft = __builtin_isnan(p->wheel_ft) || p->wheel_ft < risk->touchdown_ft
                       ? risk->touchdown_ft
                       : p->wheel_ft;
    predict_braking(risk, p);
    bool planned = by_plan && is_plan_used(risk, p),
         charted = by_plan && report->basis & MR_RISK_CHART_USED;
    if (!planned)
        predict_present_braking(risk, p);
    mr_predictor_find_kinematic_zone(p, &closed, left_in);
    x[MR_RISK_CONSTANT] = 1.0f;
    x[MR_RISK_FUTURE] = compute_zone_share(zone->future_mats);
    x[MR_RISK_KINEMATIC] = blind ? 0.0f : compute_zone_ratio(closed.mats);
    x[MR_RISK_EXCESS] = compute_excess_share(zone->future_mats);
    x[MR_RISK_BRAKING] =
        (risk->hardest_braking_ft_s2 < 20.0f ? risk->hardest_braking_ft_s2 : 20.0f) / 6.0f;
    float still = 1.0f - (planned ? compute_excess_share(risk->planned_mats) : x[MR_RISK_EXCESS]);
    x[MR_RISK_DISTANCE] =
        still * (risk->stopping_distance_ft < 150.0f ? risk->stopping_distance_ft : 150.0f) / 50.0f;
    x[MR_RISK_FRICTION] = p->config.chain.friction_lb / p->config.mat_weight_lb / 0.6f;
    x[MR_RISK_LANDINGS] =
        ((float)p->landing_count < LANDINGS_MAX ? (float)p->landing_count : LANDINGS_MAX) / 3.0f;
    x[MR_RISK_OPENING] = compute_mean_opening_in(risk, wheel_ft, left_in) / 0.015f;
    x[MR_RISK_PLANNED] = planned ? 0.5f * (compute_zone_share(risk->planned_mats) +
                                           compute_excess_share(risk->planned_mats))
                                 : 0.0f;
    x[MR_RISK_CHART] = 0.0f;
    if (charted) {
        x[MR_RISK_CHART] =
            interpolate(risk->plan.chart_deceleration_ft_s2, risk->plan.chart_log_odds,
                        count_chart_rows(&risk->plan),
                        risk->planned_mean_deceleration_ft_s2 * risk->speed_loss_ratio);
    }
    report->weight_set = (charted   ? MR_RISK_WEIGHTS_CHART
                          : planned ? MR_RISK_WEIGHTS_PLAN
                                    : MR_RISK_WEIGHTS_NO_PLAN) +
                         (report->basis & MR_RISK_BRAKING_KNOWN ? MR_RISK_WEIGHTS_IF_BRAKING : 0u) +
                         (blind ? MR_RISK_WEIGHTS_IF_NO_SENSOR : 0u);
}

static float compute_risk(const struct mr_risk_report *report)
{
    float sum = 0.0f;
    for (unsigned i = 0; i < MR_RISK_INPUT_COUNT; i++)
        sum += risk_weights[report->weight_set][i] * report->input[i];
    return mr_risk_logistic(sum);
}

void mr_risk_compute(struct mr_risk_state *risk, const struct mr_predictor *p,
                     const struct mr_predictor_zone *zone, struct mr_risk_report *report)
{
    *report = (struct mr_risk_report){.risk = MR_NAN, .basis = find_risk_basis(risk, p, zone)};
    set_zone_times(p, zone, report);
    bool moves = !(report->basis & MR_RISK_NO_MOTION);
    /* without switches the motion, which the rule needs, is not known */
    if ((moves || report->basis & MR_RISK_PLAN_USED) && !(p->moved_mask && !moves)) {
        set_risk_inputs(risk, p, zone, true, report);
        report->risk = compute_risk(report);
        /* a plan must not reduce the risk of a measured zone */
        if (zone->mats >= MR_PREDICTOR_WARNING_MATS && report->start_s >= 0.0f &&
            report->weight_set >= MR_RISK_WEIGHTS_PLAN) {
            struct mr_risk_report without = *report;
            set_risk_inputs(risk, p, zone, false, &without);
            without.risk = compute_risk(&without);
            if (without.risk > report->risk)
                *report = without;
        }
    }
    if (moves && risk->has_touched_down && p->speed_ft_s < SLOW_MAX_FT_S) {
        report->basis |= MR_RISK_STOPPED;
        report->risk = 0.0f;
    }
    report->reason = find_risk_reason(risk, zone, report);
}

float mr_risk_lamp_limit(float cost_ratio)
{
    return 1.0f / (1.0f + cost_ratio);
}

bool mr_risk_is_lamp_on(float limit, const struct mr_predictor_zone *zone,
                        const struct mr_risk_report *report)
{
    if (__builtin_isnan(limit) || __builtin_isnan(report->risk))
        return zone->verdict == MR_PREDICTOR_WARNING;
    return report->risk >= limit;
}
