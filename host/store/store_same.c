/* One landing twice in a campaign: a log was ended in the middle of the landing, what the campaign
 * did not take was saved beside it, and is taken in with the landing from its beginning. What
 * proves that two are one are rows that no two landings share: a CAN frame with its stamp of this
 * computer's clock, which the saved log keeps; with serial alone a block's record. A recording that
 * is logged twice proves nothing: the second must go on where the first was cut off. */
#include <stdio.h>

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
