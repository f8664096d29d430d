/* What comes over the two links, frame by frame: its time, what of it is lost, whose it is, and the
 * raw row; then what it means (collect_message.c).
 *
 * Serial has one board at its end, on CAN anybody may speak. So serial is the record while it is
 * there: what the board sends on both links is then taken from serial alone. CAN is kept raw, and
 * shown; it fills what serial lost when a landing is over (collect_landing.c). */
#include <math.h>
#include <string.h>

#include "common/block.h"
#include "host/collect/collect.h"
#include "host/collect/collect_state.h"

/* Messages of a link are in order: a statement may be about a moment that is past, readings are of
 * now, and clocks come every 100 blocks. */
#define BEHIND_BLOCKS         2000
#define READING_BEHIND_BLOCKS 200
#define AHEAD_BLOCKS          1000

#define RECORD_BLOCKS \
    1000 /* serial is silent when CAN is so far ahead of it, or of its own beginning */
#define MARK_BLOCKS 5000

/* The board began again. `whole`: the frame to come is its first. */
static enum mr_status restart(struct collector *collector, struct side *side, uint64_t host_us,
                              bool whole, struct error *error)
{
    enum mr_status status = collect_put_time_map(collector, side, NULL, error);
    if (status != MR_OK)
        return status;
    collect_leave(side);
    side->state_block = 0;
    side->time_doubt = (struct timebase_doubt){0};
    side->boot++;
    side->time = (struct timebase){0};
    side->clock_block = side->first_clock = 0;
    collect_forget_time(side);
    account_restart(&side->account, whole);
    side->shunt.number = 0;
    memset(collector->fault_count, 0, sizeof collector->fault_count);
    collector->alarm = (struct mr_can_alarm){0};
    struct store_event event = {.session = collector->session,
                                .boot = side->boot,
                                .run = STORE_NONE,
                                .board_us = 0,
                                .host_us = (int64_t)host_us,
                                .kind = "restart",
                                .links = 1 << side->kind};
    return store_event_put(collector->store, &event, error);
}

/* Takes the time a message carries. A clock with tick 0 comes from a board whose scans stand: its
 * block is no time. On CAN anybody may have sent it. */
static enum timebase_verdict take_time(struct side *side, const struct mr_message *message)
{
    if (message->place == MR_PLACE_CLOCK || message->place == MR_PLACE_SYNC) {
        bool sync = message->place == MR_PLACE_SYNC;
        uint32_t block = sync ? message->as.sync.block : message->as.clock.block;
        uint32_t tick = sync ? message->as.sync.tick : message->as.clock.tick;
        if (tick == 0)
            return TIMEBASE_GOES_ON;
        if (side->kind == LINK_CAN)
            return timebase_clock_doubting(&side->time, &side->time_doubt, block, tick);
        return timebase_clock(&side->time, block, tick) ? TIMEBASE_BEGAN_AGAIN : TIMEBASE_GOES_ON;
    }
    if (message->block16 >= 0)
        timebase_unwrap(&side->time, (uint16_t)message->block16);
    return TIMEBASE_GOES_ON;
}

enum mr_status collect_store_gaps(struct collector *collector, struct side *side,
                                  struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < side->account.gaps && status == MR_OK; i++) {
        const struct store_gap *gap = &side->account.gap[i];
        const struct slot *slot = side->current;
        if (!slot && side->last && gap->from_block != STORE_NONE &&
            gap->from_block <= side->last->end_block)
            slot = side->last;
        status = store_gap_put(collector->store, collector->session,
                               slot ? slot->row.id : STORE_NONE, gap, error);
    }
    side->account.gaps = 0;
    return status;
}

static enum mr_status store_raw(struct collector *collector, const struct side *side,
                                const struct slot *slot, struct store_frame *frame,
                                struct error *error)
{
    frame->run = slot ? slot->row.id : STORE_NONE;
    frame->link = (int)side->kind;
    return store_frame_put(collector->store, collector->session, frame, error);
}

/* On CAN: a time that no message of the board can have now. Time goes on while nothing comes, and
 * queues hold some back. */
static bool is_out_of_time(const struct side *side, const struct mr_message *message,
                           uint64_t host_us)
{
    int64_t newest = collect_newest_block(side);
    int64_t board_us = collect_board_time(side, message);
    int64_t paused = host_us > side->heard_us ? (int64_t)(host_us - side->heard_us) / 1000 : 0;
    if (side->kind != LINK_CAN || newest < 0)
        return false;
    int64_t behind = message->info->direction == MR_DIRECTION_CAN ? READING_BEHIND_BLOCKS
                                                                  : BEHIND_BLOCKS;
    return board_us == STORE_NONE || board_us / 1000 < newest - behind ||
           board_us / 1000 > newest + AHEAD_BLOCKS + 2 * paused;
}

/* ---- serial is the record ---- */

static bool serial_is_record(const struct collector *collector)
{
    const struct side *can = &collector->side[LINK_CAN], *serial = &collector->side[LINK_SERIAL];
    int64_t spoke = serial->time.known ? collect_newest_block(serial) : can->first_clock;
    return !serial->ended && serial->boot == can->boot && can->clock_block - spoke <= RECORD_BLOCKS;
}

/* A frame has its own stamp, serial's bytes that of their reading. */
static enum mr_status stamp_landing(struct collector *collector, struct side *can,
                                    const struct collector_event *event, struct error *error)
{
    struct slot *slot = can->current;
    if (event->message->place == MR_PLACE_LANDING &&
        event->message->as.landing.state == MR_LANDING_ARMED &&
        event->message->as.landing.block != can->armed.block) {
        can->armed = event->message->as.landing;
        can->armed_us = event->host_us;
    }
    if (!slot || slot->row.armed_us == (int64_t)can->armed_us ||
        slot->row.armed_block != (int64_t)can->armed.block ||
        slot->row.board_landing != can->armed.landing)
        return MR_OK;
    slot->row.armed_us = (int64_t)can->armed_us;
    return store_landing_put(collector->store, &slot->row, error);
}

/* Some seconds back, for the landing that begins. */
static enum mr_status mark_frames(struct collector *collector, struct side *can,
                                  struct error *error)
{
    int64_t block = collect_newest_block(can);
    if (block >= can->mark_block && block < can->mark_block + MARK_BLOCKS)
        return MR_OK;
    can->mark_block = block;
    can->mark[0] = can->mark[1];
    return store_frames_mark(collector->store, &can->mark[1], error);
}

/* What the board sends on both links to say the same. */
static bool is_of_both(const struct mr_message *message)
{
    switch (message->place) {
    case MR_PLACE_CLOCK:
    case MR_PLACE_CAN_HEALTH:
    case MR_PLACE_MESSAGE_COUNT:
    case MR_PLACE_CAN_ALARM:
    case MR_PLACE_CONFIG_IMAGE: return false; /* of one link */
    default: return message->info->direction == MR_DIRECTION_BOTH;
    }
}

/* CAN is in the landing that serial says, from its first block to its last. */
static void follow_serial(struct collector *collector, struct side *can)
{
    int64_t block = collect_newest_block(can);
    struct slot *slot = can->current;
    if (slot && slot->left[LINK_SERIAL] && block > slot->end_block)
        collect_leave(can);
    for (size_t i = 0; i < SLOTS && !can->current; i++) {
        slot = &collector->slot[i];
        if (slot->row.id == 0 || slot->row.boot != can->boot || slot->left[LINK_CAN] ||
            !slot->entered[LINK_SERIAL] || slot->finished || block < slot->row.armed_block ||
            (slot->left[LINK_SERIAL] && block > slot->end_block))
            continue;
        slot->entered[LINK_CAN] = true;
        can->current = slot;
        account_break(&can->account);
    }
}

/* Who a board on CAN is: where the board that serial knows never speaks on CAN, the two links are
 * of two boards. */
static void note_identity(struct collector *collector, struct side *can,
                          const struct mr_message *message)
{
    const uint32_t words[2] = {message->as.board_uid.uid0, message->as.board_uid.uid1};
    if (message->place != MR_PLACE_BOARD_UID || !collector->uid_vouched)
        return;
    bool own = memcmp(words, collector->uid, sizeof words) == 0;
    can->own_heard |= own;
    can->others = own ? 0 : can->others + 1;
    if (!own)
        memcpy(can->other_uid, words, sizeof words);
}

/* Tells who listens, and does what the message says. */
static enum mr_status hear(struct collector *collector, struct side *side,
                           const struct collector_event *event, struct error *error)
{
    if (collector->listener)
        collector->listener->message(collector->listener->context, event);
    if (!collector->hello && event->message->place != MR_PLACE_HELLO)
        return MR_OK;
    if (side->kind == LINK_CAN && serial_is_record(collector)) {
        follow_serial(collector, side);
        if (mark_frames(collector, side, error) != MR_OK ||
            stamp_landing(collector, side, event, error) != MR_OK)
            return error->status;
        if (collector->hello && is_of_both(event->message)) {
            note_identity(collector, side, event->message);
            side->state_block = 0; /* it begins anew when serial falls silent */
            return MR_OK;
        }
    }
    return collect_message(collector, side, event, error);
}

/* A message of the board, from either link: time, account, meaning, storage. */
static enum mr_status take_message(struct collector *collector, struct side *side,
                                   const struct mr_message *message, int64_t seq, uint64_t host_us,
                                   struct error *error)
{
    const struct mr_message_info *info = message->info;
    bool lost_in_time = is_out_of_time(side, message, host_us);
    enum timebase_verdict time = lost_in_time ? TIMEBASE_DOUBTED : take_time(side, message);
    enum mr_status status = MR_OK;
    side->heard_us = host_us;
    if (time == TIMEBASE_BEGAN_AGAIN) {
        status = restart(collector, side, host_us, false, error);
        take_time(side, message);
    }
    if (side->kind == LINK_CAN)
        account_can_frame(&side->account);
    else
        account_serial_frame(&side->account, (uint16_t)seq, collect_newest_block(side));
    if (message->place == MR_PLACE_CLOCK && side->time.tick_known && time != TIMEBASE_DOUBTED) {
        side->clock_block = message->as.clock.block;
        if (side->first_clock == 0)
            side->first_clock = side->clock_block;
        account_goes_on(&side->account);
    }
    account_message(&side->account, message->place);

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
    struct slot *before = side->current;
    enum mr_status meaning = MR_OK;
    if (status == MR_OK && time != TIMEBASE_DOUBTED)
        meaning = hear(collector, side, &event, error);
    if (status == MR_OK)
        status = store_raw(collector, side,
                           lost_in_time    ? NULL
                           : side->current ? side->current
                                           : before,
                           &frame, error);
    if (status == MR_OK)
        status = collect_store_gaps(collector, side, error);
    if (status == MR_OK)
        status = meaning;
    return status == MR_OK ? collect_finish_what_is_over(collector, error) : status;
}

enum mr_status collector_frame(struct collector *collector, const struct link_frame *frame,
                               struct error *error)
{
    struct side *side = &collector->side[LINK_CAN];
    struct mr_message message;
    bool standard = !(frame->id & (LINK_ID_EXTENDED | LINK_ID_REMOTE | LINK_ID_ERROR));
    uint32_t id = link_id_from_bus(frame->id, collector->can_base);
    if (standard && mr_message_read(&message, (uint16_t)id, frame->data, frame->length) == MR_OK &&
        message.info->direction != MR_DIRECTION_HOST)
        return take_message(collector, side, &message, side->account.counts.received,
                            frame->host_us, error);

    /* Somebody else on the bus: kept, not understood. */
    const struct mr_message_info *info = standard ? mr_message_find((uint16_t)id) : NULL;
    bool command = info && info->direction == MR_DIRECTION_HOST;
    if (!command && !(frame->id & LINK_ID_ERROR))
        side->account.counts.foreign++;
    struct store_frame raw = {.direction = command,
                              .seq = STORE_NONE,
                              .board_us = collect_board_time(side, NULL),
                              .host_us = (int64_t)frame->host_us,
                              .id = id,
                              .length = frame->length,
                              .data = frame->data};
    return store_raw(collector, side, side->current, &raw, error);
}

static enum mr_status take_block(struct collector *collector, struct side *side,
                                 const struct mr_frame *frame, uint64_t host_us,
                                 struct error *error)
{
    struct mr_block block;
    enum mr_status status = MR_OK;
    if (mr_block_get(&block, frame->payload, frame->length) != MR_OK) {
        side->account.counts.bad++;
        return MR_OK;
    }
    if (timebase_clock(&side->time, block.index, block.tick)) {
        status = restart(collector, side, host_us, false, error);
        timebase_clock(&side->time, block.index, block.tick);
    }
    account_serial_frame(&side->account, frame->seq, collect_newest_block(side));
    account_goes_on(&side->account);
    account_message(&side->account, MR_PLACE_BLOCK);
    if (side->current)
        account_block(&side->account, block.index);
    if (collector->listener)
        collector->listener->record(collector->listener->context, &block, host_us);
    if (status == MR_OK)
        status = collect_store_gaps(collector, side, error);
    if (status == MR_OK)
        status = store_block_put(collector->store, collector->session, side->boot,
                                 side->current ? side->current->row.id : STORE_NONE,
                                 (int)side->kind, block.index, (int64_t)host_us, frame->payload,
                                 frame->length, error);
    return status;
}

static enum mr_status take_serial_frame(struct collector *collector, struct side *side,
                                        const struct mr_frame *frame, uint64_t host_us,
                                        struct error *error)
{
    if (frame->type == MR_ID_BLOCK)
        return take_block(collector, side, frame, host_us, error);
    struct mr_message message;
    if (mr_message_read(&message, frame->type, frame->payload, frame->length) != MR_OK) {
        account_serial_frame(&side->account, frame->seq, collect_newest_block(side));
        /* a part of the black box, or nothing known */
        account_message(&side->account, mr_message_place(frame->type));
        side->account.counts.foreign++;
        struct store_frame raw = {.seq = frame->seq,
                                  .board_us = collect_board_time(side, NULL),
                                  .host_us = (int64_t)host_us,
                                  .id = frame->type,
                                  .length = frame->length,
                                  .data = frame->payload};
        return store_raw(collector, side, side->current, &raw, error);
    }
    /* A board that begins again says hello in its frame number 0. */
    if (message.place == MR_PLACE_HELLO && frame->seq == 0 && side->account.seq_known &&
        side->account.seq_next != 0) {
        enum mr_status status = restart(collector, side, host_us, true, error);
        if (status != MR_OK)
            return status;
    }
    return take_message(collector, side, &message, frame->seq, host_us, error);
}

enum mr_status collector_bytes(struct collector *collector, const uint8_t *bytes, size_t length,
                               uint64_t host_us, struct error *error)
{
    struct side *side = &collector->side[LINK_SERIAL];
    side->account.bytes += (int64_t)length;
    for (size_t i = 0; i < length; i++) {
        struct mr_frame frame;
        enum mr_status status = mr_deframer_push(&side->deframer, bytes[i], &frame);
        if (status == MR_OK)
            status = take_serial_frame(collector, side, &frame, host_us, error);
        else if (status != MR_TOO_FEW)
            side->account.counts.bad++;
        if (error->status != MR_OK)
            return error->status;
    }
    return MR_OK;
}

/* ---- time: pairs of the board's clock and this computer's, what they come to for each landing
 * and boot, and film frames ---- */

/* How far two clocks may be apart: crystals by 200 ppm at most and a computer's that is being
 * slewed by 500; the board's internal oscillator by a hundredth and its drift. */
#define CRYSTAL_PPM  700.0
#define INTERNAL_PPM 20000.0

void collect_sync(struct side *side, const struct mr_sync *sync, uint64_t host_us)
{
    side->sync = *sync;
    side->sync_host_us = host_us;
}

void collect_sync_at(struct side *side, const struct mr_sync_at *sync_at)
{
    bool this_one = side->sync_host_us != 0 && (uint16_t)side->sync.block == sync_at->block16;
    if (this_one && sync_at->sent) {
        uint32_t origin = mr_boardtime_origin(side->sync.block, side->sync.tick);
        int64_t ticks = mr_boardtime_ticks(origin, side->sync.block, sync_at->tick);
        timemap_add(&side->map, (double)ticks / MR_TICKS_PER_US, (int64_t)side->sync_host_us);
    }
    side->sync_host_us = 0;
}

void collect_clock(struct side *side, const struct mr_clock *clock, uint64_t host_us)
{
    if (side->kind == LINK_SERIAL && clock->tick != 0)
        timemap_add(&side->map, 1000.0 * (double)clock->block + TIMEMAP_SERIAL_US,
                    (int64_t)host_us);
}

void collect_forget_time(struct side *side)
{
    side->map.count = 0;
    side->sync_host_us = 0;
}

enum mr_status collect_put_time_map(struct collector *collector, const struct side *side,
                                    const struct slot *slot, struct error *error)
{
    struct timemap_fit fit;
    bool crystal = collector->identity.clock_source == 0;
    if (side->map.count == 0)
        return MR_OK;
    timemap_fit(&side->map, crystal ? CRYSTAL_PPM : INTERNAL_PPM, &fit);
    struct store_time_map row = {.session = collector->session,
                                 .boot = side->boot,
                                 .link = side->kind,
                                 .run = slot ? slot->row.id : STORE_NONE,
                                 .refusal = fit.refusal,
                                 .pairs = (int64_t)fit.pairs,
                                 .from_us = llround(fit.from_us),
                                 .to_us = llround(fit.to_us),
                                 .spread_us = (double)NAN,
                                 .fast_ppm = (double)NAN,
                                 .fast_half_ppm = (double)NAN,
                                 .board_us = STORE_NONE,
                                 .host_us = STORE_NONE,
                                 .host_half_us = (double)NAN};
    if (fit.refusal == TIMEMAP_GOOD || fit.refusal == TIMEMAP_OTHER_PACE) {
        row.fast_ppm = fit.fast_ppm.value;
        row.fast_half_ppm = fit.fast_ppm.half;
    }
    if (fit.refusal == TIMEMAP_GOOD) {
        row.spread_us = fit.spread_us;
        row.board_us = llround(slot && slot->first_edge_us > 0.0 ? slot->first_edge_us : fit.to_us);
        struct timemap_value host = timemap_host_us(&fit, (double)row.board_us);
        row.host_us = llround(host.value);
        row.host_half_us = host.half;
    }
    return store_time_map_put(collector->store, &row, error);
}

enum mr_status collect_film_frame(struct collector *collector, struct side *side,
                                  const struct mr_film_frame *frame, struct error *error)
{
    struct slot *slot = side->current;
    if (!slot)
        return MR_OK;
    int64_t number = slot->film_frames +
                     (int16_t)(uint16_t)(frame->number - (uint16_t)slot->film_frames);
    if (number > slot->film_frames)
        slot->film_frames = number;
    struct store_film_frame row = {.number = number,
                                   .tick = frame->tick,
                                   .board_us = timebase_tick_us(&side->time, frame->tick),
                                   .links = 1 << side->kind};
    return store_film_frame_put(collector->store, slot->row.id, &row, error);
}

/* ---- side ----
 *
 * What a link knows of now, and the event that something makes there. All other files of the
 * collector stand on this one. */

int64_t collect_newest_block(const struct side *side)
{
    return side->time.known ? side->time.block : -1;
}

int64_t collect_board_time(const struct side *side, const struct mr_message *message)
{
    struct timebase copy = side->time;
    if (!copy.known)
        return STORE_NONE;
    if (message && message->block16 >= 0) {
        int64_t block = timebase_unwrap(&copy, (uint16_t)message->block16);
        return block < 0 ? STORE_NONE : 1000 * block;
    }
    return timebase_now_us(&side->time);
}

int64_t collect_block(struct side *side, const struct mr_message *message)
{
    return message->block16 >= 0 ? timebase_unwrap(&side->time, (uint16_t)message->block16)
                                 : message->block;
}

int64_t collect_link_bit(const struct side *side)
{
    return 1 << side->kind;
}

enum mr_status collect_put_event(struct collector *collector, const struct side *side,
                                 const char *kind, int64_t block, int64_t code, int64_t detail,
                                 int64_t value, uint64_t host_us, struct error *error)
{
    struct store_event event = {
        .session = collector->session,
        .boot = side->boot,
        .run = side->current ? side->current->row.id : STORE_NONE,
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
