/* A landing that frames of a stranger tore, on CAN alone: the board says in the end that it goes
 * on. What came meanwhile was taken for nobody's, or for that of a landing which the stranger
 * began. */
#include <stdio.h>

#include "host/collect/collect_state.h"
#include "host/store/store_frames_join.h"
#include "host/store/store_journal.h"

#define BEHIND_BLOCKS 200 /* a reading may be so old (collect_links.c) */

static struct slot *find_torn(struct collector *collector, const struct side *side)
{
    struct slot *torn = NULL;
    for (size_t i = 0; i < SLOTS; i++) {
        struct slot *slot = &collector->slot[i];
        if (slot->row.id && slot->row.boot == side->boot &&
            slot->row.board_landing == side->story.said.landing && slot->left[side->kind] &&
            (!torn || slot->row.id > torn->row.id))
            torn = slot;
    }
    return torn;
}

/* The frames of others that no block of the board dates stay where they are. */
static enum mr_status take_frames(struct collector *collector, const struct side *side,
                                  const struct slot *torn, int64_t from_run, int64_t end_block,
                                  struct error *error)
{
    const struct store_frames_span span = {.session = collector->session,
                                           .link = (int)side->kind,
                                           .mark = torn->left_mark,
                                           .from_us = 1000 * (end_block - BEHIND_BLOCKS),
                                           .to_us = 1000 * (collect_newest_block(side) + 1)};
    return store_frames_join(collector->store, &span, from_run, torn->row.id, error);
}

/* Landings that began since then, of which no other link knows. */
static enum mr_status take_from_others(struct collector *collector, const struct side *side,
                                       const struct slot *torn, int64_t end_block,
                                       struct error *error)
{
    enum mr_status status = take_frames(collector, side, torn, STORE_NONE, end_block, error);
    for (size_t i = 0; i < SLOTS && status == MR_OK; i++) {
        const struct slot *slot = &collector->slot[i];
        if (slot->row.id <= torn->row.id || slot->entered[1 - side->kind])
            continue;
        struct store_change change = {.run = slot->row.id,
                                      .made_us = (int64_t)link_now_us(),
                                      .who = "matrig log",
                                      .field = "void",
                                      .value = "yes"};
        snprintf(change.reason, sizeof change.reason,
                 "a stranger on CAN began it; what came is of RUN %lld", (long long)torn->row.id);
        status = store_change_add(collector->store, &change, error);
        if (status == MR_OK)
            status = take_frames(collector, side, torn, slot->row.id, end_block, error);
    }
    return status;
}

enum mr_status collect_join(struct collector *collector, struct side *side, struct error *error)
{
    const struct slot *phantom = side->current;
    bool goes_on = side->story.said.state >= MR_LANDING_ARMED &&
                   side->story.said.state <= MR_LANDING_SETTLING;
    if (phantom && (phantom->row.board_landing != side->story.said.landing || !goes_on))
        collect_leave(side);
    struct slot *torn = goes_on && !side->current ? find_torn(collector, side) : NULL;
    if (!torn)
        return MR_OK;
    const int64_t end_block = torn->end_block;
    torn->left[side->kind] = torn->finished = false;
    torn->end_block = torn->left[1 - side->kind] ? torn->end_block : -1;
    torn->state_block = side->story.said.block;
    side->current = torn;
    account_break(&side->account);
    enum mr_status status = take_from_others(collector, side, torn, end_block, error);
    return status == MR_OK ? collect_understand_again(collector, side, torn, torn->left_mark, error)
                           : status;
}
