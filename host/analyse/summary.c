#include "host/analyse/summary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/command.h"
#include "common/fault.h"
#include "host/analyse/measured_load.h"
#include "host/base/units.h"
#include "host/board/health_client.h"
#include "host/link/timemap.h"
#include "host/store/store_journal.h"
#include "host/store/store_readiness.h"

const char *summary_link_name(int link)
{
    return link == LINK_CAN ? "CAN" : link == LINK_SERIAL ? "serial" : "file";
}

static enum mr_status load_link_errors(struct store *store, int64_t run, int kind,
                                       struct summary_link *link, struct error *error)
{
    struct store_link_error *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_link_errors_get(store, run, kind, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (rows[i].code >= 0 && rows[i].code < LINK_FAULT_COUNT)
            link->error_count[rows[i].code] = rows[i].count;
    }
    free(rows);
    return status;
}

void summary_count_gaps(const struct store_gap *gaps, size_t count,
                        struct summary_link link[LINK_KINDS])
{
    for (size_t i = 0; i < count; i++) {
        const struct store_gap *gap = &gaps[i];
        if (gap->link < 0 || gap->link >= LINK_KINDS)
            continue;
        struct summary_link *its = &link[gap->link];
        if (strcmp(gap->cause, "silence") == 0 || gap->count == STORE_NONE)
            its->was_silent = true;
        else if (strcmp(gap->message, "frame") == 0)
            *(strcmp(gap->cause, "board") == 0 ? &its->dropped_frames
                                               : &its->lost_frames) += gap->count;
    }
}

static enum mr_status load_links(struct store *store, struct summary *summary, struct error *error)
{
    int64_t run = summary->measured.landing.id;
    enum mr_status status = store_gaps_get(store, run, &summary->gap, &summary->gap_count, error);
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct summary_link *link = &summary->link[kind];
        const char *spec = kind == LINK_CAN ? summary->session.can_link
                                            : summary->session.serial_link;
        link->is_used = spec[0] != '\0';
        status = store_frames_count(store, run, kind, &link->received_frames, error);
        int64_t blocks = 0;
        if (status == MR_OK && kind == LINK_SERIAL)
            status = store_blocks_count(store, run, &blocks, error);
        link->received_frames += blocks;
        if (status == MR_OK)
            status = load_link_errors(store, run, kind, link, error);
    }
    summary_count_gaps(summary->gap, summary->gap_count, summary->link);
    return status;
}

void summary_format_link_errors(const int64_t *trouble, char *out, size_t size)
{
    size_t used = 0;
    out[0] = '\0';
    for (unsigned i = 0; i < LINK_FAULT_COUNT && used < size; i++) {
        if (trouble[i] > 0)
            used += (size_t)snprintf(out + used, size - used, "%s%s %lld", used ? ", " : "",
                                     link_fault_text(i), (long long)trouble[i]);
    }
}

json_t *summary_link_errors_to_json(const int64_t *trouble)
{
    json_t *object = json_object();
    for (unsigned i = 0; i < LINK_FAULT_COUNT; i++) {
        if (trouble[i] > 0)
            json_object_set_new(object, link_fault_text(i), json_integer((json_int_t)trouble[i]));
    }
    return object;
}

/* Returns the reason why the frames of a gap are missing. */
static const char *get_gap_reason(const char *cause)
{
    static const struct {
        const char *cause;
        const char *text;
    } reasons[] = {
        {"board", "not sent by the board"},
        {"queue", "lost in this computer's receive queue"},
        {"lock", "lost while another program held the campaign"},
        {"slow disk", "lost while the disk was slow"},
        {"full disk", "lost while the disk was full"},
        {"processor", "lost because this computer was too slow"},
        {"adapter", "lost in the adapter"},
        {"bus-off", "lost while the adapter was off the bus"},
        {"away", "lost while the link was disconnected"},
        {"file", "missing in the file"},
        {"silence", "the link was silent"},
    };
    for (size_t i = 0; i < sizeof reasons / sizeof reasons[0]; i++) {
        if (strcmp(cause, reasons[i].cause) == 0)
            return reasons[i].text;
    }
    return "lost";
}

static void add_gap(const struct store_gap *gap, struct answer *answer)
{
    answer_open_row(answer);
    answer_add_text(answer, NULL, "link", "%s", summary_link_name(gap->link));
    answer_add_text(answer, "link", NULL, gap->link == LINK_CAN ? "can" : "serial");
    answer_add_count(answer, "count", "count", gap->count);
    answer_add_text(answer, "message", "data", "%s", gap->message);
    answer_add_text(answer, "channels", "channels", "%s", gap->channels);
    answer_add_text(answer, NULL, "cause", "%s", get_gap_reason(gap->cause));
    answer_add_text(answer, "cause", NULL, "%s", gap->cause);
    answer_add_count(answer, "from_block", "from block", gap->from_block);
    answer_add_count(answer, "to_block", "to block", gap->to_block);
}

static void add_link(const struct summary_link *link, int kind, struct answer *answer)
{
    char line[400], label[20];
    if (!link->is_used) {
        answer_add_text(answer, NULL, summary_link_name(kind), "not used");
        return;
    }
    answer_add_text(
        answer, NULL, summary_link_name(kind),
        "%lld frames received, %lld lost, %lld not sent by the board%s",
        (long long)link->received_frames, (long long)link->lost_frames,
        (long long)link->dropped_frames,
        link->was_silent ? "; the link was silent for a time, so more frames may be lost" : "");
    summary_format_link_errors(link->error_count, line, sizeof line);
    snprintf(label, sizeof label, "%s link", summary_link_name(kind));
    if (line[0])
        answer_add_text(answer, NULL, label, "%s", line);
    answer_open_group(answer, kind == LINK_CAN ? "can" : "serial", NULL);
    answer_add_count(answer, "received", NULL, link->received_frames);
    answer_add_count(answer, "lost", NULL, link->lost_frames);
    answer_add_count(answer, "dropped", NULL, link->dropped_frames);
    answer_add_flag(answer, "silent", NULL, link->was_silent);
    answer_add_json(answer, "troubles", summary_link_errors_to_json(link->error_count));
    answer_close_group(answer);
}

static void add_links(const struct summary *summary, struct answer *answer)
{
    answer_open_group(answer, "links", "");
    for (int kind = 0; kind < LINK_KINDS; kind++)
        add_link(&summary->link[kind], kind, answer);
    answer_close_group(answer);
    if (summary->gap_count == 0)
        answer_add_text(answer, NULL, "gaps", "none");
    answer_open_table(answer, "gaps", "gaps");
    for (size_t i = 0; i < summary->gap_count; i++)
        add_gap(&summary->gap[i], answer);
    answer_close_group(answer);
}

static enum mr_status load_mean(struct store *store, int64_t run, struct store_mean *mean,
                                struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < MR_QUANTITY_COUNT && status == MR_OK; i++)
        status = store_mean_get(store, run, (enum mr_quantity)i, &mean[i], error);
    return status;
}

static void add_mean(const struct store_mean *mean, struct answer *answer)
{
    for (unsigned i = 0; i < MR_QUANTITY_COUNT; i++) {
        const struct mr_quantity_info *info = mr_quantity_at(i);
        const struct store_mean *m = &mean[i];
        if (!m->readings && m->messages)
            answer_add_text(answer, NULL, info->name, "none of the %lld readings is valid; %s",
                            (long long)m->messages, info->missing_reason);
        if (!m->readings)
            continue;
        answer_add_estimate(answer, NULL, info->name, UNIT_NUMBER, m->mean, m->error,
                            info->decimals);
        answer_append_remark(answer, " %s, %lld of %lld readings", info->unit,
                             (long long)m->readings, (long long)m->messages);
        answer_add_value(answer, info->key, NULL, UNIT_NUMBER, m->mean, info->decimals);
        if (!isnan(m->error))
            answer_add_value(answer, info->error_key, NULL, UNIT_NUMBER, m->error, info->decimals)
                ->digits = 4;
    }
}

static bool has_missing_samples(const struct measured_channel *channel, enum mr_channel_kind kind)
{
    return channel->config.kind == kind && channel->missing_end > channel->missing_start;
}

/* Lists the channels for which data is missing in the same time as for channel `c`: "1, 2, 5".
 * Returns false if `c` is in the list of an earlier channel. */
static bool format_channels_missing_alike(const struct measured_landing *measured, unsigned c,
                                          char *out, size_t size)
{
    const struct measured_channel *first = &measured->channel[c];
    size_t used = 0;
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        const struct measured_channel *channel = &measured->channel[i];
        if (!has_missing_samples(channel, first->config.kind) ||
            channel->missing_start != first->missing_start ||
            channel->missing_end != first->missing_end)
            continue;
        if (i < c)
            return false;
        if (used < size)
            used += (size_t)snprintf(out + used, size - used, "%s%u", used > 0 ? ", " : "",
                                     channel->config.number);
    }
    return true;
}

static void add_missing_samples(const struct measured_landing *measured, enum mr_channel_kind kind,
                                struct answer *answer)
{
    char numbers[120];
    if (measured->has_no_baseline && kind == MR_KIND_DISPLACEMENT)
        answer_add_sentence(
            answer, NULL,
            "Movements are unknown, because no reading at rest was received before the landing.");
    else if (measured->is_start_missing && measured->first_edge > 0)
        answer_add_sentence(answer, NULL,
                            "The first switch edges were not received: minimum, maximum and end "
                            "values cover only the time from edge %lld on.",
                            (long long)measured->first_edge);
    if (measured_ends_while_moving(measured))
        answer_add_sentence(answer, NULL,
                            "The record ends %.3f s after %s, while the gear %s: peaks and end "
                            "values cover only the time until then.",
                            measured_time_s(measured, measured->samples - 1),
                            measured_origin_text(measured), measured_motion_at_end_text(measured));
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (!has_missing_samples(channel, kind) ||
            !format_channels_missing_alike(measured, c, numbers, sizeof numbers))
            continue;
        answer_add_sentence(answer, NULL,
                            "Readings are missing from %.3f to %.3f s (%s%s %s): a peak in this "
                            "interval is not measured, and the stated errors do not include this.",
                            measured_time_s(measured, channel->missing_start),
                            measured_time_s(measured, channel->missing_end),
                            kind == MR_KIND_TENSION ? "gage" : "transducer",
                            strpbrk(numbers, " ") ? "s" : "", numbers);
    }
}

#define US_PER_MIN 60e6

static const char *get_ready_kind_name(int kind)
{
    return kind == 0 ? "ready" : "walk";
}

static void copy_failed_checks(const char *checks, char *out, size_t size)
{
    json_t *object = json_loads(checks, 0, NULL), *check;
    size_t i;
    json_array_foreach(json_object_get(object, "checks"), i, check)
    {
        const char *verdict = json_string_value(json_object_get(check, "verdict"));
        const char *name = json_string_value(json_object_get(check, "name")),
                   *value = json_string_value(json_object_get(check, "value"));
        size_t at = strlen(out);
        if (verdict && name && value && strcmp(verdict, "NO-GO") == 0)
            snprintf(out + at, size - at, "%s%s: %s", at ? "; " : "", name, value);
    }
    json_decref(object);
}

static enum mr_status load_ready_checks(struct store *store, const struct store_landing *landing,
                                        struct summary_ready_check ready[SUMMARY_READY_CHECK_COUNT],
                                        struct error *error)
{
    enum mr_status status = MR_OK;
    memset(ready, 0, SUMMARY_READY_CHECK_COUNT * sizeof *ready);
    for (int kind = 0; kind < SUMMARY_READY_CHECK_COUNT && status == MR_OK && landing->board_uid[0];
         kind++) {
        struct store_readiness row;
        status = store_readiness_get(store, landing->board_uid, get_ready_kind_name(kind),
                                     landing->armed_us, true, &row, &ready[kind].is_known, error);
        if (status != MR_OK || !ready[kind].is_known)
            continue;
        ready[kind].is_go = strcmp(row.verdict, "go") == 0;
        ready[kind].minutes_before_arming = (double)(landing->armed_us - row.made_us) / US_PER_MIN;
        copy_failed_checks(row.checks, ready[kind].failed_checks, sizeof ready[kind].failed_checks);
        free(row.checks);
    }
    return status;
}

static void add_ready_checks(const struct summary_ready_check ready[SUMMARY_READY_CHECK_COUNT],
                             struct answer *answer)
{
    for (int kind = 0; kind < SUMMARY_READY_CHECK_COUNT; kind++) {
        const struct summary_ready_check *r = &ready[kind];
        if (r->is_known)
            answer_add_text(answer, NULL, get_ready_kind_name(kind), "%s, %.0f min before%s%s",
                            r->is_go ? "go" : "NO-GO", r->minutes_before_arming,
                            r->failed_checks[0] ? ": " : "", r->failed_checks)
                ->is_warning = !r->is_go;
    }
    answer_open_group(answer, "readiness", NULL);
    for (int kind = 0; kind < SUMMARY_READY_CHECK_COUNT; kind++) {
        if (!ready[kind].is_known) {
            answer_add_missing_value(answer, get_ready_kind_name(kind), NULL, "");
            continue;
        }
        answer_open_group(answer, get_ready_kind_name(kind), NULL);
        answer_add_flag(answer, "go", NULL, ready[kind].is_go);
        answer_add_value(answer, "before_min", NULL, UNIT_NUMBER, ready[kind].minutes_before_arming,
                         0)
            ->digits = 4;
        answer_add_text(answer, "no_go", NULL, "%s", ready[kind].failed_checks);
        answer_close_group(answer);
    }
    answer_close_group(answer);
}

#define HOST_TIME_MAX_US 1e17 /* largest host time, in the year 5138 */

/* Returns true if time map `a` is better than `b`. Usable maps are better than refused ones. Of two
 * usable maps, CAN is better, because its delay is shorter. Of two refused maps, the refusal with
 * more information is better. */
static bool is_better_clock(const struct store_time_map *a, const struct store_time_map *b)
{
    if (a->refusal != TIMEMAP_OK || b->refusal != TIMEMAP_OK)
        return b->refusal != TIMEMAP_OK && (a->refusal == TIMEMAP_OK || a->refusal > b->refusal);
    return a->link == LINK_CAN && b->link != LINK_CAN;
}

enum mr_status summary_load_clock(struct store *store, int64_t run, struct store_time_map *clock,
                                  bool *known, struct error *error)
{
    struct store_time_map *map = NULL;
    size_t maps = 0;
    *known = false;
    enum mr_status status = store_time_maps_get(store, run, &map, &maps, error);
    for (size_t i = 0; status == MR_OK && i < maps; i++) {
        if (!*known || is_better_clock(&map[i], clock))
            *clock = map[i];
        *known = true;
    }
    free(map);
    return status;
}

struct summary_moment summary_convert_to_host_time(const struct store_time_map *clock,
                                                   double board_us)
{
    double since_us = board_us - (double)clock->board_us;
    return (struct summary_moment){
        (double)clock->host_us + since_us / (1.0 + clock->fast_ppm * 1e-6),
        clock->host_half_us + fabs(since_us) * clock->fast_half_ppm * 1e-6};
}

static enum mr_status load_time(struct store *store, struct summary *summary, struct error *error)
{
    return film_load(store, &summary->measured, &summary->film, error)
             ?: summary_load_clock(store, summary->measured.landing.id, &summary->clock,
                                   &summary->is_clock_known, error);
}

struct summary_moment summary_convert_to_time_of_day(const struct summary *summary, double board_us)
{
    if (!summary->is_clock_known || summary->clock.refusal != TIMEMAP_OK)
        return (struct summary_moment){(double)NAN, (double)NAN};
    return summary_convert_to_host_time(&summary->clock, board_us);
}

/* Formats a time in Unix microseconds, for example "2026-11-21 22:28:14.1234 UTC". */
static void format_time_of_day(double host_us, char *out, size_t size)
{
    time_t second = fabs(host_us) < HOST_TIME_MAX_US ? (time_t)floor(host_us / 1e6) : 0;
    struct tm utc;
    char text[40];
    if (!(fabs(host_us) < HOST_TIME_MAX_US) || !gmtime_r(&second, &utc)) {
        snprintf(out, size, "unknown (date outside the calendar)");
        return;
    }
    strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &utc);
    snprintf(out, size, "%s.%04d UTC", text, (int)floor((host_us / 1e6 - (double)second) * 1e4));
}

static void add_clock(const struct summary *summary, struct answer *answer)
{
    const struct store_time_map *clock = &summary->clock;
    const struct summary_moment touchdown =
        summary_convert_to_time_of_day(summary, (double)summary->measured.t0_us);
    bool good = clock->refusal == TIMEMAP_OK;
    char day[60];
    if (!summary->is_clock_known)
        return;
    answer_open_group(answer, "clock", "");
    answer_add_flag(answer, "good", NULL, good);
    answer_add_text(answer, "text", NULL, "%s", timemap_refusal_text((unsigned)clock->refusal));
    if (good) {
        answer_add_text(
            answer, NULL, "clock",
            "the board's clock is %.2f +- %.2f ppm %s (%s, %lld time pairs); times of day "
            "are known within %.2f ms (95 %%) plus the minimum delay of the link",
            fabs(clock->fast_ppm), clock->fast_half_ppm, clock->fast_ppm < 0.0 ? "slow" : "fast",
            summary_link_name((int)clock->link), (long long)clock->pairs,
            clock->host_half_us / 1e3);
        answer_add_text(answer, "link", NULL, clock->link == LINK_CAN ? "can" : "serial");
        answer_add_count(answer, "moments", NULL, clock->pairs);
        answer_add_value(answer, "fast_ppm", NULL, UNIT_NUMBER, clock->fast_ppm, 2);
        answer_add_value(answer, "fast_half_ppm", NULL, UNIT_NUMBER, clock->fast_half_ppm, 2);
        answer_add_count(answer, "t0_unix_us", NULL, llround(touchdown.host_us));
        answer_add_value(answer, "t0_half_us", NULL, UNIT_NUMBER, touchdown.half_width_us, 0);
    } else {
        answer_add_text(answer, NULL, "clock", "times of day unknown: %s",
                        timemap_refusal_text((unsigned)clock->refusal));
    }
    if (good && summary->measured.is_t0_touchdown) {
        format_time_of_day(touchdown.host_us, day, sizeof day);
        answer_add_text(answer, NULL, "touchdown at", "%s", day);
    }
    answer_close_group(answer);
}

static void add_film(const struct summary *summary, struct answer *answer)
{
    const struct film *film = &summary->film;
    const struct unit *station = unit_get(UNIT_STATION, answer_is_si(answer));
    double worst_ft = 0.0;
    size_t placed = 0;
    char gear[120] = "";
    if (film->frame_count == 0)
        return;
    for (size_t i = 0; i < film->frame_count; i++) {
        if (isnan(film->frame[i].station_ft.value))
            continue;
        worst_ft = fmax(worst_ft, film->frame[i].station_ft.error);
        placed++;
    }
    if (placed)
        snprintf(gear, sizeof gear,
                 "; the position of the gear is known on %zu of them within %.3f %s (95 %%)",
                 placed, SUMMARY_HALF_WIDTH_95 * worst_ft * station->factor, station->text);
    answer_open_group(answer, "film", "");
    answer_add_text(answer, NULL, "film", "%zu frames, %.2f a second, %lld missing%s",
                    film->frame_count, film->rate_hz, (long long)film->missing_frame_count, gear);
    answer_add_count(answer, "frames", NULL, (int64_t)film->frame_count);
    answer_add_count(answer, "missing", NULL, film->missing_frame_count);
    answer_add_value(answer, "rate_hz", NULL, UNIT_NUMBER, film->rate_hz, 2)->digits = 9;
    answer_close_group(answer);
}

void summary_add_times(const struct summary *summary, struct answer *answer)
{
    add_clock(summary, answer);
    add_film(summary, answer);
}

/* ---- the summary ---- */

enum mr_status summary_load(struct store *store, int64_t run, struct summary *summary,
                            struct error *error)
{
    memset(summary, 0, sizeof *summary);
    return measured_load(store, run, &summary->measured, error) ?:
           braking_load(store, &summary->measured, &summary->braking, error) ?:
           zones_load(store, &summary->measured, &summary->zones, error) ?:
           predictor_inputs_load(store, &summary->measured, &summary->predictor_inputs, error) ?:
           store_session_get(store, summary->measured.landing.session, &summary->session, error) ?:
           store_import_get(store, summary->measured.landing.session, &summary->import,
                            &summary->is_imported, error) ?:
           load_links(store, summary, error) ?: load_time(store, summary, error) ?:
           store_faults_get(store, &summary->measured.landing, &summary->fault,
                            &summary->fault_count, error) ?:
           store_switch_events_get(store, run, &summary->switch_event, &summary->switch_event_count,
                               error) ?:
           store_channel_events_get(store, run, &summary->channel_event,
                                    &summary->channel_event_count, error) ?:
           store_restarts_get(store, run, &summary->restart, &summary->restart_count, error) ?:
           store_command_events_get(store, run, &summary->command, &summary->command_count,
                                    error) ?:
           store_key_states_get(store, run, &summary->key_state, &summary->key_state_count,
                                error) ?:
           bands_load(store, &summary->measured, &summary->bands, error) ?:
           load_mean(store, run, summary->mean, error) ?:
           load_ready_checks(store, &summary->measured.landing, summary->ready_check, error) ?:
           store_find_duplicate(store, run, &summary->duplicate_run, error);
}

enum mr_status summary_load_outcome(struct store *store, struct summary *summary,
                                    struct error *error)
{
    const struct outcome_record_landing loaded = {&summary->measured, &summary->zones};
    return outcome_record_evaluate_one(store, &loaded, &summary->outcome, error);
}

void summary_free(struct summary *summary)
{
    measured_free(&summary->measured);
    zones_free(&summary->zones);
    bands_free(&summary->bands);
    film_free(&summary->film);
    free(summary->gap);
    free(summary->fault);
    free(summary->switch_event);
    free(summary->channel_event);
    free(summary->restart);
    free(summary->command);
    free(summary->key_state);
}

void summary_format_switches(const struct measured_landing *measured, char *out, size_t size)
{
    size_t seen = measured->gate_count;
    bool all = seen == measured->switch_count && seen > 0;
    int length = all ? snprintf(out, size, "all %zu seen", seen)
                     : snprintf(out, size, "%zu of %zu seen", seen, measured->switch_count);
    const char *before = ", missing ";
    uint64_t unseen = measured->fitted_switches & ~measured->switches_with_edges;
    /* do not count the switches beyond the last one with an edge: the gear may have stopped before
     * them */
    unsigned last = measured->switches_with_edges
                      ? 63u - (unsigned)__builtin_clzll(measured->switches_with_edges)
                      : 63u;
    uint64_t beyond = last < 63 ? unseen >> (last + 1) << (last + 1) : 0;
    for (size_t p = 0; p < 64 && length > 0 && (size_t)length < size; p++) {
        if (!(unseen & ~beyond & 1ull << p))
            continue;
        length += snprintf(out + length, size - (size_t)length, "%s%zu", before, p + 1);
        before = ", ";
    }
    if (beyond && length > 0 && (size_t)length < size) {
        const char *state = measured->fit_status == MR_TRUNCATED ||
                                    measured_ends_while_moving(measured)
                              ? "not received"
                              : "not reached";
        int from = __builtin_ctzll(beyond) + 1, to = 64 - __builtin_clzll(beyond);
        length += from == to
                    ? snprintf(out + length, size - (size_t)length, "; switch %d %s", from, state)
                    : snprintf(out + length, size - (size_t)length, "; switches %d to %d %s", from,
                               to, state);
    }
    if (measured->edge_count > seen && length > 0 && (size_t)length < size)
        snprintf(out + length, size - (size_t)length,
                 "; %zu edges could not be assigned to a switch", measured->edge_count - seen);
}

static double get_event_time_s(const struct measured_landing *measured,
                               const struct store_fault *event)
{
    return (double)(event->board_us - measured->t0_us) / 1e6;
}

/* Adds "transducer 4 (70.0 ft): stuck, from 2.345 s on" or "... to 3.456 s". Events that a channel
 * is valid again get no line, because the line of the fault contains its end. */
static void add_channel_fault(const struct summary *summary, size_t i, struct answer *answer)
{
    const struct measured_landing *measured = &summary->measured;
    const struct store_fault *event = &summary->channel_event[i];
    if (event->code == MR_VALID || event->detail < 0 || event->detail >= (int64_t)MR_CHANNELS)
        return;
    const struct mr_channel_config *config = &measured->channel[event->detail].config;
    const struct unit *station = unit_get(UNIT_STATION, answer_is_si(answer));
    bool bridge = config->kind == MR_KIND_TENSION;
    char until[40] = " on";
    for (size_t later = summary->channel_event_count; later-- > i + 1;) {
        if (summary->channel_event[later].detail == event->detail)
            snprintf(until, sizeof until, " to %.3f s",
                     get_event_time_s(measured, &summary->channel_event[later]));
    }
    answer_add_text(answer, NULL, "channels", "%s %u (%.1f %s): %s, from %.3f s%s",
                    bridge ? "gage" : "transducer", config->number,
                    (double)config->station_ft * station->factor, station->text,
                    bridge && event->code == MR_INVALID_OPEN
                        ? "bridge open"
                        : mr_validity_text((unsigned)event->code),
                    get_event_time_s(measured, event), until);
}

static void add_channel_events(const struct summary *summary, struct answer *answer)
{
    for (size_t i = 0; i < summary->channel_event_count; i++)
        add_channel_fault(summary, i, answer);
    answer_open_table(answer, "channel_events", NULL);
    for (size_t i = 0; i < summary->channel_event_count; i++) {
        const struct store_fault *event = &summary->channel_event[i];
        answer_open_row(answer);
        answer_add_count(answer, "channel", NULL, event->detail);
        answer_add_count(answer, "validity", NULL, event->code);
        answer_add_text(answer, "text", NULL, "%s", mr_validity_text((unsigned)event->code));
        answer_add_value(answer, "t", NULL, UNIT_TIME, get_event_time_s(&summary->measured, event),
                         3)
            ->digits = 9;
    }
    answer_close_group(answer);
}

static void add_restarts(const struct summary *summary, struct answer *answer)
{
    const struct measured_landing *measured = &summary->measured;
    char cause[100], after[40] = "";
    if (summary->restart_count == 0) {
        answer_add_missing_value(answer, "restart", NULL, "");
        return;
    }
    health_reset_text(summary->restart->detail, cause, sizeof cause);
    if (measured->samples)
        snprintf(after, sizeof after, " after %.3f s",
                 measured_time_s(measured, measured->samples - 1));
    answer_add_text(answer, NULL, "restart", "the board restarted (%s), so the record ends%s",
                    cause[0] ? cause : "cause not known", after)
        ->is_warning = true;
    answer_open_group(answer, "restart", "");
    answer_add_text(answer, "cause", NULL, "%s", cause);
    answer_add_count(answer, "reset_cause", NULL, summary->restart->detail);
    answer_close_group(answer);
}

/* Adds one line for each command except an accepted arming, which every landing has. */
static void add_commands(const struct summary *summary, struct answer *answer)
{
    for (size_t i = 0; i < summary->command_count; i++) {
        const struct store_fault *order = &summary->command[i];
        enum mr_status status = (enum mr_status)order->detail;
        if (order->code != MR_COMMAND_ARM || status != MR_OK)
            answer_add_text(answer, NULL, "command", "%s, sent by %s at %.3f s: %s%s",
                            mr_command_name((unsigned)order->code),
                            order->count ? "matrig log" : "another program",
                            get_event_time_s(&summary->measured, order),
                            status == MR_OK ? "executed" : "refused, ",
                            status == MR_OK ? "" : mr_status_text(status))
                ->is_warning = status != MR_OK;
    }
    answer_open_table(answer, "orders", NULL);
    for (size_t i = 0; i < summary->command_count; i++) {
        const struct store_fault *order = &summary->command[i];
        answer_open_row(answer);
        answer_add_text(answer, "command", NULL, "%s", mr_command_name((unsigned)order->code));
        answer_add_count(answer, "status", NULL, order->detail);
        answer_add_flag(answer, "own", NULL, order->count);
        answer_add_value(answer, "t", NULL, UNIT_TIME, get_event_time_s(&summary->measured, order),
                         3)
            ->digits = 9;
    }
    answer_close_group(answer);
}

static void add_switch_events(const struct summary *summary, struct answer *answer)
{
    answer_open_table(answer, "switch_events", NULL);
    for (size_t i = 0; i < summary->switch_event_count; i++) {
        const struct store_fault *event = &summary->switch_event[i];
        answer_open_row(answer);
        answer_add_count(answer, "switch", NULL, event->detail);
        answer_add_count(answer, "reason", NULL, event->code);
        answer_add_text(answer, "text", NULL, "%s", mr_switch_reason_text((unsigned)event->code));
        answer_add_count(answer, "count", NULL, event->count);
    }
    answer_close_group(answer);
    for (size_t i = 0; i < summary->switch_event_count; i++) {
        const struct store_fault *event = &summary->switch_event[i];
        char times[32] = "", which[32] = "edge";
        if (event->count > 1)
            snprintf(times, sizeof times, ", %lld times", (long long)event->count);
        if (event->detail > 0)
            snprintf(which, sizeof which, "switch %lld", (long long)event->detail);
        answer_add_text(answer, NULL, "switches", "%s: %s%s", which,
                        mr_switch_reason_text((unsigned)event->code), times);
    }
}

static void add_motion_estimate(const char *name, const char *label, enum unit_kind unit,
                                struct mr_estimate value, int decimals, struct answer *answer)
{
    struct answer_style *fact = answer_add_estimate(answer, name, label, unit, value.value,
                                                    value.error, decimals);
    fact->digits = 9;
    fact->shows_interval = true;
}

static void add_motion(const struct summary *summary, struct answer *answer)
{
    const struct measured_landing *measured = &summary->measured;
    const struct mr_gates_summary *fit = &measured->summary;
    char switches[200];
    summary_format_switches(measured, switches, sizeof switches);
    answer_add_text(answer, NULL, "switches", "%s", switches);
    add_switch_events(summary, answer);
    answer_add_count(answer, "switches", NULL, (int64_t)measured->switch_count);
    answer_add_count(answer, "switches_seen", NULL, (int64_t)measured->gate_count);
    answer_add_text(answer, "fit", NULL, "%s", mr_status_text(measured->fit_status));
    if (measured->fit_status == MR_OK || measured->fit_status == MR_TRUNCATED)
        add_motion_estimate("touchdown_speed", "touchdown", UNIT_SPEED, fit->touchdown_speed_ft_s,
                            4, answer);
    if (measured->fit_status == MR_TRUNCATED) {
        char reason[MEASURED_REASON_SIZE];
        measured_format_unknown_stop(measured, reason);
        answer_add_text(answer, NULL, "stop", "not known: %s", reason);
    } else if (measured->fit_status != MR_OK) {
        answer_add_text(answer, NULL, "motion", "not known: %s",
                        measured->is_start_missing ? "the first switch edges were not received"
                                                   : mr_status_text(measured->fit_status));
    } else {
        add_motion_estimate("mean_deceleration", "deceleration", UNIT_DECELERATION,
                            fit->mean_deceleration_ft_s2, 4, answer);
        add_motion_estimate("stop_station", "stop", UNIT_STATION, fit->stop_station_ft, 3, answer);
        answer_add_value(answer, "stop_after_touchdown", "time to rest", UNIT_TIME,
                         fit->stop_t_s.value - fit->touchdown_t_s.value, 3)
            ->digits = 9;
        answer_add_count(answer, "stop_gates", NULL, fit->gates_used_for_stop);
    }
}

static void add_channel(const struct measured_landing *measured,
                        const struct measured_channel *channel, struct answer *answer)
{
    const bool gage = channel->config.kind == MR_KIND_TENSION;
    const enum unit_kind unit = gage ? UNIT_TENSION : UNIT_DISPLACEMENT;
    const int decimals = gage ? 1 : 4;
    const double valid = measured->samples
                           ? (double)channel->valid_samples / (double)measured->samples
                           : 0.0;
    answer_add_count(answer, "number", gage ? "gage" : "transducer", channel->config.number);
    if (gage)
        answer_add_count(answer, "band", "band", channel->config.band);
    answer_add_value(answer, "station", "station", UNIT_STATION, (double)channel->config.station_ft,
                     1)
        ->digits = 9;
    answer_add_value(answer, "before", gage ? "before" : NULL, unit, channel->baseline, decimals)
        ->digits = 9;
    if (!gage) {
        answer_add_estimate(answer, NULL, "peak", unit, channel->peak, channel->peak_error,
                            decimals);
        answer_add_value(answer, "peak", NULL, unit, channel->peak, decimals)->digits = 9;
    }
    answer_add_value(answer, "error", NULL, unit, channel->peak_error, decimals)->digits = 9;
    answer_add_estimate(answer, "least", gage ? "least" : NULL, unit, channel->low,
                        channel->low_error, decimals)
        ->digits = 9;
    answer_add_estimate(answer, "most", gage ? "most" : NULL, unit, channel->high,
                        channel->high_error, decimals)
        ->digits = 9;
    answer_add_estimate(answer, "end", "at the end", unit, channel->end, channel->end_error,
                        decimals)
        ->digits = 9;
    if (channel->missing_end > channel->missing_start) {
        answer_add_value(answer, "missing_from", NULL, UNIT_TIME,
                         measured_time_s(measured, channel->missing_start), 3)
            ->digits = 9;
        answer_add_value(answer, "missing_to", NULL, UNIT_TIME,
                         measured_time_s(measured, channel->missing_end), 3)
            ->digits = 9;
    }
    answer_add_value(answer, "valid_fraction", NULL, UNIT_NUMBER, valid, 3);
    answer_add_value(answer, NULL, "valid|%", UNIT_NUMBER, 100.0 * valid, 1);
}

void summary_add_channels(const struct measured_landing *measured, enum mr_channel_kind kind,
                          const char *label, struct answer *answer)
{
    bool any = false;
    if (label)
        add_missing_samples(measured, kind, answer);
    for (unsigned c = 0; c < MR_CHANNELS; c++)
        any |= measured->channel[c].config.kind == kind;
    answer_open_table(answer, kind == MR_KIND_TENSION ? "tensions" : "displacements",
                      any ? label : NULL);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (measured->channel[c].config.kind != kind)
            continue;
        answer_open_row(answer);
        add_channel(measured, &measured->channel[c], answer);
    }
    answer_close_group(answer);
}

static void add_channels(const struct measured_landing *measured, struct answer *answer)
{
    bool read = measured->source != MEASURED_NO_SOURCE;
    summary_add_channels(measured, MR_KIND_DISPLACEMENT,
                         read ? "movement of the mat (+-: one standard error; -: not valid)" : NULL,
                         answer);
    summary_add_channels(
        measured, MR_KIND_TENSION,
        read ? "tension of the bands (+-: one standard error; -: not valid)" : NULL, answer);
}

static void add_faults(const struct summary *summary, struct answer *answer)
{
    if (summary->fault_count == 0)
        answer_add_text(answer, NULL, "faults", "none");
    answer_open_table(answer, "faults", "faults");
    for (size_t i = 0; i < summary->fault_count; i++) {
        const struct store_fault *fault = &summary->fault[i];
        answer_open_row(answer);
        answer_add_count(answer, "code", NULL, fault->code);
        answer_add_text(answer, "text", "fault", "%s", mr_fault_text((unsigned)fault->code));
        answer_add_count(answer, "detail", "[detail]", fault->detail);
        answer_add_count(answer, "count", "times", fault->count);
    }
    answer_close_group(answer);
}

static void add_import(const struct summary *summary, struct answer *answer)
{
    const struct store_import *import = &summary->import;
    if (!summary->is_imported) {
        answer_add_missing_value(answer, "import", NULL, "");
        return;
    }
    answer_open_group(answer, "import", "");
    answer_add_text(answer, NULL, "imported from", "%s (%s%s%s, %lld bytes, SHA-256 %s)",
                    import->file, import->format, import->bus[0] ? " of " : "", import->bus,
                    (long long)import->bytes, import->sha256);
    answer_add_text(answer, "file", NULL, "%s", import->file);
    answer_add_text_or_missing(answer, "bus", NULL, import->bus[0] ? import->bus : NULL, NULL);
    answer_add_text(answer, "verdict", "file state", "%s", import->verdict);
    answer_add_text(answer, "sha256", NULL, "%s", import->sha256);
    answer_add_count(answer, "bytes", NULL, import->bytes);
    answer_close_group(answer);
}

static void add_source(const struct measured_landing *measured, struct answer *answer)
{
    char source[MEASURED_SOURCE_SIZE];
    measured_format_source(measured, source);
    answer_add_text(answer, NULL, "readings", "%s", source);
    answer_add_text(answer, "source", NULL, "%s", measured_source_name(measured->source));
    answer_open_table(answer, "stretches", NULL);
    for (size_t i = 0; i < measured->stretch_count; i++) {
        answer_open_row(answer);
        answer_add_text(answer, "source", NULL, "%s",
                        measured_source_name(measured->stretch[i].source));
        answer_add_count(answer, "from_block", NULL, measured->stretch[i].from_block);
        answer_add_count(answer, "to_block", NULL, measured->stretch[i].to_block);
    }
    answer_close_group(answer);
    answer_add_json(answer, "set_aside", measured_excluded_json(measured));
}

static const char *text_or_unknown(const char *text)
{
    return text[0] ? text : "unknown";
}

static void add_board(const struct store_landing *landing, int64_t can_base, struct answer *answer)
{
    answer_add_text(answer, NULL, "board", "%s", text_or_unknown(landing->board_uid));
    if (can_base > 0)
        answer_append_remark(answer, ", at base 0x%03llx on CAN", (unsigned long long)can_base);
    answer_add_text(answer, "board", NULL, "%s", landing->board_uid);
    answer_add_count(answer, "can_base", NULL, can_base == STORE_NONE ? 0 : can_base);
    answer_add_text(
        answer, NULL, "firmware", "%s, image %08llx, commit %s", text_or_unknown(landing->firmware),
        landing->image_crc == STORE_NONE ? 0ull : (unsigned long long)landing->image_crc,
        text_or_unknown(landing->image_commit));
    answer_add_text(answer, "firmware", NULL, "%s", landing->firmware);
    answer_add_count(answer, "image_crc", NULL, landing->image_crc);
    answer_add_text(answer, "image_commit", NULL, "%s", landing->image_commit);
    answer_add_count(answer, "config_crc", NULL, landing->config_crc);
    answer_add_count(answer, "clock_source", NULL, landing->clock_source);
    answer_add_text(answer, NULL, "oscillator",
                    landing->clock_source == STORE_NONE ? "not known"
                    : landing->clock_source > 0 ? "internal oscillator: 1 %% error in all speeds"
                                                : "crystal");
}

void summary_add_calibration(const struct measured_landing *measured, struct answer *answer)
{
    answer_add_json(answer, "uncalibrated",
                    measured->has_calibration_dates ? json_boolean(measured->is_uncalibrated)
                                                    : json_null());
}

void summary_format_heading(const struct summary *summary, char out[SUMMARY_HEADING_SIZE])
{
    const struct store_landing *landing = &summary->measured.landing;
    snprintf(out, SUMMARY_HEADING_SIZE, "RUN %lld: landing %lld, %s%s%s", (long long)landing->id,
             (long long)landing->board_landing, mr_landing_state_text((unsigned)landing->state),
             measured_quality_text(&summary->measured),
             measured_is_emulated(landing) ? " (emulated board, synthetic data)" : "");
}

void summary_add_alerts(const struct summary *summary, struct answer *answer)
{
    const struct measured_landing *measured = &summary->measured;
    char torn[MEASURED_MISSING_START_SIZE];
    measured_format_missing_start(measured, torn);
    if (torn[0])
        answer_add_text(answer, NULL, "incomplete", "%s", torn + strlen("incomplete: "))
            ->is_warning = true;
    answer_add_flag(answer, "torn", NULL, measured->is_start_missing);
    if (summary->duplicate_run)
        answer_add_text(answer, NULL, "twice", "RUN %lld is the same landing",
                        (long long)summary->duplicate_run)
            ->is_warning = true;
    answer_add_count(answer, "same_as", NULL,
                     summary->duplicate_run ? summary->duplicate_run : ANSWER_COUNT_UNKNOWN);
    summary_add_calibration(measured, answer);
    add_restarts(summary, answer);
    add_commands(summary, answer);
    add_ready_checks(summary->ready_check, answer);
}

void summary_add_facts(const struct summary *summary, struct answer *answer)
{
    const struct measured_landing *measured = &summary->measured;
    summary_add_alerts(summary, answer);
    add_motion(summary, answer);
    braking_to_answer(&summary->braking, answer);
    add_channel_events(summary, answer);
    add_source(measured, answer);
    add_import(summary, answer);
    add_mean(summary->mean, answer);
    predictor_inputs_to_answer(&summary->predictor_inputs, measured, answer);
    add_board(&measured->landing, summary->session.can_base, answer);
}

void summary_add_health(const struct summary *summary, struct answer *answer)
{
    summary_add_times(summary, answer);
    add_links(summary, answer);
    add_faults(summary, answer);
}

void summary_add_zone(const struct summary *summary, struct answer *answer)
{
    zones_to_answer(&summary->zones, summary->measured.source != MEASURED_IMPORT, answer);
}

void summary_to_answer(const struct summary *summary, struct answer *answer)
{
    const struct store_landing *landing = &summary->measured.landing;
    char heading[SUMMARY_HEADING_SIZE];
    summary_format_heading(summary, heading);
    answer_open_group(answer, NULL, heading);
    answer_add_count(answer, "run", NULL, landing->id);
    answer_add_count(answer, "landing", NULL, landing->board_landing);
    answer_add_text(answer, "state", NULL, "%s", mr_landing_state_text((unsigned)landing->state));
    answer_add_flag(answer, "emulated", NULL, measured_is_emulated(landing));
    if (summary->outcome.is_evaluated)
        outcome_record_add_outcome(&summary->outcome, answer);
    summary_add_facts(summary, answer);
    summary_add_zone(summary, answer);
    add_channels(&summary->measured, answer);
    bands_to_answer(&summary->bands, &summary->measured, answer);
    bands_add_shunts(&summary->bands, false, answer);
    summary_add_health(summary, answer);
    answer_close_group(answer);
}

json_t *summary_to_json(const struct summary *summary, bool si)
{
    struct answer *answer = answer_new(si);
    summary_to_answer(summary, answer);
    json_t *json = answer_make_json(answer);
    answer_free(answer);
    return json;
}
