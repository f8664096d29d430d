#include "host/advise/advise.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/statistics.h"
#include "host/base/xmalloc.h"

/* Standard error of the touchdown speed, as a fraction of the planned speed */
#define SPEED_ERROR_FRACTION         0.01
#define TOUCHDOWN_ERROR_FT           0.5 /* standard error of the touchdown station */
/* A planned value outside the range of earlier landings by more than this fraction of the range
 * widens the ensemble. */
#define OUTSIDE_RANGE_FRACTION       0.15
#define OUTSIDE_RANGE_SPREAD_FACTOR  1.5
#define EVENLY_SPACED_ROWS           (ADVISE_ROW_COUNT - 1u)
/* Deceleration of the last row: the larger of two products, this ratio times the least braking that
 * stops on the runway, and the next ratio times the planned braking. */
#define MAX_TO_LEAST_BRAKING_RATIO   2.2
#define MAX_TO_PLANNED_BRAKING_RATIO 1.3
#define MAX_BRAKING_TEXT_SIZE        160
#define ZONE_TEXT_SIZE               80
#define ROLL_OFF_TEXT_SIZE           80
#define MIN_SPEED_FRACTION           0.6 /* lowest evaluated touchdown speed / planned speed */
#define MAX_SPEED_FRACTION           1.3 /* highest evaluated touchdown speed / planned speed */
/* Resolution of the speed limit, as a fraction of the planned speed. */
#define SPEED_RESOLUTION_FRACTION    0.04

const char *advise_verdict_text(enum advise_verdict verdict)
{
    static const char *const texts[] = {"clear", "caution", "against"};
    return texts[verdict];
}

/* ---- update of the ensemble from earlier landings ---- */

static const struct history_landing *find_last_measured(const struct history *history)
{
    for (size_t i = history->landing_count; i-- > 0;) {
        if (history->landing[i].is_measured)
            return &history->landing[i];
    }
    return NULL;
}

/* Applies the repairs that were made after RUN `from` and before RUN `to`: new joints are drawn for
 * the repaired mats. */
static void redraw_repaired_joints(struct advise *advise, int64_t from, int64_t to)
{
    const struct history *history = &advise->history;
    const double mat_ft = (double)history->runway.chain.mat_length_ft,
                 end = history->runway.chain.mats;
    for (size_t i = 0; i < history->inspections.count; i++) {
        const struct inspection *entry = &history->inspections.entry[i];
        const char *how = json_string_value(json_object_get(entry->values, "repair")),
                   *what = json_string_value(json_object_get(entry->values, "what"));
        double first = inspection_get_number(entry->values, "station_ft").value / mat_ft,
               mats = fmax(inspection_get_number(entry->values, "length_ft").value / mat_ft, 0.0),
               before = inspection_get_number(entry->values, "repaired").value;
        int64_t run = isnan(before) ? entry->row.run + 1 : (int64_t)before;
        if (!inspection_is_valid(entry, NULL, 0) || !how || !(first <= end) || run <= from ||
            run > to || (strcmp(how, "replaced") != 0 && strcmp(how, "relaid") != 0) ||
            /* these repairs leave the joints unchanged */
            (what && strstr("band|rivet|stiffener|membrane", what)))
            continue;
        advise_redraw_joints(&advise->members, (unsigned)lround(first),
                             (unsigned)lround(fmin(first + mats, end)));
        advise->repair_count++;
    }
}

static enum mr_status update_ensemble(struct advise *advise, struct error *error)
{
    const struct history *history = &advise->history;
    for (size_t i = 0; i < history->landing_count; i++) {
        const struct history_landing *landing = &history->landing[i];
        progress_set(advise->progress, "%zu of %zu landings processed", i, history->landing_count);
        if (landing->is_relaid)
            advise_redraw_all_joints(&advise->members);
        redraw_repaired_joints(advise, i ? landing[-1].run : 0, landing->run);
        if (!landing->is_measured) {
            advise->skipped_landing_count++;
            continue;
        }
        if (!advise_update(&advise->members, &landing->observation))
            return error_set(error, MR_NUMERICS,
                             "cannot update the model from RUN %lld: a simulation of the ensemble "
                             "diverged; check the readings of that landing, or void the landing",
                             (long long)landing->run);
    }
    if (history->is_relaid_since_landing)
        advise_redraw_all_joints(&advise->members);
    redraw_repaired_joints(
        advise, history->landing_count ? history->landing[history->landing_count - 1].run : 0,
        advise->request.before_run ? advise->request.before_run : history->newest_run + 1);
    advise_apply_survey(&advise->members, history->segment_sum_in, history->survey_error_in);
    return MR_OK;
}

/* ---- plan ---- */

static bool is_outside_range(double value, double low, double high)
{
    return value > high * (1.0 + OUTSIDE_RANGE_FRACTION) ||
           value < low * (1.0 - OUTSIDE_RANGE_FRACTION);
}

static void detect_plan_outside_range(struct advise *advise)
{
    const struct history *history = &advise->history;
    double braking[2] = {(double)INFINITY, 0.0}, speed[2] = {(double)INFINITY, 0.0};
    for (size_t i = 0; i < history->landing_count; i++) {
        const struct advise_braking *was = &history->landing[i].observation.braking;
        if (!history->landing[i].is_measured)
            continue;
        braking[0] = fmin(braking[0], was->mean_braking_ft_s2);
        braking[1] = fmax(braking[1], was->mean_braking_ft_s2);
        speed[0] = fmin(speed[0], was->speed_ft_s);
        speed[1] = fmax(speed[1], was->speed_ft_s);
    }
    advise->is_plan_outside_range =
        advise->members.update_count &&
        (is_outside_range(advise->plan.mean_braking_ft_s2, braking[0], braking[1]) ||
         is_outside_range(advise->plan.speed_ft_s, speed[0], speed[1]));
}

static void set_plan_deviation(struct advise *advise)
{
    const struct history *history = &advise->history;
    double *log_ratio = xcalloc(history->landing_count + 1, sizeof *log_ratio);
    size_t count = 0;
    for (size_t i = 0; i < history->landing_count; i++) {
        const struct history_landing *landing = &history->landing[i];
        if (landing->is_measured && landing->planned_deceleration_ft_s2 > 0.0)
            log_ratio[count++] = log(landing->observation.braking.mean_braking_ft_s2 /
                                     landing->planned_deceleration_ft_s2);
    }
    advise->planned_landing_count = (unsigned)count;
    advise_predict_plan_deviation(log_ratio, count, &advise->plan.braking_log_bias,
                                  &advise->plan.braking_spread);
    free(log_ratio);
}

/* Returns the mean deceleration, v^2 / (2 s) for the stopping distance s; NaN if the gear does not
 * stop. */
static double compute_mean_deceleration_ft_s2(const struct advise_profile *profile,
                                              double speed_ft_s)
{
    const double step_s = 1e-3;
    double v = speed_ft_s, stopping_distance_ft = 0.0, t_s = 0.0;
    for (; v > 0.0 && t_s < 600.0; t_s += step_s) {
        stopping_distance_ft += v * step_s;
        v -= advise_braking_factor(profile, t_s) * step_s;
    }
    return v > 0.0 ? (double)NAN : speed_ft_s * speed_ft_s / (2.0 * stopping_distance_ft);
}

static enum mr_status make_plan(struct advise *advise, struct error *error)
{
    const struct advise_request *request = &advise->request;
    const struct history_landing *last = find_last_measured(&advise->history);
    double length_ft = (double)advise->history.runway.chain.mat_length_ft *
                       advise->history.runway.chain.mats;
    advise->plan = (struct advise_plan){.speed_ft_s = request->speed_ft_s,
                                        .speed_spread = SPEED_ERROR_FRACTION,
                                        .mean_braking_ft_s2 = request->deceleration_ft_s2,
                                        .touchdown_ft = request->touchdown_ft,
                                        .touchdown_spread_ft = TOUCHDOWN_ERROR_FT,
                                        .profile = request->profile,
                                        .seed = (uint64_t)request->seed};
    struct advise_plan *plan = &advise->plan;
    if (isnan(plan->touchdown_ft))
        plan->touchdown_ft = isfinite(advise->history.touchdown_ft) ? advise->history.touchdown_ft
                                                                    : 0.0;
    if (plan->touchdown_ft >= length_ft)
        return error_set(error, MR_USAGE,
                         "touchdown station beyond the runway: %.1f ft; the mats end at %.1f ft, "
                         "give a smaller --station",
                         plan->touchdown_ft, length_ft);
    advise->is_based_on_previous_landing =
        isnan(plan->speed_ft_s) || (isnan(plan->mean_braking_ft_s2) && !plan->profile.point_count);
    if (advise->is_based_on_previous_landing && !last)
        return error_set(error, MR_USAGE,
                         "no plan: the campaign has no earlier landing with a speed and a "
                         "deceleration; give --speed and --deceleration");
    if (isnan(plan->speed_ft_s))
        plan->speed_ft_s = last->observation.braking.speed_ft_s;
    if (plan->profile.point_count) {
        plan->mean_braking_ft_s2 = compute_mean_deceleration_ft_s2(&plan->profile,
                                                                   plan->speed_ft_s);
        if (isnan(plan->mean_braking_ft_s2))
            return error_set(error, MR_USAGE,
                             "no stop: with this --profile the gear still rolls after 10 min; give "
                             "higher decelerations");
        for (size_t i = 0; i < plan->profile.point_count; i++)
            plan->profile.factor[i] /= plan->mean_braking_ft_s2;
    } else if (isnan(plan->mean_braking_ft_s2))
        plan->mean_braking_ft_s2 = last->observation.braking.mean_braking_ft_s2;
    set_plan_deviation(advise);
    return MR_OK;
}

/* ---- rows ---- */

/* Chooses the decelerations of the rows: equal steps that begin at the least braking that stops on
 * the runway (rounded to a tenth), and the planned deceleration. */
static void choose_row_decelerations(struct advise *advise, double mean_ft_s2[ADVISE_ROW_COUNT])
{
    double low = ceil(10.0 * advise->min_braking_ft_s2) / 10.0,
           high = fmax(MAX_TO_LEAST_BRAKING_RATIO * advise->min_braking_ft_s2,
                       MAX_TO_PLANNED_BRAKING_RATIO * advise->plan.mean_braking_ft_s2);
    for (unsigned i = 0; i < EVENLY_SPACED_ROWS; i++)
        mean_ft_s2[i] = round(10.0 * (low + (high - low) * i / (EVENLY_SPACED_ROWS - 1u))) / 10.0;
    mean_ft_s2[EVENLY_SPACED_ROWS] = advise->plan.mean_braking_ft_s2;
    sort_numbers(mean_ft_s2, ADVISE_ROW_COUNT);
    for (unsigned i = 0; i < ADVISE_ROW_COUNT; i++) {
        if (fabs(mean_ft_s2[i] - advise->plan.mean_braking_ft_s2) < 1e-9)
            advise->plan_row = i;
    }
}

/* Returns the fraction of simulated runways (members) on which the aircraft rolls off the end at
 * this braking, interpolated between rows. */
static double interpolate_off_runway(const struct advise *advise, double mean_ft_s2)
{
    const struct advise_row *row = advise->row;
    size_t i = 1;
    while (i + 1 < advise->row_count && row[i].mean_braking_ft_s2 < mean_ft_s2)
        i++;
    double part = (mean_ft_s2 - row[i - 1].mean_braking_ft_s2) /
                  (row[i].mean_braking_ft_s2 - row[i - 1].mean_braking_ft_s2);
    return row[i - 1].off_runway_share +
           part * (row[i].off_runway_share - row[i - 1].off_runway_share);
}

/* Finds the hardest braking at which the probability of a zone is below the risk limit. Discards
 * the result if the aircraft may roll off the runway at that braking. */
static void find_max_braking(struct advise *advise)
{
    struct advise_row row[ADVISE_ROW_COUNT];
    double mean_ft_s2[ADVISE_ROW_COUNT], limit = advise->request.risk_limit;
    size_t first = 0, rows;
    while (first + 1 < advise->row_count &&
           advise->row[first].mean_braking_ft_s2 < advise->min_braking_ft_s2)
        first++;
    rows = advise->row_count - first;
    for (size_t i = 0; i < rows; i++) {
        row[i] = advise->row[first + i];
        row[i].off_runway_share = 0.0;
        mean_ft_s2[i] = row[i].mean_braking_ft_s2;
    }
    advise->max_braking = advise_find_limit_crossing(mean_ft_s2, row, rows, limit);
    if (isfinite(advise->max_braking.value) &&
        interpolate_off_runway(advise, advise->max_braking.value) >= limit)
        advise->max_braking.value = (double)NAN;
    advise->stop_short_braking_ft_s2 = advise_find_stop_short_ft_s2(row, rows, limit);
}

/* Finds the highest touchdown speed at the planned braking by bisection: below the planned speed,
 * or above it if the plan is within the risk limit. Returns false if memory is insufficient. */
static bool refine_max_speed(struct advise *advise, struct advise_braking *braking,
                             struct advise_outcome *outcome)
{
    struct advise_row row[ADVISE_SPEEDS_MAX] = {advise->row[advise->plan_row]};
    double speed_ft_s[ADVISE_SPEEDS_MAX] = {advise->plan.speed_ft_s},
           planned_ft_s = advise->plan.speed_ft_s, limit = advise->request.risk_limit;
    bool below = row[0].zone_probability.probability < limit && row[0].off_runway_share < limit;
    struct advise_plan plan = advise->plan;
    size_t rows = 1;
    advise->min_speed_ft_s = MIN_SPEED_FRACTION * planned_ft_s;
    for (size_t at = below ? 1 : 0; rows < ADVISE_SPEEDS_MAX; rows++) {
        double tried_ft_s = rows > 1 ? (speed_ft_s[at - 1] + speed_ft_s[at]) / 2.0
                          : below    ? MAX_SPEED_FRACTION * planned_ft_s
                                     : advise->min_speed_ft_s;
        progress_set(advise->progress, "simulating touchdown at %.1f ft/s", tried_ft_s);
        memmove(row + at + 1, row + at, (rows - at) * sizeof *row);
        memmove(speed_ft_s + at + 1, speed_ft_s + at, (rows - at) * sizeof *speed_ft_s);
        plan.speed_ft_s = speed_ft_s[at] = tried_ft_s;
        if (!advise_compute_row(&advise->members, &plan, plan.mean_braking_ft_s2, braking, outcome,
                                &row[at]))
            return false;
        at = advise_find_wide_row_step(speed_ft_s, row, rows + 1, limit,
                                       SPEED_RESOLUTION_FRACTION * planned_ft_s) +
             1;
        if (at > rows + 1) {
            rows++;
            break;
        }
    }
    advise->max_speed = advise_find_limit_crossing(speed_ft_s, row, rows, limit);
    return true;
}

static enum mr_status compute_advice_rows(struct advise *advise, struct error *error)
{
    struct advise_members *members = &advise->members;
    struct advise_braking *braking = xcalloc(members->member_count, sizeof *braking);
    struct advise_outcome *outcome = xcalloc(members->member_count, sizeof *outcome);
    double mean_ft_s2[ADVISE_ROW_COUNT];
    bool good = true;
    advise->min_braking_ft_s2 = advise_compute_min_braking_ft_s2(members, &advise->plan);
    choose_row_decelerations(advise, mean_ft_s2);
    for (size_t i = 0; good && i < ADVISE_ROW_COUNT; i++) {
        progress_set(advise->progress, "%zu of %u decelerations simulated", i, ADVISE_ROW_COUNT);
        good = advise_compute_row(members, &advise->plan, mean_ft_s2[i], braking, outcome,
                                  &advise->row[i]);
        advise->row_count++;
    }
    if (good) {
        find_max_braking(advise);
        good = refine_max_speed(advise, braking, outcome);
    }
    free(braking);
    free(outcome);
    if (!good)
        return error_set(error, MR_FULL,
                         "too little memory for an ensemble of %zu runways; give a smaller number "
                         "with --members",
                         members->member_count);
    return MR_OK;
}

/* ---- verdict ---- */

static void format_max_braking(const struct advise *advise, bool si,
                               char out[MAX_BRAKING_TEXT_SIZE])
{
    char value[UNIT_TEXT_SIZE], from[UNIT_TEXT_SIZE];
    unit_value_text(UNIT_DECELERATION, si, advise->max_braking.value, 1, value);
    unit_value_text(UNIT_DECELERATION, si, advise->stop_short_braking_ft_s2, 1, from);
    if (isfinite(advise->max_braking.value))
        snprintf(out, MAX_BRAKING_TEXT_SIZE, "the probability stays below the limit %s to %s",
                 advise->max_braking.is_unbounded ? "at least up" : "up", value);
    else if (isfinite(advise->stop_short_braking_ft_s2))
        snprintf(out, MAX_BRAKING_TEXT_SIZE,
                 "the probability is below the limit only at a deceleration of %s or more, which "
                 "stops the gear before the closed mats",
                 from);
    else
        snprintf(out, MAX_BRAKING_TEXT_SIZE,
                 "at every deceleration, the risk of a zone or of rolling off the end exceeds the "
                 "limit");
}

/* Writes "a zone of 50 mats has a probability of 7 % (95 %: 7 to 23)". */
static void format_zone_probability(const struct advise_row *row, char out[ZONE_TEXT_SIZE])
{
    snprintf(out, ZONE_TEXT_SIZE,
             "a zone of %u mats has a probability of %.0f %% (95 %%: %.0f to %.0f)",
             ADVISE_ZONE_MATS, 100.0 * row->zone_probability.probability,
             100.0 * row->zone_probability.low, 100.0 * row->zone_probability.high);
}

/* Writes "; 8 % of the simulated landings roll off the runway's end", or "" if the share is below
 * 0.5 %. */
static void format_roll_off_share(const struct advise_row *row, char out[ROLL_OFF_TEXT_SIZE])
{
    out[0] = '\0';
    if (row->off_runway_share >= 0.005)
        snprintf(out, ROLL_OFF_TEXT_SIZE,
                 "; %.0f %% of the simulated landings roll off the runway's end",
                 100.0 * row->off_runway_share);
}

/* Returns the lowest deceleration above which the share of simulated landings that roll off stays
 * below the limit; NaN if there is none. */
static double get_min_braking_ft_s2(const struct advise *advise)
{
    const struct advise_row *row = advise->row;
    size_t i = advise->row_count;
    while (i > 0 && row[i - 1].off_runway_share < advise->request.risk_limit)
        i--;
    if (i == 0 || i == advise->row_count)
        return (double)NAN;
    return row[i - 1].mean_braking_ft_s2 +
           (row[i].mean_braking_ft_s2 - row[i - 1].mean_braking_ft_s2) *
               (row[i - 1].off_runway_share - advise->request.risk_limit) /
               (row[i - 1].off_runway_share - row[i].off_runway_share);
}

static void set_verdict(struct advise *advise, bool si)
{
    const struct advise_row *row = &advise->row[advise->plan_row];
    const double limit = advise->request.risk_limit;
    char braking[UNIT_TEXT_SIZE], hardest[MAX_BRAKING_TEXT_SIZE], zone[ZONE_TEXT_SIZE],
        roll_off[ROLL_OFF_TEXT_SIZE];
    const char *lacks = !advise->members.update_count
                          ? "the model has not been updated from any landing"
                      : advise->is_plan_outside_range
                          ? "no earlier landing was similar to this plan"
                      : advise->history.surveyed_segment_count < advise->history.segment_count / 2u
                          ? "the mat has not been surveyed since the last landing"
                          : NULL;
    unit_value_text(UNIT_DECELERATION, si, row->mean_braking_ft_s2, 1, braking);
    format_max_braking(advise, si, hardest);
    format_zone_probability(row, zone);
    format_roll_off_share(row, roll_off);
    bool off = row->off_runway_share > limit;
    advise->verdict = off || row->zone_probability.low >= limit    ? ADVISE_AGAINST
                    : row->zone_probability.high < limit && !lacks ? ADVISE_CLEAR
                                                                   : ADVISE_CAUTION;
    if (off)
        snprintf(advise->reason, sizeof advise->reason, "at %s, %s; %s", braking, roll_off + 2,
                 zone);
    else if (row->zone_probability.high < limit)
        snprintf(advise->reason, sizeof advise->reason,
                 "at %s %s, below the limit of %.0f %%%s%s%s", braking, zone, 100.0 * limit,
                 roll_off, lacks ? ", but " : "", lacks ? lacks : "");
    else
        snprintf(advise->reason, sizeof advise->reason, "at %s %s, %s the limit of %.0f %%%s; %s",
                 braking, zone,
                 row->zone_probability.low >= limit ? "above" : "not significantly different from",
                 100.0 * limit, roll_off, hardest);
}

/* Writes a limit and its interval: "with at most 6.9 ft/s2 (6.5 to 7.2)". Omits an end of the
 * interval that is outside the rows. */
static void format_bound(const struct advise_limit_crossing *reach, enum unit_kind unit, bool si,
                         char out[3 * UNIT_TEXT_SIZE])
{
    char at[UNIT_TEXT_SIZE], interval[UNIT_TEXT_SIZE] = "";
    const int decimals = unit_decimals(unit, si, 1);
    double low = reach->low * unit_get(unit, si)->factor,
           high = reach->high * unit_get(unit, si)->factor;
    unit_value_text(unit, si, reach->value, 1, at);
    if (isfinite(low) && isfinite(high))
        snprintf(interval, sizeof interval, " (95 %%: %.*f to %.*f)", decimals, low, decimals,
                 high);
    else if (isfinite(low))
        snprintf(interval, sizeof interval, " (95 %%: %.*f or more)", decimals, low);
    else if (isfinite(high))
        snprintf(interval, sizeof interval, " (95 %%: %.*f or less)", decimals, high);
    if (reach->is_unbounded)
        snprintf(out, 3 * UNIT_TEXT_SIZE, "with up to %s (the largest value tried)", at);
    else
        snprintf(out, 3 * UNIT_TEXT_SIZE, "with at most %s%s", at, interval);
}

/* Returns the subject of the sentence that explains why no braking can be recommended. Braking that
 * stops the gear before the closed mats is not recommended. */
static const char *get_no_braking_subject(const struct advise *advise)
{
    return isfinite(advise->stop_short_braking_ft_s2) ? "no gentler braking" : "no rate of braking";
}

/* Writes one sentence that recommends to the operator what to do. */
static void set_action_text(struct advise *advise, bool si)
{
    char speed[UNIT_TEXT_SIZE], slowest[UNIT_TEXT_SIZE], braking[UNIT_TEXT_SIZE],
        from[UNIT_TEXT_SIZE], least[UNIT_TEXT_SIZE], brake[3 * UNIT_TEXT_SIZE],
        land[3 * UNIT_TEXT_SIZE];
    const char *none = get_no_braking_subject(advise);
    const double percent = 100.0 * advise->request.risk_limit,
                 min_ft_s2 = get_min_braking_ft_s2(advise);
    unit_value_text(UNIT_DECELERATION, si, min_ft_s2, 1, least);
    unit_value_text(UNIT_SPEED, si, advise->plan.speed_ft_s, 1, speed);
    unit_value_text(UNIT_SPEED, si, advise->min_speed_ft_s, 1, slowest);
    unit_value_text(UNIT_DECELERATION, si, advise->plan.mean_braking_ft_s2, 1, braking);
    unit_value_text(UNIT_DECELERATION, si, advise->stop_short_braking_ft_s2, 1, from);
    format_bound(&advise->max_braking, UNIT_DECELERATION, si, brake);
    format_bound(&advise->max_speed, UNIT_SPEED, si, land);
    const size_t size = sizeof advise->action;
    if (isfinite(advise->max_braking.value) && isfinite(advise->max_speed.value))
        snprintf(
            advise->action, size,
            "To keep the risks of a zone and of rolling off the end below %.0f %%: brake %s after "
            "touchdown at %s, or touch down %s and brake at %s.",
            percent, brake, speed, land, braking);
    else if (isfinite(advise->max_braking.value))
        snprintf(
            advise->action, size,
            "To keep the risks of a zone and of rolling off the end below %.0f %%: brake %s after "
            "touchdown at %s. With braking at %s, every touchdown speed of %s or more exceeds "
            "the limit.",
            percent, brake, speed, braking, slowest);
    else if (isfinite(advise->max_speed.value))
        snprintf(
            advise->action, size,
            "To keep the risks of a zone and of rolling off the end below %.0f %%: touch down %s "
            "and brake at %s. After touchdown at %s, %s keeps them below the limit.",
            percent, land, braking, speed, none);
    else
        snprintf(advise->action, size,
                 "After touchdown at %s, %s keeps the risks of a zone and of rolling off the end "
                 "below %.0f %%. With braking at %s, every touchdown speed of %s or more exceeds "
                 "the limit.",
                 speed, none, percent, braking, slowest);
    size_t used = strlen(advise->action);
    if (isnan(advise->max_braking.value) && isfinite(advise->stop_short_braking_ft_s2))
        snprintf(advise->action + used, size - used,
                 " Braking at %s or harder stops the gear before the closed mats.", from);
    used = strlen(advise->action);
    if (isfinite(min_ft_s2))
        snprintf(advise->action + used, size - used,
                 " With braking below %s at %s, the gear rolls off the end in over %.0f %% of the "
                 "simulations.",
                 least, speed, percent);
}

enum mr_status advise_begin(struct store *store, const struct advise_request *request,
                            struct advise *advise, struct error *error)
{
    *advise = (struct advise){.request = *request};
    enum mr_status status = history_load(store, request->before_run, &advise->history, error);
    if (status == MR_OK && isfinite(request->thrust_share))
        advise->history.runway.thrust_share = request->thrust_share;
    return status ?: make_plan(advise, error);
}

enum mr_status advise_compute(struct advise *advise, bool si, struct progress *progress,
                              struct error *error)
{
    const struct advise_request *request = &advise->request;
    enum mr_status status = MR_OK;
    advise->progress = progress;
    if (advise_members_draw(&advise->members, &advise->history.runway, (size_t)request->members,
                            (uint64_t)request->seed) != MR_OK)
        status = error_set(error, MR_USAGE,
                           "no runway: the parameters of the board's predictor are inconsistent; "
                           "check them with matrig board config");
    if (status == MR_OK)
        status = update_ensemble(advise, error);
    if (status == MR_OK) {
        detect_plan_outside_range(advise);
        if (advise->is_plan_outside_range)
            advise_widen_spread(&advise->members, OUTSIDE_RANGE_SPREAD_FACTOR);
        status = compute_advice_rows(advise, error);
    }
    if (status == MR_OK) {
        set_verdict(advise, si);
        set_action_text(advise, si);
    }
    return status;
}

void advise_free(struct advise *advise)
{
    history_free(&advise->history);
    advise_members_free(&advise->members);
}

struct store_advice advise_to_stored_row(const struct advise *advise, int64_t made_us)
{
    const struct advise_row *row = &advise->row[advise->plan_row];
    struct store_advice kept = {
        .made_us = made_us,
        .speed_ft_s = advise->plan.speed_ft_s,
        .deceleration_ft_s2 = advise->plan.mean_braking_ft_s2,
        .touchdown_ft = advise->plan.touchdown_ft,
        .zone = row->zone_probability.probability,
        .zone_low = row->zone_probability.low,
        .zone_high = row->zone_probability.high,
        .most = advise->request.risk_limit,
        .hardest_ft_s2 = advise->max_braking.value,
        .members = (int64_t)advise->members.member_count,
        .seed = advise->request.seed,
        .landings = advise->members.update_count,
        .after_run = advise->history.newest_run,
    };
    snprintf(kept.verdict, sizeof kept.verdict, "%s", advise_verdict_text(advise->verdict));
    snprintf(kept.reason, sizeof kept.reason, "%s", advise->reason);
    return kept;
}

/* ---- answer ---- */

/* Adds a probability with its interval: "12 % (8 to 17)" in text, plain numbers in the JSON. */
static void add_probability(struct answer *answer, const char *name, const char *label,
                            const struct advise_probability *probability)
{
    char low[40], high[40];
    snprintf(low, sizeof low, "%s_low", name);
    snprintf(high, sizeof high, "%s_high", name);
    if (isfinite(probability->probability))
        answer_add_text(answer, NULL, label, "%.0f %% (%.0f to %.0f)",
                        100.0 * probability->probability, 100.0 * probability->low,
                        100.0 * probability->high);
    else
        answer_add_text(answer, NULL, label, "-");
    answer_add_value(answer, name, NULL, UNIT_NUMBER, probability->probability, 3);
    answer_add_value(answer, low, NULL, UNIT_NUMBER, probability->low, 3);
    answer_add_value(answer, high, NULL, UNIT_NUMBER, probability->high, 3);
}

static void add_row(const struct advise *advise, const struct advise_row *row,
                    struct answer *answer)
{
    bool si = answer_is_si(answer);
    const struct unit *station = unit_get(UNIT_STATION, si);
    double length_ft = (double)advise->history.runway.chain.mat_length_ft *
                       advise->history.runway.chain.mats;
    answer_open_row(answer);
    bool plan = row == &advise->row[advise->plan_row];
    answer_add_text(answer, NULL, "row", "%s", plan ? "plan" : "");
    answer_add_value(answer, "deceleration", "braking", UNIT_DECELERATION, row->mean_braking_ft_s2,
                     1);
    answer_add_flag(answer, "plan", NULL, plan);
    add_probability(answer, "zone", "zone (95 %)", &row->zone_probability);
    answer_open_list(answer, "by_station", NULL);
    for (unsigned s = 0; s < ADVISE_RUNWAY_PARTS; s++) {
        answer_open_row(answer);
        answer_add_value(answer, "station", NULL, UNIT_STATION,
                         length_ft * (s + 1u) / ADVISE_RUNWAY_PARTS, 1);
        answer_add_value(answer, "zone", NULL, UNIT_NUMBER,
                         row->zone_probability_by_part[s].probability, 3);
        answer_add_value(answer, "zone_low", NULL, UNIT_NUMBER,
                         row->zone_probability_by_part[s].low, 3);
        answer_add_value(answer, "zone_high", NULL, UNIT_NUMBER,
                         row->zone_probability_by_part[s].high, 3);
    }
    answer_close_group(answer);
    for (unsigned s = 1; s + 1u < ADVISE_RUNWAY_PARTS; s++) {
        char label[40];
        snprintf(label, sizeof label, "by|%.0f %s",
                 station->factor * length_ft * (s + 1u) / ADVISE_RUNWAY_PARTS, station->text);
        answer_add_text(answer, NULL, label, "%.0f %%",
                        100.0 * row->zone_probability_by_part[s].probability);
    }
    answer_add_value(answer, "half_station", "half of|zones by", UNIT_STATION,
                     row->median_zone_station_ft, 0);
    answer_add_text(answer, NULL, "rolls off|the end", "%.0f %%", 100.0 * row->off_runway_share);
    answer_add_value(answer, "off_runway", NULL, UNIT_NUMBER, row->off_runway_share, 3);
}

static void add_plan(const struct advise *advise, struct answer *answer)
{
    const struct advise_plan *plan = &advise->plan;
    answer_open_group(answer, "plan", "Plan");
    answer_add_value(answer, "speed", "speed", UNIT_SPEED, plan->speed_ft_s, 1);
    answer_add_value(answer, "touchdown", "touchdown", UNIT_STATION, plan->touchdown_ft, 1);
    answer_add_value(answer, "deceleration", "braking", UNIT_DECELERATION, plan->mean_braking_ft_s2,
                     2);
    if (advise->planned_landing_count)
        answer_add_text(answer, NULL, "followed",
                        "deceleration differs from the plan by %.0f %% rms, %+.0f %% on average, "
                        "in %u landings with a stored plan",
                        100.0 * plan->braking_spread, 100.0 * (exp(plan->braking_log_bias) - 1.0),
                        advise->planned_landing_count);
    else
        answer_add_text(answer, NULL, "followed",
                        "deceleration assumed to differ from the plan by %.0f %% rms, because no "
                        "landing has a stored plan (--keep)",
                        100.0 * plan->braking_spread);
    answer_add_value(answer, "spread", NULL, UNIT_NUMBER, plan->braking_spread, 3);
    answer_add_value(answer, "bias", NULL, UNIT_NUMBER, plan->braking_log_bias, 3);
    answer_add_count(answer, "plans_kept", NULL, advise->planned_landing_count);
    answer_add_value(answer, "least", "minimum to stop", UNIT_DECELERATION,
                     advise->min_braking_ft_s2, 2);
    answer_append_remark(answer, ", at the end of the runway");
    answer_add_flag(answer, "as_before", NULL, advise->is_based_on_previous_landing);
    answer_close_group(answer);
}

static void add_parameters(const struct advise *advise, struct answer *answer)
{
    static const struct {
        const char *name, *label;
        enum advise_unknown unknown;
        enum unit_kind unit;
        int decimals;
    } rows[] = {{"share", "thrust on the strip / (W/axles x a/g)", ADVISE_UNKNOWN_THRUST_SHARE,
                 UNIT_NUMBER, 2},
                {"friction", "friction of a mat", ADVISE_UNKNOWN_FRICTION, UNIT_TENSION, 3},
                {"resistance", "resistance of a joint", ADVISE_UNKNOWN_RESISTANCE, UNIT_TENSION, 1},
                {"stiffness", "stiffness of a joint", ADVISE_UNKNOWN_STIFFNESS, UNIT_STIFFNESS, 0}};
    answer_open_group(answer, "learned", "Estimates from the landings");
    answer_add_count(answer, "landings", "landings", advise->members.update_count);
    answer_add_count(answer, "not_learned", NULL, (int64_t)advise->skipped_landing_count);
    answer_add_count(answer, "voided", NULL, (int64_t)advise->history.voided_landing_count);
    answer_add_count(answer, "repairs", NULL, (int64_t)advise->repair_count);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        double mean, spread;
        advise_parameter_moments(&advise->members, rows[i].unknown, &mean, &spread);
        answer_add_estimate(answer, rows[i].name, rows[i].label, rows[i].unit, mean, mean * spread,
                            rows[i].decimals);
    }
    answer_close_group(answer);
}

/* Adds a note for everything that makes the advice less certain. */
static void add_notes(const struct advise *advise, struct answer *answer)
{
    const struct history *history = &advise->history;
    const bool surveyed = advise->members.is_surveyed;
    answer_add_text(answer, NULL, "note",
                    "because the model is not exact, the stated probability of a zone is %.0f %% "
                    "if no simulated runway reached a zone, and %.0f %% if all did",
                    100.0 * advise_calibrate_share(0.0, surveyed),
                    100.0 * advise_calibrate_share(1.0, surveyed));
    if (!advise->members.update_count)
        answer_add_text(answer, NULL, "note",
                        "the model has not been updated from any landing: it uses the initial "
                        "ranges of its parameters");
    if (advise->skipped_landing_count)
        answer_add_text(answer, NULL, "note",
                        "landings left out for lack of a measured stop: %zu; their effect on the "
                        "joints is unknown",
                        advise->skipped_landing_count);
    if (history->voided_landing_count)
        answer_add_text(answer, NULL, "note", "void landings left out of the model: %zu",
                        history->voided_landing_count);
    if (history->surveyed_segment_count < history->segment_count)
        answer_add_text(
            answer, NULL, "note",
            "%u of %u segments were surveyed since the last landing; the openings of the "
            "other segments are estimated from the simulated runways",
            history->surveyed_segment_count, history->segment_count);
    if (history->is_relaid_since_landing)
        answer_add_text(answer, NULL, "note",
                        "a series has begun since the last landing: the joints are assumed to have "
                        "the openings of a newly laid runway");
    if (advise->repair_count)
        answer_add_text(
            answer, NULL, "note",
            "%zu repair%s: the repaired joints are assumed to have the openings of newly laid mats",
            advise->repair_count, advise->repair_count == 1 ? "" : "s");
    if (advise->is_plan_outside_range)
        answer_add_text(answer, NULL, "note",
                        "the plan is outside the range of the earlier landings: the uncertainty of "
                        "the estimates is multiplied by 1.5");
    if (advise->is_based_on_previous_landing)
        answer_add_text(answer, NULL, "note",
                        "speed or deceleration not given: the values of the last landing are used");
}

/* Adds the thrust and its ratio to the critical thrust. Thrust above the critical thrust lifts a
 * bow wave (docs/explanation/bow-waves.md). */
static void add_thrust(const struct advise *advise, struct answer *answer)
{
    const struct advise_runway *runway = &advise->history.runway;
    const struct mr_estimate measured_lb = advise->history.braking.thrust_lb;
    char waves[UNIT_TEXT_SIZE];
    double share, spread,
        critical_lb = (double)runway->chain.mass_slug * ADVISE_G_FT_S2 *
                      (double)runway->chain.mat_length_ft / (2.0 * runway->ground_irregularity_ft);
    advise_parameter_moments(&advise->members, ADVISE_UNKNOWN_THRUST_SHARE, &share, &spread);
    if (runway->ground_irregularity_ft > 0.0) {
        answer_add_value(
            answer, "thrust", "planned thrust", UNIT_TENSION,
            share * runway->thrust_lb_per_g * advise->plan.mean_braking_ft_s2 / ADVISE_G_FT_S2, 1);
        if (measured_lb.value > 0.0) {
            answer_add_estimate(answer, "measured_thrust", "measured thrust", UNIT_TENSION,
                                measured_lb.value, measured_lb.error, 1);
            answer_append_remark(answer,
                                 ", in the last landing, from the brake signal to the stop");
        }
        answer_add_value(answer, "critical", "critical thrust", UNIT_TENSION, critical_lb, 1);
        unit_value_text(UNIT_TENSION, answer_is_si(answer), 1.2 * critical_lb, 0, waves);
        answer_append_remark(
            answer, ", for the assumed irregularity; bow waves form above about %s", waves);
    } else {
        answer_add_missing_value(
            answer, "critical", "critical thrust",
            "unknown, because predict.bump_in of the board's configuration is 0");
    }
}

/* Adds the ends of the 95 % interval. Only the JSON shows them. */
static void add_interval(const char *name, enum unit_kind unit,
                         const struct advise_limit_crossing *reach, struct answer *answer)
{
    char low[40], high[40];
    snprintf(low, sizeof low, "%s_low", name);
    snprintf(high, sizeof high, "%s_high", name);
    answer_add_value(answer, low, NULL, unit, reach->low, 1);
    answer_add_value(answer, high, NULL, unit, reach->high, 1);
}

void advise_to_answer(const struct advise *advise, struct answer *answer)
{
    answer_add_text(answer, "verdict", NULL, "%s", advise_verdict_text(advise->verdict));
    answer_add_text(answer, "reason", NULL, "%s", advise->reason);
    answer_add_sentence(answer, NULL, "%s: %s.", advise_verdict_text(advise->verdict),
                        advise->reason);
    add_plan(advise, answer);
    answer_open_table(
        answer, "rows",
        "Probability that the wheel reaches a zone of 50 closed mats, by mean deceleration (rows) "
        "and before each station (columns). In brackets: 95 % interval for the sampling error of "
        "the ensemble. Last column: share of the simulated landings that roll off the end");
    for (size_t i = 0; i < advise->row_count; i++)
        add_row(advise, &advise->row[i], answer);
    answer_close_group(answer);
    answer_add_value(answer, "limit", NULL, UNIT_NUMBER, advise->request.risk_limit, 3);
    answer_add_value(answer, "hardest", "hardest braking", UNIT_DECELERATION,
                     advise->max_braking.value, 1);
    if (isnan(advise->max_braking.value))
        answer_append_remark(
            answer, "; %s keeps the risks of a zone and of rolling off the end below %.0f %%",
            get_no_braking_subject(advise), 100.0 * advise->request.risk_limit);
    else
        answer_append_remark(
            answer,
            advise->max_braking.is_unbounded
                ? ", the last row, still keeps the risks of a zone and of rolling off the end "
                  "below %.0f %%"
                : " keeps the risks of a zone and of rolling off the end below %.0f %%",
            100.0 * advise->request.risk_limit);
    answer_add_flag(answer, "hardest_beyond", NULL, advise->max_braking.is_unbounded);
    add_notes(advise, answer);
    answer_add_value(answer, "short",
                     isfinite(advise->stop_short_braking_ft_s2) ? "stops short" : NULL,
                     UNIT_DECELERATION, advise->stop_short_braking_ft_s2, 1);
    if (isfinite(advise->stop_short_braking_ft_s2))
        answer_append_remark(answer, " or harder: the gear stops before the closed mats");
    answer_add_flag(answer, "outside", NULL, advise->is_plan_outside_range);
    answer_add_count(answer, "segments_surveyed", NULL, advise->history.surveyed_segment_count);
    add_parameters(advise, answer);
    add_thrust(advise, answer);
    answer_add_count(answer, "members", "members", (int64_t)advise->members.member_count);
    answer_append_remark(answer, "; seed %lld", (long long)advise->request.seed);
    answer_add_count(answer, "seed", NULL, advise->request.seed);
    add_interval("hardest", UNIT_DECELERATION, &advise->max_braking, answer);
    answer_add_value(answer, "fastest", NULL, UNIT_SPEED, advise->max_speed.value, 1);
    answer_add_flag(answer, "fastest_beyond", NULL, advise->max_speed.is_unbounded);
    add_interval("fastest", UNIT_SPEED, &advise->max_speed, answer);
    answer_add_sentence(answer, "action", "%s", advise->action);
}

/* ---- chart ---- */

_Static_assert(MR_RISK_CHART_ROWS >= ADVISE_ROW_COUNT,
               "the chart of a board has a place for every row");

static float convert_to_log_odds(double p)
{
    return (float)log(p / (1.0 - p));
}

enum mr_status advise_make_chart(const struct advise *advise, unsigned landings,
                                 struct mr_risk_plan *plan, struct error *error)
{
    const struct advise_profile *profile = &advise->plan.profile;
    mr_risk_plan_clear(plan);
    plan->landing_count = (float)landings;
    plan->speed_ft_s = (float)advise->plan.speed_ft_s;
    for (size_t i = 0; i < advise->row_count; i++) {
        plan->chart_deceleration_ft_s2[i] = (float)advise->row[i].mean_braking_ft_s2;
        plan->chart_log_odds[i] = convert_to_log_odds(advise->row[i].zone_probability.probability);
        plan->chart_zone_ft[i] = (float)advise->row[i].median_zone_station_ft;
    }
    plan->plan_time_s[0] = 0.0f;
    plan->plan_deceleration_ft_s2[0] = (float)advise->plan.mean_braking_ft_s2;
    for (size_t i = 0; i < profile->point_count; i++) {
        plan->plan_time_s[i] = (float)profile->t_s[i];
        plan->plan_deceleration_ft_s2[i] =
            (float)(profile->factor[i] * advise->plan.mean_braking_ft_s2);
    }
    return mr_risk_plan_check(plan) == MR_OK
             ? MR_OK
             : error_set(error, MR_USAGE,
                         "the board cannot store this plan; give a speed of 1 to 300 ft/s and a "
                         "final deceleration of 0.1 ft/s2 or more");
}
