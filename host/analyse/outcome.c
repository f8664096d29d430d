#include "host/analyse/measured_load.h"
#include "host/analyse/outcome.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "common/closure.h"
#include "common/wire.h"
#include "host/base/units.h"
#include "host/base/xmalloc.h"
#include "host/store/store_journal.h"
#include "host/store/store.h"
#include "host/survey/survey.h"

/* ---- predictions ---- */

static enum mr_status load_max_risk(struct store *store, struct outcome_record_row *row,
                                    struct error *error)
{
    struct store_risk *risk = NULL;
    size_t risks = 0;
    row->max_risk = (double)NAN;
    enum mr_status status = store_risks_get(store, row->run, &risk, &risks, error);
    for (size_t i = 0; status == MR_OK && i < risks; i++)
        row->max_risk = fmax(row->max_risk, risk[i].risk);
    free(risk);
    return status;
}

static void set_warning(const struct measured_landing *measured, const struct zones *zones,
                        struct outcome_record_row *row)
{
    const struct zone_warning *warning = &zones->warning;
    char doubt[ZONES_REASON_SIZE];
    row->warned_t_s = row->warned_zone_start_ft = row->warned_wheel_ft = (double)NAN;
    row->lead_time_s = row->lead_time_low_s = row->lead_time_high_s = (double)NAN;
    if (warning->has_warning) {
        row->warning_status = WARNING_SENT;
        row->warned_t_s = warning->t_s;
        row->time_origin = zones->received.origin;
        row->warned_zone_start_ft = warning->start_ft;
        row->warned_wheel_ft = warning->wheel_ft;
    } else if (measured->source == MEASURED_IMPORT)
        row->warning_status = WARNING_NO_BOARD;
    else
        row->warning_status = zones_format_missed_warning_reason(&zones->received, (double)INFINITY,
                                                                 doubt)
                                ? WARNING_NOT_RECEIVED
                                : WARNING_NOT_SENT;
}

/* Compares the landing with its advice. The landing is off plan if its braking or speed differs
 * from the plan. */
static void set_deviation_from_plan(const struct measured_landing *measured,
                                    struct outcome_record_row *row)
{
    const struct mr_gates_summary *fit = &measured->summary;
    if (!row->has_advice || measured->fit_status != MR_OK)
        return;
    double speed_ft_s = fit->touchdown_speed_ft_s.value,
           stopping_distance_ft = fit->stop_station_ft.value - measured->landing.touchdown_ft,
           braking_ft_s2 = speed_ft_s * speed_ft_s / (2.0 * stopping_distance_ft);
    bool off_speed = fabs(speed_ft_s / row->advice.speed_ft_s - 1.0) > OUTCOME_OFF_PLAN_SPEED_SHARE;
    row->has_motion = true;
    row->is_off_plan = off_speed || (stopping_distance_ft > 0.0 &&
                                     fabs(braking_ft_s2 / row->advice.deceleration_ft_s2 - 1.0) >
                                         OUTCOME_OFF_PLAN_BRAKING_SHARE);
    row->followed_advice_against = strcmp(row->advice.verdict, "against") == 0 && !off_speed &&
                                   stopping_distance_ft > 0.0 &&
                                   braking_ft_s2 <= row->advice.hardest_ft_s2;
}

/* ---- outcome ---- */

static void set_outcome_after_warning(struct outcome_record_row *row)
{
    const struct outcome *outcome = &row->outcome;
    if (outcome->reached == OUTCOME_NOT_REACHED)
        row->warning_outcome = WARNING_FALSE_ALARM;
    else {
        row->warning_outcome = outcome->reached_t_s < row->warned_t_s ? WARNING_LATE : WARNING_HIT;
        row->lead_time_s = outcome->reached_t_s - row->warned_t_s;
        row->lead_time_low_s = outcome->reached_earliest_s - row->warned_t_s;
        row->lead_time_high_s = outcome->reached_latest_s - row->warned_t_s;
    }
}

static void set_warning_outcome(struct outcome_record_row *row)
{
    row->warning_outcome = WARNING_OUTCOME_UNKNOWN;
    if (row->is_void)
        row->unknown_reason = "the landing is void";
    else if (row->outcome.reached == OUTCOME_UNKNOWN)
        row->unknown_reason = row->outcome.unknown_reason;
    else if (row->warning_status == WARNING_NO_BOARD)
        row->unknown_reason = "no board was recording";
    else if (row->warning_status == WARNING_NOT_RECEIVED)
        row->unknown_reason = "no warning was received, but one may have been sent";
    else if (row->warning_status == WARNING_SENT)
        set_outcome_after_warning(row);
    else
        row->warning_outcome = row->outcome.reached == OUTCOME_REACHED ? WARNING_MISS
                                                                       : WARNING_TRUE_NEGATIVE;
}

/* The landings of the same board before and after a landing; NULL: none. */
struct adjacent_landings {
    const struct store_landing *previous_landing, *next_landing;
    /* the next landing began on the runway as it was saved before this landing */
    bool is_runway_restored;
};

/* step between checks, samples of 1 ms; the wheel rolls 0.7 ft at most in this time */
#define ZONE_STEP_SAMPLES 20
/* a zone that exists for a shorter time is an artefact of coarse segments */
#define MIN_ZONE_S        0.07
#define MIN_SPEED_FT_S    2.0 /* below this speed, the wheel is about to stop */
#define MIN_COVERED_SHARE 0.5

const char *outcome_basis_text(enum outcome_basis basis)
{
    static const char *const text[OUTCOME_BASIS_COUNT] = {
        [OUTCOME_NO_BASIS] = "nothing",
        [OUTCOME_OBSERVATION] = "observation",
        [OUTCOME_TRANSDUCERS] = "survey before and transducers",
        [OUTCOME_SURVEY_AFTER] = "survey after",
    };
    return text[basis];
}

/* ---- surveys ---- */

/* Loads the survey that the board sent with a landing. A board sends its survey even if it is old.
 * All of it counts as new if at least half of its openings changed (a new reading of a closed
 * segment may equal the old one exactly). Otherwise only the changed openings count as new. */
static enum mr_status load_board_survey(struct store *store, int64_t run, int64_t run_before,
                                        struct zones_slack *survey, struct error *error)
{
    struct zones_slack last;
    size_t changed = 0;
    enum mr_status status = zones_load_survey(store, run, survey, error);
    if (status != MR_OK || run_before == 0)
        return status;
    status = zones_load_survey(store, run_before, &last, error);
    bool other[MR_SEGMENTS];
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float now_in = survey->slack_in[s], then_in = last.slack_in[s];
        other[s] = isfinite(now_in) && (isnan(then_in) || now_in < then_in || now_in > then_in);
        changed += other[s];
    }
    for (unsigned s = 0; s < MR_SEGMENTS && 2 * changed < survey->surveyed_segment_count; s++) {
        if (!other[s])
            survey->slack_in[s] = MR_NAN;
    }
    survey->surveyed_segment_count = 2 * changed < survey->surveyed_segment_count
                                       ? changed
                                       : survey->surveyed_segment_count;
    return status;
}

/* Replaces the board's survey by the newest gage survey that has readings and began between the two
 * times. */
static enum mr_status load_gage_survey(struct store *store, int64_t from_us, int64_t to_us,
                                       struct zones_slack *slack, struct error *error)
{
    static struct survey_results found;
    bool exists;
    enum mr_status status = survey_evaluate_between(store, from_us, to_us, &found, &exists, error);
    if (status != MR_OK || !exists)
        return status;
    slack->surveyed_segment_count = found.slack.surveyed_segment_count;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        slack->slack_in[s] = (float)found.slack.segment[s].value_in;
    return MR_OK;
}

/* ---- transducers ---- */

void reached_zone_init(struct reached_zone *reach)
{
    *reach = (struct reached_zone){.longest_start_ft = (double)NAN};
    for (unsigned k = 0; k < REACHED_ZONE_LIMIT_COUNT; k++)
        reach->reached_t_s[k] = reach->since_s[k] = (double)NAN;
}

void reached_zone_update(struct reached_zone *reach, double t_s, double wheel_ft,
                         const struct mr_closure_zone *zone)
{
    static const struct {
        unsigned mats;
        /* distance of the wheel from the zone; 0: the wheel is inside the zone */
        double distance_ft;
    } limit[REACHED_ZONE_LIMIT_COUNT] = {
        [REACHED_ZONE_EARLIEST] = {OUTCOME_MIN_ZONE_MATS - ZONES_ERROR_MATS,
                                   REACHED_ZONE_DISTANCE_MAX_FT},
        [REACHED_ZONE_BEST] = {OUTCOME_MIN_ZONE_MATS, OUTCOME_REACHED_DISTANCE_FT},
        [REACHED_ZONE_LATEST] = {OUTCOME_MIN_ZONE_MATS, 0.0},
    };
    double distance_ft = fmax(0.0, (double)(zone->start_ft - (float)wheel_ft));
    for (unsigned k = 0; k < REACHED_ZONE_LIMIT_COUNT; k++) {
        if (zone->mats < limit[k].mats || distance_ft > limit[k].distance_ft)
            reach->since_s[k] = (double)NAN;
        else if (isnan(reach->since_s[k]))
            reach->since_s[k] = t_s;
        if (isnan(reach->reached_t_s[k]) && t_s - reach->since_s[k] > MIN_ZONE_S)
            reach->reached_t_s[k] = reach->since_s[k];
    }
    if (distance_ft <= OUTCOME_REACHED_DISTANCE_FT && zone->mats > reach->longest_mats) {
        reach->longest_mats = zone->mats;
        reach->longest_start_ft = (double)zone->start_ft;
    }
}

static struct reached_zone find_reached_zone(const struct measured_landing *measured,
                                             const struct zones_slack *slack)
{
    struct reached_zone reach;
    reached_zone_init(&reach);
    for (size_t i = 0; i < measured->samples; i += ZONE_STEP_SAMPLES) {
        float left_in[MR_SEGMENTS];
        struct mr_closure_zone zone;
        double t_s = measured_time_s(measured, i), error_ft_s,
               wheel_ft = measured_station_ft(measured, t_s);
        if (t_s > measured->summary.stop_t_s.value)
            break;
        if (isnan(wheel_ft) || !(measured_speed_ft_s(measured, t_s, &error_ft_s) > MIN_SPEED_FT_S))
            continue;
        zones_compute_remaining_slack(measured, slack, i, left_in);
        zones_find_longest_zone(slack->slack_in, left_in, wheel_ft, REACHED_ZONE_DISTANCE_MAX_FT,
                                &zone);
        reached_zone_update(&reach, t_s, wheel_ft, &zone);
    }
    return reach;
}

/* Returns the fraction of the distance from touchdown to 50 mats beyond the stop that lies between
 * the first and the last transducer that worked to the end. */
static double compute_covered_share(const struct measured_landing *measured)
{
    double from_ft = measured->landing.touchdown_ft,
           to_ft = measured->summary.stop_station_ft.value +
                   OUTCOME_MIN_ZONE_MATS * (double)MR_MAT_LENGTH_FT,
           first_ft = (double)NAN, last_ft = (double)NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct measured_channel *channel = &measured->channel[i];
        if (channel->config.kind != MR_KIND_DISPLACEMENT || !isfinite(channel->end))
            continue;
        double at_ft = (double)channel->config.station_ft;
        first_ft = isnan(first_ft) ? at_ft : first_ft;
        last_ft = at_ft;
    }
    double watched_ft = fmin(last_ft, to_ft) - fmax(first_ft, from_ft);
    return isnan(first_ft) || !(to_ft > from_ft) ? 0.0 : fmax(0.0, watched_ft) / (to_ft - from_ft);
}

static void determine_outcome_from_transducers(const struct measured_landing *measured,
                                               const struct zones_slack *slack,
                                               struct outcome *outcome)
{
    struct zones_slack closed = *slack; /* count segments that were not surveyed as closed */
    if (measured->fit_status != MR_OK) {
        outcome->unknown_reason = "the motion of the gear up to its stop is unknown";
        return;
    }
    if (slack->surveyed_segment_count == 0) {
        outcome->unknown_reason =
            "there was no survey between the previous landing and this landing";
        return;
    }
    outcome->covered_share = compute_covered_share(measured);
    if (!(outcome->covered_share > 0.0)) {
        outcome->unknown_reason = "fewer than two transducers have readings";
        return;
    }
    struct reached_zone reach = find_reached_zone(measured, slack);
    outcome->longest_mats = (int64_t)reach.longest_mats;
    outcome->longest_start_ft = reach.longest_start_ft;
    outcome->reached_t_s = reach.reached_t_s[REACHED_ZONE_BEST];
    outcome->reached_earliest_s = reach.reached_t_s[REACHED_ZONE_EARLIEST];
    outcome->reached_latest_s = reach.reached_t_s[REACHED_ZONE_LATEST];
    if (isfinite(outcome->reached_t_s)) {
        outcome->reached = OUTCOME_REACHED;
        outcome->basis = OUTCOME_TRANSDUCERS;
        return;
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        closed.slack_in[s] = isnan(closed.slack_in[s]) ? 0.0f : closed.slack_in[s];
    if (outcome->covered_share < MIN_COVERED_SHARE)
        outcome->unknown_reason = "the transducers cover less than half of the gear's path";
    else if (slack->surveyed_segment_count < MR_SEGMENTS &&
             isfinite(find_reached_zone(measured, &closed).reached_t_s[REACHED_ZONE_BEST]))
        outcome->unknown_reason =
            "the survey before the landing omits segments where a zone may have formed";
    else {
        outcome->reached = OUTCOME_NOT_REACHED;
        outcome->basis = OUTCOME_TRANSDUCERS;
    }
}

/* ---- survey afterwards and observations ---- */

static void determine_outcome_from_survey_after(const struct measured_landing *measured,
                                                const struct zones_slack *slack,
                                                struct outcome *outcome)
{
    struct mr_closure_zone zone;
    double stop_ft = measured->summary.stop_station_ft.value;
    if (measured->fit_status != MR_OK || slack->surveyed_segment_count == 0)
        return;
    zones_find_longest_zone(slack->slack_in, slack->slack_in, stop_ft, OUTCOME_REACHED_DISTANCE_FT,
                            &zone);
    outcome->closed_after_mats = (int64_t)zone.mats;
    if (outcome->closed_after_mats < OUTCOME_MIN_ZONE_MATS || outcome->reached == OUTCOME_REACHED)
        return;
    if (outcome->reached == OUTCOME_NOT_REACHED) {
        outcome->reached = OUTCOME_UNKNOWN;
        outcome->basis = OUTCOME_NO_BASIS;
        outcome->unknown_reason = "the transducers and the survey after the landing disagree";
    } else {
        outcome->reached = OUTCOME_REACHED;
        outcome->basis = OUTCOME_SURVEY_AFTER;
    }
}

static enum mr_status determine_outcome_from_observations(struct store *store, int64_t run,
                                                          struct outcome *outcome,
                                                          struct error *error)
{
    struct store_observation *row = NULL;
    size_t count = 0;
    double observed_t_s = (double)NAN;
    enum mr_status status = store_observations_get(store, run, &row, &count, error);
    for (size_t i = 0; i < count; i++) {
        bool wave = strcmp(row[i].kind, "wave") == 0 && strcmp(row[i].form, "two-panel") != 0;
        if (row[i].withdrawn || row[i].withdraws != STORE_NONE)
            continue;
        outcome->wave_count += wave;
        outcome->break_count += strcmp(row[i].kind, "break") == 0;
        if (outcome->wave_count + outcome->break_count == 0)
            continue;
        observed_t_s = fmin(observed_t_s, row[i].time_s);
        outcome->reached = OUTCOME_REACHED;
        outcome->basis = OUTCOME_OBSERVATION;
        outcome->unknown_reason = NULL;
    }
    if (isnan(outcome->reached_t_s)) {
        outcome->reached_t_s = observed_t_s;
        outcome->reached_earliest_s = outcome->reached_latest_s = (double)NAN;
    }
    free(row);
    return status;
}

static const struct outcome unknown_outcome = {.longest_mats = STORE_NONE,
                                               .closed_after_mats = STORE_NONE,
                                               .longest_start_ft = (double)NAN,
                                               .reached_t_s = (double)NAN,
                                               .reached_earliest_s = (double)NAN,
                                               .reached_latest_s = (double)NAN};

/* `measured` must be loaded with samples (measured_load). */
static enum mr_status outcome_load(struct store *store, const struct measured_landing *measured,
                                   const struct adjacent_landings *between, struct outcome *outcome,
                                   struct error *error)
{
    struct zones_slack before, after = {.surveyed_segment_count = 0};
    const struct store_landing *landing = &measured->landing;
    enum mr_status status =
        load_board_survey(store, landing->id,
                          between->previous_landing ? between->previous_landing->id : 0, &before,
                          error)
            ?: load_gage_survey(store,
                                between->previous_landing ? between->previous_landing->armed_us
                                                          : INT64_MIN,
                                landing->armed_us, &before, error);
    if (status == MR_OK && between->next_landing && !between->is_runway_restored)
        status = load_board_survey(store, between->next_landing->id, landing->id, &after, error);
    if (status == MR_OK)
        status = load_gage_survey(
            store, landing->armed_us,
            between->next_landing ? between->next_landing->armed_us : INT64_MAX, &after, error);
    if (status != MR_OK)
        return status;
    determine_outcome_from_transducers(measured, &before, outcome);
    determine_outcome_from_survey_after(measured, &after, outcome);
    status = determine_outcome_from_observations(store, landing->id, outcome, error);
    if (outcome->reached != OUTCOME_UNKNOWN)
        outcome->unknown_reason = NULL;
    return status;
}

/* ---- a landing ---- */

/* Sets the newest advice between the previous landing of the campaign and this one. */
static void set_newest_advice(const struct store_advice *advice, size_t count, int64_t before,
                              struct outcome_record_row *row)
{
    for (size_t i = 0; i < count; i++) {
        if (advice[i].after_run < before || advice[i].after_run >= row->run)
            continue;
        row->has_advice = true;
        row->advice = advice[i];
    }
}

/* Identifies the history of the runway on which a landing of an emulated board began, apart from
 * surveys; 0: none, or not known. */
static uint64_t find_runway_history_id(struct store *store, const struct store_landing *landing)
{
    struct mr_predictor_state state;
    struct error ignored = {0};
    int64_t source;
    uint32_t scale;
    bool exists = false;
    if (!measured_is_emulated(landing) ||
        store_runway_get(store, landing->id, &state, &source, &exists, &ignored) != MR_OK ||
        !exists || state.landing_count == 0)
        return 0;
    memcpy(&scale, &state.resistance_scale, sizeof scale);
    return (uint64_t)state.landing_count << 32 | scale;
}

/* Finds the landing whose runway was restored for this landing, and the advice for that runway. */
static void set_first_run_on_runway(const struct outcome_record *record, const uint64_t *history,
                                    struct outcome_record_row *row)
{
    const size_t at = (size_t)(row - record->row);
    for (size_t i = 0; i < at && row->first_run_on_runway == STORE_NONE && history[at]; i++) {
        if (history[i] != history[at])
            continue;
        row->first_run_on_runway = record->row[i].run;
        if (!row->has_advice) {
            row->has_advice = record->row[i].has_advice;
            row->advice = record->row[i].advice;
        }
    }
}

static const struct store_landing *find_adjacent_landing(const struct store_landing *all,
                                                         size_t count, size_t at, int step)
{
    for (size_t i = at + (size_t)step; i < count; i += (size_t)step) {
        if (strcmp(all[i].board_uid, all[at].board_uid) == 0)
            return &all[i];
    }
    return NULL;
}

/* Checks whether there is a survey before loading samples, which is slow and useful only with a
 * survey. */
static enum mr_status find_any_survey(struct store *store, int64_t run, bool *has,
                                      struct error *error)
{
    struct zones_slack survey;
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    enum mr_status status = zones_load_survey(store, run, &survey, error)
                              ?: store_gage_surveys_get(store, &rows, &count, error);
    *has = status == MR_OK && (survey.surveyed_segment_count > 0 || count > 0);
    free(rows);
    return status;
}

static enum mr_status evaluate_landing(struct store *store, const struct adjacent_landings *between,
                                       const struct outcome_record_landing *loaded,
                                       struct outcome_record_row *row, struct error *error)
{
    set_warning(loaded->measured, loaded->zones, row);
    set_deviation_from_plan(loaded->measured, row);
    enum mr_status status = load_max_risk(store, row, error);
    row->outcome = unknown_outcome; /* for a void landing this remains */
    if (status == MR_OK && !row->is_void)
        status = outcome_load(store, loaded->measured, between, &row->outcome, error);
    if (status == MR_OK)
        set_warning_outcome(row);
    row->is_evaluated = status == MR_OK;
    return status;
}

static enum mr_status load_landing(struct store *store, const struct adjacent_landings *between,
                                   struct outcome_record_row *row, struct error *error)
{
    /* static instead of on the stack, because it takes about ten kilobytes */
    static struct measured_landing measured;
    struct zones zones = {0};
    bool surveyed = false;
    enum mr_status status = find_any_survey(store, row->run, &surveyed, error);
    memset(&measured, 0, sizeof measured);
    if (status == MR_OK)
        status = surveyed && !row->is_void ? measured_load(store, row->run, &measured, error)
                                           : measured_load_gear(store, row->run, &measured, error);
    if (status == MR_OK)
        status = zones_load(store, &measured, &zones, error);
    if (status == MR_OK)
        status = evaluate_landing(
            store, between,
            &(struct outcome_record_landing){.measured = &measured, .zones = &zones}, row, error);
    zones_free(&zones);
    measured_free(&measured);
    return status;
}

/* ---- totals ---- */

static void add_row_to_totals(struct outcome_record *record, const struct outcome_record_row *row)
{
    record->void_count += row->is_void;
    if (row->is_void)
        return;
    record->landing_count++;
    record->warning_outcome_count[row->warning_outcome]++;
    if (row->has_advice && (row->is_off_plan || row->followed_advice_against))
        record->off_plan_count++;
    else if (row->has_advice)
        record->advice_count[strcmp(row->advice.verdict, "against") == 0 ? ADVICE_AGAINST
                             : strcmp(row->advice.verdict, "caution") == 0
                                 ? ADVICE_CAUTION
                                 : ADVICE_CLEAR][row->outcome.reached]++;
}

/* ---- the campaign ---- */

struct outcome_record_row *outcome_record_find_row(struct outcome_record *record, int64_t run)
{
    size_t low = 0, high = record->row_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (record->row[middle].run < run)
            low = middle + 1;
        else
            high = middle;
    }
    return low < record->row_count && record->row[low].run == run ? &record->row[low] : NULL;
}

static struct adjacent_landings find_adjacent_landings(const struct outcome_record *record,
                                                       const struct outcome_record_row *row)
{
    size_t at = (size_t)(row - record->row);
    const struct store_landing *after = find_adjacent_landing(record->landing, record->row_count,
                                                              at, 1);
    return (struct adjacent_landings){
        find_adjacent_landing(record->landing, record->row_count, at, -1), after,
        after && record->row[after - record->landing].first_run_on_runway != STORE_NONE};
}

enum mr_status outcome_record_begin(struct store *store, struct outcome_record *record,
                                    struct error *error)
{
    struct store_advice *advice = NULL;
    size_t count = 0, advices = 0;
    *record = (struct outcome_record){0};
    enum mr_status status = store_landings_get(store, &record->landing, &count, error)
                              ?: store_advices_get(store, &advice, &advices, error);
    uint64_t *history = xcalloc(count + 1, sizeof *history);
    if (status == MR_OK)
        record->row = xcalloc(count, sizeof *record->row);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        struct outcome_record_row *row = &record->row[record->row_count++];
        row->run = record->landing[i].id;
        row->first_run_on_runway = STORE_NONE;
        history[i] = find_runway_history_id(store, &record->landing[i]);
        set_newest_advice(advice, advices, i ? record->landing[i - 1].id : 0, row);
        set_first_run_on_runway(record, history, row);
        status = store_is_void(store, row->run, &row->is_void, NULL, error);
    }
    free(advice);
    free(history);
    return status;
}

enum mr_status outcome_record_evaluate(struct store *store, struct outcome_record *record,
                                       const struct outcome_record_landing *loaded,
                                       struct error *error)
{
    struct outcome_record_row *row = outcome_record_find_row(record, loaded->measured->landing.id);
    if (!row)
        return MR_OK;
    const struct adjacent_landings between = find_adjacent_landings(record, row);
    return evaluate_landing(store, &between, loaded, row, error);
}

enum mr_status outcome_record_evaluate_one(struct store *store,
                                           const struct outcome_record_landing *loaded,
                                           struct outcome_record_row *row, struct error *error)
{
    struct outcome_record record;
    enum mr_status status = outcome_record_begin(store, &record, error)
                              ?: outcome_record_evaluate(store, &record, loaded, error);
    const struct outcome_record_row *found = outcome_record_find_row(&record,
                                                                     loaded->measured->landing.id);
    if (status == MR_OK && found)
        *row = *found;
    outcome_record_free(&record);
    return status;
}

enum mr_status outcome_record_end(struct store *store, struct outcome_record *record,
                                  struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; status == MR_OK && i < record->row_count; i++) {
        struct outcome_record_row *row = &record->row[i];
        const struct adjacent_landings between = find_adjacent_landings(record, row);
        if (!row->is_evaluated)
            status = load_landing(store, &between, row, error);
    }
    for (size_t i = 0; status == MR_OK && i < record->row_count; i++)
        add_row_to_totals(record, &record->row[i]);
    return status;
}

enum mr_status outcome_record_load(struct store *store, struct outcome_record *record,
                                   struct error *error)
{
    return outcome_record_begin(store, record, error) ?: outcome_record_end(store, record, error);
}

void outcome_record_free(struct outcome_record *record)
{
    free(record->row);
    free(record->landing);
    record->row = NULL;
    record->landing = NULL;
}

const char *warning_outcome_text(enum warning_outcome verdict)
{
    static const char *const text[WARNING_OUTCOME_COUNT] = {
        [WARNING_OUTCOME_UNKNOWN] = "not known", [WARNING_HIT] = "hit",
        [WARNING_LATE] = "warned, but too late", [WARNING_MISS] = "missed",
        [WARNING_FALSE_ALARM] = "false",         [WARNING_TRUE_NEGATIVE] = "correctly quiet",
    };
    return text[verdict];
}

bool outcome_record_is_marginal(const struct outcome_record_row *row)
{
    return row->outcome.basis == OUTCOME_TRANSDUCERS &&
           llabs(row->outcome.longest_mats - OUTCOME_MIN_ZONE_MATS) <= ZONES_ERROR_MATS;
}

const char *outcome_record_format_lead_time(const struct outcome_record_row *row, bool in_table,
                                            char out[OUTCOME_LEAD_TIME_SIZE])
{
    const char *unit = in_table ? "" : " s", *begin = in_table ? " (" : " (75 % interval: ";
    const double low_s = unit_round_to_zero(row->lead_time_low_s, 0.1),
                 high_s = unit_round_to_zero(row->lead_time_high_s, 0.1);
    if (isnan(row->lead_time_s))
        return strcpy(out, "-");
    int used = snprintf(out, OUTCOME_LEAD_TIME_SIZE, "%.1f%s",
                        unit_round_to_zero(row->lead_time_s, 0.1), unit);
    const size_t size = OUTCOME_LEAD_TIME_SIZE - (size_t)used;
    if (isfinite(high_s))
        snprintf(out + used, size, "%s%.1f to %.1f%s)", begin, low_s, high_s, unit);
    else if (isfinite(low_s))
        snprintf(out + used, size, "%s%.1f%s or more)", begin, low_s, unit);
    return out;
}

const char *outcome_record_format_outcome(const struct outcome_record_row *row,
                                          char out[OUTCOME_TEXT_SIZE])
{
    char lead[OUTCOME_LEAD_TIME_SIZE];
    const bool has_lead = !isnan(row->lead_time_s);
    snprintf(out, OUTCOME_TEXT_SIZE, "%s%s%s", warning_outcome_text(row->warning_outcome),
             has_lead ? ", lead time about " : "",
             has_lead ? outcome_record_format_lead_time(row, false, lead) : "");
    return out;
}

/* Appends what the wheel reached, from the evidence of the outcome. */
static void append_reached_zone(const struct outcome *outcome, char *out, size_t size)
{
    if (outcome->reached == OUTCOME_UNKNOWN)
        snprintf(out, size, "whether the wheel reached a closed zone is not known");
    else if (isfinite(outcome->reached_t_s))
        snprintf(out, size,
                 "the wheel reached %d closed mats about %.1f s after touchdown (evidence: %s%s)",
                 OUTCOME_MIN_ZONE_MATS, outcome->reached_t_s, outcome_basis_text(outcome->basis),
                 outcome->basis == OUTCOME_OBSERVATION && isfinite(outcome->reached_earliest_s)
                     ? ", survey before and transducers"
                     : "");
    else if (outcome->reached == OUTCOME_REACHED)
        snprintf(out, size, "the wheel reached a closed zone (evidence: %s)",
                 outcome_basis_text(outcome->basis));
    else if (outcome->longest_mats > 0)
        snprintf(out, size, "the longest closed zone that the wheel reached had %lld +- %d mats",
                 (long long)outcome->longest_mats, ZONES_ERROR_MATS);
    else
        snprintf(out, size, "the wheel reached no closed zone");
}

const char *outcome_record_format_evidence(const struct outcome_record_row *row,
                                           char out[OUTCOME_TEXT_SIZE])
{
    static const char *const warned[] = {
        [WARNING_NO_BOARD] = "no board recorded this landing",
        [WARNING_NOT_SENT] = "the board did not warn",
        [WARNING_NOT_RECEIVED] = "the log received no warning, but may have missed one"};
    const struct outcome *outcome = &row->outcome;
    size_t used;
    if (row->warning_status == WARNING_SENT)
        snprintf(out, OUTCOME_TEXT_SIZE, "the board warned %.3f s %s %s; ", fabs(row->warned_t_s),
                 row->warned_t_s < 0.0 ? "before" : "after", row->time_origin);
    else
        snprintf(out, OUTCOME_TEXT_SIZE, "%s; ", warned[row->warning_status]);
    used = strlen(out);
    append_reached_zone(outcome, out + used, OUTCOME_TEXT_SIZE - used);
    used = strlen(out);
    if (outcome_record_is_marginal(row) && outcome->reached == OUTCOME_REACHED)
        snprintf(out + used, OUTCOME_TEXT_SIZE - used,
                 "; the longest closed zone had %lld +- %d mats", (long long)outcome->longest_mats,
                 ZONES_ERROR_MATS);
    used = strlen(out);
    if (outcome_record_is_marginal(row))
        snprintf(out + used, OUTCOME_TEXT_SIZE - used,
                 ", within its standard error of the limit of %d", OUTCOME_MIN_ZONE_MATS);
    used = strlen(out);
    if (row->warning_outcome == WARNING_OUTCOME_UNKNOWN && row->unknown_reason)
        snprintf(out + used, OUTCOME_TEXT_SIZE - used, " (%s)", row->unknown_reason);
    return out;
}

const char *outcome_record_format_line(const struct outcome_record_row *row,
                                       char out[OUTCOME_LINE_SIZE])
{
    char outcome[OUTCOME_TEXT_SIZE], evidence[OUTCOME_TEXT_SIZE];
    snprintf(out, OUTCOME_LINE_SIZE, "%s: %s", outcome_record_format_outcome(row, outcome),
             outcome_record_format_evidence(row, evidence));
    return out;
}

void outcome_record_add_outcome(const struct outcome_record_row *row, struct answer *answer)
{
    const struct outcome *outcome = &row->outcome;
    char line[OUTCOME_LINE_SIZE];
    answer_add_text(answer, NULL, "outcome", "%s", outcome_record_format_line(row, line));
    answer_open_group(answer, "outcome", NULL);
    answer_add_text(answer, "result", NULL, "%s", warning_outcome_text(row->warning_outcome));
    answer_add_value(answer, "lead", NULL, UNIT_TIME, row->lead_time_s, 3);
    answer_add_value(answer, "lead_low", NULL, UNIT_TIME, row->lead_time_low_s, 3);
    answer_add_value(answer, "lead_high", NULL, UNIT_TIME, row->lead_time_high_s, 3);
    if (outcome->reached == OUTCOME_UNKNOWN)
        answer_add_missing_value(answer, "zone_reached", NULL, "");
    else
        answer_add_flag(answer, "zone_reached", NULL, outcome->reached == OUTCOME_REACHED);
    answer_add_value(answer, "zone_reached_t", NULL, UNIT_TIME, outcome->reached_t_s, 3);
    answer_add_count(answer, "zone_mats", NULL, outcome->longest_mats);
    answer_add_text(answer, "evidence", NULL, "%s", outcome_record_format_evidence(row, line));
    answer_close_group(answer);
}

const char *outcome_record_format_advice(const struct outcome_record_row *row,
                                         char out[OUTCOME_ADVICE_SIZE])
{
    bool against = row->has_advice && strcmp(row->advice.verdict, "against") == 0;
    snprintf(out, OUTCOME_ADVICE_SIZE, "%s%s", row->has_advice ? row->advice.verdict : "none",
             row->followed_advice_against          ? ", followed"
             : row->has_advice && row->is_off_plan ? ", plan not followed"
             : against && row->has_motion          ? ", not followed"
                                                   : "");
    return out;
}

static void add_warnings(const struct outcome_record *record, struct answer *answer)
{
    static const char *const names[WARNING_OUTCOME_COUNT] = {"unknown", "hits",  "late",
                                                             "misses",  "false", "silences"};
    answer_open_group(answer, "warnings", "warnings");
    for (size_t i = 1; i <= WARNING_OUTCOME_COUNT; i++) {
        enum warning_outcome verdict = (enum warning_outcome)(i % WARNING_OUTCOME_COUNT);
        answer_add_count(answer, names[verdict], warning_outcome_text(verdict),
                         (int64_t)record->warning_outcome_count[verdict]);
    }
    answer_close_group(answer);
}

static void add_advice(const struct outcome_record *record, struct answer *answer)
{
    static const char *const names[ADVICE_LEVEL_COUNT] = {"clear", "caution", "against"};
    char none[40] = "";
    size_t landings[ADVICE_LEVEL_COUNT] = {0}, sum = 0;
    for (size_t i = 0; i < ADVICE_LEVEL_COUNT; i++) {
        for (size_t k = 0; k < 3; k++)
            landings[i] += record->advice_count[i][k];
        sum += landings[i];
    }
    answer_open_table(answer, "advice", sum ? "advice before landings" : NULL);
    for (size_t i = 0; i < ADVICE_LEVEL_COUNT; i++) {
        const size_t *count = record->advice_count[i], used = strlen(none);
        const bool shown = landings[i] > 0; /* the JSON has each advice */
        answer_open_row(answer);
        answer_add_text(answer, "advice", shown ? "advice" : NULL, "%s", names[i]);
        answer_add_count(answer, "came", shown ? "zone reached" : NULL,
                         (int64_t)count[OUTCOME_REACHED]);
        answer_add_count(answer, "did_not", shown ? "not reached" : NULL,
                         (int64_t)count[OUTCOME_NOT_REACHED]);
        answer_add_count(answer, "unknown", shown ? "not known" : NULL,
                         (int64_t)count[OUTCOME_UNKNOWN]);
        if (!shown)
            snprintf(none + used, sizeof none - used, "%s%s", used ? ", " : "", names[i]);
    }
    answer_close_group(answer);
    if (sum && none[0])
        answer_add_text(answer, NULL, "advice without a landing", "%s", none);
    answer_add_count(answer, "off_plan", "not landed as planned", (int64_t)record->off_plan_count);
}

static void add_summary_line(const struct outcome_record *record, struct answer *answer)
{
    const size_t *verdict = record->warning_outcome_count;
    const size_t reached = verdict[WARNING_HIT] + verdict[WARNING_LATE] + verdict[WARNING_MISS];
    answer_add_sentence(
        answer, NULL,
        "The wheel reached a zone in %zu landing%s: the board warned in time in %zu, too late in "
        "%zu and not at all in %zu. The other landings: %zu with a false warning, %zu correctly "
        "quiet, %zu unknown (matrig report lists all).",
        reached, reached == 1 ? "" : "s", verdict[WARNING_HIT], verdict[WARNING_LATE],
        verdict[WARNING_MISS], verdict[WARNING_FALSE_ALARM], verdict[WARNING_TRUE_NEGATIVE],
        verdict[WARNING_OUTCOME_UNKNOWN]);
    for (size_t i = 0; i < record->row_count; i++) {
        char evidence[OUTCOME_TEXT_SIZE];
        if (!record->row[i].is_void && outcome_record_is_marginal(&record->row[i]))
            answer_add_sentence(answer, NULL, "RUN %lld: %s.", (long long)record->row[i].run,
                                outcome_record_format_evidence(&record->row[i], evidence));
    }
}

void outcome_record_to_answer(const struct outcome_record *record, bool brief,
                              struct answer *answer)
{
    answer_open_group(answer, "record", brief ? NULL : "");
    answer_add_count(answer, "counted", brief ? NULL : "landings", (int64_t)record->landing_count);
    answer_add_count(answer, "voided", brief ? NULL : "void, not counted",
                     (int64_t)record->void_count);
    add_warnings(record, answer);
    add_advice(record, answer);
    answer_close_group(answer);
    if (brief)
        add_summary_line(record, answer);
}
