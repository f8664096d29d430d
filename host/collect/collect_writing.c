/* What the collector has to do with how it is written.
 *
 * Going back to where a transaction began, when what was written since is taken back. All that the
 * collector knows is in one piece of memory, whose pointers point into itself or to what outlives
 * it: a copy of its bytes is a copy of it. */
#include <stdlib.h>
#include <string.h>

#include "host/collect/collect_state.h"

enum mr_status collector_mark(struct collector *collector, struct error *error)
{
    if (!collector->mark)
        collector->mark = malloc(sizeof *collector->mark);
    if (!collector->mark)
        return error_set(error, MR_FULL, "no memory: logging to %s; close other programs",
                         store_path(collector->store));
    *collector->mark = *collector;
    return MR_OK;
}

void collector_back_to_mark(struct collector *collector)
{
    struct collector *mark = collector->mark;
    if (mark)
        *collector = *mark;
}

void collector_forget_time(struct collector *collector, enum link_kind kind)
{
    collect_forget_time(&collector->side[kind]);
}

static int64_t run_of(const struct collector *collector)
{
    int64_t run = STORE_NONE;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct slot *slot = collector->side[kind].current;
        if (slot && slot->row.id > run)
            run = slot->row.id;
    }
    return run;
}

int64_t collector_marked_run(const struct collector *collector)
{
    return collector->mark ? run_of(collector->mark) : STORE_NONE;
}

int64_t collector_since_us(const struct collector *collector)
{
    int64_t since_us = STORE_NONE;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct slot *slot = collector->side[kind].current;
        if (slot && (since_us == STORE_NONE || slot->row.armed_us < since_us))
            since_us = slot->row.armed_us;
    }
    return since_us;
}

enum mr_status collector_held(struct collector *collector, int64_t run, int64_t cause,
                              int64_t permille, int64_t us, struct error *error)
{
    struct store_event event = {.session = collector->session,
                                .run = run,
                                .board_us = STORE_NONE,
                                .host_us = (int64_t)link_now_us(),
                                .kind = "held",
                                .code = cause,
                                .detail = permille,
                                .value = us};
    if (run == STORE_NONE)
        event.run = run_of(collector);
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct side *side = &collector->side[kind];
        event.boot = side->boot > event.boot ? side->boot : event.boot;
    }
    return store_event_put(collector->store, &event, error);
}

void collector_move(struct collector *collector, struct store *store)
{
    collector->store = store;
}

/* What the board says of itself when it is asked, or once. */
static void inherit(struct collector *now, const struct collector *before)
{
    now->hello = before->hello;
    now->identity = before->identity;
    memcpy(now->uid, before->uid, sizeof now->uid);
    now->uid_parts = before->uid_parts;
    now->uid_vouched = before->uid_vouched;
    memcpy(now->channel_known, before->channel_known, sizeof now->channel_known);
    memcpy(now->zero_known, before->zero_known, sizeof now->zero_known);
    memcpy(now->channel, before->channel, sizeof now->channel);
    memcpy(now->items_known, before->items_known, sizeof now->items_known);
    memcpy(now->switch_known, before->switch_known, sizeof now->switch_known);
    memcpy(now->place, before->place, sizeof now->place);
    memcpy(now->segment_known, before->segment_known, sizeof now->segment_known);
    memcpy(now->segment, before->segment, sizeof now->segment);
    memcpy(now->predict_known, before->predict_known, sizeof now->predict_known);
    memcpy(now->predict_item, before->predict_item, sizeof now->predict_item);
    memcpy(now->risk_known, before->risk_known, sizeof now->risk_known);
    memcpy(now->risk_item, before->risk_item, sizeof now->risk_item);
}

enum mr_status collector_again(const struct collector *before, struct store *store, bool whole,
                               struct collector **collector, struct error *error)
{
    enum mr_status status = collector_open(store, before->side[LINK_CAN].spec, before->can_base,
                                           before->side[LINK_SERIAL].spec, collector, error);
    if (status == MR_OK && !whole)
        inherit(*collector, before);
    return status;
}
