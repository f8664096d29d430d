#include "host/analyse/summary_time.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "common/catalogue.h"
#include "host/base/cli.h"
#include "host/link/timemap.h"
#include "host/base/units.h"

#define BLOCK_US 1000.0
#define DAY_MOST_US 1e17 /* the year 5138 */

/* The best map is one that is good, and of two that of CAN, whose least delay is the shorter; of two that are none, the one that
 * says more. */
static bool better(const struct store_time_map *a, const struct store_time_map *b)
{
    if (a->refusal != TIMEMAP_GOOD || b->refusal != TIMEMAP_GOOD)
        return b->refusal != TIMEMAP_GOOD && (a->refusal == TIMEMAP_GOOD || a->refusal > b->refusal);
    return a->link == LINK_CAN && b->link != LINK_CAN;
}

enum mr_status summary_time_clock(struct store *store, int64_t run, struct store_time_map *clock, bool *known, struct error *error)
{
    struct store_time_map *map = NULL;
    size_t maps = 0;
    *known = false;
    enum mr_status status = store_time_maps(store, run, &map, &maps, error);
    for (size_t i = 0; status == MR_OK && i < maps; i++) {
        if (!*known || better(&map[i], clock))
            *clock = map[i];
        *known = true;
    }
    free(map);
    return status;
}

struct summary_moment summary_time_by(const struct store_time_map *clock, double board_us)
{
    double since_us = board_us - (double)clock->board_us;
    return (struct summary_moment){(double)clock->host_us + since_us / (1.0 + clock->fast_ppm * 1e-6),
                                   clock->host_half_us + fabs(since_us) * clock->fast_half_ppm * 1e-6};
}

/* The frame that said the first warning, on one link. */
struct told {
    int64_t block_us, host_us; /* STORE_NONE: it did not come over this link */
};

static enum mr_status find_told(void *context, const struct store_frame *frame)
{
    struct told *told = context;
    if (frame->id == MR_ID_ZONE_LEAD && frame->board_us == told->block_us && (told->host_us == STORE_NONE || frame->host_us < told->host_us))
        told->host_us = frame->host_us;
    return MR_OK;
}

/* Decided on the board and received by this computer are two moments; only a clock that both share tells them apart. */
static enum mr_status load_received(struct store *store, struct summary *summary, struct error *error)
{
    const struct zone_warning *warning = &summary->zones.warning;
    enum mr_status status = MR_OK;
    for (int kind = 0; kind < LINK_KINDS; kind++)
        summary->warning_received_s[kind] = (double)NAN;
    if (!warning->warned || !summary->clock_known || summary->clock.refusal != TIMEMAP_GOOD || warning->block < 0 || warning->block > UINT32_MAX)
        return MR_OK;
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct told told = {1000 * warning->block, STORE_NONE};
        status = store_frames_each(store, summary->measured.landing.id, kind, find_told, &told, error);
        struct summary_moment complete = summary_time_by(&summary->clock, 1000.0 * (double)(warning->block + 1));
        double late_us = (double)told.host_us - complete.host_us;
        if (told.host_us != STORE_NONE && late_us > -complete.half_us - BLOCK_US) /* else stamped by another clock than the map's */
            summary->warning_received_s[kind] = late_us / 1e6;
    }
    return status;
}

enum mr_status summary_time_load(struct store *store, struct summary *summary, struct error *error)
{
    enum mr_status status = film_load(store, &summary->measured, &summary->film, error);
    if (status == MR_OK)
        status = summary_time_clock(store, summary->measured.landing.id, &summary->clock, &summary->clock_known, error);
    return status == MR_OK ? load_received(store, summary, error) : status;
}

struct summary_moment summary_time_of_day(const struct summary *summary, double board_us)
{
    if (!summary->clock_known || summary->clock.refusal != TIMEMAP_GOOD)
        return (struct summary_moment){(double)NAN, (double)NAN};
    return summary_time_by(&summary->clock, board_us);
}

/* "2026-11-21 22:28:14.1234 UTC" */
static void day_text(double host_us, char *out, size_t size)
{
    time_t second = fabs(host_us) < DAY_MOST_US ? (time_t)floor(host_us / 1e6) : 0;
    struct tm utc;
    char text[40];
    if (!(fabs(host_us) < DAY_MOST_US) || !gmtime_r(&second, &utc)) {
        snprintf(out, size, "a time that no calendar has");
        return;
    }
    strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &utc);
    snprintf(out, size, "%s.%04d UTC", text, (int)floor((host_us / 1e6 - (double)second) * 1e4));
}

static void print_clock(const struct summary *summary, FILE *out)
{
    const struct store_time_map *clock = &summary->clock;
    char day[60];
    if (!summary->clock_known)
        return;
    if (clock->refusal != TIMEMAP_GOOD) {
        fprintf(out, "  %-13s no times of day: %s\n", "clock", timemap_refusal_text((unsigned)clock->refusal));
        return;
    }
    fprintf(out, "  %-13s board %.2f +- %.2f ppm %s (%s, %lld moments); times of day within %.2f ms (95 %%) and the link's least delay\n", "clock",
            fabs(clock->fast_ppm), clock->fast_half_ppm, clock->fast_ppm < 0.0 ? "slow" : "fast",
            summary_link_name((int)clock->link), (long long)clock->pairs, clock->host_half_us / 1e3);
    if (!summary->measured.t0_is_touchdown)
        return;
    day_text(summary_time_of_day(summary, (double)summary->measured.t0_us).host_us, day, sizeof day);
    fprintf(out, "  %-13s %s\n", "touchdown at", day);
}

static void print_received(const struct summary *summary, FILE *out)
{
    const struct zone_warning *warning = &summary->zones.warning;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        if (isnan(summary->warning_received_s[kind]))
            continue;
        struct summary_moment decided = summary_time_of_day(summary, 1000.0 * (double)(warning->block + 1));
        fprintf(out, "  %-13s the first warning over %s %.1f ms after it was decided (95 %%: +- %.1f, and the link's least delay)\n", "received",
                summary_link_name(kind), 1e3 * summary->warning_received_s[kind], decided.half_us / 1e3);
    }
}

static void print_film(const struct summary *summary, bool si, FILE *out)
{
    const struct film *film = &summary->film;
    const struct unit *station = unit_of(UNIT_STATION, si);
    double worst_ft = 0.0;
    size_t placed = 0;
    if (film->frames == 0)
        return;
    for (size_t i = 0; i < film->frames; i++) {
        if (isnan(film->frame[i].station_ft.value))
            continue;
        worst_ft = fmax(worst_ft, film->frame[i].station_ft.error);
        placed++;
    }
    fprintf(out, "  %-13s %zu frames, %.2f a second, %lld missing", "film", film->frames, film->rate_hz,
            (long long)film->missing);
    if (placed)
        fprintf(out, "; gear on %zu of them within %.3f %s (95 %%)", placed, SUMMARY_95 * worst_ft * station->factor,
                station->text);
    fputc('\n', out);
}

void summary_time_print(const struct summary *summary, bool si, FILE *out)
{
    print_clock(summary, out);
    print_received(summary, out);
    print_film(summary, si, out);
}

void summary_time_json(const struct summary *summary, json_t *object)
{
    const struct store_time_map *clock = &summary->clock;
    if (summary->clock_known) {
        bool good = clock->refusal == TIMEMAP_GOOD;
        json_t *row = json_pack("{sbss}", "good", good, "text", timemap_refusal_text((unsigned)clock->refusal));
        if (good) {
            struct summary_moment touchdown = summary_time_of_day(summary, (double)summary->measured.t0_us);
            json_object_set_new(row, "link", json_string(clock->link == LINK_CAN ? "can" : "serial"));
            json_object_set_new(row, "moments", json_integer((json_int_t)clock->pairs));
            json_object_set_new(row, "fast_ppm", cli_json_number(clock->fast_ppm, 6));
            json_object_set_new(row, "fast_half_ppm", cli_json_number(clock->fast_half_ppm, 6));
            json_object_set_new(row, "t0_unix_us", json_integer((json_int_t)llround(touchdown.host_us)));
            json_object_set_new(row, "t0_half_us", cli_json_number(touchdown.half_us, 6));
        }
        json_object_set_new(object, "clock", row);
        json_object_set_new(object, "warning_received_s",
                            json_pack("{soso}", "can", cli_json_number(summary->warning_received_s[LINK_CAN], 6), "serial",
                                      cli_json_number(summary->warning_received_s[LINK_SERIAL], 6)));
    }
    if (summary->film.frames)
        json_object_set_new(object, "film", json_pack("{sIsIso}", "frames", (json_int_t)summary->film.frames, "missing",
                                                      (json_int_t)summary->film.missing, "rate_hz",
                                                      cli_json_number(summary->film.rate_hz, 9)));
}
