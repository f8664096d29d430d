/* Contents of a report: the landings with their samples, one at a time, and the facts of each
 * landing for the front page. */
#include <math.h>
#include <sha2.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/board/config_text.h"
#include "host/report/report.h"
#include "host/store/store_journal.h"

const char *report_problem_text(unsigned i)
{
    static const char *const text[REPORT_PROBLEM_COUNT] = {
        "a wave was seen",
        "a break was seen",
        "missed or late warning",
        "false warning",
        "the first switch edges are missing",
        "speed or stop is unknown",
        "a transducer or gage was not valid",
        "the board reported a fault",
        "frames were lost, or a link was silent",
        "NO-GO in the check before the landing",
    };
    return i < REPORT_PROBLEM_COUNT ? text[i] : "";
}

/* ---- movement and tension ---- */

static void set_movement(const struct measured_landing *measured, struct report_facts *facts)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        int c = measured_channel_index(measured, MR_KIND_DISPLACEMENT, i + 1);
        const double none = (double)NAN;
        facts->movement[i] = (struct report_movement){none, none, none, none, none};
        if (c < 0)
            continue;
        const struct measured_channel *channel = &measured->channel[c];
        facts->movement[i] = (struct report_movement){(double)channel->config.station_ft,
                                                      channel->peak, channel->peak_error,
                                                      channel->end, channel->end_error};
    }
}

static void set_band_tensions(const struct measured_landing *measured, struct report_facts *facts)
{
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        unsigned band = channel->config.band;
        if (channel->config.kind != MR_KIND_TENSION || band == 0 || band > REPORT_BANDS_MAX ||
            isnan(channel->baseline) || isnan(channel->low))
            continue;
        struct report_band *change = &facts->band[band - 1];
        change->fall_lb += channel->low - channel->baseline;
        change->rise_lb += channel->high - channel->baseline;
        change->tension_fall_error_lb = hypot(change->tension_fall_error_lb, channel->low_error);
        change->tension_rise_error_lb = hypot(change->tension_rise_error_lb, channel->high_error);
        change->gage_count++;
    }
    for (unsigned b = 0; b < REPORT_BANDS_MAX; b++) {
        double gages = facts->band[b].gage_count ? (double)facts->band[b].gage_count : (double)NAN;
        facts->band[b].fall_lb /= gages;
        facts->band[b].rise_lb /= gages;
        facts->band[b].tension_fall_error_lb /= gages;
        facts->band[b].tension_rise_error_lb /= gages;
    }
}

/* ---- zones ---- */

/* The board sends the errors of a zone with the same block. */
static struct report_zone convert_zone(const struct report_landing *landing,
                                       const struct store_zone *row)
{
    const double none = (double)NAN;
    struct report_zone zone = {0, none, none, none, none};
    if (!row || row->mats <= 0)
        return zone;
    zone.mats = row->mats;
    zone.start_ft = row->start_ft;
    zone.end_ft = row->end_ft;
    const struct store_prediction *prediction =
        zones_find_prediction(landing->prediction, landing->prediction_count, row->block);
    if (prediction) {
        zone.start_error_ft = prediction->start_error_ft;
        zone.end_error_ft = prediction->end_error_ft;
    }
    return zone;
}

static void set_zones(const struct report_landing *landing, struct report_facts *facts)
{
    const struct measured_landing *measured = &landing->summary.measured;
    const struct zones *zones = &landing->summary.zones;
    const struct store_zone *longest = NULL, *warned = NULL;
    char why[ZONES_REASON_SIZE];
    facts->zone_report_count = zones->count;
    facts->warning = zones->warning;
    facts->may_have_missed_warning = zones_format_missed_warning_reason(&zones->received,
                                                                        (double)INFINITY, why);
    for (size_t i = 0; i < zones->count; i++) {
        if (zones->row[i].mats > 0 && (!longest || zones->row[i].mats > longest->mats))
            longest = &zones->row[i];
        if (zones->row[i].warning == 1 && (!warned || zones->row[i].mats > warned->mats))
            warned = &zones->row[i];
    }
    facts->longest_zone = convert_zone(landing, longest);
    facts->longest_warned_zone = convert_zone(landing, warned);
    facts->last_zone = convert_zone(landing, zones->count ? &zones->row[zones->count - 1] : NULL);
    facts->worst_predictor_verdict = STORE_NONE;
    for (size_t i = 0; i < landing->prediction_count; i++) {
        if (landing->prediction[i].verdict > facts->worst_predictor_verdict)
            facts->worst_predictor_verdict = landing->prediction[i].verdict;
    }
    if (measured->samples == 0)
        return;
    float remaining_in[MR_SEGMENTS];
    zones_compute_remaining_slack(measured, &landing->survey, measured->samples - 1, remaining_in);
    for (unsigned s = 0; s < MR_SEGMENTS && s < 64; s++)
        facts->closed_segments |= remaining_in[s] < ZONES_CLOSED_SEGMENT_MAX_IN ? 1ull << s : 0ull;
}

/* ---- comparison ---- */

static struct compare_overlap find_overlap(const struct compare_zones *zones, bool rest, bool board)
{
    const struct compare_zone_moment *moment = compare_find_moment(zones, rest);
    return !moment ? (struct compare_overlap){.is_known = false}
         : board   ? moment->board_overlap
                   : moment->simulated_overlap;
}

static void set_comparison(const struct report_landing *landing, struct report_facts *facts)
{
    const struct compare_figures *figures = landing->comparison;
    if (!figures)
        return;
    snprintf(facts->comparison.compared_with, sizeof facts->comparison.compared_with, "%s",
             figures->model_file);
    facts->comparison.channel_count = figures->channel_count;
    facts->comparison.mean = compare_compute_means(figures);
    facts->comparison.at_longest_zone = find_overlap(&figures->zones, false, false);
    facts->comparison.board_at_longest_zone = find_overlap(&figures->zones, false, true);
    facts->comparison.at_rest = find_overlap(&figures->zones, true, false);
    facts->comparison.solver_error_in = figures->solver_error_in;
}

/* ---- problems ---- */

static unsigned find_problems(const struct summary *summary, const struct report_facts *facts)
{
    unsigned wrong = (facts->is_incomplete ? REPORT_MISSING_EDGES : 0u) |
                     (facts->has_motion_fit ? 0u : REPORT_UNKNOWN_STOP) |
                     (summary->fault_count ? REPORT_BOARD_FAULT : 0u) |
                     (facts->lost_frames ? REPORT_LOST_FRAMES : 0u);
    for (int kind = 0; kind < LINK_KINDS; kind++)
        wrong |= summary->link[kind].is_used && summary->link[kind].was_silent ? REPORT_LOST_FRAMES
                                                                               : 0u;
    for (size_t i = 0; i < summary->channel_event_count; i++)
        wrong |= summary->channel_event[i].code != MR_VALID ? REPORT_INVALID_CHANNEL : 0u;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &summary->measured.channel[c];
        if (summary->measured.samples && mr_channel_is_sensor(&channel->config) &&
            channel->valid_samples == 0)
            wrong |= REPORT_INVALID_CHANNEL;
    }
    for (int kind = 0; kind < (int)SUMMARY_READY_CHECK_COUNT; kind++)
        wrong |= summary->ready_check[kind].is_known && !summary->ready_check[kind].is_go
                   ? REPORT_CHECK_NO_GO
                   : 0u;
    return wrong;
}

/* ---- all facts ---- */

/* Sets a digest that is equal for landings with the same calibration. */
static void set_calibration(const struct report_landing *landing, struct report_facts *facts)
{
    const struct measured_landing *measured = &landing->summary.measured;
    SHA2_CTX hash;
    SHA256Init(&hash);
    SHA256Update(&hash, (const uint8_t *)&measured->landing.config_crc,
                 sizeof measured->landing.config_crc);
    for (unsigned i = 0; i < MR_CHANNELS; i++)
        SHA256Update(&hash, (const uint8_t *)&measured->channel[i].config.unit_per_code,
                     sizeof measured->channel[i].config.unit_per_code);
    SHA256End(&hash, facts->calibration_hash);
}

static void set_site(const struct report_landing *landing, struct report_facts *facts)
{
    const struct summary *summary = &landing->summary;
    snprintf(facts->can_link, sizeof facts->can_link, "%s", summary->session.can_link);
    snprintf(facts->serial_link, sizeof facts->serial_link, "%s", summary->session.serial_link);
    facts->has_config = landing->config != NULL;
    for (unsigned i = 0; landing->config && i < MR_CHANNELS; i++) {
        const struct mr_channel_config *channel = &landing->config->channel[i];
        facts->sensor_count += mr_channel_is_sensor(channel);
        facts->serial_number_count += mr_channel_is_sensor(channel) && channel->serial[0];
    }
    if (landing->config)
        snprintf(facts->site, sizeof facts->site, "%.*s", (int)sizeof landing->config->site[0].name,
                 landing->config->site[0].name);
}

static void set_facts(const struct report_landing *landing, struct report_facts *facts)
{
    const struct summary *summary = &landing->summary;
    const struct measured_landing *measured = &summary->measured;
    const struct mr_estimate none = {(double)NAN, (double)NAN};
    facts->landing = measured->landing;
    facts->series = landing->series;
    facts->source = measured->source;
    facts->is_incomplete = measured->is_start_missing;
    facts->is_emulated = measured_is_emulated(&measured->landing);
    facts->quality_text = measured_quality_text(measured);
    facts->recalibrated_channels = measured->recalibrated_channels;
    facts->has_motion_fit = measured->fit_status == MR_OK;
    facts->gate_count = measured->gate_count;
    facts->switch_count = measured->switch_count;
    facts->command_rights = summary->key_state_count
                              ? mr_key_state_text((unsigned)summary->key_state->code)
                              : NULL;
    facts->surveyed_segment_count = landing->survey.surveyed_segment_count;
    facts->speed_ft_s = facts->has_motion_fit ? measured->summary.touchdown_speed_ft_s : none;
    facts->deceleration_ft_s2 = facts->has_motion_fit ? measured->summary.mean_deceleration_ft_s2
                                                      : none;
    facts->stop_ft = facts->has_motion_fit ? measured->summary.stop_station_ft : none;
    facts->lost_frames = summary->link[LINK_CAN].lost_frames +
                         summary->link[LINK_SERIAL].lost_frames;
    set_movement(measured, facts);
    set_band_tensions(measured, facts);
    set_zones(landing, facts);
    set_comparison(landing, facts);
    set_calibration(landing, facts);
    set_site(landing, facts);
    facts->problems = find_problems(summary, facts);
}

/* ---- loading ---- */

/* Loads the configuration that was active when the landing was armed, if its text is stored and
 * valid. */
static enum mr_status load_config(struct store *store, struct report_landing *landing,
                                  struct error *error)
{
    int64_t crc = landing->summary.measured.landing.config_crc;
    /* treat an invalid text as unknown: another version of matrig may have written it */
    struct error ignored = {0};
    char *text = NULL;
    if (crc == STORE_NONE)
        return MR_OK;
    enum mr_status status = store_configuration_get(store, (uint32_t)crc, &text, error);
    if (status == MR_OK && text) {
        landing->config = xmalloc(sizeof *landing->config);
        if (config_text_read(text, "configuration", landing->config, &ignored) != MR_OK) {
            free(landing->config);
            landing->config = NULL;
        }
    }
    free(text);
    return status;
}

static enum mr_status load_landing(struct store *store, const struct store_landing *row,
                                   struct report_landing *landing, struct error *error)
{
    return summary_load(store, row->id, &landing->summary, error) ?:
           zones_load_survey(store, row->id, &landing->survey, error) ?:
           store_landing_series_get(store, row, &landing->series, error) ?:
           store_motions_get(store, row->id, &landing->motion, &landing->motion_count, error) ?:
           store_predictions_get(store, row->id, &landing->prediction, &landing->prediction_count,
                             error) ?:
           store_simulations_get(store, row->id, &landing->simulation, &landing->simulation_count,
                             error) ?:
           store_simulation_summary_get(store, row->id, &landing->simulation_summary, error) ?:
           load_config(store, landing, error);
}

/* Computes the wheel's position at each sample, and the figures of the newest comparison. The
 * figures are computed again, because a calibration may have changed since the comparison. */
static void compute_derived_data(struct report_landing *landing)
{
    const struct measured_landing *measured = &landing->summary.measured;
    const struct compare_board_reports reported = {.zone = landing->summary.zones.row,
                                                   .zone_count = landing->summary.zones.count};
    if (measured->fit_status != MR_OK || measured->samples == 0)
        return;
    landing->station_ft = xmalloc(measured->samples * sizeof *landing->station_ft);
    for (size_t i = 0; i < measured->samples; i++)
        landing->station_ft[i] = measured_station_ft(measured, measured_time_s(measured, i));
    if (landing->simulation_count == 0)
        return;
    landing->comparison = xmalloc(sizeof *landing->comparison);
    compare_compute_figures(measured, &landing->survey, &reported, &landing->simulation_summary,
                            landing->simulation, landing->simulation_count, landing->comparison);
}

/* Loads the weight that the user entered. */
static enum mr_status load_weight(struct store *store, int64_t run, struct mr_estimate *weight_lb,
                                  struct error *error)
{
    char text[STORE_JOURNAL_TEXT_SIZE];
    enum mr_status status = store_change_get(store, run, "weight_lb", text, NULL, error);
    weight_lb->value = status == MR_OK && text[0] ? strtod(text, NULL) : (double)NAN;
    weight_lb->error = (double)NAN;
    return status;
}

/* Loads the facts that are in the database. */
static enum mr_status load_facts(struct report *report, const struct report_landing *landing,
                                 struct report_facts *facts, struct error *error)
{
    const struct measured_landing *measured = &landing->summary.measured;
    const struct outcome_record_landing given = {measured, &landing->summary.zones};
    memset(facts, 0, sizeof *facts);
    set_facts(landing, facts);
    return load_weight(report->store, measured->landing.id, &facts->weight_lb, error)
             ?: outcome_record_evaluate(report->store, &report->record, &given, error);
}

/* Set the outcome of the landing's warnings. */
static void set_outcome(struct report *report, struct report_facts *facts)
{
    const struct outcome_record_row *row = outcome_record_find_row(&report->record,
                                                                   facts->landing.id);
    if (!row)
        return;
    facts->warning_record = *row;
    snprintf(facts->outcome_reason, sizeof facts->outcome_reason, "%s",
             row->unknown_reason ? row->unknown_reason : "");
    facts->problems |= (row->outcome.wave_count ? REPORT_OBSERVED_WAVE : 0u) |
                       (row->outcome.break_count ? REPORT_OBSERVED_BREAK : 0u) |
                       (row->warning_outcome == WARNING_MISS || row->warning_outcome == WARNING_LATE
                            ? REPORT_MISSED_WARNING
                            : 0u) |
                       (row->warning_outcome == WARNING_FALSE_ALARM ? REPORT_FALSE_WARNING : 0u);
}

enum mr_status report_landing_load(struct report *report, size_t at, struct report_landing *landing,
                                   struct error *error)
{
    struct report_facts *facts = &report->facts[at];
    memset(landing, 0, sizeof *landing);
    enum mr_status status = load_landing(report->store, &report->row[at], landing, error);
    if (status == MR_OK) {
        compute_derived_data(landing);
        status = load_facts(report, landing, facts, error);
    }
    if (status != MR_OK)
        return status;
    set_outcome(report, facts);
    bool listed = false;
    for (size_t i = 0; i < at && !listed; i++)
        listed = strcmp(report->facts[i].calibration_hash, facts->calibration_hash) == 0;
    if (!listed)
        report_add_calibration(landing, report->calibrations);
    return MR_OK;
}

const struct report_movement *report_find_largest_movement(const struct report_facts *facts)
{
    const struct report_movement *largest = NULL;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct report_movement *moved = &facts->movement[i];
        if (!isnan(moved->peak_in) && (!largest || fabs(moved->peak_in) > fabs(largest->peak_in)))
            largest = moved;
    }
    return largest;
}

enum mr_status report_begin(struct report *report, bool voided, struct error *error)
{
    struct store_landing one;
    size_t count = 0;
    enum mr_status status = MR_OK;
    if (report->run)
        status = store_landing_get(report->store, report->run, &one, error);
    if (status == MR_OK)
        status = store_landings_get(report->store, &report->row, &count, error);
    if (status == MR_OK)
        status = outcome_record_begin(report->store, &report->record, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        bool is_void = false;
        if (report->run && report->row[i].id != report->run)
            continue;
        status = store_is_void(report->store, report->row[i].id, &is_void, NULL, error);
        if (is_void && !voided)
            report->voided_landings++;
        else
            report->row[report->landings++] = report->row[i];
    }
    report->facts = xcalloc(report->landings + 1, sizeof *report->facts);
    return status ?: inspection_load(report->store, &report->records, error)
                  ?: store_slow_log_get(report->store, NULL, &report->slow_reading,
                                     &report->slow_count, error);
}

void report_landing_free(struct report_landing *landing)
{
    summary_free(&landing->summary);
    free(landing->motion);
    free(landing->prediction);
    free(landing->config);
    free(landing->station_ft);
    free(landing->comparison);
    store_simulations_free(landing->simulation, landing->simulation_count);
    free(landing->simulation_summary.segments_in);
    memset(landing, 0, sizeof *landing);
}

void report_free(struct report *report)
{
    outcome_record_free(&report->record);
    inspection_free(&report->records);
    free(report->row);
    free(report->facts);
    free(report->slow_reading);
    report->row = NULL;
    report->facts = NULL;
    report->slow_reading = NULL;
}
