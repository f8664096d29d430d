/* Which landing a link is in: entered when it is reported, left when it is over, finished when
 * every link has left. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/collect/collect_state.h"
#include "host/store/store.h"
#include "host/store/store_journal.h"

/* A link whose newest block is this far behind the other's is silent: clock messages come every
 * 100. */
#define SILENT_BLOCKS 300
/* A link that brought the landing and then nothing more is not waited for any longer than this once
 * the other one has its end: a cable that came off. Links are read in step, so nothing of it waits
 * unread. */
#define GONE_BLOCKS   5000
/* A message tells of a moment that is past: so far around what serial lost CAN fills. */
#define AROUND_BLOCKS 1000

/* Gives up what a link should have brought of a landing and did not. */
static enum mr_status add_silence(struct collector *collector, const struct slot *slot,
                                  const struct side *side, const struct side *other,
                                  struct error *error)
{
    struct store_gap gap = {.link = (int)side->kind,
                            .message = "all",
                            .channels = "all",
                            .cause = "silence",
                            .count = STORE_NONE,
                            .from_block = slot->row.armed_block,
                            .to_block = slot->end_block < 0 ? STORE_NONE : slot->end_block};
    if (slot->entered[side->kind]) {
        if (slot->left[side->kind] ||
            collect_newest_block(other) - collect_newest_block(side) <= SILENT_BLOCKS)
            return MR_OK;
        gap.from_block = collect_newest_block(side);
    } else if (!slot->entered[other->kind]) {
        return MR_OK;
    }
    return store_gap_put(collector->store, collector->session, slot->row.id, &gap, error);
}

/* It may be what was saved when an earlier log was ended in the middle of it. */
static enum mr_status find_same(struct collector *collector, const struct slot *slot,
                                struct error *error)
{
    struct store_same same;
    enum mr_status status = store_find_same(collector->store, slot->row.id, (int64_t)link_now_us(),
                                            &same, error);
    if (status == MR_OK && same.cut) {
        collector->same = same;
        collector->same_run = slot->row.id;
    }
    return status;
}

/* Whether serial lost something about then. */
static bool serial_lost(const struct store_gap *gaps, size_t count, int64_t block)
{
    for (size_t i = 0; i < count; i++) {
        int64_t from = gaps[i].from_block, to = gaps[i].to_block;
        if (gaps[i].link == LINK_SERIAL && (from == STORE_NONE || block + AROUND_BLOCKS >= from) &&
            (to == STORE_NONE || block - AROUND_BLOCKS <= to))
            return true;
    }
    return false;
}

/* What the gear, the predictor and the bands did: as if it came now. Rows that are there stay. */
static enum mr_status understand(struct collector *collector, struct side *side,
                                 const struct store_kept_frame *frame, struct error *error)
{
    struct mr_message message;
    if (frame->id > UINT16_MAX ||
        mr_message_read(&message, (uint16_t)frame->id, frame->data, frame->length) != MR_OK ||
        message.info->direction == MR_DIRECTION_HOST)
        return MR_OK;
    const struct collector_event event = {.link = side->kind,
                                          .message = &message,
                                          .host_us = frame->host_us,
                                          .board_us = frame->board_us};
    return collect_message_again(collector, side, &event, error);
}

static enum mr_status understand_again(struct collector *collector, struct side *side,
                                       const struct slot *slot, int64_t mark, struct error *error)
{
    struct store_kept_frame *frame = NULL;
    size_t count = 0;
    enum mr_status status = store_frames_since(collector->store, slot->row.id, (int)side->kind,
                                               mark, &frame, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++)
        status = understand(collector, side, &frame[i], error);
    free(frame);
    return status;
}

/* A landing is over: CAN fills what serial lost of it. */
static enum mr_status fill(struct collector *collector, struct slot *slot, struct error *error)
{
    struct side can = collector->side[LINK_CAN]; /* as it was then */
    struct store_gap *gaps = NULL;
    struct store_kept_frame *frame = NULL;
    size_t count = 0, frames = 0;
    bool lost = false;
    enum mr_status status = store_gaps(collector->store, slot->row.id, &gaps, &count, error);
    for (size_t i = 0; i < count; i++)
        lost |= gaps[i].link == LINK_SERIAL;
    if (status == MR_OK && lost && slot->entered[LINK_CAN] && slot->entered[LINK_SERIAL])
        status = store_frames_since(collector->store, slot->row.id, LINK_CAN, 0, &frame, &frames,
                                    error);
    can.current = slot;
    for (size_t i = 0; i < frames && status == MR_OK; i++) {
        can.time.block = frame[i].board_us / 1000;
        if (frame[i].board_us != STORE_NONE && serial_lost(gaps, count, can.time.block))
            status = understand(collector, &can, &frame[i], error);
    }
    free(frame);
    free(gaps);
    return status;
}

enum mr_status collect_finish(struct collector *collector, struct slot *slot, struct error *error)
{
    enum mr_status status = MR_OK;
    slot->finished = true;
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        if (collector->side[kind].spec)
            status = add_silence(collector, slot, &collector->side[kind],
                                 &collector->side[1 - kind], error);
    }
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        if (collector->side[kind].boot == slot->row.boot)
            status = collect_put_time_map(collector, &collector->side[kind], slot, error);
    }
    if (status == MR_OK && slot->entered[LINK_SERIAL])
        status = store_frames_place(collector->store, collector->session, slot->row.id,
                                    slot->begun_mark, slot->left[LINK_SERIAL], error);
    if (status == MR_OK)
        status = fill(collector, slot, error);
    if (status == MR_OK)
        status = find_same(collector, slot, error);
    if (collector->finished_count < SLOTS)
        collector->finished[collector->finished_count++] = slot->row.id;
    return status;
}

/* A landing is over when every link has left it, has ended, or is known to have missed it. */
enum mr_status collect_finish_what_is_over(struct collector *collector, struct error *error)
{
    for (size_t i = 0; i < SLOTS; i++) {
        struct slot *slot = &collector->slot[i];
        if (slot->row.id == 0 || slot->finished || slot->end_block < 0)
            continue;
        bool over = true;
        for (int kind = 0; kind < LINK_KINDS; kind++) {
            const struct side *side = &collector->side[kind];
            const struct side *other = &collector->side[1 - kind];
            bool passed = collect_newest_block(side) > slot->end_block + SILENT_BLOCKS ||
                          collect_newest_block(other) > slot->end_block + 1000;
            bool gone = slot->left[1 - kind] &&
                        collect_newest_block(other) > slot->end_block + GONE_BLOCKS &&
                        collect_newest_block(side) < slot->end_block;
            over = over &&
                   (side->ended || slot->left[kind] || (!slot->entered[kind] && passed) || gone);
        }
        if (!over)
            continue;
        enum mr_status status = collect_finish(collector, slot, error);
        if (status != MR_OK)
            return status;
    }
    return MR_OK;
}

static struct slot *find_slot(struct collector *collector, const struct side *side, uint16_t number,
                              int64_t armed_block)
{
    struct slot *found = NULL;
    for (size_t i = 0; i < SLOTS; i++) {
        struct slot *slot = &collector->slot[i];
        if (slot->row.id == 0 || slot->row.boot != side->boot ||
            slot->row.board_landing != number || slot->left[side->kind])
            continue;
        if (armed_block != STORE_NONE && slot->row.armed_block != STORE_NONE &&
            slot->row.armed_block != armed_block)
            continue;
        if (!found || slot->row.id > found->row.id)
            found = slot;
    }
    return found;
}

static enum mr_status make_slot(struct collector *collector, const struct side *side,
                                const struct mr_landing *landing, int64_t armed_block,
                                uint64_t host_us, struct slot **slot, struct error *error)
{
    struct slot *oldest = &collector->slot[0];
    for (size_t i = 1; i < SLOTS; i++) {
        if (collector->slot[i].row.id < oldest->row.id)
            oldest = &collector->slot[i];
    }
    if (oldest->row.id && !oldest->finished) {
        enum mr_status status = collect_finish(collector, oldest, error);
        if (status != MR_OK)
            return status;
    }
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct side *each = &collector->side[kind];
        each->current = each->current == oldest ? NULL : each->current;
        each->last = each->last == oldest ? NULL : each->last;
    }
    *oldest = (struct slot){.row = collector->identity, .end_block = -1};
    oldest->row.session = collector->session;
    oldest->row.boot = side->boot;
    oldest->row.board_landing = landing->landing;
    oldest->row.armed_block = armed_block;
    oldest->row.armed_us = (int64_t)host_us;
    oldest->row.state = landing->state;
    oldest->begun_mark = collector->side[LINK_CAN].mark[0];
    *slot = oldest;
    enum mr_status status = store_landing_add(collector->store, &oldest->row, error);
    return status == MR_OK ? collect_write_configuration(collector, oldest, error) : status;
}

void collect_leave(struct side *side)
{
    struct slot *slot = side->current;
    if (!slot)
        return;
    slot->left[side->kind] = true;
    if (slot->end_block < 0)
        slot->end_block = collect_newest_block(side);
    side->last = slot;
    side->current = NULL;
    account_break(&side->account);
}

/* Nobody vouches for that: the frames from here on may turn out to be its own. */
static enum mr_status leave(struct collector *collector, struct side *side, struct error *error)
{
    struct slot *slot = side->current;
    enum mr_status status = MR_OK;
    if (slot && side->kind == LINK_CAN)
        status = store_frames_mark(collector->store, &slot->left_mark, error);
    collect_leave(side);
    return status;
}

static enum mr_status enter(struct collector *collector, struct side *side,
                            const struct mr_landing *landing, uint64_t host_us, struct error *error)
{
    int64_t armed_block = landing->state == MR_LANDING_ARMED ? (int64_t)landing->block : STORE_NONE;
    struct slot *slot = find_slot(collector, side, landing->landing, armed_block);
    if (slot && slot == side->current)
        return MR_OK;
    enum mr_status status = leave(collector, side, error);
    if (status == MR_OK && !slot)
        status = make_slot(collector, side, landing, armed_block, host_us, &slot, error);
    else if (status == MR_OK) /* what this link reported before it came to the landing */
        status = collect_write_configuration(collector, slot, error);
    if (status != MR_OK)
        return status;
    if (side->kind == LINK_CAN && !slot->entered[LINK_CAN])
        /* a frame has its own stamp, serial's bytes that of their reading */
        slot->row.armed_us = (int64_t)host_us;
    slot->entered[side->kind] = true;
    side->current = slot;
    account_break(&side->account);
    return MR_OK;
}

static enum mr_status follow(struct collector *collector, struct side *side,
                             const struct mr_landing *landing, uint64_t host_us,
                             struct error *error)
{
    enum mr_status status = MR_OK;
    bool going_on = landing->state >= MR_LANDING_ARMED && landing->state <= MR_LANDING_SETTLING;
    if (going_on)
        status = enter(collector, side, landing, host_us, error);
    struct slot *slot = side->current;
    if (status != MR_OK || !slot)
        return status;
    if (landing->state == MR_LANDING_ARMED && slot->row.armed_block == STORE_NONE)
        slot->row.armed_block = landing->block;
    if ((int64_t)landing->block >= slot->state_block) {
        slot->state_block = landing->block;
        slot->row.state = landing->state;
        status = store_landing_put(collector->store, &slot->row, error);
    }
    return status == MR_OK && !going_on ? leave(collector, side, error) : status;
}

/* ---- join ----
 *
 * A landing that frames of a stranger tore, on CAN alone: the board says in the end that it goes
 * on. What came meanwhile was taken for nobody's, or for that of a landing which the stranger
 * began. */

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

static enum mr_status join(struct collector *collector, struct side *side, struct error *error)
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
    return status == MR_OK ? understand_again(collector, side, torn, torn->left_mark, error)
                           : status;
}

enum mr_status collect_landing(struct collector *collector, struct side *side,
                               const struct mr_landing *landing, uint64_t host_us, bool *believed,
                               struct error *error)
{
    enum mr_status status = MR_OK;
    struct landing_story *story = &side->story;
    enum landing_belief belief = side->kind == LINK_CAN
                                   ? landing_story_hear(story, landing, collect_newest_block(side))
                                   : landing_story_believe(story, landing);
    *believed = belief != LANDING_DOUBTED;
    if (belief == LANDING_TAKEN_BACK)
        status = join(collector, side, error);
    return status == MR_OK && *believed ? follow(collector, side, landing, host_us, error) : status;
}
