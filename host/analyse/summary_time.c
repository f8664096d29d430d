#include "host/analyse/summary_time.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "host/link/timemap.h"
#include "host/base/units.h"

#define BLOCK_US    1000.0
#define DAY_MOST_US 1e17 /* the year 5138 */

/* The best map is one that is good, and of two that of CAN, whose least delay is the shorter; of
 * two that are none, the one that says more. */
static bool better(const struct store_time_map *a, const struct store_time_map *b)
{
    if (a->refusal != TIMEMAP_GOOD || b->refusal != TIMEMAP_GOOD)
        return b->refusal != TIMEMAP_GOOD &&
               (a->refusal == TIMEMAP_GOOD || a->refusal > b->refusal);
    return a->link == LINK_CAN && b->link != LINK_CAN;
}

enum mr_status summary_time_clock(struct store *store, int64_t run, struct store_time_map *clock,
                                  bool *known, struct error *error)
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
    return (struct summary_moment){
        (double)clock->host_us + since_us / (1.0 + clock->fast_ppm * 1e-6),
        clock->host_half_us + fabs(since_us) * clock->fast_half_ppm * 1e-6};
}

/* The frame that said the first warning, on one link. */
struct told {
    int64_t block_us, host_us; /* STORE_NONE: it did not come over this link */
};

static enum mr_status find_told(void *context, const struct store_frame *frame)
{
    struct told *told = context;
    if (frame->id == MR_ID_ZONE_LEAD && frame->board_us == told->block_us &&
        (told->host_us == STORE_NONE || frame->host_us < told->host_us))
        told->host_us = frame->host_us;
    return MR_OK;
}

/* Decided on the board and received by this computer are two moments; only a clock that both share
 * tells them apart. */
static enum mr_status load_received(struct store *store, struct summary *summary,
                                    struct error *error)
{
    const struct zone_warning *warning = &summary->zones.warning;
    enum mr_status status = MR_OK;
    for (int kind = 0; kind < LINK_KINDS; kind++)
        summary->warning_received_s[kind] = (double)NAN;
    if (!warning->warned || !summary->clock_known || summary->clock.refusal != TIMEMAP_GOOD ||
        warning->block < 0 || warning->block > UINT32_MAX)
        return MR_OK;
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct told told = {1000 * warning->block, STORE_NONE};
        status = store_frames_each(store, summary->measured.landing.id, kind, find_told, &told,
                                   error);
        struct summary_moment complete = summary_time_by(&summary->clock,
                                                         1000.0 * (double)(warning->block + 1));
        double late_us = (double)told.host_us - complete.host_us;
        /* else stamped by another clock than the map's */
        if (told.host_us != STORE_NONE && late_us > -complete.half_us - BLOCK_US)
            summary->warning_received_s[kind] = late_us / 1e6;
    }
    return status;
}

enum mr_status summary_time_load(struct store *store, struct summary *summary, struct error *error)
{
    enum mr_status status = film_load(store, &summary->measured, &summary->film, error);
    if (status == MR_OK)
        status = summary_time_clock(store, summary->measured.landing.id, &summary->clock,
                                    &summary->clock_known, error);
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

static void clock_answer(const struct summary *summary, struct answer *answer)
{
    const struct store_time_map *clock = &summary->clock;
    const struct summary_moment touchdown = summary_time_of_day(summary,
                                                                (double)summary->measured.t0_us);
    bool good = clock->refusal == TIMEMAP_GOOD;
    char day[60];
    if (!summary->clock_known)
        return;
    answer_open(answer, "clock", "");
    answer_flag(answer, "good", NULL, good);
    answer_words(answer, "text", NULL, "%s", timemap_refusal_text((unsigned)clock->refusal));
    if (good) {
        answer_words(answer, NULL, "clock",
                     "board %.2f +- %.2f ppm %s (%s, %lld moments); times of day within %.2f ms "
                     "(95 %%) and the link's least delay",
                     fabs(clock->fast_ppm), clock->fast_half_ppm,
                     clock->fast_ppm < 0.0 ? "slow" : "fast", summary_link_name((int)clock->link),
                     (long long)clock->pairs, clock->host_half_us / 1e3);
        answer_words(answer, "link", NULL, clock->link == LINK_CAN ? "can" : "serial");
        answer_count(answer, "moments", NULL, clock->pairs);
        answer_value(answer, "fast_ppm", NULL, UNIT_NUMBER, clock->fast_ppm, 2);
        answer_value(answer, "fast_half_ppm", NULL, UNIT_NUMBER, clock->fast_half_ppm, 2);
        answer_count(answer, "t0_unix_us", NULL, llround(touchdown.host_us));
        answer_value(answer, "t0_half_us", NULL, UNIT_NUMBER, touchdown.half_us, 0);
    } else {
        answer_words(answer, NULL, "clock", "no times of day: %s",
                     timemap_refusal_text((unsigned)clock->refusal));
    }
    if (good && summary->measured.t0_is_touchdown) {
        day_text(touchdown.host_us, day, sizeof day);
        answer_words(answer, NULL, "touchdown at", "%s", day);
    }
    answer_close(answer);
}

static void received_answer(const struct summary *summary, struct answer *answer)
{
    const struct zone_warning *warning = &summary->zones.warning;
    if (!summary->clock_known)
        return;
    answer_open(answer, "warning_received_s", "");
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        double received_s = summary->warning_received_s[kind];
        struct summary_moment decided = summary_time_of_day(summary,
                                                            1000.0 * (double)(warning->block + 1));
        answer_value(answer, kind == LINK_CAN ? "can" : "serial", NULL, UNIT_NUMBER, received_s, 6);
        if (!isnan(received_s))
            answer_words(answer, NULL, "received",
                         "the first warning over %s %.1f ms after it was decided (95 %%: +- %.1f, "
                         "and the link's least delay)",
                         summary_link_name(kind), 1e3 * received_s, decided.half_us / 1e3);
    }
    answer_close(answer);
}

static void film_answer(const struct summary *summary, struct answer *answer)
{
    const struct film *film = &summary->film;
    const struct unit *station = unit_of(UNIT_STATION, answer_in_si(answer));
    double worst_ft = 0.0;
    size_t placed = 0;
    char gear[80] = "";
    if (film->frames == 0)
        return;
    for (size_t i = 0; i < film->frames; i++) {
        if (isnan(film->frame[i].station_ft.value))
            continue;
        worst_ft = fmax(worst_ft, film->frame[i].station_ft.error);
        placed++;
    }
    if (placed)
        snprintf(gear, sizeof gear, "; gear on %zu of them within %.3f %s (95 %%)", placed,
                 SUMMARY_95 * worst_ft * station->factor, station->text);
    answer_open(answer, "film", "");
    answer_words(answer, NULL, "film", "%zu frames, %.2f a second, %lld missing%s", film->frames,
                 film->rate_hz, (long long)film->missing, gear);
    answer_count(answer, "frames", NULL, (int64_t)film->frames);
    answer_count(answer, "missing", NULL, film->missing);
    answer_value(answer, "rate_hz", NULL, UNIT_NUMBER, film->rate_hz, 2)->digits = 9;
    answer_close(answer);
}

void summary_time_answer(const struct summary *summary, struct answer *answer)
{
    clock_answer(summary, answer);
    received_answer(summary, answer);
    film_answer(summary, answer);
}
