#include "host/analyse/summary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/fault.h"
#include "common/switches.h"
#include "host/analyse/measured_source.h"
#include "host/analyse/summary_held.h"
#include "host/analyse/summary_links.h"
#include "host/analyse/summary_time.h"
#include "host/base/cli.h"
#include "host/collect/collect.h"
#include "host/base/units.h"

enum mr_status summary_load(struct store *store, int64_t run, struct summary *summary, struct error *error)
{
    memset(summary, 0, sizeof *summary);
    enum mr_status status = measured_load(store, run, &summary->measured, error);
    if (status == MR_OK)
        status = zones_load(store, &summary->measured, &summary->zones, error);
    if (status == MR_OK)
        status = foresight_load(store, &summary->measured, &summary->foresight, error);
    if (status == MR_OK)
        status = store_session_get(store, summary->measured.landing.session, &summary->session, error);
    if (status == MR_OK)
        status = store_import_get(store, summary->measured.landing.session, &summary->import, &summary->imported, error);
    if (status == MR_OK)
        status = summary_links_load(store, summary, error);
    if (status == MR_OK)
        status = summary_time_load(store, summary, error);
    if (status == MR_OK)
        status = store_faults(store, &summary->measured.landing, &summary->fault, &summary->faults, error);
    if (status == MR_OK)
        status = store_switch_events(store, run, &summary->switch_event, &summary->switch_events, error);
    if (status == MR_OK)
        status = store_channel_events(store, run, &summary->channel_event, &summary->channel_events, error);
    if (status == MR_OK)
        status = store_result_get(store, run, &summary->result, &summary->result_known, error);
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

void summary_switches(const struct measured *measured, char *out, size_t size)
{
    size_t seen = measured->gates;
    bool all = seen == measured->switches && seen > 0;
    int length = all ? snprintf(out, size, "all %zu seen", seen)
                     : snprintf(out, size, "%zu of %zu seen", seen, measured->switches);
    const char *before = ", missing ";
    uint64_t unseen = measured->fitted & ~measured->seen;
    unsigned last = measured->seen ? 63u - (unsigned)__builtin_clzll(measured->seen) : 63u; /* beyond it the gear may have stopped */
    uint64_t beyond = last < 63 ? unseen >> (last + 1) << (last + 1) : 0;
    for (size_t p = 0; p < 64 && length > 0 && (size_t)length < size; p++) {
        if (!(unseen & ~beyond & 1ull << p))
            continue;
        length += snprintf(out + length, size - (size_t)length, "%s%zu", before, p + 1);
        before = ", ";
    }
    if (beyond && length > 0 && (size_t)length < size)
        length += snprintf(out + length, size - (size_t)length, ", not reached from %d on", __builtin_ctzll(beyond) + 1);
    if (measured->edges > seen && length > 0 && (size_t)length < size)
        snprintf(out + length, size - (size_t)length, "; %zu edges not named", measured->edges - seen);
}

void summary_switch_event(const struct store_fault *event, char *out, size_t size)
{
    char times[32] = "", which[32] = "edge";
    if (event->count > 1)
        snprintf(times, sizeof times, ", %lld times", (long long)event->count);
    if (event->detail > 0)
        snprintf(which, sizeof which, "switch %lld", (long long)event->detail);
    snprintf(out, size, "%s: %s%s", which, mr_switch_reason_text((unsigned)event->code), times);
}

static double event_time_s(const struct measured *measured, const struct store_fault *event)
{
    return (double)(event->board_us - measured->t0_us) / 1e6;
}

bool summary_channel_event(const struct summary *summary, size_t i, bool si, char *out, size_t size)
{
    const struct measured *measured = &summary->measured;
    const struct store_fault *event = &summary->channel_event[i];
    if (event->code == MR_VALID || event->detail < 0 || event->detail >= (int64_t)MR_CHANNELS)
        return false;
    const struct mr_channel_config *config = &measured->channel[event->detail].config;
    const struct unit *station = unit_of(UNIT_STATION, si);
    bool bridge = config->kind == MR_KIND_TENSION;
    char until[40] = " on";
    for (size_t later = summary->channel_events; later-- > i + 1;) {
        if (summary->channel_event[later].detail == event->detail)
            snprintf(until, sizeof until, " to %.3f s", event_time_s(measured, &summary->channel_event[later]));
    }
    snprintf(out, size, "%s %u (%.1f %s): %s, from %.3f s%s", bridge ? "gage" : "transducer",
             config->number, (double)config->station_ft * station->factor, station->text,
             bridge && event->code == MR_INVALID_OPEN ? "bridge open" : mr_validity_text((unsigned)event->code),
             event_time_s(measured, event), until);
    return true;
}

/* ---- text ---- */

static void print_estimate(FILE *out, const char *label, struct mr_estimate value, const struct unit *unit, int digits,
                           const struct doubts *doubts)
{
    double v = value.value * unit->factor;
    double e = value.error * unit->factor;
    fprintf(out, "  %-13s %.*f +- %.*f %s (95 %%: %.*f to %.*f)%s", label, digits, v, digits + 1, e, unit->text,
            digits, v - SUMMARY_95 * e, digits, v + SUMMARY_95 * e, doubts_mark(doubts));
}

static void print_motion(const struct summary *summary, bool si, FILE *out)
{
    const struct measured *measured = &summary->measured;
    const struct mr_gates_summary *fit = &measured->summary;
    char switches[200];
    summary_switches(measured, switches, sizeof switches);
    fprintf(out, "  %-13s %s\n", "switches", switches);
    for (size_t i = 0; i < summary->switch_events; i++) {
        char line[160];
        summary_switch_event(&summary->switch_event[i], line, sizeof line);
        fprintf(out, "  %-13s %s\n", "", line);
    }
    if (measured->fit_status == MR_TRUNCATED) {
        print_estimate(out, "touchdown", fit->touchdown_speed_ft_s, unit_of(UNIT_SPEED, si), 3, &measured->doubts);
        fprintf(out, "\n  %-13s not known: the record ends while the gear moves\n", "stop");
        return;
    }
    if (measured->fit_status != MR_OK) {
        fprintf(out, "  %-13s not known: %s\n", "motion",
                measured->doubts.torn ? "the landing is torn, its first edges never came" : mr_status_text(measured->fit_status));
        return;
    }
    print_estimate(out, "touchdown", fit->touchdown_speed_ft_s, unit_of(UNIT_SPEED, si), 3, &measured->doubts);
    fprintf(out, "\n");
    print_estimate(out, "deceleration", fit->mean_deceleration_ft_s2, unit_of(UNIT_DECELERATION, si), 3, &measured->doubts);
    fprintf(out, "\n");
    print_estimate(out, "stop", fit->stop_station_ft, unit_of(UNIT_STATION, si), 2, &measured->doubts);
    fprintf(out, ", %.3f s after touchdown\n", fit->stop_t_s.value - fit->touchdown_t_s.value);
}

static bool has_any(const struct measured *measured, enum mr_channel_kind kind)
{
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (measured->channel[c].config.kind == kind)
            return true;
    }
    return false;
}

static void print_damage(const struct summary *summary, bool si, FILE *out)
{
    const char *label = "channels";
    for (size_t i = 0; i < summary->channel_events; i++) {
        char line[160];
        if (!summary_channel_event(summary, i, si, line, sizeof line))
            continue;
        fprintf(out, "  %-13s %s\n", label, line);
        label = "";
    }
}

static void print_channels(const struct measured *measured, bool si, FILE *out)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    const struct unit *force = unit_of(UNIT_TENSION, si);
    if (has_any(measured, MR_KIND_DISPLACEMENT))
        fprintf(out, "  peak movement by station, %s (standard error)\n", length->text);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_DISPLACEMENT)
            continue;
        fprintf(out, "    %6.1f %s  ", (double)channel->config.station_ft * station->factor, station->text);
        if (isnan(channel->peak))
            fprintf(out, "not valid\n");
        else if (isnan(channel->end))
            fprintf(out, "%8.4f (%.4f)  at the end not valid\n", unit_tidy(channel->peak * length->factor, 1e-4),
                    channel->error * length->factor);
        else
            fprintf(out, "%8.4f (%.4f)  at the end %8.4f\n", unit_tidy(channel->peak * length->factor, 1e-4),
                    channel->error * length->factor, unit_tidy(channel->end * length->factor, 1e-4));
    }
    if (has_any(measured, MR_KIND_TENSION))
        fprintf(out, "  least tension by gage, %s +- standard error (before the landing)\n", force->text);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_TENSION)
            continue;
        fprintf(out, "    %2u band %u %6.1f %s  ", channel->config.number, channel->config.band,
                (double)channel->config.station_ft * station->factor, station->text);
        if (isnan(channel->low) || isnan(channel->baseline))
            fprintf(out, "not valid\n");
        else
            fprintf(out, "%7.1f +- %.1f (%.1f)\n", channel->low * force->factor, channel->low_error * force->factor,
                    channel->baseline * force->factor);
    }
}

static void print_zone(const struct zone_warning *w, bool since_touchdown, bool si, FILE *out)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    if (!w->warned) {
        fprintf(out, "  %-13s no warning\n", "zone");
        return;
    }
    char when[80];
    zones_when(w, since_touchdown, when, sizeof when);
    fprintf(out, "  %-13s warned %s: %lld closed mats, stations %.1f to %.1f %s", "zone", when, (long long)w->mats,
            w->start_ft * station->factor, w->end_ft * station->factor, station->text);
    if (w->inferred_percent > 0)
        fprintf(out, ", %lld %% of it inferred", (long long)w->inferred_percent);
    if (w->reached)
        fprintf(out, "; the wheel came there %.3f s later\n", w->true_lead_s);
    else
        fprintf(out, "; the wheel did not come there in the record\n");
    if (w->reason != STORE_NONE) {
        fprintf(out, "  %-13s %s", "reason", mr_predictor_reason_text((unsigned)w->reason));
        if (w->coming_mats > 0)
            fprintf(out, ": %lld mats before the wheel at station %.1f %s", (long long)w->coming_mats, w->coming_wheel_ft * station->factor,
                    station->text);
        if (!isnan(w->coming_after_s))
            fprintf(out, ", where it was %.3f s later", w->coming_after_s);
        if (!isnan(w->start_error_ft))
            fprintf(out, "; ends good to %.1f and %.1f %s (one standard error)", w->start_error_ft * station->factor,
                    w->end_error_ft * station->factor, station->text);
        fprintf(out, "; model: %s\n", mr_predictor_level_text((unsigned)w->level));
    }
    if (!isnan(w->lead_s)) {
        fprintf(out, "  %-13s %.3f s to station %.1f %s, given at %.3f s", "lead time", w->lead_s,
                w->lead_start_ft * station->factor, station->text, w->lead_t_s);
        if (isnan(w->lead_became_s))
            fprintf(out, "; the wheel did not come there in the record\n");
        else
            fprintf(out, "; it took %.3f s\n", w->lead_became_s);
    }
    fprintf(out, "  %-13s %lld mats, stations %.1f to %.1f %s\n", "longest zone", (long long)w->most_mats,
            w->most_start_ft * station->factor, w->most_end_ft * station->factor, station->text);
}

static void print_foresight(const struct summary *summary, bool si, FILE *out)
{
    char line[240];
    for (size_t i = 0; foresight_line(&summary->foresight, &summary->measured, i, si, line, sizeof line); i++)
        fprintf(out, "  %-13s %s\n", i ? "" : "foresight", line);
}

static void print_faults(const struct summary *summary, FILE *out)
{
    for (size_t i = 0; i < summary->faults; i++)
        fprintf(out, "  %-13s %s [%lld], %lld times\n", "fault",
                mr_fault_text((unsigned)summary->fault[i].code), (long long)summary->fault[i].detail,
                (long long)summary->fault[i].count);
    if (summary->faults == 0)
        fprintf(out, "  %-13s none\n", "faults");
}

void summary_print(const struct summary *summary, bool si, FILE *out)
{
    char source[MEASURED_SOURCE_TEXT];
    const struct store_landing *landing = &summary->measured.landing;
    fprintf(out, "RUN %lld: landing %lld, %s, board %s, firmware %s, image %08llx, commit %s\n", (long long)landing->id,
            (long long)landing->board_landing, mr_landing_state_text((unsigned)landing->state),
            landing->board_uid[0] ? landing->board_uid : "unknown",
            landing->firmware[0] ? landing->firmware : "unknown",
            landing->image_crc == STORE_NONE ? 0ull : (unsigned long long)landing->image_crc,
            landing->image_commit[0] ? landing->image_commit : "unknown");
    summary_doubts_print(summary, out);
    summary_ready_print(summary->ready, out);
    measured_source_text(&summary->measured, source);
    fprintf(out, "  %-13s %s\n", "readings", source);
    if (summary->imported)
        fprintf(out, "  %-13s %s, %s, SHA-256 %s\n", "imported from", summary->import.file, summary->import.verdict,
                summary->import.sha256);
    summary_mean_print(summary->mean, out);
    print_motion(summary, si, out);
    print_damage(summary, si, out);
    if (summary->measured.source != MEASURED_NOTHING)
        print_channels(&summary->measured, si, out);
    bands_print(&summary->bands, &summary->measured, si, out);
    if (summary->measured.source != MEASURED_IMPORT)
        print_zone(&summary->zones.warning, summary->measured.t0_is_touchdown, si, out);
    print_foresight(summary, si, out);
    summary_time_print(summary, si, out);
    summary_held_print(&summary->held, out);
    summary_links_print(summary, out);
    print_faults(summary, out);
}

/* ---- JSON ---- */

static void set_value(json_t *object, const char *name, const struct unit *unit, double value)
{
    char key[80];
    snprintf(key, sizeof key, "%s_%s", name, unit->suffix);
    json_object_set_new(object, key, cli_json_number(value * unit->factor, 9));
}

static void set_estimate(json_t *object, const char *name, const struct unit *unit, struct mr_estimate value)
{
    char error_name[60];
    snprintf(error_name, sizeof error_name, "%s_error", name);
    set_value(object, name, unit, value.value);
    set_value(object, error_name, unit, value.error);
}

static json_t *integer_or_null(int64_t value)
{
    return value == STORE_NONE ? json_null() : json_integer(value);
}

static json_t *channels_json(const struct measured *measured, enum mr_channel_kind kind, bool si)
{
    const struct unit *unit = unit_of(kind == MR_KIND_DISPLACEMENT ? UNIT_DISPLACEMENT : UNIT_TENSION, si);
    json_t *list = json_array();
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != kind)
            continue;
        json_t *row = json_object();
        json_object_set_new(row, "number", json_integer(channel->config.number));
        if (kind == MR_KIND_TENSION)
            json_object_set_new(row, "band", json_integer(channel->config.band));
        set_value(row, "station", unit_of(UNIT_STATION, si), (double)channel->config.station_ft);
        if (kind == MR_KIND_DISPLACEMENT)
            set_value(row, "peak", unit, channel->peak);
        set_value(row, "least", unit, channel->low);
        set_value(row, "most", unit, channel->high);
        set_value(row, "end", unit, channel->end);
        set_value(row, "error", unit, channel->error);
        set_value(row, "least_error", unit, channel->low_error);
        set_value(row, "most_error", unit, channel->high_error);
        set_value(row, "end_error", unit, channel->end_error);
        set_value(row, "before", unit, channel->baseline);
        json_object_set_new(
            row, "valid_fraction",
            cli_json_number(measured->samples ? (double)channel->valid / (double)measured->samples : 0.0, 6));
        json_array_append_new(list, row);
    }
    return list;
}

static json_t *foresight_json(const struct summary *summary, bool si)
{
    char line[240];
    json_t *lines = json_array();
    for (size_t i = 0; foresight_line(&summary->foresight, &summary->measured, i, si, line, sizeof line); i++)
        json_array_append_new(lines, json_string(line));
    return lines;
}

static json_t *zone_json(const struct zone_warning *w, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    json_t *zone = json_object();
    json_object_set_new(zone, "warned", json_boolean(w->warned));
    if (!w->warned)
        return zone;
    json_object_set_new(zone, "t_s", cli_json_number(w->t_s, 9));
    json_object_set_new(zone, "decided_block", json_integer(w->block));
    json_object_set_new(zone, "mats", json_integer(w->mats));
    set_value(zone, "start", station, w->start_ft);
    set_value(zone, "end", station, w->end_ft);
    set_value(zone, "wheel", station, w->wheel_ft);
    json_object_set_new(zone, "inferred_percent", integer_or_null(w->inferred_percent));
    json_object_set_new(zone, "reason", w->reason == STORE_NONE ? json_null() : json_string(mr_predictor_reason_text((unsigned)w->reason)));
    json_object_set_new(zone, "level", w->level == STORE_NONE ? json_null() : json_string(mr_predictor_level_text((unsigned)w->level)));
    set_value(zone, "start_error", station, w->start_error_ft);
    set_value(zone, "end_error", station, w->end_error_ft);
    json_object_set_new(zone, "coming_mats", integer_or_null(w->coming_mats));
    set_value(zone, "coming_wheel", station, w->coming_wheel_ft);
    json_object_set_new(zone, "coming_after_s", cli_json_number(w->coming_after_s, 6));
    json_object_set_new(zone, "most_mats", json_integer(w->most_mats));
    set_value(zone, "most_start", station, w->most_start_ft);
    set_value(zone, "most_end", station, w->most_end_ft);
    json_object_set_new(zone, "reached", json_boolean(w->reached));
    json_object_set_new(zone, "true_lead_s", cli_json_number(w->true_lead_s, 6));
    json_object_set_new(zone, "lead_s", cli_json_number(w->lead_s, 6));
    json_object_set_new(zone, "lead_t_s", cli_json_number(w->lead_t_s, 9));
    set_value(zone, "lead_start", station, w->lead_start_ft);
    json_object_set_new(zone, "lead_became_s", cli_json_number(w->lead_became_s, 6));
    return zone;
}

static json_t *channel_events_json(const struct summary *summary)
{
    json_t *events = json_array();
    for (size_t i = 0; i < summary->channel_events; i++) {
        const struct store_fault *event = &summary->channel_event[i];
        json_t *row = json_pack("{sIsIss}", "channel", (json_int_t)event->detail, "validity", (json_int_t)event->code, "text",
                                mr_validity_text((unsigned)event->code));
        json_object_set_new(row, "t_s", cli_json_number(event_time_s(&summary->measured, event), 9));
        json_array_append_new(events, row);
    }
    return events;
}

static json_t *stretches_json(const struct measured *measured)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < measured->stretches; i++)
        json_array_append_new(rows, json_pack("{sssIsI}", "source", measured_source_name(measured->stretch[i].source), "from_block",
                                              (json_int_t)measured->stretch[i].from_block, "to_block",
                                              (json_int_t)measured->stretch[i].to_block));
    return rows;
}

json_t *summary_json(const struct summary *summary, bool si)
{
    const struct measured *measured = &summary->measured;
    const struct store_landing *landing = &measured->landing;
    json_t *object =
        json_pack("{sIsIssssss}", "run", (json_int_t)landing->id, "landing",
                  (json_int_t)landing->board_landing, "state", mr_landing_state_text((unsigned)landing->state),
                  "board", landing->board_uid, "firmware", landing->firmware);
    json_object_set_new(object, "image_crc", integer_or_null(landing->image_crc));
    json_object_set_new(object, "image_commit", json_string(landing->image_commit));
    json_object_set_new(object, "config_crc", integer_or_null(landing->config_crc));
    json_object_set_new(object, "clock_source", integer_or_null(landing->clock_source));
    json_object_set_new(object, "source", json_string(measured_source_name(measured->source)));
    json_object_set_new(object, "stretches", stretches_json(measured));
    json_object_set_new(object, "set_aside", measured_aside_json(measured));
    json_object_set_new(object, "import",
                        summary->imported ? json_pack("{sssssssI}", "file", summary->import.file, "sha256", summary->import.sha256, "verdict",
                                                      summary->import.verdict, "bytes", (json_int_t)summary->import.bytes)
                                          : json_null());
    json_object_set_new(object, "switches", json_integer((json_int_t)measured->switches));
    json_object_set_new(object, "switches_seen", json_integer((json_int_t)measured->gates));
    json_object_set_new(object, "fit", json_string(mr_status_text(measured->fit_status)));
    const struct mr_gates_summary *fit = &measured->summary;
    if (measured->fit_status == MR_OK || measured->fit_status == MR_TRUNCATED)
        set_estimate(object, "touchdown_speed", unit_of(UNIT_SPEED, si), fit->touchdown_speed_ft_s);
    if (measured->fit_status == MR_OK) {
        set_estimate(object, "mean_deceleration", unit_of(UNIT_DECELERATION, si),
                     fit->mean_deceleration_ft_s2);
        set_estimate(object, "stop_station", unit_of(UNIT_STATION, si), fit->stop_station_ft);
        json_object_set_new(object, "stop_after_touchdown_s",
                            cli_json_number(fit->stop_t_s.value - fit->touchdown_t_s.value, 9));
        json_object_set_new(object, "stop_gates", json_integer(fit->used_for_stop));
    }
    json_object_set_new(object, "displacements", channels_json(measured, MR_KIND_DISPLACEMENT, si));
    json_object_set_new(object, "tensions", channels_json(measured, MR_KIND_TENSION, si));
    bands_json(&summary->bands, measured, si, object);
    json_object_set_new(object, "zone", zone_json(&summary->zones.warning, si));
    json_object_set_new(object, "foresight", foresight_json(summary, si));
    summary_mean_json(summary->mean, object);
    summary_time_json(summary, object);
    json_object_set_new(object, "readiness", summary_ready_json(summary->ready));
    json_object_set_new(object, "held", summary_held_json(&summary->held));
    summary_links_json(summary, object);
    json_t *faults = json_array();
    for (size_t i = 0; i < summary->faults; i++)
        json_array_append_new(faults, json_pack("{sIsssIsI}", "code", (json_int_t)summary->fault[i].code,
                                                "text", mr_fault_text((unsigned)summary->fault[i].code),
                                                "detail", (json_int_t)summary->fault[i].detail, "count",
                                                (json_int_t)summary->fault[i].count));
    json_object_set_new(object, "faults", faults);
    json_t *events = json_array();
    for (size_t i = 0; i < summary->switch_events; i++) {
        const struct store_fault *event = &summary->switch_event[i];
        json_array_append_new(events, json_pack("{sIsIsssI}", "switch", (json_int_t)event->detail, "reason",
                                                (json_int_t)event->code, "text",
                                                mr_switch_reason_text((unsigned)event->code), "count",
                                                (json_int_t)event->count));
    }
    json_object_set_new(object, "switch_events", events);
    json_object_set_new(object, "channel_events", channel_events_json(summary));
    return object;
}
