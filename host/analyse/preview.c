#include "host/analyse/measured_load.h"
#include "host/analyse/preview.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/summary.h"
#include "host/survey/survey.h"

#define NOTE_SHOWN 60 /* characters of a note, for people */

static enum mr_status load_links(struct store *store, int64_t run, struct preview *glance,
                                 struct error *error)
{
    struct store_gap *gap = NULL;
    size_t gaps = 0;
    enum mr_status status = store_gaps(store, run, &gap, &gaps, error);
    if (status == MR_OK)
        summary_count_gaps(gap, gaps, glance->link);
    free(gap);
    return status;
}

static enum mr_status load_said(struct store *store, int64_t run, struct preview *glance,
                                struct error *error)
{
    struct store_observation *row = NULL;
    size_t count = 0;
    enum mr_status status = store_changes(store, run, &glance->change, &glance->changes, error);
    if (status == MR_OK)
        status = store_observations(store, run, &row, &count, error);
    for (size_t i = 0; i < count; i++)
        glance->seen += !row[i].withdrawn;
    free(row);
    return status == MR_OK ? store_is_void(store, run, &glance->is_void, NULL, error) : status;
}

enum mr_status preview_load(struct store *store, int64_t run, struct preview *glance,
                            struct error *error)
{
    struct store_import import = {0};
    memset(glance, 0, sizeof *glance);
    enum mr_status status = measured_load_gear(store, run, &glance->measured, error);
    if (status == MR_OK)
        status = zones_load(store, &glance->measured, &glance->zones, error);
    if (status == MR_OK)
        status = load_links(store, run, glance, error);
    if (status == MR_OK)
        status = store_series_of(store, &glance->measured.landing, &glance->series, error);
    if (status == MR_OK)
        status = load_said(store, run, glance, error);
    if (status == MR_OK)
        status = store_frames_base(store, run, &glance->can_base, error);
    if (status == MR_OK)
        status = store_import_get(store, glance->measured.landing.session, &import,
                                  &glance->imported, error);
    free(import.mapping);
    return status == MR_OK ? store_edges(store, run, &glance->edge, &glance->edges, error) : status;
}

void preview_free(struct preview *glance)
{
    measured_free(&glance->measured);
    zones_free(&glance->zones);
    free(glance->change);
    free(glance->edge);
}

/* ---- a row ---- */

static void state_text(const struct preview *glance, char *out, size_t size)
{
    snprintf(out, size, "%lld, %s%s%s%s", (long long)glance->measured.landing.board_landing,
             mr_landing_state_text((unsigned)glance->measured.landing.state),
             glance->is_void ? ", VOID" : "", glance->imported ? ", imported" : "",
             glance->measured.torn ? ", torn" : "");
}

static void motion_answer(const struct measured *measured, struct answer *answer)
{
    const struct mr_gates_summary *fit = &measured->summary;
    const struct mr_estimate none = {(double)NAN, (double)NAN};
    bool fitted = measured->fit_status == MR_OK,
         speed_known = fitted || measured->fit_status == MR_TRUNCATED;
    struct mr_estimate speed = speed_known ? fit->touchdown_speed_ft_s : none,
                       stop = fitted ? fit->stop_station_ft : none;
    answer_estimate(answer, "touchdown_speed", "touchdown", UNIT_SPEED, speed.value, speed.error, 3)
        ->digits = 9;
    answer_estimate(answer, "stop_station", "stop", UNIT_STATION, stop.value, stop.error, 2)
        ->digits = 9;
}

static void warning_answer(const struct preview *glance, struct answer *answer)
{
    const struct zone_warning *w = &glance->zones.warning;
    const struct unit *station = unit_of(UNIT_STATION, answer_in_si(answer));
    char doubt[ZONES_HEARD_TEXT], label[20];
    bool watched = glance->measured.source != MEASURED_IMPORT;
    bool all_heard = watched && !zones_heard_doubt(&glance->zones.heard, (double)INFINITY, doubt);
    snprintf(label, sizeof label, "warned of|%s", station->text);
    if (w->warned)
        answer_words(answer, NULL, label, "%.1f to %.1f", station->factor * w->start_ft,
                     station->factor * w->end_ft)
            ->warn = true;
    else
        answer_words(answer, NULL, label, "%s",
                     !watched    ? "no board"
                     : all_heard ? "none"
                                 : "not known");
    answer_flag(answer, "warned", NULL, w->warned);
    answer_flag(answer, "all_heard", NULL, all_heard);
    answer_value(answer, "warning_t", NULL, UNIT_TIME, w->warned ? w->t_s : (double)NAN, 3)
        ->digits = 9;
    answer_value(answer, "warning_start", NULL, UNIT_STATION, w->warned ? w->start_ft : (double)NAN,
                 1)
        ->digits = 9;
    answer_value(answer, "warning_end", NULL, UNIT_STATION, w->warned ? w->end_ft : (double)NAN, 1)
        ->digits = 9;
}

static void lost_answer(const struct preview *glance, struct answer *answer)
{
    const struct summary_link *can = &glance->link[LINK_CAN], *serial = &glance->link[LINK_SERIAL];
    answer_words(answer, NULL, "frames|lost", "%lld%s", (long long)(can->lost + serial->lost),
                 can->silent || serial->silent ? ", more" : "");
    answer_count(answer, "lost", NULL, can->lost + serial->lost);
    answer_count(answer, "dropped", NULL, can->dropped + serial->dropped);
    answer_flag(answer, "silent", NULL, can->silent || serial->silent);
}

static void add(char *out, size_t size, const char *text)
{
    size_t used = strlen(out);
    snprintf(out + used, size - used, "%s%s", used ? "; " : "", text);
}

/* The newest note, how many there are besides, what was seen, and what else is to be known. */
static void said_answer(const struct preview *glance, int64_t same, struct answer *answer)
{
    char text[NOTE_SHOWN + 120] = "", part[NOTE_SHOWN + 40];
    const char *newest = NULL;
    size_t notes = 0;
    for (size_t i = 0; i < glance->changes; i++) {
        if (strcmp(glance->change[i].field, "note") != 0)
            continue;
        newest = glance->change[i].value;
        notes++;
    }
    if (same) {
        snprintf(part, sizeof part, "the same landing as RUN %lld", (long long)same);
        add(text, sizeof text, part);
    }
    if (newest) {
        size_t length = strlen(newest), shown = length > NOTE_SHOWN ? NOTE_SHOWN - 3 : length;
        while (length > NOTE_SHOWN && ((unsigned char)newest[shown] & 0xc0u) == 0x80u)
            shown--; /* a character of several bytes stays whole */
        snprintf(part, sizeof part, "%.*s%s", (int)shown, newest, length > NOTE_SHOWN ? "..." : "");
        add(text, sizeof text, part);
    }
    if (notes > 1) {
        snprintf(part, sizeof part, "%zu notes", notes);
        add(text, sizeof text, part);
    }
    if (glance->seen) {
        snprintf(part, sizeof part, "%zu seen", glance->seen);
        add(text, sizeof text, part);
    }
    answer_words(answer, NULL, "notes", "%s", text);
    answer_list(answer, "notes", NULL);
    for (size_t i = 0; i < glance->changes; i++) {
        if (strcmp(glance->change[i].field, "note") == 0)
            answer_words(answer, NULL, NULL, "%s", glance->change[i].value);
    }
    answer_close(answer);
    answer_count(answer, "seen", NULL, (int64_t)glance->seen);
    answer_count(answer, "same_as", NULL, same ? same : ANSWER_UNKNOWN);
}

void preview_answer(const struct preview *glance, int64_t same, bool bases, struct answer *answer)
{
    const struct store_landing *landing = &glance->measured.landing;
    char when[40], state[80];
    survey_time_text(landing->armed_us, when, sizeof when);
    const int day_and_minute = (int)strcspn(when, "U") - 1; /* without UTC, which the head has */
    state_text(glance, state, sizeof state);
    answer_count(answer, "run", "RUN", landing->id);
    answer_words(answer, NULL, "armed|UTC", "%.*s", day_and_minute, when);
    answer_words(answer, "armed", NULL, "%s", when);
    answer_count(answer, "armed_us", NULL, landing->armed_us);
    answer_words_or_none(answer, "series", "series", glance->series.name, "-");
    answer_words(answer, NULL, "landing", "%s", state);
    answer_count(answer, "landing", NULL, landing->board_landing);
    answer_words(answer, "state", NULL, "%s", mr_landing_state_text((unsigned)landing->state));
    answer_words(answer, "board", NULL, "%s", landing->board_uid);
    if (bases)
        answer_words(answer, NULL, "board at|CAN base", "0x%03x", glance->can_base);
    answer_count(answer, "can_base", NULL, glance->can_base);
    answer_flag(answer, "void", NULL, glance->is_void);
    answer_flag(answer, "imported", NULL, glance->imported);
    answer_flag(answer, "torn", NULL, glance->measured.torn);
    motion_answer(&glance->measured, answer);
    warning_answer(glance, answer);
    lost_answer(glance, answer);
    said_answer(glance, same, answer);
}
