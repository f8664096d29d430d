#include "host/analyse/summary.h"

#include <stdlib.h>
#include <string.h>

#include "common/fault.h"
#include "host/analyse/measured_source.h"
#include "host/analyse/summary_held.h"
#include "host/analyse/summary_links.h"
#include "host/analyse/summary_missing.h"
#include "host/analyse/summary_time.h"
#include "host/base/units.h"

enum mr_status summary_load(struct store *store, int64_t run, struct summary *summary,
                            struct error *error)
{
    memset(summary, 0, sizeof *summary);
    enum mr_status status = measured_load(store, run, &summary->measured, error);
    if (status == MR_OK)
        status = zones_load(store, &summary->measured, &summary->zones, error);
    if (status == MR_OK)
        status = foresight_load(store, &summary->measured, &summary->foresight, error);
    if (status == MR_OK)
        status = store_session_get(store, summary->measured.landing.session, &summary->session,
                                   error);
    if (status == MR_OK)
        status = store_import_get(store, summary->measured.landing.session, &summary->import,
                                  &summary->imported, error);
    if (status == MR_OK)
        status = summary_links_load(store, summary, error);
    if (status == MR_OK)
        status = summary_time_load(store, summary, error);
    if (status == MR_OK)
        status = store_faults(store, &summary->measured.landing, &summary->fault, &summary->faults,
                              error);
    if (status == MR_OK)
        status = store_switch_events(store, run, &summary->switch_event, &summary->switch_events,
                                     error);
    if (status == MR_OK)
        status = store_channel_events(store, run, &summary->channel_event, &summary->channel_events,
                                      error);
    if (status == MR_OK)
        status = bands_load(store, &summary->measured, &summary->bands, error);
    if (status == MR_OK)
        status = summary_mean_load(store, run, summary->mean, error);
    if (status == MR_OK)
        status = summary_ready_load(store, &summary->measured.landing, summary->ready, error);
    return status;
}

void summary_free(struct summary *summary)
{
    measured_free(&summary->measured);
    zones_free(&summary->zones);
    bands_free(&summary->bands);
    film_free(&summary->film);
    free(summary->import.mapping);
    free(summary->gap);
    free(summary->fault);
    free(summary->switch_event);
    free(summary->channel_event);
}

/* "all 24 seen" or "22 of 24 seen, missing 3, 17; 1 edges not named". */
static void switches_text(const struct measured *measured, char *out, size_t size)
{
    size_t seen = measured->gates;
    bool all = seen == measured->switches && seen > 0;
    int length = all ? snprintf(out, size, "all %zu seen", seen)
                     : snprintf(out, size, "%zu of %zu seen", seen, measured->switches);
    const char *before = ", missing ";
    uint64_t unseen = measured->fitted & ~measured->seen;
    /* beyond it the gear may have stopped */
    unsigned last = measured->seen ? 63u - (unsigned)__builtin_clzll(measured->seen) : 63u;
    uint64_t beyond = last < 63 ? unseen >> (last + 1) << (last + 1) : 0;
    for (size_t p = 0; p < 64 && length > 0 && (size_t)length < size; p++) {
        if (!(unseen & ~beyond & 1ull << p))
            continue;
        length += snprintf(out + length, size - (size_t)length, "%s%zu", before, p + 1);
        before = ", ";
    }
    if (beyond && length > 0 && (size_t)length < size)
        length += snprintf(out + length, size - (size_t)length, ", %s from %d on",
                           measured->fit_status == MR_TRUNCATED || measured_ends_early(measured)
                               ? "none heard"
                               : "not reached",
                           __builtin_ctzll(beyond) + 1);
    if (measured->edges > seen && length > 0 && (size_t)length < size)
        snprintf(out + length, size - (size_t)length, "; %zu edges not named",
                 measured->edges - seen);
}

static double event_time_s(const struct measured *measured, const struct store_fault *event)
{
    return (double)(event->board_us - measured->t0_us) / 1e6;
}

/* "transducer 4 (70.0 ft): stuck, from 2.345 s on" or "... to 3.456 s". That a channel is valid
 * again, the line of what was wrong with it says. */
static void damage_answer(const struct summary *summary, size_t i, struct answer *answer)
{
    const struct measured *measured = &summary->measured;
    const struct store_fault *event = &summary->channel_event[i];
    if (event->code == MR_VALID || event->detail < 0 || event->detail >= (int64_t)MR_CHANNELS)
        return;
    const struct mr_channel_config *config = &measured->channel[event->detail].config;
    const struct unit *station = unit_of(UNIT_STATION, answer_in_si(answer));
    bool bridge = config->kind == MR_KIND_TENSION;
    char until[40] = " on";
    for (size_t later = summary->channel_events; later-- > i + 1;) {
        if (summary->channel_event[later].detail == event->detail)
            snprintf(until, sizeof until, " to %.3f s",
                     event_time_s(measured, &summary->channel_event[later]));
    }
    answer_words(answer, NULL, "channels", "%s %u (%.1f %s): %s, from %.3f s%s",
                 bridge ? "gage" : "transducer", config->number,
                 (double)config->station_ft * station->factor, station->text,
                 bridge && event->code == MR_INVALID_OPEN ? "bridge open"
                                                          : mr_validity_text((unsigned)event->code),
                 event_time_s(measured, event), until);
}

static void channel_events_answer(const struct summary *summary, struct answer *answer)
{
    for (size_t i = 0; i < summary->channel_events; i++)
        damage_answer(summary, i, answer);
    answer_table(answer, "channel_events", NULL);
    for (size_t i = 0; i < summary->channel_events; i++) {
        const struct store_fault *event = &summary->channel_event[i];
        answer_row(answer);
        answer_count(answer, "channel", NULL, event->detail);
        answer_count(answer, "validity", NULL, event->code);
        answer_words(answer, "text", NULL, "%s", mr_validity_text((unsigned)event->code));
        answer_value(answer, "t", NULL, UNIT_TIME, event_time_s(&summary->measured, event), 3)
            ->digits = 9;
    }
    answer_close(answer);
}

static void switch_events_answer(const struct summary *summary, struct answer *answer)
{
    answer_table(answer, "switch_events", NULL);
    for (size_t i = 0; i < summary->switch_events; i++) {
        const struct store_fault *event = &summary->switch_event[i];
        answer_row(answer);
        answer_count(answer, "switch", NULL, event->detail);
        answer_count(answer, "reason", NULL, event->code);
        answer_words(answer, "text", NULL, "%s", mr_switch_reason_text((unsigned)event->code));
        answer_count(answer, "count", NULL, event->count);
    }
    answer_close(answer);
    for (size_t i = 0; i < summary->switch_events; i++) {
        const struct store_fault *event = &summary->switch_event[i];
        char times[32] = "", which[32] = "edge";
        if (event->count > 1)
            snprintf(times, sizeof times, ", %lld times", (long long)event->count);
        if (event->detail > 0)
            snprintf(which, sizeof which, "switch %lld", (long long)event->detail);
        answer_words(answer, NULL, "switches", "%s: %s%s", which,
                     mr_switch_reason_text((unsigned)event->code), times);
    }
}

static void motion_estimate(const struct summary *summary, const char *name, const char *label,
                            enum unit_kind unit, struct mr_estimate value, int decimals,
                            struct answer *answer)
{
    struct answer_fact *fact = answer_estimate(answer, name, label, unit, value.value, value.error,
                                               decimals);
    fact->digits = 9;
    fact->interval = true;
    fact->end = doubts_mark(&summary->measured.doubts);
}

static void motion_answer(const struct summary *summary, struct answer *answer)
{
    const struct measured *measured = &summary->measured;
    const struct mr_gates_summary *fit = &measured->summary;
    char switches[200];
    switches_text(measured, switches, sizeof switches);
    answer_words(answer, NULL, "switches", "%s", switches);
    switch_events_answer(summary, answer);
    answer_count(answer, "switches", NULL, (int64_t)measured->switches);
    answer_count(answer, "switches_seen", NULL, (int64_t)measured->gates);
    answer_words(answer, "fit", NULL, "%s", mr_status_text(measured->fit_status));
    if (measured->fit_status == MR_OK || measured->fit_status == MR_TRUNCATED)
        motion_estimate(summary, "touchdown_speed", "touchdown", UNIT_SPEED,
                        fit->touchdown_speed_ft_s, 4, answer);
    if (measured->fit_status == MR_TRUNCATED) {
        char reason[MEASURED_REASON];
        measured_no_stop_text(measured, reason);
        answer_words(answer, NULL, "stop", "not known: %s", reason);
    } else if (measured->fit_status != MR_OK) {
        answer_words(answer, NULL, "motion", "not known: %s",
                     measured->doubts.torn ? "the landing is torn, its first edges never came"
                                           : mr_status_text(measured->fit_status));
    } else {
        motion_estimate(summary, "mean_deceleration", "deceleration", UNIT_DECELERATION,
                        fit->mean_deceleration_ft_s2, 4, answer);
        motion_estimate(summary, "stop_station", "stop", UNIT_STATION, fit->stop_station_ft, 3,
                        answer);
        answer_value(answer, "stop_after_touchdown", "time to rest", UNIT_TIME,
                     fit->stop_t_s.value - fit->touchdown_t_s.value, 3)
            ->digits = 9;
        answer_count(answer, "stop_gates", NULL, fit->used_for_stop);
    }
}

void summary_channel_answer(const struct measured *measured, const struct measured_channel *channel,
                            struct answer *answer)
{
    const bool gage = channel->config.kind == MR_KIND_TENSION;
    const enum unit_kind unit = gage ? UNIT_TENSION : UNIT_DISPLACEMENT;
    const int decimals = gage ? 1 : 4;
    const double valid = measured->samples ? (double)channel->valid / (double)measured->samples
                                           : 0.0;
    answer_count(answer, "number", gage ? "gage" : "transducer", channel->config.number);
    if (gage)
        answer_count(answer, "band", "band", channel->config.band);
    answer_value(answer, "station", "station", UNIT_STATION, (double)channel->config.station_ft, 1)
        ->digits = 9;
    answer_value(answer, "before", gage ? "before" : NULL, unit, channel->baseline, decimals)
        ->digits = 9;
    if (!gage) {
        answer_estimate(answer, NULL, "peak", unit, channel->peak, channel->error, decimals);
        answer_value(answer, "peak", NULL, unit, channel->peak, decimals)->digits = 9;
    }
    answer_value(answer, "error", NULL, unit, channel->error, decimals)->digits = 9;
    answer_estimate(answer, "least", gage ? "least" : NULL, unit, channel->low, channel->low_error,
                    decimals)
        ->digits = 9;
    answer_estimate(answer, "most", gage ? "most" : NULL, unit, channel->high, channel->high_error,
                    decimals)
        ->digits = 9;
    answer_estimate(answer, "end", "at the end", unit, channel->end, channel->end_error, decimals)
        ->digits = 9;
    if (channel->missing_to > channel->missing_from) {
        answer_value(answer, "missing_from", NULL, UNIT_TIME,
                     measured_time_s(measured, channel->missing_from), 3)
            ->digits = 9;
        answer_value(answer, "missing_to", NULL, UNIT_TIME,
                     measured_time_s(measured, channel->missing_to), 3)
            ->digits = 9;
    }
    answer_value(answer, "valid_fraction", NULL, UNIT_NUMBER, valid, 3);
    answer_value(answer, NULL, "valid|%", UNIT_NUMBER, 100.0 * valid, 1);
}

void summary_channels_answer(const struct measured *measured, enum mr_channel_kind kind,
                             const char *label, struct answer *answer)
{
    bool any = false;
    if (label)
        summary_missing_answer(measured, kind, answer);
    for (unsigned c = 0; c < MR_CHANNELS; c++)
        any |= measured->channel[c].config.kind == kind;
    answer_table(answer, kind == MR_KIND_TENSION ? "tensions" : "displacements",
                 any ? label : NULL);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (measured->channel[c].config.kind != kind)
            continue;
        answer_row(answer);
        summary_channel_answer(measured, &measured->channel[c], answer);
    }
    answer_close(answer);
}

static void channels_answer(const struct measured *measured, struct answer *answer)
{
    bool read = measured->source != MEASURED_NOTHING;
    summary_channels_answer(
        measured, MR_KIND_DISPLACEMENT,
        read ? "movement of the mat (+- is one standard error, - not valid)" : NULL, answer);
    summary_channels_answer(
        measured, MR_KIND_TENSION,
        read ? "tension of the bands (+- is one standard error, - not valid)" : NULL, answer);
}

static void faults_answer(const struct summary *summary, struct answer *answer)
{
    if (summary->faults == 0)
        answer_words(answer, NULL, "faults", "none");
    answer_table(answer, "faults", "faults");
    for (size_t i = 0; i < summary->faults; i++) {
        const struct store_fault *fault = &summary->fault[i];
        answer_row(answer);
        answer_count(answer, "code", NULL, fault->code);
        answer_words(answer, "text", "fault", "%s", mr_fault_text((unsigned)fault->code));
        answer_count(answer, "detail", "[detail]", fault->detail);
        answer_count(answer, "count", "times", fault->count);
    }
    answer_close(answer);
}

static void import_answer(const struct summary *summary, struct answer *answer)
{
    const struct store_import *import = &summary->import;
    if (!summary->imported) {
        answer_none(answer, "import", NULL, "");
        return;
    }
    answer_open(answer, "import", "");
    answer_words(answer, NULL, "imported from", "%s (%s, %lld bytes, SHA-256 %s)", import->file,
                 import->format, (long long)import->bytes, import->sha256);
    answer_words(answer, "file", NULL, "%s", import->file);
    answer_words(answer, "verdict", "the file", "%s", import->verdict);
    answer_words(answer, "sha256", NULL, "%s", import->sha256);
    answer_count(answer, "bytes", NULL, import->bytes);
    answer_close(answer);
}

static void source_answer(const struct measured *measured, struct answer *answer)
{
    char source[MEASURED_SOURCE_TEXT];
    measured_source_text(measured, source);
    answer_words(answer, NULL, "readings", "%s", source);
    answer_words(answer, "source", NULL, "%s", measured_source_name(measured->source));
    answer_table(answer, "stretches", NULL);
    for (size_t i = 0; i < measured->stretches; i++) {
        answer_row(answer);
        answer_words(answer, "source", NULL, "%s",
                     measured_source_name(measured->stretch[i].source));
        answer_count(answer, "from_block", NULL, measured->stretch[i].from_block);
        answer_count(answer, "to_block", NULL, measured->stretch[i].to_block);
    }
    answer_close(answer);
    answer_json_value(answer, "set_aside", measured_aside_json(measured));
}

static const char *or_unknown(const char *text)
{
    return text[0] ? text : "unknown";
}

static void board_answer(const struct store_landing *landing, int64_t can_base,
                         struct answer *answer)
{
    answer_words(answer, NULL, "board", "%s", or_unknown(landing->board_uid));
    if (can_base > 0)
        answer_remark(answer, ", at base 0x%03llx on CAN", (unsigned long long)can_base);
    answer_words(answer, "board", NULL, "%s", landing->board_uid);
    answer_count(answer, "can_base", NULL, can_base == STORE_NONE ? 0 : can_base);
    answer_words(answer, NULL, "firmware", "%s, image %08llx, commit %s",
                 or_unknown(landing->firmware),
                 landing->image_crc == STORE_NONE ? 0ull : (unsigned long long)landing->image_crc,
                 or_unknown(landing->image_commit));
    answer_words(answer, "firmware", NULL, "%s", landing->firmware);
    answer_count(answer, "image_crc", NULL, landing->image_crc);
    answer_words(answer, "image_commit", NULL, "%s", landing->image_commit);
    answer_count(answer, "config_crc", NULL, landing->config_crc);
    answer_count(answer, "clock_source", NULL, landing->clock_source);
    answer_words(answer, NULL, "oscillator",
                 landing->clock_source == STORE_NONE ? "not known"
                 : landing->clock_source > 0         ? "internal: 1 %% in every speed"
                                                     : "crystal");
}

void summary_heading(const struct summary *summary, char out[SUMMARY_HEADING])
{
    const struct store_landing *landing = &summary->measured.landing;
    snprintf(out, SUMMARY_HEADING, "RUN %lld: landing %lld, %s", (long long)landing->id,
             (long long)landing->board_landing, mr_landing_state_text((unsigned)landing->state));
}

void summary_facts_answer(const struct summary *summary, struct answer *answer)
{
    const struct measured *measured = &summary->measured;
    doubts_answer(&measured->doubts, answer);
    summary_ready_answer(summary->ready, answer);
    motion_answer(summary, answer);
    channel_events_answer(summary, answer);
    source_answer(measured, answer);
    import_answer(summary, answer);
    summary_mean_answer(summary->mean, answer);
    foresight_answer(&summary->foresight, measured, answer);
    board_answer(&measured->landing, summary->session.can_base, answer);
}

void summary_health_answer(const struct summary *summary, struct answer *answer)
{
    summary_time_answer(summary, answer);
    summary_held_answer(&summary->held, answer);
    summary_links_answer(summary, answer);
    faults_answer(summary, answer);
}

void summary_zone_answer(const struct summary *summary, struct answer *answer)
{
    zones_answer(&summary->zones, summary->measured.source != MEASURED_IMPORT, answer);
}

void summary_answer(const struct summary *summary, struct answer *answer)
{
    const struct store_landing *landing = &summary->measured.landing;
    char heading[SUMMARY_HEADING];
    summary_heading(summary, heading);
    answer_open(answer, NULL, heading);
    answer_count(answer, "run", NULL, landing->id);
    answer_count(answer, "landing", NULL, landing->board_landing);
    answer_words(answer, "state", NULL, "%s", mr_landing_state_text((unsigned)landing->state));
    summary_facts_answer(summary, answer);
    summary_zone_answer(summary, answer);
    channels_answer(&summary->measured, answer);
    bands_answer(&summary->bands, &summary->measured, answer);
    bands_shunts_answer(&summary->bands, false, answer);
    summary_health_answer(summary, answer);
    answer_close(answer);
}

bool summary_print(const struct summary *summary, bool si, FILE *out)
{
    struct answer *answer = answer_new(si);
    summary_answer(summary, answer);
    bool printed = answer_text(answer, out);
    answer_free(answer);
    return printed;
}

json_t *summary_json(const struct summary *summary, bool si)
{
    struct answer *answer = answer_new(si);
    summary_answer(summary, answer);
    json_t *json = answer_json(answer);
    answer_free(answer);
    return json;
}
