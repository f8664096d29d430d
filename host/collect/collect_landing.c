/* The landing of each link. A link enters a landing when the link reports it, and leaves at its
 * end. A landing is finished when all links have left it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/collect/collect.h"
#include "host/collect/collect_state.h"
#include "host/store/store.h"
#include "host/store/store_journal.h"

/* A link is silent if its newest block is this far behind that of the other link. Clock messages
 * arrive every 100 blocks. */
#define LINK_SILENCE_MIN_BLOCKS 300
/* Time to wait for a silent link after the other link has delivered the end of the landing. The
 * links are read in step, so the silent link has no unread data; its cable was probably
 * unplugged. */
#define SILENT_LINK_WAIT_BLOCKS 5000
/* CAN data is used up to this far before and after a gap in the serial data, because a message may
 * describe an earlier moment. */
#define FILL_MARGIN_BLOCKS      1000
/* largest age of the newest known block */
#define CLOCK_AGE_MAX_BLOCKS    1000

/* Records a gap for the part of a landing that a link did not deliver. */
static enum mr_status add_silence_gap(struct collector *collector, const struct landing_slot *slot,
                                      const struct link_state *side, const struct link_state *other,
                                      struct error *error)
{
    struct store_gap gap = {.link = (int)side->kind,
                            .message = "all",
                            .channels = "all",
                            .cause = "silence",
                            .count = STORE_NONE,
                            .from_block = slot->row.armed_block,
                            .to_block = slot->end_block < 0 ? STORE_NONE : slot->end_block};
    if (slot->link_entered[side->kind]) {
        if (slot->link_left[side->kind] ||
            collect_newest_block(other) - collect_newest_block(side) <= LINK_SILENCE_MIN_BLOCKS)
            return MR_OK;
        gap.from_block = collect_newest_block(side);
    } else if (!slot->link_entered[other->kind]) {
        return MR_OK;
    }
    return store_gap_put(collector->store, collector->session, slot->row.id, &gap, error);
}

/* Fills the losses of serial with CAN data after a landing. */
struct gap_filler {
    struct collector *collector;
    struct link_state can; /* state of the CAN side when the frame was received */
    struct store_gap *gaps;
    size_t count;
    struct error *error;
};

/* True if serial lost data near block `block`. */
static bool is_lost_on_serial(const struct gap_filler *filler, int64_t block)
{
    for (size_t i = 0; i < filler->count; i++) {
        const struct store_gap *gap = &filler->gaps[i];
        int64_t from = gap->from_block, to = gap->to_block;
        if (gap->link == LINK_SERIAL &&
            (from == STORE_NONE || block + FILL_MARGIN_BLOCKS >= from) &&
            (to == STORE_NONE || block - FILL_MARGIN_BLOCKS <= to))
            return true;
    }
    return false;
}

/* Processes a stored frame of gear, predictor or bands as if it had just been received. Existing
 * rows are not changed. */
static enum mr_status fill_frame(void *context, const struct store_frame *frame)
{
    struct gap_filler *filler = context;
    struct mr_message message;
    if (frame->board_us == STORE_NONE || frame->direction != 0 || frame->id > UINT16_MAX ||
        !is_lost_on_serial(filler, frame->board_us / 1000) ||
        mr_message_decode(&message, (uint16_t)frame->id, frame->data, frame->length) != MR_OK ||
        message.info->direction == MR_DIRECTION_HOST)
        return MR_OK;
    filler->can.timebase.newest_block = frame->board_us / 1000;
    const struct collector_event event = {.link = LINK_CAN,
                                          .message = &message,
                                          .host_us = (uint64_t)frame->host_us,
                                          .board_us = frame->board_us};
    return collect_reprocess_message(filler->collector, &filler->can, &event, filler->error);
}

static enum mr_status fill_gaps(struct collector *collector, struct landing_slot *slot,
                                struct error *error)
{
    struct gap_filler filler = {
        .collector = collector, .can = collector->side[LINK_CAN], .error = error};
    bool lost = false;
    filler.can.current_landing = slot;
    enum mr_status status = store_gaps_get(collector->store, slot->row.id, &filler.gaps,
                                           &filler.count, error);
    for (size_t i = 0; i < filler.count; i++)
        lost |= filler.gaps[i].link == LINK_SERIAL;
    if (status == MR_OK && lost && slot->link_entered[LINK_CAN] && slot->link_entered[LINK_SERIAL])
        status = store_frames_for_each(collector->store, slot->row.id, LINK_CAN, fill_frame,
                                       &filler, error);
    free(filler.gaps);
    return status;
}

enum mr_status collect_finish_landing(struct collector *collector, struct landing_slot *slot,
                                      struct error *error)
{
    enum mr_status status = MR_OK;
    slot->is_finished = true;
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        if (collector->side[kind].link_spec)
            status = add_silence_gap(collector, slot, &collector->side[kind],
                                     &collector->side[1 - kind], error);
    }
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        if (collector->side[kind].boot == slot->row.boot)
            status = collect_put_time_map(collector, &collector->side[kind], slot, error);
    }
    bool ended = slot->link_left[LINK_SERIAL] && !slot->was_interrupted;
    if (status == MR_OK && slot->link_entered[LINK_SERIAL])
        status = store_frames_assign(collector->store, collector->session, slot->row.id,
                                     slot->begin_frame_row,
                                     ended                          ? STORE_NONE
                                     : slot->interruption_frame_row ? slot->interruption_frame_row
                                                                    : INT64_MAX,
                                     error);
    if (status == MR_OK)
        status = fill_gaps(collector, slot, error);
    if (collector->finished_run_count < LANDING_SLOT_COUNT)
        collector->finished_runs[collector->finished_run_count++] = slot->row.id;
    return status;
}

/* Finishes each landing that is over on every link: the link has left it, or ended during it, or is
 * known to have missed it. */
enum mr_status collect_finish_ended_landings(struct collector *collector, struct error *error)
{
    for (size_t i = 0; i < LANDING_SLOT_COUNT; i++) {
        struct landing_slot *slot = &collector->slot[i];
        if (slot->row.id == 0 || slot->is_finished || slot->end_block < 0)
            continue;
        bool over = true;
        for (int kind = 0; kind < LINK_KINDS; kind++) {
            const struct link_state *side = &collector->side[kind];
            const struct link_state *other = &collector->side[1 - kind];
            bool passed = collect_newest_block(side) > slot->end_block + LINK_SILENCE_MIN_BLOCKS ||
                          collect_newest_block(other) > slot->end_block + 1000;
            bool gone = slot->link_left[1 - kind] &&
                        collect_newest_block(other) > slot->end_block + SILENT_LINK_WAIT_BLOCKS &&
                        collect_newest_block(side) < slot->end_block;
            over = over && (side->has_ended || slot->link_left[kind] ||
                            (!slot->link_entered[kind] && passed) || gone);
        }
        if (!over)
            continue;
        enum mr_status status = collect_finish_landing(collector, slot, error);
        if (status != MR_OK)
            return status;
    }
    return MR_OK;
}

static struct landing_slot *find_slot(struct collector *collector, const struct link_state *side,
                                      uint16_t number, int64_t armed_block)
{
    struct landing_slot *found = NULL;
    for (size_t i = 0; i < LANDING_SLOT_COUNT; i++) {
        struct landing_slot *slot = &collector->slot[i];
        if (slot->row.id == 0 || slot->row.boot != side->boot ||
            slot->row.board_landing != number || slot->link_left[side->kind])
            continue;
        if (armed_block != STORE_NONE && slot->row.armed_block != STORE_NONE &&
            slot->row.armed_block != armed_block)
            continue;
        if (!found || slot->row.id > found->row.id)
            found = slot;
    }
    return found;
}

static enum mr_status create_slot(struct collector *collector, const struct link_state *side,
                                  const struct mr_landing *landing, int64_t armed_block,
                                  uint64_t host_us, struct landing_slot **slot, struct error *error)
{
    struct landing_slot *oldest = &collector->slot[0];
    for (size_t i = 1; i < LANDING_SLOT_COUNT; i++) {
        if (collector->slot[i].row.id < oldest->row.id)
            oldest = &collector->slot[i];
    }
    if (oldest->row.id && !oldest->is_finished) {
        enum mr_status status = collect_finish_landing(collector, oldest, error);
        if (status != MR_OK)
            return status;
    }
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct link_state *each = &collector->side[kind];
        each->current_landing = each->current_landing == oldest ? NULL : each->current_landing;
        each->last_landing = each->last_landing == oldest ? NULL : each->last_landing;
    }
    *oldest = (struct landing_slot){.row = collector->reported.identity, .end_block = -1};
    oldest->row.session = collector->session;
    oldest->row.boot = side->boot;
    oldest->row.board_landing = landing->landing;
    oldest->row.armed_block = armed_block;
    oldest->row.armed_us = (int64_t)host_us;
    oldest->row.state = landing->state;
    oldest->begin_frame_row = collector->side[LINK_CAN].marked_frame_row[0];
    *slot = oldest;
    enum mr_status status = store_landing_add(collector->store, &oldest->row, error);
    return status == MR_OK ? collect_write_configuration(collector, oldest, error) : status;
}

void collect_leave_landing(struct link_state *side)
{
    struct landing_slot *slot = side->current_landing;
    if (!slot)
        return;
    slot->link_left[side->kind] = true;
    if (slot->end_block < 0)
        slot->end_block = collect_newest_block(side);
    side->last_landing = slot;
    side->current_landing = NULL;
    loss_tracker_reset_series_steps(&side->loss_tracker);
}

static enum mr_status enter_landing(struct collector *collector, struct link_state *side,
                                    const struct mr_landing *landing, uint64_t host_us,
                                    struct error *error)
{
    int64_t armed_block = landing->state == MR_LANDING_ARMED ? (int64_t)landing->block : STORE_NONE;
    struct landing_slot *slot = find_slot(collector, side, landing->landing, armed_block);
    if (slot && slot == side->current_landing)
        return MR_OK;
    enum mr_status status = MR_OK;
    collect_leave_landing(side);
    if (!slot)
        status = create_slot(collector, side, landing, armed_block, host_us, &slot, error);
    else /* otherwise the link reported the configuration before the landing */
        status = collect_write_configuration(collector, slot, error);
    if (status != MR_OK)
        return status;
    if (side->kind == LINK_CAN && !slot->link_entered[LINK_CAN])
        /* Use the time of CAN: a CAN frame has the time of its arrival, serial bytes only the time
         * at which they were read. */
        slot->row.armed_us = (int64_t)host_us;
    slot->link_entered[side->kind] = true;
    side->current_landing = slot;
    loss_tracker_reset_series_steps(&side->loss_tracker);
    return MR_OK;
}

static enum mr_status update_current_landing(struct collector *collector, struct link_state *side,
                                             const struct mr_landing *landing, uint64_t host_us,
                                             struct error *error)
{
    enum mr_status status = MR_OK;
    bool going_on = landing->state >= MR_LANDING_ARMED && landing->state <= MR_LANDING_SETTLING;
    if (going_on)
        status = enter_landing(collector, side, landing, host_us, error);
    struct landing_slot *slot = side->current_landing;
    if (status != MR_OK || !slot)
        return status;
    if (landing->state == MR_LANDING_ARMED && slot->row.armed_block == STORE_NONE)
        slot->row.armed_block = landing->block;
    if ((int64_t)landing->block >= slot->state_block) {
        slot->state_block = landing->block;
        slot->row.state = landing->state;
        status = store_landing_put(collector->store, &slot->row, error);
    }
    if (!going_on)
        collect_leave_landing(side);
    return status;
}

enum mr_status collect_handle_landing(struct collector *collector, struct link_state *side,
                                      const struct mr_landing *landing, uint64_t host_us,
                                      bool *believed, struct error *error)
{
    int64_t newest = collect_newest_block(side);
    /* On CAN, reject a state that is invalid, later than the present, or delayed by a
     * controller. */
    *believed = side->kind != LINK_CAN ||
                (landing->state <= MR_LANDING_DONE && landing->cause <= MR_LANDING_BY_LIMIT &&
                 landing->block >= side->state_block &&
                 (newest < 0 || (int64_t)landing->block <= newest + CLOCK_AGE_MAX_BLOCKS));
    if (!*believed)
        return MR_OK;
    side->state_block = landing->block;
    return update_current_landing(collector, side, landing, host_us, error);
}
