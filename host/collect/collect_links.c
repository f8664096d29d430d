/* Processing of frames of the two links: board time, losses, identity of the board, and storage of
 * the raw frame. collect_message.c processes the content.
 *
 * Serial connects to one board; on CAN any node may send. Serial is therefore the record while it
 * is connected: if a message is sent on both links, only the serial copy is used. CAN frames are
 * stored raw and shown; after a landing they fill gaps in the serial data (collect_landing.c). */
#include <math.h>
#include <string.h>

#include "common/block.h"
#include "host/collect/collect.h"
#include "host/collect/collect_state.h"

/* largest age of a message: messages of a link arrive in order, a prediction may describe an
 * earlier moment, and clock messages arrive every 100 blocks */
#define MESSAGE_AGE_MAX_BLOCKS 2000
#define READING_AGE_MAX_BLOCKS 200
#define CLOCK_AGE_MAX_BLOCKS   1000

/* serial is silent if it is this far behind CAN, or, before its first data, behind CAN's first
 * clock message */
#define SERIAL_SILENCE_MIN_BLOCKS 1000
#define FRAME_MARK_PERIOD_BLOCKS  5000
#define SAME_START_MAX_BLOCKS     10000

/* Handles a restart of the board. `hello`: the board's first hello after it, in the next frame;
 * NULL: not received. */
static enum mr_status handle_restart(struct collector *collector, struct link_state *side,
                                     uint64_t host_us, const struct mr_hello *hello,
                                     struct error *error)
{
    const struct landing_slot *broken_off = side->current_landing;
    enum mr_status status = collect_put_time_map(collector, side, NULL, error);
    for (size_t i = 0; i < LANDING_SLOT_COUNT && status == MR_OK; i++) {
        struct landing_slot *slot = &collector->slot[i];
        if (slot->row.id == 0 || slot->row.boot != side->boot ||
            (slot->end_block >= 0 && !slot->was_interrupted))
            continue;
        slot->was_interrupted = true;
        if (side->kind == LINK_CAN)
            status = store_newest_frame_get(collector->store, &slot->interruption_frame_row, error);
    }
    if (status != MR_OK)
        return status;
    collect_leave_landing(side);
    side->state_block = 0;
    side->time_candidate = (struct timebase_candidate){0};
    side->boot++;
    side->timebase = (struct timebase){0};
    side->newest_clock_block = side->first_clock_block = 0;
    collect_discard_time_map(side);
    loss_tracker_restart(&side->loss_tracker, hello != NULL);
    side->shunt.number = 0;
    memset(collector->fault_count, 0, sizeof collector->fault_count);
    collector->alarm = (struct mr_can_alarm){0};
    struct store_event event = {.session = collector->session,
                                .boot = side->boot,
                                .run = broken_off ? broken_off->row.id : STORE_NONE,
                                .board_us = 0,
                                .host_us = (int64_t)host_us,
                                .kind = "restart",
                                .detail = hello ? hello->reset_cause : STORE_NONE,
                                .links = 1 << side->kind};
    return store_event_put(collector->store, &event, error);
}

/* Gets block index and tick of a clock message. Returns false for other messages. */
static bool get_clock_fields(const struct mr_message *message, uint32_t *block, uint32_t *tick)
{
    bool sync = message->index == MR_INDEX_SYNC;
    *block = sync ? message->as.sync.block : message->as.clock.block;
    *tick = sync ? message->as.sync.tick : message->as.clock.tick;
    return sync || message->index == MR_INDEX_CLOCK;
}

/* Updates the board time from a message. A clock with tick 0 means that scanning is stopped, so its
 * block is not a time. On CAN the message may come from another node. */
static enum timebase_result update_board_time(struct link_state *side,
                                              const struct mr_message *message)
{
    uint32_t block, tick;
    if (get_clock_fields(message, &block, &tick)) {
        if (tick == 0)
            return TIMEBASE_CONTINUES;
        if (side->kind == LINK_CAN)
            return timebase_check_clock(&side->timebase, &side->time_candidate, block, tick, false);
        return timebase_apply_clock(&side->timebase, block, tick) ? TIMEBASE_RESTARTED
                                                                  : TIMEBASE_CONTINUES;
    }
    if (message->block16 >= 0)
        timebase_unwrap(&side->timebase, (uint16_t)message->block16);
    return TIMEBASE_CONTINUES;
}

enum mr_status collect_store_gaps(struct collector *collector, struct link_state *side,
                                  struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < side->loss_tracker.gap_count && status == MR_OK; i++) {
        const struct store_gap *gap = &side->loss_tracker.gap[i];
        const struct landing_slot *slot = side->current_landing;
        if (!slot && side->last_landing && gap->from_block != STORE_NONE &&
            gap->from_block <= side->last_landing->end_block)
            slot = side->last_landing;
        status = store_gap_put(collector->store, collector->session,
                               slot ? slot->row.id : STORE_NONE, gap, error);
    }
    side->loss_tracker.gap_count = 0;
    return status;
}

static enum mr_status store_raw_frame(struct collector *collector, const struct link_state *side,
                                      const struct landing_slot *slot, struct store_frame *frame,
                                      struct error *error)
{
    frame->run = slot ? slot->row.id : STORE_NONE;
    frame->link = (int)side->kind;
    return store_frame_put(collector->store, collector->session, frame, error);
}

/* True if the board cannot have sent a message with this time by now, considering the pause since
 * the last message and delays in queues. Always false for serial. */
static bool is_impossible_time(const struct link_state *side, const struct mr_message *message,
                               uint64_t host_us)
{
    int64_t newest = collect_newest_block(side);
    int64_t board_us = collect_board_time(side, message);
    int64_t paused = host_us > side->received_us ? (int64_t)(host_us - side->received_us) / 1000
                                                 : 0;
    if (side->kind != LINK_CAN || newest < 0)
        return false;
    int64_t behind = message->info->direction == MR_DIRECTION_CAN ? READING_AGE_MAX_BLOCKS
                                                                  : MESSAGE_AGE_MAX_BLOCKS;
    return board_us == STORE_NONE || board_us / 1000 < newest - behind ||
           board_us / 1000 > newest + CLOCK_AGE_MAX_BLOCKS + 2 * paused;
}

/* ---- priority of serial data over CAN ---- */

static bool is_serial_primary(const struct collector *collector)
{
    const struct link_state *can = &collector->side[LINK_CAN],
                            *serial = &collector->side[LINK_SERIAL];
    int64_t spoke = serial->timebase.is_block_known ? collect_newest_block(serial)
                                                    : can->first_clock_block;
    /* CAN is behind: it still delivers frames from before a restart that serial has already
     * reported */
    bool behind = serial->boot > can->boot;
    return !serial->has_ended &&
           (behind || (serial->boot == can->boot &&
                       can->newest_clock_block - spoke <= SERIAL_SILENCE_MIN_BLOCKS));
}

/* Adopts serial's count of restarts for CAN. Each link counts by itself, and CAN may miss a short
 * restart or mistake another node's message for one. The count is adopted when both links have had
 * the same time for longer than CAN can be behind. */
static void copy_serial_boot(const struct collector *collector, struct link_state *can)
{
    const struct link_state *serial = &collector->side[LINK_SERIAL];
    int64_t block = can->newest_clock_block, apart = block - collect_newest_block(serial);
    if (!serial->has_ended && !can->current_landing && apart <= SERIAL_SILENCE_MIN_BLOCKS &&
        apart >= -SERIAL_SILENCE_MIN_BLOCKS && block > SAME_START_MAX_BLOCKS)
        can->boot = serial->boot;
}

/* Sets the arming time from CAN: a CAN frame has the time of its arrival, serial bytes only the
 * time at which they were read. */
static enum mr_status set_arming_time_from_can(struct collector *collector, struct link_state *can,
                                               const struct collector_event *event,
                                               struct error *error)
{
    struct landing_slot *slot = can->current_landing;
    if (event->message->index == MR_INDEX_LANDING &&
        event->message->as.landing.state == MR_LANDING_ARMED &&
        event->message->as.landing.block != can->armed_landing.block) {
        can->armed_landing = event->message->as.landing;
        can->armed_us = event->host_us;
    }
    if (!slot || slot->row.armed_us == (int64_t)can->armed_us ||
        slot->row.armed_block != (int64_t)can->armed_landing.block ||
        slot->row.board_landing != can->armed_landing.landing)
        return MR_OK;
    slot->row.armed_us = (int64_t)can->armed_us;
    return store_landing_put(collector->store, &slot->row, error);
}

/* Stores the row of the newest frame at intervals. The next landing begins at a stored row from
 * some seconds ago. */
static enum mr_status mark_newest_frame_row(struct collector *collector, struct link_state *can,
                                            struct error *error)
{
    int64_t block = collect_newest_block(can);
    if (block >= can->frame_mark_block && block < can->frame_mark_block + FRAME_MARK_PERIOD_BLOCKS)
        return MR_OK;
    can->frame_mark_block = block;
    can->marked_frame_row[0] = can->marked_frame_row[1];
    return store_newest_frame_get(collector->store, &can->marked_frame_row[1], error);
}

/* True if the board sends the same message on both links. */
static bool is_sent_on_both_links(const struct mr_message *message)
{
    switch (message->index) {
    case MR_INDEX_CLOCK:
    case MR_INDEX_CAN_HEALTH:
    case MR_INDEX_MESSAGE_COUNT:
    case MR_INDEX_CAN_ALARM:
    /* these messages have different content on the two links */
    case MR_INDEX_CONFIG_IMAGE: return false;
    default: return message->info->direction == MR_DIRECTION_BOTH;
    }
}

/* Assigns the landing on serial to CAN data from the first block of the landing to the last. */
static void copy_serial_landing(struct collector *collector, struct link_state *can)
{
    int64_t block = collect_newest_block(can);
    struct landing_slot *slot = can->current_landing;
    if (slot && slot->link_left[LINK_SERIAL] && block > slot->end_block)
        collect_leave_landing(can);
    for (size_t i = 0; i < LANDING_SLOT_COUNT && !can->current_landing; i++) {
        slot = &collector->slot[i];
        if (slot->row.id == 0 || slot->row.boot != can->boot || slot->link_left[LINK_CAN] ||
            !slot->link_entered[LINK_SERIAL] || slot->is_finished ||
            block < slot->row.armed_block ||
            (slot->link_left[LINK_SERIAL] && block > slot->end_block))
            continue;
        slot->link_entered[LINK_CAN] = true;
        can->current_landing = slot;
        loss_tracker_reset_series_steps(&can->loss_tracker);
    }
}

/* Compares the identity of the board on CAN with that on serial. If serial's board never sends on
 * CAN, the two links belong to two boards. */
static void compare_can_identity(struct collector *collector, struct link_state *can,
                                 const struct mr_message *message)
{
    const uint32_t words[2] = {message->as.board_uid.uid0, message->as.board_uid.uid1};
    if (message->index != MR_INDEX_BOARD_UID || !collector->reported.is_uid_from_serial)
        return;
    bool own = memcmp(words, collector->reported.uid, sizeof words) == 0;
    can->own_board_seen |= own;
    can->other_board_message_count = own ? 0 : can->other_board_message_count + 1;
    if (!own)
        memcpy(can->other_uid, words, sizeof words);
}

/* Passes the message to the listener, then handles it. */
static enum mr_status deliver_message(struct collector *collector, struct link_state *side,
                                      const struct collector_event *event, struct error *error)
{
    if (collector->listener)
        collector->listener->message(collector->listener->context, event);
    if (!collector->reported.hello_known && event->message->index != MR_INDEX_HELLO)
        return MR_OK;
    if (event->message->index == MR_INDEX_LANDING) {
        collector->reported.landing = event->message->as.landing;
        collector->reported.landing_known = true;
    }
    if (side->kind == LINK_CAN && is_serial_primary(collector)) {
        copy_serial_landing(collector, side);
        if (mark_newest_frame_row(collector, side, error) != MR_OK ||
            set_arming_time_from_can(collector, side, event, error) != MR_OK)
            return error->status;
        if (collector->reported.hello_known && is_sent_on_both_links(event->message)) {
            compare_can_identity(collector, side, event->message);
            /* when serial falls silent, CAN's landing states are compared only with later ones */
            side->state_block = 0;
            return MR_OK;
        }
    }
    return collect_message(collector, side, event, error);
}

/* Handles a message of the board from either link: time, losses, content, storage. */
static enum mr_status handle_message(struct collector *collector, struct link_state *side,
                                     const struct mr_message *message, int64_t seq,
                                     uint64_t host_us, struct error *error)
{
    const struct mr_message_info *info = message->info;
    bool lost_in_time = is_impossible_time(side, message, host_us);
    enum timebase_result time = lost_in_time ? TIMEBASE_UNCONFIRMED
                                             : update_board_time(side, message);
    enum mr_status status = MR_OK;
    side->received_us = host_us;
    if (time == TIMEBASE_RESTARTED) {
        status = handle_restart(collector, side, host_us, NULL, error);
        update_board_time(side, message);
    }
    if (side->kind == LINK_CAN)
        loss_tracker_add_can_frame(&side->loss_tracker);
    else
        loss_tracker_add_serial_frame(&side->loss_tracker, (uint16_t)seq,
                                      collect_newest_block(side));
    if (message->index == MR_INDEX_CLOCK && side->timebase.is_tick_known &&
        time != TIMEBASE_UNCONFIRMED) {
        side->newest_clock_block = message->as.clock.block;
        if (side->first_clock_block == 0)
            side->first_clock_block = side->newest_clock_block;
        if (side->kind == LINK_CAN)
            copy_serial_boot(collector, side);
        loss_tracker_confirm_board_time(&side->loss_tracker);
    }
    loss_tracker_add_message(&side->loss_tracker, message->index);

    const struct collector_event event = {.link = side->kind,
                                          .message = message,
                                          .host_us = host_us,
                                          .board_us = collect_board_time(side, message)};
    struct store_frame frame = {.seq = seq,
                                .board_us = lost_in_time ? STORE_NONE : event.board_us,
                                .host_us = (int64_t)host_us,
                                .id = info->id,
                                .length = info->length,
                                .data = message->payload};
    struct landing_slot *before = side->current_landing;
    enum mr_status meaning = MR_OK;
    if (status == MR_OK && time != TIMEBASE_UNCONFIRMED)
        meaning = deliver_message(collector, side, &event, error);
    if (status == MR_OK)
        status = store_raw_frame(collector, side,
                                 lost_in_time            ? NULL
                                 : side->current_landing ? side->current_landing
                                                         : before,
                                 &frame, error);
    if (status == MR_OK)
        status = collect_store_gaps(collector, side, error);
    if (status == MR_OK)
        status = meaning;
    return status == MR_OK ? collect_finish_ended_landings(collector, error) : status;
}

/* Decodes a frame. Returns true if it is a catalogue message, from the board or from another node
 * with the same identifiers. */
static bool decode_can_frame(const struct collector *collector, const struct link_frame *frame,
                             struct mr_message *message)
{
    uint32_t id = link_id_from_bus(frame->id, collector->can_base);
    return !(frame->id & (LINK_ID_EXTENDED | LINK_ID_REMOTE | LINK_ID_ERROR)) &&
           mr_message_decode(message, (uint16_t)id, frame->data, frame->length) == MR_OK &&
           message->info->direction != MR_DIRECTION_HOST;
}

static enum mr_status handle_can_frame(struct collector *collector, struct link_state *side,
                                       const struct link_frame *frame, struct error *error)
{
    struct mr_message message;
    bool standard = !(frame->id & (LINK_ID_EXTENDED | LINK_ID_REMOTE | LINK_ID_ERROR));
    uint32_t id = link_id_from_bus(frame->id, collector->can_base);
    if (decode_can_frame(collector, frame, &message))
        return handle_message(collector, side, &message, side->loss_tracker.counts.received,
                              frame->host_us, error);

    /* frames of other nodes are stored raw and not interpreted */
    const struct mr_message_info *info = standard ? mr_message_find((uint16_t)id) : NULL;
    bool command = info && info->direction == MR_DIRECTION_HOST;
    if (!command && !(frame->id & LINK_ID_ERROR))
        side->loss_tracker.counts.foreign++;
    struct store_frame raw = {.direction = command,
                              .seq = STORE_NONE,
                              .board_us = collect_board_time(side, NULL),
                              .host_us = (int64_t)frame->host_us,
                              .id = id,
                              .length = frame->length,
                              .data = frame->data};
    return store_raw_frame(collector, side, side->current_landing, &raw, error);
}

static enum mr_status handle_block(struct collector *collector, struct link_state *side,
                                   const struct mr_frame *frame, uint64_t host_us,
                                   struct error *error)
{
    struct mr_block block;
    enum mr_status status = MR_OK;
    if (mr_block_decode(&block, frame->payload, frame->length) != MR_OK) {
        side->loss_tracker.counts.bad++;
        return MR_OK;
    }
    if (timebase_apply_clock(&side->timebase, block.index, block.tick)) {
        status = handle_restart(collector, side, host_us, NULL, error);
        timebase_apply_clock(&side->timebase, block.index, block.tick);
    }
    loss_tracker_add_serial_frame(&side->loss_tracker, frame->seq, collect_newest_block(side));
    loss_tracker_confirm_board_time(&side->loss_tracker);
    loss_tracker_add_message(&side->loss_tracker, MR_INDEX_BLOCK);
    if (side->current_landing)
        loss_tracker_add_block(&side->loss_tracker, block.index);
    if (collector->listener)
        collector->listener->record(collector->listener->context, &block, host_us);
    if (status == MR_OK)
        status = collect_store_gaps(collector, side, error);
    if (status == MR_OK)
        status = store_block_put(collector->store, collector->session, side->boot,
                                 side->current_landing ? side->current_landing->row.id : STORE_NONE,
                                 (int)side->kind, block.index, (int64_t)host_us, frame->payload,
                                 frame->length, error);
    return status;
}

static enum mr_status process_serial_frame(struct collector *collector, struct link_state *side,
                                           const struct mr_frame *frame, uint64_t host_us,
                                           struct error *error)
{
    if (frame->type == MR_ID_BLOCK)
        return handle_block(collector, side, frame, host_us, error);
    struct mr_message message;
    if (mr_message_decode(&message, frame->type, frame->payload, frame->length) == MR_OK)
        return handle_message(collector, side, &message, frame->seq, host_us, error);
    loss_tracker_add_serial_frame(&side->loss_tracker, frame->seq, collect_newest_block(side));
    /* pages of the black box and unknown frames are counted too */
    loss_tracker_add_message(&side->loss_tracker, mr_message_index(frame->type));
    side->loss_tracker.counts.foreign++;
    struct store_frame raw = {.seq = frame->seq,
                              .board_us = collect_board_time(side, NULL),
                              .host_us = (int64_t)host_us,
                              .id = frame->type,
                              .length = frame->length,
                              .data = frame->payload};
    return store_raw_frame(collector, side, side->current_landing, &raw, error);
}

/* ---- assignment of frames to starts of the board ----
 *
 * A board sends a hello first after a restart. On serial it is frame 0, but the reset may
 * corrupt it. On CAN a hello is sent every second, and only the next clock shows whether the
 * board restarted. Frames after a hello on CAN, or after a loss on serial, are therefore held
 * until the time is known: some milliseconds in a landing, 0.1 s otherwise. */

#define FRAME_HOLD_MAX_US 1000000u /* how long frames wait for a board time */
/* a sequence number below this means that the board has just started */
#define RESTART_SEQ_LIMIT 64u

enum board_start { BOARD_START_UNKNOWN, BOARD_START_SAME, BOARD_START_NEW };

static enum board_start classify_start(struct link_state *side, const struct mr_message *message)
{
    struct timebase copy = side->timebase;
    uint32_t block, tick;
    if (get_clock_fields(message, &block, &tick)) {
        if (tick != 0 && side->kind == LINK_SERIAL)
            return timebase_is_restart(&copy, block) ? BOARD_START_NEW : BOARD_START_SAME;
        enum timebase_result verdict =
            tick == 0 ? TIMEBASE_CONTINUES
                      : timebase_check_clock(&copy, &side->time_candidate, block, tick, true);
        return verdict == TIMEBASE_UNCONFIRMED ? BOARD_START_UNKNOWN
             : verdict == TIMEBASE_RESTARTED   ? BOARD_START_NEW
                                               : BOARD_START_SAME;
    }
    if (message->block16 < 0 || message->info->direction != MR_DIRECTION_CAN)
        return BOARD_START_UNKNOWN;
    int64_t ahead = timebase_unwrap(&copy, (uint16_t)message->block16) -
                    side->timebase.newest_block;
    return ahead >= 0 && ahead <= READING_AGE_MAX_BLOCKS ? BOARD_START_SAME : BOARD_START_UNKNOWN;
}

static enum mr_status process_held_frame(struct collector *collector, struct link_state *side,
                                         const struct held_frame *held, struct error *error)
{
    const struct mr_frame frame = {.seq = held->seq,
                                   .type = (uint16_t)held->frame.id,
                                   .length = held->frame.length,
                                   .payload = held->frame.data};
    return side->kind == LINK_CAN
             ? handle_can_frame(collector, side, &held->frame, error)
             : process_serial_frame(collector, side, &frame, held->frame.host_us, error);
}

/* Processes the waiting frames. `start` is BOARD_START_NEW if the first of them is the first known
 * frame of a new start. */
static enum mr_status release_held_frames(struct collector *collector, struct link_state *side,
                                          enum board_start start, uint64_t host_us,
                                          struct error *error)
{
    const struct held_frame *first = side->held_frames;
    size_t count = side->held_frame_count;
    struct mr_message hello;
    enum mr_status status = MR_OK;
    side->held_frame_count = 0;
    if (start == BOARD_START_NEW) {
        bool has_hello = count && side->kind == LINK_CAN &&
                         decode_can_frame(collector, &first->frame, &hello);
        status = handle_restart(collector, side, count ? first->frame.host_us : host_us,
                                has_hello ? &hello.as.hello : NULL, error);
        if (count && side->kind == LINK_SERIAL && first->seq < RESTART_SEQ_LIMIT)
            loss_tracker_expect_first_frame(&side->loss_tracker);
    }
    for (size_t i = 0; i < count && status == MR_OK; i++)
        status = process_held_frame(collector, side, &side->held_frames[i], error);
    return status;
}

/* Returns true if the frame must wait; false if the waiting frames were processed, or if `error` is
 * set. */
static bool hold_frame(struct collector *collector, struct link_state *side, enum board_start start,
                       const struct held_frame *held, struct error *error)
{
    uint64_t host_us = held->frame.host_us;
    bool room = side->held_frame_count < COLLECT_HELD_FRAMES_MAX &&
                (side->held_frame_count == 0 ||
                 host_us < side->held_frames[0].frame.host_us + FRAME_HOLD_MAX_US);
    if (start == BOARD_START_UNKNOWN && room) {
        side->held_frames[side->held_frame_count++] = *held;
        return true;
    }
    release_held_frames(collector, side, start, host_us, error);
    return false;
}

enum mr_status collect_release_held_frames(struct collector *collector, struct link_state *side,
                                           struct error *error)
{
    const struct timebase_candidate *doubt = &side->time_candidate;
    bool back = side->held_frame_count && doubt->is_pending &&
                (int64_t)doubt->block < side->timebase.newest_clock_block;
    return release_held_frames(collector, side, back ? BOARD_START_NEW : BOARD_START_SAME, 0,
                               error);
}

enum mr_status collector_receive_frame(struct collector *collector, const struct link_frame *frame,
                                       struct error *error)
{
    struct link_state *side = &collector->side[LINK_CAN];
    const struct held_frame held = {.frame = *frame};
    struct mr_message message;
    bool ours = decode_can_frame(collector, frame, &message);
    bool hello = ours && message.index == MR_INDEX_HELLO && side->timebase.is_block_known;
    if ((hello || side->held_frame_count) &&
        hold_frame(collector, side, ours ? classify_start(side, &message) : BOARD_START_UNKNOWN,
                   &held, error))
        return MR_OK;
    return error->status == MR_OK ? handle_can_frame(collector, side, frame, error) : error->status;
}

static enum mr_status handle_serial_frame(struct collector *collector, struct link_state *side,
                                          const struct mr_frame *frame, uint64_t host_us,
                                          struct error *error)
{
    struct held_frame held = {.frame = {.id = frame->type, .host_us = host_us}, .seq = frame->seq};
    struct mr_message message;
    struct mr_block block;
    bool jump = side->loss_tracker.seq_known && frame->seq != side->loss_tracker.next_seq;
    bool ours = frame->type != MR_ID_BLOCK &&
                mr_message_decode(&message, frame->type, frame->payload, frame->length) == MR_OK;
    if (ours && jump && frame->seq == 0 && message.index == MR_INDEX_HELLO) {
        if (release_held_frames(collector, side, BOARD_START_SAME, host_us, error) == MR_OK)
            handle_restart(collector, side, host_us, &message.as.hello, error);
    } else if (side->held_frame_count || (jump && side->timebase.is_block_known)) {
        enum board_start start = BOARD_START_SAME;
        if (ours) {
            start = classify_start(side, &message);
            held.frame.length = (uint8_t)frame->length;
            memcpy(held.frame.data, frame->payload, frame->length);
        } else if (frame->type == MR_ID_BLOCK &&
                   mr_block_decode(&block, frame->payload, frame->length) == MR_OK) {
            start = timebase_is_restart(&side->timebase, block.index) ? BOARD_START_NEW
                                                                      : BOARD_START_SAME;
        }
        if (hold_frame(collector, side, start, &held, error))
            return MR_OK;
    }
    return error->status == MR_OK ? process_serial_frame(collector, side, frame, host_us, error)
                                  : error->status;
}

enum mr_status collector_receive_bytes(struct collector *collector, const uint8_t *bytes,
                                       size_t length, uint64_t host_us, struct error *error)
{
    struct link_state *side = &collector->side[LINK_SERIAL];
    side->loss_tracker.received_bytes += (int64_t)length;
    for (size_t i = 0; i < length; i++) {
        struct mr_frame frame;
        enum mr_status status = mr_deframer_push(&side->deframer, bytes[i], &frame);
        if (status == MR_OK)
            status = handle_serial_frame(collector, side, &frame, host_us, error);
        else if (status != MR_TOO_FEW)
            side->loss_tracker.counts.bad++;
        if (error->status != MR_OK)
            return error->status;
    }
    return MR_OK;
}

/* ---- time: pairs of board clock and computer clock, the fit for each landing and boot, and
 * film frames ---- */

/* Largest rate difference between two clocks: 200 ppm for crystals, 1 % plus drift for the board's
 * internal oscillator. The clock of a computer that is being slewed may differ more and is then
 * rejected. */
#define CRYSTAL_DRIFT_PPM  200.0
#define INTERNAL_DRIFT_PPM 20000.0

void collect_handle_sync(struct link_state *side, const struct mr_sync *sync, uint64_t host_us)
{
    side->sync = *sync;
    side->sync_host_us = host_us;
}

void collect_handle_sync_at(struct link_state *side, const struct mr_sync_at *sync_at)
{
    bool this_one = side->sync_host_us != 0 && (uint16_t)side->sync.block == sync_at->block16;
    if (this_one && sync_at->sent) {
        uint32_t origin = mr_boardtime_origin_tick(side->sync.block, side->sync.tick);
        int64_t ticks = mr_boardtime_unwrap(origin, side->sync.block, sync_at->tick);
        timemap_add(&side->time_map, (double)ticks / MR_TICKS_PER_US, (int64_t)side->sync_host_us);
    }
    side->sync_host_us = 0;
}

void collect_handle_clock(struct link_state *side, const struct mr_clock *clock, uint64_t host_us)
{
    if (side->kind == LINK_SERIAL && clock->tick != 0)
        timemap_add(&side->time_map, 1000.0 * (double)clock->block + TIMEMAP_SERIAL_DELAY_US,
                    (int64_t)host_us);
}

void collect_discard_time_map(struct link_state *side)
{
    side->time_map.pair_count = 0;
    side->sync_host_us = 0;
}

enum mr_status collect_put_time_map(struct collector *collector, const struct link_state *side,
                                    const struct landing_slot *slot, struct error *error)
{
    struct timemap_fit fit;
    bool crystal = collector->reported.identity.clock_source == 0;
    if (side->time_map.pair_count == 0)
        return MR_OK;
    timemap_fit(&side->time_map, crystal ? CRYSTAL_DRIFT_PPM : INTERNAL_DRIFT_PPM, &fit);
    struct store_time_map row = {.session = collector->session,
                                 .boot = side->boot,
                                 .link = side->kind,
                                 .run = slot ? slot->row.id : STORE_NONE,
                                 .refusal = fit.refusal,
                                 .pairs = (int64_t)fit.pair_count,
                                 .from_us = llround(fit.from_us),
                                 .to_us = llround(fit.to_us),
                                 .spread_us = (double)NAN,
                                 .fast_ppm = (double)NAN,
                                 .fast_half_ppm = (double)NAN,
                                 .board_us = STORE_NONE,
                                 .host_us = STORE_NONE,
                                 .host_half_us = (double)NAN};
    if (fit.refusal == TIMEMAP_OK || fit.refusal == TIMEMAP_WRONG_RATE) {
        row.fast_ppm = fit.rate_ppm.value;
        row.fast_half_ppm = fit.rate_ppm.half_width;
    }
    if (fit.refusal == TIMEMAP_OK) {
        row.spread_us = fit.spread_us;
        row.board_us = llround(slot && slot->first_edge_us > 0.0 ? slot->first_edge_us : fit.to_us);
        struct timemap_value host = timemap_to_host_us(&fit, (double)row.board_us);
        row.host_us = llround(host.value);
        row.host_half_us = host.half_width;
    }
    return store_time_map_put(collector->store, &row, error);
}

enum mr_status collect_handle_film_frame(struct collector *collector, struct link_state *side,
                                         const struct mr_film_frame *frame, struct error *error)
{
    struct landing_slot *slot = side->current_landing;
    if (!slot)
        return MR_OK;
    int64_t number = slot->newest_film_frame +
                     (int16_t)(uint16_t)(frame->number - (uint16_t)slot->newest_film_frame);
    if (number > slot->newest_film_frame)
        slot->newest_film_frame = number;
    struct store_film_frame row = {.number = number,
                                   .tick = frame->tick,
                                   .board_us = timebase_tick_to_us(&side->timebase, frame->tick),
                                   .links = 1 << side->kind};
    return store_film_frame_put(collector->store, slot->row.id, &row, error);
}

/* ---- side: the current state of a link, and the events stored from it; all other files of the
 * collector use these functions ---- */

int64_t collect_newest_block(const struct link_state *side)
{
    return side->timebase.is_block_known ? side->timebase.newest_block : -1;
}

int64_t collect_board_time(const struct link_state *side, const struct mr_message *message)
{
    struct timebase copy = side->timebase;
    if (!copy.is_block_known)
        return STORE_NONE;
    if (message && message->block16 >= 0) {
        int64_t block = timebase_unwrap(&copy, (uint16_t)message->block16);
        return block < 0 ? STORE_NONE : 1000 * block;
    }
    return timebase_now_us(&side->timebase);
}

int64_t collect_event_block(struct link_state *side, const struct mr_message *message)
{
    return message->block16 >= 0 ? timebase_unwrap(&side->timebase, (uint16_t)message->block16)
                                 : message->block;
}

int64_t collect_link_bit(const struct link_state *side)
{
    return 1 << side->kind;
}

enum mr_status collect_put_event(struct collector *collector, const struct link_state *side,
                                 const char *kind, int64_t block, int64_t code, int64_t detail,
                                 int64_t value, uint64_t host_us, struct error *error)
{
    struct store_event event = {
        .session = collector->session,
        .boot = side->boot,
        .run = side->current_landing ? side->current_landing->row.id : STORE_NONE,
        .board_us = 1000 * block,
        .host_us = (int64_t)host_us,
        .kind = kind,
        .code = code,
        .detail = detail,
        .value = value,
        .links = collect_link_bit(side),
    };
    return store_event_put(collector->store, &event, error);
}
