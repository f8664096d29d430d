#include "host/analyse/zones.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/predictor.h"
#include "common/wire.h"
#include "host/store/store.h"

#define NO_WARNING_TEXT_SIZE (ZONES_REASON_SIZE + 60)

double zones_time_s(const struct measured_landing *measured, const struct store_zone *zone)
{
    return measured_block_time_s(measured, zone->block);
}

/* bytes of a text for a time, for example "2.824 s after touchdown" */
#define MOMENT_TEXT_SIZE 60
static const char *format_moment(double t_s, const char *origin, char out[MOMENT_TEXT_SIZE])
{
    snprintf(out, MOMENT_TEXT_SIZE, "%.3f s %s %s", fabs(t_s), t_s < 0.0 ? "before" : "after",
             origin);
    return out;
}

static struct zone_warning find_first_warning(const struct measured_landing *measured,
                                              const struct store_zone *row)
{
    struct zone_warning warning = {
        .has_warning = true,
        .block = row->block,
        .t_s = zones_time_s(measured, row),
        .mats = row->mats,
        .start_ft = row->start_ft,
        .end_ft = row->end_ft,
        .wheel_ft = row->wheel_ft,
        .inferred_percent = row->inferred_percent,
        .predicted_lead_s = (double)NAN,
        .predicted_lead_error_s = (double)NAN,
        .predicted_lead_block = STORE_NONE,
        .predicted_lead_made_t_s = (double)NAN,
        .predicted_lead_start_ft = (double)NAN,
        .actual_lead_s = (double)NAN,
        .reason = STORE_NONE,
        .level = STORE_NONE,
        .start_error_ft = (double)NAN,
        .end_error_ft = (double)NAN,
        .predicted_mats = STORE_NONE,
        .predicted_wheel_ft = (double)NAN,
        .predicted_wheel_delay_s = (double)NAN,
    };
    warning.is_path_known = measured->fit_status == MR_OK;
    return warning;
}

const struct store_prediction *zones_find_prediction(const struct store_prediction *row,
                                                     size_t count, int64_t block)
{
    while (count > 0 && row[count - 1].block != block)
        count--;
    return count > 0 ? &row[count - 1] : NULL;
}

/* Loads the message of the predictor that belongs to the block of the first warning. */
static enum mr_status load_warning_reason(struct store *store,
                                          const struct measured_landing *measured,
                                          struct zones *zones, struct error *error)
{
    struct store_prediction *row = NULL;
    size_t count = 0;
    struct zone_warning *warning = &zones->warning;
    enum mr_status status = warning->has_warning
                              ? store_predictions_get(store, measured->landing.id, &row, &count,
                                                      error)
                              : MR_OK;
    const struct store_prediction *found = zones_find_prediction(row, count, warning->block);
    if (found) {
        double arrival_s = measured_arrival_time_s(measured, found->coming_wheel_ft);
        warning->reason = found->reason;
        warning->level = found->level;
        warning->start_error_ft = found->start_error_ft;
        warning->end_error_ft = found->end_error_ft;
        warning->predicted_mats = found->coming_mats;
        warning->predicted_wheel_ft = found->coming_wheel_ft;
        if (!isnan(arrival_s))
            warning->predicted_wheel_delay_s = fmax(arrival_s, warning->t_s) - warning->t_s;
    }
    found = zones_find_prediction(row, count, warning->predicted_lead_block);
    if (found) {
        double ignored,
            speed_ft_s = measured_speed_ft_s(measured, warning->predicted_lead_made_t_s, &ignored);
        warning->predicted_lead_error_s = found->start_error_ft / speed_ft_s;
    }
    free(row);
    return status;
}

static void find_warning(const struct measured_landing *measured, struct zones *zones)
{
    struct zone_warning *warning = &zones->warning;
    for (size_t i = 0; i < zones->count; i++) {
        const struct store_zone *row = &zones->row[i];
        if (row->warning != 1)
            continue;
        if (!warning->has_warning)
            *warning = find_first_warning(measured, row);
        if (isnan(warning->predicted_lead_s) && !isnan(row->lead_s)) {
            warning->predicted_lead_s = row->lead_s;
            warning->predicted_lead_made_t_s = zones_time_s(measured, row);
            warning->predicted_lead_block = row->block;
            warning->predicted_lead_start_ft = row->start_ft;
            warning->actual_lead_s = measured_arrival_time_s(measured, row->start_ft) -
                                     warning->predicted_lead_made_t_s;
        }
        if (row->mats > warning->longest_mats) {
            warning->longest_mats = row->mats;
            warning->longest_start_ft = row->start_ft;
            warning->longest_end_ft = row->end_ft;
        }
    }
}

/* twice the interval of zone messages; during a longer pause, a warning may have been missed */
#define PAUSE_MAX_BLOCKS 100

/* Summarizes the zone messages `row`, which must be sorted by time. */
static struct zones_completeness compute_completeness(const struct measured_landing *measured,
                                                      const struct store_zone *row, size_t count)
{
    const struct store_landing *landing = &measured->landing;
    struct zones_completeness received = {.has_messages = count > 0,
                                          .has_end = landing->state == MR_LANDING_DONE ||
                                                     landing->state == MR_LANDING_IDLE,
                                          .pause_from_s = (double)NAN,
                                          .pause_to_s = (double)NAN,
                                          .origin = measured_origin_text(measured)};
    int64_t longest = PAUSE_MAX_BLOCKS;
    if (count == 0)
        return received;
    received.first_s = measured_block_time_s(measured, row[0].block);
    received.last_s = measured_block_time_s(measured, row[count - 1].block);
    received.is_first_message_late = landing->armed_block == STORE_NONE ||
                                     row[0].block - landing->armed_block > PAUSE_MAX_BLOCKS;
    for (size_t i = 1; i < count; i++) {
        if (row[i].block - row[i - 1].block <= longest)
            continue;
        longest = row[i].block - row[i - 1].block;
        received.pause_from_s = measured_block_time_s(measured, row[i - 1].block);
        received.pause_to_s = measured_block_time_s(measured, row[i].block);
    }
    return received;
}

enum mr_status zones_load(struct store *store, const struct measured_landing *measured,
                          struct zones *zones, struct error *error)
{
    memset(zones, 0, sizeof *zones);
    enum mr_status status = store_zones_get(store, measured->landing.id, &zones->row, &zones->count,
                                            error);
    if (status != MR_OK)
        return status;
    zones->received = compute_completeness(measured, zones->row, zones->count);
    find_warning(measured, zones);
    return load_warning_reason(store, measured, zones, error);
}

void zones_free(struct zones *zones)
{
    free(zones->row);
}

enum mr_status zones_load_survey(struct store *store, int64_t run, struct zones_slack *slack,
                                 struct error *error)
{
    struct store_segment *rows;
    size_t count;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        slack->slack_in[s] = MR_NAN;
    slack->surveyed_segment_count = 0;
    enum mr_status status = store_segments_get(store, run, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (rows[i].segment < 0 || rows[i].segment >= (int64_t)MR_SEGMENTS ||
            isnan(rows[i].slack_in))
            continue;
        slack->slack_in[rows[i].segment] = (float)rows[i].slack_in;
        slack->surveyed_segment_count++;
    }
    free(rows);
    return status;
}

/* largest remaining slack of a segment whose joints are all closed (to 0.001 in each) */
#define CLOSED_JOINTS_MAX_IN 0.009f

/* Returns the station at which a run of closed segments ends; `end` is the first segment that does
 * not belong to it. */
static double find_zone_end_ft(const float *slack_in, const float *remaining_in, unsigned end)
{
    unsigned last = end - 1;
    double open_share = 0.0;
    if (slack_in[last] >= ZONES_CLOSED_SEGMENT_MAX_IN && remaining_in[last] > CLOSED_JOINTS_MAX_IN)
        open_share = (double)(remaining_in[last] / slack_in[last]);
    else if (end < MR_SEGMENTS && slack_in[end] > remaining_in[end])
        open_share = (double)(remaining_in[end] / slack_in[end]) - 1.0;
    return (double)MR_SEGMENT_LENGTH_FT * (end - open_share);
}

void zones_find_longest_zone(const float *slack_in, const float *remaining_in, double wheel_ft,
                             double within_ft, struct mr_closure_zone *zone)
{
    double longest_ft = 0.0;
    *zone = (struct mr_closure_zone){0};
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        unsigned first = s;
        while (s < MR_SEGMENTS && remaining_in[s] < ZONES_CLOSED_SEGMENT_MAX_IN)
            s++;
        if (s == first)
            continue;
        double start_ft = fmax(first * (double)MR_SEGMENT_LENGTH_FT,
                               isnan(wheel_ft) ? 0.0 : wheel_ft),
               end_ft = find_zone_end_ft(slack_in, remaining_in, s);
        unsigned mats = end_ft > start_ft
                          ? (unsigned)((end_ft - start_ft) / (double)MR_MAT_LENGTH_FT + 0.5)
                          : 0;
        if (mats == 0 || start_ft - wheel_ft > within_ft || !(end_ft - start_ft > longest_ft))
            continue;
        longest_ft = end_ft - start_ft;
        *zone = (struct mr_closure_zone){mats, (float)start_ft, (float)end_ft};
    }
}

void zones_compute_remaining_slack(const struct measured_landing *measured,
                                   const struct zones_slack *slack, size_t sample,
                                   float remaining_in[MR_SEGMENTS])
{
    struct mr_closure_zone ignored; /* found with the board's limit */
    float station_ft[MR_TRANSDUCERS];
    float displacement_in[MR_TRANSDUCERS];
    double t_s = measured_time_s(measured, sample);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct measured_channel *channel = &measured->channel[i];
        station_ft[i] = channel->config.station_ft;
        displacement_in[i] = channel->config.kind == MR_KIND_DISPLACEMENT
                               ? (float)measured_moving_mean(measured, channel, sample,
                                                             MEASURED_MEAN_BLOCKS / 2)
                               : MR_NAN;
    }
    struct mr_closure_input input = {
        .station_ft = station_ft,
        .displacement_in = displacement_in,
        .slack_in = slack->slack_in,
        .wheel_ft = (float)measured_station_ft(measured, t_s),
    };
    mr_closure_find_zone(&input, &ignored, remaining_in);
}

/* ---- answer ---- */

static const char *get_label_if_known(const char *label, double value)
{
    return isnan(value) ? NULL : label;
}

static void add_warning_reason(const struct zone_warning *w, struct answer *answer)
{
    if (w->reason == STORE_NONE)
        answer_add_missing_value(answer, "reason", NULL, "");
    else
        answer_add_text(answer, "reason", "reason", "%s",
                        mr_predictor_reason_text((unsigned)w->reason));
    if (w->level == STORE_NONE)
        answer_add_missing_value(answer, "level", NULL, "");
    else
        answer_add_text(answer, "level", "model", "%s",
                        mr_predictor_level_text((unsigned)w->level));
    answer_add_count(answer, "coming_mats", w->predicted_mats > 0 ? "zone predicted, mats" : NULL,
                     w->predicted_mats);
    answer_add_value(answer, "coming_wheel", w->predicted_mats > 0 ? "with the wheel at" : NULL,
                     UNIT_STATION, w->predicted_wheel_ft, 1)
        ->digits = 9;
    answer_add_value(answer, "coming_after", NULL, UNIT_TIME, w->predicted_wheel_delay_s, 3);
}

static const char *get_not_reached_text(const struct zone_warning *w)
{
    return w->is_path_known ? "none, because the gear stopped before this zone"
                            : "unknown, because the record does not show where the gear stopped";
}

/* Adds the board's own prediction. It is not the lead time to 50 closed mats (record.h). */
static void add_lead_time(const struct zone_warning *w, struct answer *answer)
{
    const char *label = get_label_if_known("predicted time to zone", w->predicted_lead_s);
    const bool is_at_zone = w->predicted_lead_s <= fmax(0.0, w->predicted_lead_error_s);
    answer_add_estimate(answer, "time_to_zone", is_at_zone ? NULL : label, UNIT_TIME,
                        w->predicted_lead_s, w->predicted_lead_error_s, 2);
    if (is_at_zone)
        answer_add_text(answer, NULL, label, "none: the wheel was at the zone");
    if (isfinite(w->predicted_lead_s) && isfinite(w->actual_lead_s))
        answer_append_remark(answer, ", reported at %.2f s; actual %.2f s",
                             w->predicted_lead_made_t_s, w->actual_lead_s);
    else if (isfinite(w->predicted_lead_s))
        answer_append_remark(answer, ", reported at %.2f s; actual: %s", w->predicted_lead_made_t_s,
                             get_not_reached_text(w));
    answer_add_value(answer, "time_to_zone_t", NULL, UNIT_TIME, w->predicted_lead_made_t_s, 3)
        ->digits = 9;
    answer_add_value(answer, "time_to_zone_start", NULL, UNIT_STATION, w->predicted_lead_start_ft,
                     1)
        ->digits = 9;
    if (isnan(w->actual_lead_s))
        answer_add_missing_value(answer, "actual_time_to_zone_s", NULL, get_not_reached_text(w));
    else
        answer_add_value(answer, "actual_time_to_zone", NULL, UNIT_TIME, w->actual_lead_s, 3);
}

/* Adds the content of a warning. */
static void add_warning(const struct zone_warning *w, struct answer *answer)
{
    answer_add_value(answer, "t", NULL, UNIT_TIME, w->t_s, 3)->digits = 9;
    answer_add_count(answer, "decided_block", NULL, w->block);
    add_warning_reason(w, answer);
    answer_add_count(answer, "mats", "closed zone, mats", w->mats);
    answer_add_estimate(answer, "start", "from station", UNIT_STATION, w->start_ft,
                        w->start_error_ft, 1)
        ->digits = 9;
    answer_add_estimate(answer, "end", "to station", UNIT_STATION, w->end_ft, w->end_error_ft, 1)
        ->digits = 9;
    answer_add_value(answer, "wheel", get_label_if_known("wheel was at", w->wheel_ft), UNIT_STATION,
                     w->wheel_ft, 1)
        ->digits = 9;
    answer_add_count(answer, "inferred_percent", NULL, w->inferred_percent);
    if (w->inferred_percent > 0)
        answer_add_text(answer, NULL, "inferred",
                        "%lld %% of the zone was inferred from the survey alone",
                        (long long)w->inferred_percent);
    add_lead_time(w, answer);
    answer_add_count(answer, "most_mats", "zone warned of, mats", w->longest_mats);
    answer_add_value(answer, "most_start", "zone warned of, start", UNIT_STATION,
                     w->longest_start_ft, 1)
        ->digits = 9;
    answer_add_value(answer, "most_end", "zone warned of, end", UNIT_STATION, w->longest_end_ft, 1)
        ->digits = 9;
}

/* Writes "no warning", or the reason why a warning may have been missed. */
static void format_no_warning(const struct zones *zones, char out[NO_WARNING_TEXT_SIZE])
{
    char doubt[ZONES_REASON_SIZE];
    if (zones_format_missed_warning_reason(&zones->received, (double)INFINITY, doubt))
        snprintf(out, NO_WARNING_TEXT_SIZE,
                 "no warning was received, but one may have been sent: %s", doubt);
    else
        snprintf(out, NO_WARNING_TEXT_SIZE, "no warning");
}

bool zones_format_earlier_warning_reason(const struct zones *zones, char out[ZONES_REASON_SIZE])
{
    const struct zone_warning *w = &zones->warning;
    return w->has_warning && zones_format_missed_warning_reason(&zones->received, w->t_s, out);
}

/* Adds whether and when the board warned, and a note if the record may lack a warning. */
static void add_warning_status(const struct zones *zones, struct answer *answer)
{
    const struct zone_warning *w = &zones->warning;
    char when[MOMENT_TEXT_SIZE], quiet[NO_WARNING_TEXT_SIZE], doubt[ZONES_REASON_SIZE];
    format_no_warning(zones, quiet);
    if (w->has_warning)
        answer_add_text(answer, NULL, "zone", "warned %s, decided in block %lld",
                        format_moment(w->t_s, zones->received.origin, when), (long long)w->block)
            ->is_warning = true;
    else
        answer_add_text(answer, NULL, "zone", "%s", quiet)->is_warning =
            zones_format_missed_warning_reason(&zones->received, (double)INFINITY, doubt);
    if (zones_format_earlier_warning_reason(zones, doubt))
        answer_add_text(answer, NULL, "zone", "an earlier warning may have been missed: %s", doubt)
            ->is_warning = true;
}

void zones_add_warning_status(const struct zones *zones, bool has_board, struct answer *answer)
{
    if (has_board)
        add_warning_status(zones, answer);
    else
        answer_add_text(
            answer, NULL, "zone",
            "no board recorded this landing: the readings are from a different instrument");
}

void zones_to_answer(const struct zones *zones, bool has_board, struct answer *answer)
{
    const struct zone_warning *w = &zones->warning;
    const struct zones_completeness *received = &zones->received;
    char doubt[ZONES_REASON_SIZE];
    zones_add_warning_status(zones, has_board, answer);
    bool first = !zones_format_earlier_warning_reason(zones, doubt);
    answer_open_group(answer, "zone",
                      !w->has_warning ? NULL
                      : first ? "first warning as the board reported it (+- is one standard error)"
                              : "first warning received (+- is one standard error)");
    answer_add_flag(answer, "warned", NULL, w->has_warning);
    answer_add_flag(answer, "all_heard", NULL,
                    has_board &&
                        !zones_format_missed_warning_reason(received, (double)INFINITY, doubt));
    answer_add_value(answer, "unheard_from", NULL, UNIT_TIME, received->pause_from_s, 3)->digits =
        9;
    answer_add_value(answer, "unheard_to", NULL, UNIT_TIME, received->pause_to_s, 3)->digits = 9;
    if (w->has_warning)
        add_warning(w, answer);
    answer_close_group(answer);
}

static void append_reason(char out[ZONES_REASON_SIZE], const char *text)
{
    size_t used = strlen(out);
    snprintf(out + used, ZONES_REASON_SIZE - used, "%s%s", used ? "; " : "", text);
}

bool zones_format_missed_warning_reason(const struct zones_completeness *received, double before_s,
                                        char out[ZONES_REASON_SIZE])
{
    char text[160], when[MOMENT_TEXT_SIZE];
    out[0] = '\0';
    if (!received->has_messages) {
        append_reason(out, "the record has no zone messages from the board");
        return true;
    }
    if (received->is_first_message_late) {
        snprintf(text, sizeof text, "no zone message was received until %s",
                 format_moment(received->first_s, received->origin, when));
        append_reason(out, text);
    }
    if (received->pause_from_s < before_s) {
        snprintf(text, sizeof text, "no zone message was received from %.3f to %.3f s after %s",
                 received->pause_from_s, received->pause_to_s, received->origin);
        append_reason(out, text);
    }
    if (!received->has_end && isinf(before_s)) {
        snprintf(text, sizeof text,
                 "the record ends %s, before the board reported the end of the landing",
                 format_moment(received->last_s, received->origin, when));
        append_reason(out, text);
    }
    return out[0] != '\0';
}

/* ---- inputs of the predictor ---- */

/* for this time after arming, missing transducers are ignored, because their zeros are being
 * determined (0.2 s) */
#define SETTLING_BLOCKS 500

static void extend_condition_span(struct predictor_span *span, double t_s)
{
    if (isnan(span->from_s))
        span->from_s = t_s;
    span->to_s = t_s;
}

/* Updates the conditions from a message of the predictor. Missing motion counts only at the
 * kinematic level, because there is none before the first switches. */
static void update_conditions(struct predictor_inputs *inputs, const struct store_prediction *row,
                              double t_s)
{
    if (row->basis == STORE_NONE || row->level == STORE_NONE)
        return;
    bool kinematic = row->level == MR_PREDICTOR_KINEMATIC && row->basis & MR_PREDICTOR_NO_MOTION;
    const bool lacks[PREDICTOR_CONDITION_COUNT] = {row->basis & MR_PREDICTOR_NO_TRANSDUCER,
                                                   kinematic, row->basis & MR_PREDICTOR_DEGRADED,
                                                   row->basis & MR_PREDICTOR_RESTARTED};
    for (unsigned i = 0; i < PREDICTOR_CONDITION_COUNT; i++) {
        if (lacks[i])
            extend_condition_span(&inputs->condition_span[i], t_s);
    }
    if (lacks[PREDICTOR_COARSE_MODEL] && row->level > inputs->worst_level)
        inputs->worst_level = row->level;
}

static void update_excluded_transducers(struct predictor_inputs *inputs,
                                        const struct measured_landing *measured,
                                        const struct store_trust *row)
{
    double t_s = measured_block_time_s(measured, row->block);
    for (unsigned i = 0; i < MR_TRANSDUCERS && row->doubts != STORE_NONE; i++) {
        unsigned why = (unsigned)row->doubts >> 2 * i & 3u;
        inputs->is_still_excluded[i] = why != 0;
        if (!why || measured->channel[i].config.kind != MR_KIND_DISPLACEMENT)
            continue;
        inputs->exclusion_reason[i] = why;
        extend_condition_span(&inputs->excluded_span[i], t_s);
    }
    if (!isnan(row->resistance))
        inputs->resistance_ratio = row->resistance;
}

static enum mr_status load_max_risk(struct store *store, const struct measured_landing *measured,
                                    struct predictor_inputs *inputs, struct error *error)
{
    struct store_risk *rows = NULL;
    size_t count = 0;
    inputs->max_risk = inputs->max_risk_s = inputs->off_plan_s = (double)NAN;
    enum mr_status status = store_risks_get(store, measured->landing.id, &rows, &count, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        double t_s = measured_block_time_s(measured, rows[i].block);
        unsigned basis = rows[i].basis == STORE_NONE ? 0u : (unsigned)rows[i].basis;
        inputs->is_chart_outdated |= (basis & MR_RISK_CHART_OUTDATED) != 0;
        if (basis & MR_RISK_PLAN_NOT_FOLLOWED && isnan(inputs->off_plan_s))
            inputs->off_plan_s = t_s;
        if (isnan(rows[i].risk) || (!isnan(inputs->max_risk) && rows[i].risk <= inputs->max_risk))
            continue;
        inputs->max_risk = rows[i].risk;
        inputs->max_risk_s = t_s;
        inputs->risk_basis = basis;
    }
    free(rows);
    return status;
}

enum mr_status predictor_inputs_load(struct store *store, const struct measured_landing *measured,
                                     struct predictor_inputs *inputs, struct error *error)
{
    struct store_prediction *rows = NULL;
    struct store_trust *trusts = NULL;
    struct mr_predictor_state state;
    size_t count = 0, trust_count = 0;
    bool exists = false;
    *inputs = (struct predictor_inputs){.runway_source = STORE_NONE,
                                        .resistance_ratio = (double)NAN};
    for (unsigned i = 0; i < PREDICTOR_CONDITION_COUNT; i++)
        inputs->condition_span[i].from_s = (double)NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        inputs->excluded_span[i].from_s = (double)NAN;
    enum mr_status status =
        store_predictions_get(store, measured->landing.id, &rows, &count, error) ?:
        store_trusts_get(store, measured->landing.id, &trusts, &trust_count, error) ?:
        store_runway_get(store, measured->landing.id, &state, &inputs->runway_source, &exists,
                         error) ?:
        load_max_risk(store, measured, inputs, error);
    if (status == MR_OK) {
        inputs->message_count = count;
        inputs->history_landings = exists ? state.landing_count : 0;
        inputs->runway_source = exists ? inputs->runway_source : STORE_NONE;
        int64_t settled = count ? rows[0].block + SETTLING_BLOCKS : 0;
        for (size_t i = 0; i < count; i++) {
            if (rows[i].block >= settled)
                update_conditions(inputs, &rows[i], measured_block_time_s(measured, rows[i].block));
        }
        for (size_t i = 0; i < trust_count; i++) {
            if (trusts[i].block >= settled)
                update_excluded_transducers(inputs, measured, &trusts[i]);
        }
    }
    free(rows);
    free(trusts);
    return status;
}

#define PREDICTOR_LABEL "predictor"

static void add_runway_state(const struct predictor_inputs *inputs, struct answer *answer)
{
    char after[40] = "", resists[80] = "";
    if (inputs->history_landings)
        snprintf(after, sizeof after, ", after %u landing%s", inputs->history_landings,
                 inputs->history_landings == 1 ? "" : "s");
    if (!isnan(inputs->resistance_ratio))
        snprintf(resists, sizeof resists, "; joint resistance %.2f times the configured value",
                 inputs->resistance_ratio);
    answer_add_text(answer, NULL, PREDICTOR_LABEL, "runway state at arming: %s%s%s",
                    inputs->runway_source == STORE_NONE
                        ? "not reported"
                        : mr_runway_source_text((unsigned)inputs->runway_source),
                    after, resists);
}

static void add_condition(const struct predictor_inputs *inputs, enum predictor_condition lack,
                          struct answer *answer)
{
    static const char *const words[] = {
        [PREDICTOR_WITHOUT_TRANSDUCERS] = "no transducer corrects the model: zones are predicted "
                                          "only from switches, survey and earlier landings",
        [PREDICTOR_WITHOUT_MOTION] = "no switch measures the position of the gear: zones are "
                                     "predicted only from transducers and survey, without times",
        [PREDICTOR_RESTARTED] = "the model diverged and was restarted from the last survey or "
                                "landing: do not rely on the zones predicted",
    };
    const struct predictor_span *span = &inputs->condition_span[lack];
    if (isnan(span->from_s))
        return;
    if (lack == PREDICTOR_COARSE_MODEL)
        answer_add_text(answer, NULL, PREDICTOR_LABEL,
                        "the ends of zones are less certain from %.3f to %.3f s, because the "
                        "update limit (predict.updates_per_block) or a backlog made the model "
                        "coarser (%s instead of every mat)",
                        span->from_s, span->to_s,
                        mr_predictor_level_text((unsigned)inputs->worst_level));
    else
        answer_add_text(answer, NULL, PREDICTOR_LABEL, "%s; from %.3f to %.3f s", words[lack],
                        span->from_s, span->to_s);
}

static void add_excluded_transducers(const struct predictor_inputs *inputs,
                                     const struct measured_landing *measured, unsigned i,
                                     struct answer *answer)
{
    const struct unit *station = unit_get(UNIT_STATION, answer_is_si(answer));
    const struct predictor_span *span = &inputs->excluded_span[i];
    char until[40] = " on";
    if (isnan(span->from_s))
        return;
    if (!inputs->is_still_excluded[i])
        snprintf(until, sizeof until, " to %.3f s", span->to_s);
    answer_add_text(
        answer, NULL, PREDICTOR_LABEL,
        "transducer %u (%.1f %s) was left out: %s, from %.3f s%s; zones near it rely on "
        "the neighbouring transducers and the model",
        i + 1u, (double)measured->channel[i].config.station_ft * station->factor, station->text,
        mr_predictor_doubt_text(inputs->exclusion_reason[i]), span->from_s, until);
}

static void add_risk(const struct predictor_inputs *inputs, struct answer *answer)
{
    if (isnan(inputs->max_risk))
        return;
    answer_add_text(
        answer, NULL, PREDICTOR_LABEL, "largest risk of a zone of %u mats: %.2f, at %.3f s%s%s",
        MR_PREDICTOR_WARNING_MATS, inputs->max_risk, inputs->max_risk_s,
        inputs->risk_basis & MR_RISK_CHART_USED  ? ", computed with chart and plan"
        : inputs->risk_basis & MR_RISK_PLAN_USED ? ", computed with the plan but without a chart"
                                                 : ", computed without plan and chart",
        inputs->risk_basis & MR_RISK_NO_TRANSDUCER ? ", without a valid transducer" : "");
    if (!isnan(inputs->off_plan_s))
        answer_add_text(answer, NULL, PREDICTOR_LABEL,
                        "the board detected at %.3f s that the landing differs from the plan: "
                        "later risks do not use the plan",
                        inputs->off_plan_s);
    if (inputs->is_chart_outdated)
        answer_add_text(answer, NULL, PREDICTOR_LABEL,
                        "the loaded chart was ignored: it was computed for a different runway or "
                        "number of landings");
}

void predictor_inputs_to_answer(const struct predictor_inputs *inputs,
                                const struct measured_landing *measured, struct answer *answer)
{
    answer_open_list(answer, "predictor", "");
    if (inputs->message_count)
        add_runway_state(inputs, answer);
    for (unsigned i = 0; inputs->message_count && i < PREDICTOR_CONDITION_COUNT; i++)
        add_condition(inputs, (enum predictor_condition)i, answer);
    for (unsigned i = 0; inputs->message_count && i < MR_TRANSDUCERS; i++)
        add_excluded_transducers(inputs, measured, i, answer);
    if (inputs->message_count)
        add_risk(inputs, answer);
    answer_close_group(answer);
}
