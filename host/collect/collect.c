#include "host/collect/collect.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/collect/collect_state.h"

enum mr_status collector_open(struct store *store, const char *can_spec, const char *serial_spec,
                              struct collector **collector, struct error *error)
{
    struct collector *made = calloc(1, sizeof *made);
    if (!made)
        return error_set(error, MR_FULL, "no memory: logging to %s; close other programs", store_path(store));
    made->store = store;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct side *side = &made->side[kind];
        side->kind = (enum link_kind)kind;
        side->spec = kind == LINK_CAN ? can_spec : serial_spec;
        side->ended = !side->spec;
        account_start(&side->account, side->kind);
        mr_deframer_init(&side->deframer);
    }
    made->identity.image_crc = STORE_NONE;
    made->identity.config_crc = STORE_NONE;
    made->identity.clock_source = STORE_NONE;
    made->identity.touchdown_ft = (double)NAN;
    made->identity.switch_error_ft = (double)NAN;

    struct store_session session = {
        .started_us = (int64_t)link_now_us(), .can_link = can_spec, .serial_link = serial_spec};
    enum mr_status status = store_session_add(store, &session, error);
    if (status != MR_OK) {
        free(made);
        return status;
    }
    made->session = session.id;
    *collector = made;
    return MR_OK;
}

void collector_close(struct collector *collector)
{
    if (collector)
        free(collector->mark);
    free(collector);
}

int64_t collector_session(const struct collector *collector)
{
    return collector->session;
}

void collector_watch(struct collector *collector, const struct collector_watcher *watcher)
{
    collector->watcher = watcher;
}

const struct crash_report *collector_take_crash(struct collector *collector)
{
    bool news = collector->crash_news;
    collector->crash_news = false;
    return news ? &collector->crashed : NULL;
}

const struct mr_can_alarm *collector_take_alarm(struct collector *collector)
{
    bool news = collector->alarm_news;
    collector->alarm_news = false;
    return news ? &collector->alarm : NULL;
}

const struct mr_ack *collector_take_answer(struct collector *collector)
{
    bool news = collector->answer_news;
    collector->answer_news = false;
    return news ? &collector->answer : NULL;
}

const char *collector_state_text(unsigned state)
{
    static const char *const texts[] = {"idle", "armed", "landing", "settling", "done"};
    return state < sizeof texts / sizeof texts[0] ? texts[state] : "unknown";
}

/* `whole`: the frame to come is the board's first. */
static enum mr_status restart(struct collector *collector, struct side *side, uint64_t host_us, bool whole,
                              struct error *error)
{
    enum mr_status status = collect_put_time_map(collector, side, NULL, error);
    if (status != MR_OK)
        return status;
    collect_leave(side);
    side->boot++;
    side->time = (struct timebase){0};
    collect_forget_time(side);
    account_restart(&side->account, whole);
    side->shunt = (struct mr_shunt){0};
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

/* Takes the time a message carries. Returns true when the board began again. A clock with tick 0 comes from a
 * board whose scans stand: its block is no time. */
static bool take_time(struct side *side, const struct mr_message_info *info, const uint8_t *payload)
{
    if (info->id == MR_ID_CLOCK || info->id == MR_ID_SYNC) { /* which begins like it */
        struct mr_clock clock;
        mr_clock_get(&clock, payload, info->length);
        return clock.tick != 0 && timebase_clock(&side->time, clock.block, clock.tick);
    }
    const struct mr_field_info *last = &info->fields[info->field_count - 1];
    if (strcmp(last->name, "block16") == 0) {
        const uint8_t *p = payload + last->offset;
        timebase_unwrap(&side->time, mr_get_u16(&p));
    }
    return false;
}

/* Board time of a message: that of its own block where it has one, else the newest known. */
static int64_t board_time(const struct side *side, const struct mr_message_info *info, const uint8_t *payload)
{
    struct timebase copy = side->time;
    if (!copy.known)
        return STORE_NONE;
    const struct mr_field_info *last = info ? &info->fields[info->field_count - 1] : NULL;
    if (last && strcmp(last->name, "block16") == 0) {
        const uint8_t *p = payload + last->offset;
        int64_t block = timebase_unwrap(&copy, mr_get_u16(&p));
        return block < 0 ? STORE_NONE : 1000 * block;
    }
    return timebase_now_us(&side->time);
}

/* Stores the gaps the account has found, with the landing they fall in. */
static enum mr_status store_account_gaps(struct collector *collector, struct side *side, struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < side->account.gaps && status == MR_OK; i++) {
        const struct store_gap *gap = &side->account.gap[i];
        const struct slot *slot = side->current;
        if (!slot && side->last && gap->from_block != STORE_NONE && gap->from_block <= side->last->end_block)
            slot = side->last;
        status =
            store_gap_put(collector->store, collector->session, slot ? slot->row.id : STORE_NONE, gap, error);
    }
    side->account.gaps = 0;
    return status;
}

static enum mr_status store_raw(struct collector *collector, const struct side *side, const struct slot *slot,
                                struct store_frame *frame, struct error *error)
{
    frame->run = slot ? slot->row.id : STORE_NONE;
    frame->link = (int)side->kind;
    return store_frame_put(collector->store, collector->session, frame, error);
}

/* A message of the board, from either link: time, account, meaning, storage. */
static enum mr_status take_message(struct collector *collector, struct side *side,
                                   const struct mr_message_info *info, int64_t seq, const uint8_t *payload,
                                   uint64_t host_us, struct error *error)
{
    enum mr_status status = MR_OK;
    if (take_time(side, info, payload)) {
        status = restart(collector, side, host_us, false, error);
        take_time(side, info, payload);
    }
    if (side->kind == LINK_CAN)
        account_can_frame(&side->account);
    else
        account_serial_frame(&side->account, (uint16_t)seq, collect_newest_block(side));
    if (info->id == MR_ID_CLOCK && side->time.tick_known)
        account_goes_on(&side->account);
    account_message(&side->account, info->id);

    struct store_frame frame = {.seq = seq,
                                .board_us = board_time(side, info, payload),
                                .host_us = (int64_t)host_us,
                                .id = info->id,
                                .length = info->length,
                                .data = payload};
    struct slot *before = side->current;
    enum mr_status meaning = MR_OK;
    if (status == MR_OK && (collector->hello || info->id == MR_ID_HELLO))
        meaning = collect_message(collector, side, info->id, payload, info->length, host_us, error);
    if (status == MR_OK)
        status = store_raw(collector, side, side->current ? side->current : before, &frame, error);
    if (collector->watcher)
        collector->watcher->message(collector->watcher->context, side->kind, info->id, payload, info->length, host_us, frame.board_us);
    if (status == MR_OK)
        status = store_account_gaps(collector, side, error);
    if (status == MR_OK)
        status = meaning;
    return status == MR_OK ? collect_finish_what_is_over(collector, error) : status;
}

enum mr_status collector_frame(struct collector *collector, const struct link_frame *frame,
                               struct error *error)
{
    struct side *side = &collector->side[LINK_CAN];
    const struct mr_message_info *info = NULL;
    if (!(frame->id & (LINK_ID_EXTENDED | LINK_ID_REMOTE | LINK_ID_ERROR)))
        info = mr_message_find((uint16_t)frame->id);
    int64_t seq = side->account.counts.received;
    if (info && info->direction != MR_DIRECTION_HOST && info->length == frame->length)
        return take_message(collector, side, info, seq, frame->data, frame->host_us, error);

    /* Somebody else on the bus: kept, not understood. */
    bool command = info && info->direction == MR_DIRECTION_HOST;
    if (!command && !(frame->id & LINK_ID_ERROR))
        side->account.counts.foreign++;
    struct store_frame raw = {.direction = command,
                              .seq = STORE_NONE,
                              .board_us = board_time(side, NULL, NULL),
                              .host_us = (int64_t)frame->host_us,
                              .id = frame->id,
                              .length = frame->length,
                              .data = frame->data};
    return store_raw(collector, side, side->current, &raw, error);
}

static enum mr_status take_block(struct collector *collector, struct side *side, const struct mr_frame *frame,
                                 uint64_t host_us, struct error *error)
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
    account_message(&side->account, MR_ID_BLOCK);
    if (side->current)
        account_block(&side->account, block.index);
    if (collector->watcher)
        collector->watcher->record(collector->watcher->context, frame->payload, frame->length, host_us);
    if (status == MR_OK)
        status = store_account_gaps(collector, side, error);
    if (status == MR_OK)
        status = store_block_put(collector->store, collector->session, side->boot,
                                 side->current ? side->current->row.id : STORE_NONE, (int)side->kind, block.index,
                                 (int64_t)host_us, frame->payload, frame->length, error);
    return status;
}

static enum mr_status take_serial_frame(struct collector *collector, struct side *side,
                                        const struct mr_frame *frame, uint64_t host_us, struct error *error)
{
    if (frame->type == MR_ID_BLOCK)
        return take_block(collector, side, frame, host_us, error);
    const struct mr_message_info *info = mr_message_find(frame->type);
    if (!info || info->length != frame->length) {
        account_serial_frame(&side->account, frame->seq, collect_newest_block(side));
        account_message(&side->account, frame->type); /* a part of the black box, or nothing known */
        side->account.counts.foreign++;
        struct store_frame raw = {.seq = frame->seq,
                                  .board_us = board_time(side, NULL, NULL),
                                  .host_us = (int64_t)host_us,
                                  .id = frame->type,
                                  .length = frame->length,
                                  .data = frame->payload};
        return store_raw(collector, side, side->current, &raw, error);
    }
    /* A board that begins again says hello in its frame number 0. */
    if (info->id == MR_ID_HELLO && frame->seq == 0 && side->account.seq_known &&
        side->account.seq_next != 0) {
        enum mr_status status = restart(collector, side, host_us, true, error);
        if (status != MR_OK)
            return status;
    }
    return take_message(collector, side, info, frame->seq, frame->payload, host_us, error);
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

/* One event for each trouble, with how often it happened since the last one. */
static enum mr_status record_troubles(struct collector *collector, struct side *side, struct error *error)
{
    enum mr_status status = MR_OK;
    if (!side->any_pending)
        return MR_OK;
    for (unsigned i = 0; i < LINK_TROUBLES && status == MR_OK; i++) {
        struct store_event event = {.session = collector->session,
                                    .boot = side->boot,
                                    .run = side->pending_run,
                                    .board_us = side->pending_us,
                                    .host_us = (int64_t)link_now_us(),
                                    .kind = store_trouble_kind(side->kind),
                                    .code = i,
                                    .detail = (int64_t)side->pending[i],
                                    .value = (int64_t)side->told[i],
                                    .links = 1 << side->kind};
        if (side->pending[i] > 0)
            status = store_event_put(collector->store, &event, error);
        side->pending[i] = 0;
    }
    side->any_pending = false;
    return status;
}

enum mr_status collector_troubles(struct collector *collector, enum link_kind kind,
                                  const struct link_counters *counters, struct error *error)
{
    struct side *side = &collector->side[kind];
    int64_t run = side->current ? side->current->row.id : STORE_NONE;
    enum mr_status status = MR_OK;
    if (side->any_pending && side->pending_run != run)
        status = record_troubles(collector, side, error);
    for (unsigned i = 0; i < LINK_TROUBLES && status == MR_OK; i++) {
        uint64_t more = counters->trouble[i] - side->told[i];
        if (more == 0)
            continue;
        if (!side->any_pending) {
            side->any_pending = true;
            side->pending_run = run;
            side->pending_us = side->time.known ? timebase_now_us(&side->time) : STORE_NONE;
        }
        side->told[i] = counters->trouble[i];
        side->pending[i] += more;
        account_trouble(&side->account, (enum link_trouble)i, (int64_t)more);
    }
    return status;
}

enum mr_status collector_clock_set(struct collector *collector, int64_t jump_us, struct error *error)
{
    struct store_event event = {.session = collector->session, .run = STORE_NONE, .board_us = STORE_NONE,
                                .host_us = (int64_t)link_now_us(), .kind = "clock-set", .value = jump_us};
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct side *side = &collector->side[kind];
        if (side->current)
            event.run = side->current->row.id;
        collect_forget_time(side);
    }
    return store_event_put(collector->store, &event, error);
}

enum mr_status collector_link_end(struct collector *collector, enum link_kind kind, struct error *error)
{
    struct side *side = &collector->side[kind];
    if (side->ended)
        return MR_OK;
    side->ended = true;
    account_end(&side->account);
    enum mr_status status = store_account_gaps(collector, side, error);
    if (status == MR_OK)
        status = collect_finish_what_is_over(collector, error);
    if (status == MR_OK && kind == LINK_SERIAL && side->deframer.length > 0) {
        side->account.counts.bad++;
        status = error_set(error, MR_TRUNCATED,
                           "the link ended inside a frame: %s; the frames before it are kept", side->spec);
    }
    return status;
}

enum mr_status collector_end(struct collector *collector, const char *ended_by, struct error *error)
{
    enum mr_status status = MR_OK;
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct side *side = &collector->side[kind];
        if (!side->ended) {
            side->ended = true;
            account_end(&side->account);
            status = store_account_gaps(collector, side, error);
        }
    }
    for (size_t i = 0; i < SLOTS && status == MR_OK; i++) {
        struct slot *slot = &collector->slot[i];
        if (slot->row.id && !slot->finished)
            status = collect_finish(collector, slot, error);
    }
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++)
        status = collect_put_time_map(collector, &collector->side[kind], NULL, error);
    if (status == MR_OK)
        status = collector_put_counts(collector, error);
    if (status == MR_OK)
        status =
            store_session_end(collector->store, collector->session, (int64_t)link_now_us(), ended_by, error);
    return status;
}

enum mr_status collector_put_counts(struct collector *collector, struct error *error)
{
    enum mr_status status = MR_OK;
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct side *side = &collector->side[kind];
        if (side->spec)
            status = store_link_put(collector->store, collector->session, kind, &side->account.counts, error);
        for (unsigned place = 0; place < MR_PLACES && status == MR_OK; place++) {
            if (side->account.missing_of[place])
                status = store_missing_put(collector->store, collector->session, kind, mr_message_text(place),
                                           side->account.missing_of[place], error);
        }
        if (status == MR_OK)
            status = record_troubles(collector, side, error);
    }
    return status;
}

int64_t collector_block(const struct collector *collector, enum link_kind kind)
{
    return collect_newest_block(&collector->side[kind]);
}

int64_t collector_take_finished(struct collector *collector)
{
    if (collector->finished_count == 0)
        return 0;
    int64_t run = collector->finished[0];
    collector->finished_count--;
    memmove(collector->finished, collector->finished + 1,
            collector->finished_count * sizeof collector->finished[0]);
    return run;
}

void collector_progress(const struct collector *collector, struct collector_progress *progress)
{
    *progress = (struct collector_progress){.hello = collector->hello,
                                            .block = -1,
                                            .before_first = collector->side[LINK_CAN].account.before_first};
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct side *side = &collector->side[kind];
        progress->counts[kind] = side->account.counts;
        memcpy(progress->missing[kind], side->account.missing_of, sizeof progress->missing[kind]);
        if (collect_newest_block(side) > progress->block)
            progress->block = collect_newest_block(side);
        if (side->current && side->current->row.id > progress->run) {
            progress->run = side->current->row.id;
            progress->state = (unsigned)side->current->row.state;
            progress->edges = side->current->edges;
        }
    }
}
