#include "host/analyse/doubts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "host/analyse/measured.h"
#include "host/link/link.h"

static enum doubt cause_of(const struct store_trouble *row)
{
    return (enum doubt)(row->code % DOUBT_ID);
}

static enum mr_status load_first_edge(struct store *store, int64_t run, struct doubts *doubts,
                                      struct error *error)
{
    struct store_edge *edges = NULL;
    size_t count;
    enum mr_status status = store_edges(store, run, &edges, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (edges[i].count > 0 && (doubts->first_edge == 0 || edges[i].count < doubts->first_edge))
            doubts->first_edge = edges[i].count;
    }
    doubts->torn = doubts->first_edge > 1;
    free(edges);
    return status;
}

enum mr_status doubts_load(struct store *store, int64_t run, struct doubts *doubts,
                           struct error *error)
{
    memset(doubts, 0, sizeof *doubts);
    enum mr_status status = store_doubts(store, run, &doubts->row, &doubts->rows, error);
    return status == MR_OK ? load_first_edge(store, run, doubts, error) : status;
}

void doubts_free(struct doubts *doubts)
{
    free(doubts->row);
    doubts->row = NULL;
}

static enum mr_status find_can(struct store *store, const struct measured *measured, bool *on_can,
                               struct error *error)
{
    struct store_session_row session;
    struct store_gap *gaps = NULL;
    size_t count = 0;
    enum mr_status status = store_session_get(store, measured->landing.session, &session, error);
    if (status == MR_OK)
        status = store_gaps(store, measured->landing.id, &gaps, &count, error);
    *on_can = measured->blocks_from[MEASURED_CAN] > 0 ||
              (status == MR_OK && !session.serial_link[0]);
    for (size_t i = 0; i < count; i++)
        *on_can |= gaps[i].link == LINK_SERIAL;
    for (size_t i = 0; i < measured->doubts.rows; i++)
        *on_can |= cause_of(&measured->doubts.row[i]) == DOUBT_ALONE;
    free(gaps);
    return status;
}

/* Frames in excess that are none of those that were recognised, and not obeyed. */
static int64_t excess_left(const struct doubts *doubts)
{
    int64_t left = 0;
    for (size_t i = 0; i < doubts->rows; i++) {
        enum doubt cause = cause_of(&doubts->row[i]);
        if (cause == DOUBT_EXCESS)
            left += doubts->row[i].count;
        /* those of another length are not counted as the board's */
        else if (!doubt_obeyed(cause) && cause != DOUBT_LENGTH)
            left -= doubts->row[i].count;
    }
    return left > 0 ? left : 0;
}

enum mr_status doubts_judge(struct store *store, const struct measured *measured,
                            struct doubts *doubts, struct error *error)
{
    enum mr_status status = doubts->rows ? find_can(store, measured, &doubts->on_can, error)
                                         : MR_OK;
    doubts->excess = doubts->on_can ? excess_left(doubts) : 0;
    doubts->doubtful = doubts->excess > 0;
    for (size_t i = 0; i < doubts->rows; i++) {
        enum doubt cause = cause_of(&doubts->row[i]);
        doubts->doubtful |= cause == DOUBT_TORN || cause == DOUBT_PHANTOM;
    }
    return status;
}

const char *doubts_mark(const struct doubts *doubts)
{
    return doubts->doubtful ? " (doubtful)" : "";
}

/* A landing that was torn or never was is worst, then what may have been obeyed, then what was
 * not. */
static int badness(const struct doubts *doubts, const struct store_trouble *row)
{
    switch (cause_of(row)) {
    case DOUBT_TORN:
    case DOUBT_PHANTOM: return 3;
    case DOUBT_EXCESS: return excess_left(doubts) > 0 ? 2 : 0;
    case DOUBT_ALONE: return 0; /* not told */
    default: return 1;
    }
}

static const struct store_trouble *row_at(const struct doubts *doubts, size_t i)
{
    for (int bad = 3; bad > 0; bad--) {
        for (size_t r = 0; r < doubts->rows; r++) {
            if (badness(doubts, &doubts->row[r]) == bad && i-- == 0)
                return &doubts->row[r];
        }
    }
    return NULL;
}

static const char *message_of(const struct store_trouble *row)
{
    unsigned place = mr_message_place((uint16_t)(row->code / DOUBT_ID));
    return row->code / DOUBT_ID && place < MR_PLACES ? mr_message_text(place) : NULL;
}

/* What is told of the i-th row: each frame once, so of those in excess the ones that nobody
 * recognised. */
struct told {
    const char *message; /* NULL: no single one */
    enum doubt cause;
    int64_t count;
    bool obeyed; /* what is stated may rest on them */
};

static bool told_at(const struct doubts *doubts, size_t i, struct told *told)
{
    const struct store_trouble *row = row_at(doubts, i);
    if (!row)
        return false;
    bool excess = cause_of(row) == DOUBT_EXCESS;
    *told = (struct told){.message = message_of(row),
                          .cause = cause_of(row),
                          .count = excess ? excess_left(doubts) : row->count,
                          .obeyed = excess ? doubts->excess > 0 : doubt_obeyed(cause_of(row))};
    return true;
}

/* Line `i` of what is doubted, the worst first; false: there are no more. */
static bool doubt_line(const struct doubts *doubts, size_t i, char out[DOUBTS_TEXT])
{
    struct told told;
    if (doubts->torn && i-- == 0) {
        snprintf(out, DOUBTS_TEXT,
                 "torn: of its edges those before number %lld never came; speeds are not stated",
                 (long long)doubts->first_edge);
        return true;
    }
    if (!told_at(doubts, i, &told))
        return false;
    const char *effect = told.obeyed                ? "what rests on CAN may be a stranger's"
                       : told.cause == DOUBT_EXCESS ? "no number rests on CAN"
                                                    : "not obeyed";
    snprintf(out, DOUBTS_TEXT, "CAN: %lld %s%s%s %s; %s", (long long)told.count,
             told.message ? told.message : "", told.message ? " " : "",
             told.count == 1 ? "frame" : "frames", doubt_text(told.cause), effect);
    return true;
}

void doubts_headline(const struct doubts *doubts, char out[DOUBTS_TEXT])
{
    char line[DOUBTS_TEXT];
    out[0] = '\0';
    if ((doubts->doubtful || doubts->torn) && doubt_line(doubts, 0, line))
        snprintf(out, DOUBTS_TEXT, "doubtful: %.*s", (int)DOUBTS_TEXT - 11, line);
}

void doubts_answer(const struct doubts *doubts, struct answer *answer)
{
    char line[DOUBTS_TEXT];
    struct told told;
    const bool warn = doubts->doubtful || doubts->torn;
    for (size_t i = 0; doubt_line(doubts, i, line); i++)
        answer_words(answer, NULL, warn ? "doubtful" : "strangers", "%s", line)->warn = warn;
    answer_open(answer, "doubts", NULL);
    answer_flag(answer, "doubtful", NULL, doubts->doubtful);
    answer_flag(answer, "torn", NULL, doubts->torn);
    answer_table(answer, "strangers", NULL);
    for (size_t i = 0; told_at(doubts, i, &told); i++) {
        answer_row(answer);
        answer_words(answer, "what", NULL, "%s", doubt_text(told.cause));
        answer_words(answer, "message", NULL, "%s", told.message ? told.message : "");
        answer_count(answer, "count", NULL, told.count);
        answer_flag(answer, "obeyed", NULL, told.obeyed);
    }
    answer_close(answer);
    answer_close(answer);
}
