/* One landing twice in a campaign: a log was ended in the middle of the landing, what the campaign
 * did not take was saved beside it, and is taken in with the landing from its beginning. What
 * proves that two are one are rows that no two landings share: a CAN frame with its stamp of this
 * computer's clock, which the saved log keeps; with serial alone a block's record. A recording that
 * is logged twice proves nothing: the second must go on where the first was cut off. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_journal.h"
#include "host/store/store_same.h"
#include "host/store/store_sql.h"

static enum mr_status ask(struct store *store, enum store_statement which, int64_t part,
                          int64_t whole, bool *there, struct error *error)
{
    int64_t answer = 0;
    enum mr_status status = store_number(store, error, which, &answer,
                                         STORE_VALUES(BIND(part), BIND(whole)));
    *there = answer == 1;
    return status;
}

static enum mr_status say(struct store *store, int64_t run, int64_t now_us, bool is_void,
                          const char *text, struct error *error)
{
    struct store_change change = {.run = run, .made_us = now_us, .who = "matrig log"};
    snprintf(change.field, sizeof change.field, is_void ? "void" : "note");
    /* a note is its own text */
    snprintf(change.value, sizeof change.value, "%s", is_void ? "yes" : text);
    snprintf(change.reason, sizeof change.reason, "%s", is_void ? text : "");
    return store_change_add(store, &change, error);
}

static enum mr_status say_same(struct store *store, const struct store_same *same, int64_t run,
                               int64_t now_us, struct error *error)
{
    char cut[60], rest[60];
    snprintf(cut, sizeof cut, "cut off; RUN %lld %s", (long long)run,
             same->whole ? "has all of it" : "goes on with it");
    snprintf(rest, sizeof rest, "goes on with RUN %lld, which was cut off", (long long)same->cut);
    enum mr_status status = say(store, same->cut, now_us, same->whole, cut, error);
    return status == MR_OK && !same->whole ? say(store, run, now_us, false, rest, error) : status;
}

enum mr_status store_find_same(struct store *store, int64_t run, int64_t now_us,
                               struct store_same *same, struct error *error)
{
    int64_t cut = 0;
    bool can = false, there = false;
    *same = (struct store_same){.cut = 0};
    enum mr_status status = STORE_NUMBER(store, error, SAME_CUT, &cut, BIND(run));
    if (status != MR_OK || cut == 0)
        return status;
    status = ask(store, STORE_SAME_BY_CAN, cut, run, &can, error);
    if (status == MR_OK) /* its newest is there, too */
        status = ask(store, can ? STORE_SAME_FRAME : STORE_SAME_BLOCK, cut, run, &there, error);
    if (status == MR_OK && there)
        status = ask(store, STORE_SAME_ARMED, cut, run, &same->whole, error);
    if (status != MR_OK || !there)
        return status;
    same->cut = cut;
    return say_same(store, same, run, now_us, error);
}

/* ---- whole, and twice ---- */

/* Earlier ones of the same number. */
static enum mr_status landings_alike(struct store *store, const struct store_landing *landing,
                                     struct store_landing **rows, size_t *count,
                                     struct error *error)
{
    STORE_ROWS(LANDINGS_ALIKE, BIND(landing->id), BIND(landing->board_landing));
}

bool store_same_landing(const struct store_landing *a, const struct store_edge *a_edge,
                        size_t a_edges, const struct store_landing *b,
                        const struct store_edge *b_edge, size_t b_edges)
{
    size_t same = 0, i = 0, k = 0;
    bool same_board = !a->board_uid[0] || !b->board_uid[0] ||
                      strcmp(a->board_uid, b->board_uid) == 0;
    if (!same_board || a->board_landing != b->board_landing)
        return false;
    while (i < a_edges && k < b_edges) { /* in order of their counts */
        int64_t ahead = a_edge[i].count - b_edge[k].count;
        if (ahead == 0 && a_edge[i].tick != b_edge[k].tick)
            return false;
        same += ahead == 0;
        i += ahead <= 0;
        k += ahead >= 0;
    }
    return same >= 2;
}

static enum mr_status is_twin(struct store *store, const struct store_landing *landing,
                              const struct store_edge *edge, size_t edges,
                              const struct store_landing *other, bool *twin, struct error *error)
{
    struct store_edge *its = NULL;
    size_t count = 0;
    bool is_void = false;
    enum mr_status status = store_edges(store, other->id, &its, &count, error);
    *twin = status == MR_OK && store_same_landing(landing, edge, edges, other, its, count);
    free(its);
    if (*twin)
        status = store_is_void(store, other->id, &is_void, NULL, error);
    *twin &= !is_void;
    return status;
}

enum mr_status store_find_twin(struct store *store, int64_t run, int64_t *twin, struct error *error)
{
    struct store_landing landing, *rows = NULL;
    struct store_edge *edge = NULL;
    size_t count = 0, edges = 0;
    *twin = 0;
    enum mr_status status = store_landing_get(store, run, &landing, error);
    if (status == MR_OK)
        status = store_edges(store, run, &edge, &edges, error);
    if (status == MR_OK)
        status = landings_alike(store, &landing, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK && *twin == 0; i++) {
        bool same = false;
        status = is_twin(store, &landing, edge, edges, &rows[i], &same, error);
        if (same)
            *twin = rows[i].id;
    }
    free(edge);
    free(rows);
    return status;
}
