#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/collect/collect.h"
#include "host/collect/collect_state.h"

enum mr_status collector_open(struct store *store, const char *can_spec, uint16_t can_base,
                              const char *serial_spec, struct collector **collector,
                              struct error *error)
{
    struct collector *made = calloc(1, sizeof *made);
    if (!made)
        return error_set(error, MR_FULL, "out of memory, logging to %s; close other programs",
                         store_path(store));
    made->store = store;
    made->can_base = can_base;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct link_state *side = &made->side[kind];
        side->kind = (enum link_kind)kind;
        side->link_spec = kind == LINK_CAN ? can_spec : serial_spec;
        side->has_ended = !side->link_spec;
        loss_tracker_start(&side->loss_tracker, side->kind);
        mr_deframer_init(&side->deframer);
    }
    made->reported.identity.image_crc = STORE_NONE;
    made->reported.identity.config_crc = STORE_NONE;
    made->reported.identity.clock_source = STORE_NONE;
    made->reported.identity.touchdown_ft = (double)NAN;
    made->reported.identity.switch_error_ft = (double)NAN;

    struct store_session session = {.started_us = (int64_t)link_now_us(),
                                    .can_link = can_spec,
                                    .serial_link = serial_spec,
                                    .can_base = can_spec ? can_base : STORE_NONE};
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
        free(collector->saved_state);
    free(collector);
}

int64_t collector_get_session(const struct collector *collector)
{
    return collector->session;
}

void collector_set_listener(struct collector *collector, const struct collector_listener *listener)
{
    collector->listener = listener;
}

const struct crash_report *collector_pop_crash(struct collector *collector)
{
    bool is_new = collector->crash_unread;
    collector->crash_unread = false;
    return is_new ? &collector->stored_crash : NULL;
}

const struct mr_can_alarm *collector_pop_alarm(struct collector *collector)
{
    bool is_new = collector->alarm_unread;
    collector->alarm_unread = false;
    return is_new ? &collector->alarm : NULL;
}

void collector_add_own_command(struct collector_own_commands *own, const struct mr_command *command)
{
    unsigned i = own->next_index++ % COLLECTOR_OWN_COMMANDS_MAX;
    own->command[i].code = command->code;
    own->command[i].tag = command->tag;
    own->command[i].block = -1;
}

void collector_set_own_commands(struct collector *collector, struct collector_own_commands *own)
{
    collector->own_commands = own;
}

bool collector_pop_answer(struct collector *collector, struct collector_answer *answer)
{
    if (collector->read_answer_count == collector->answer_add_count)
        return false;
    if (collector->answer_add_count - collector->read_answer_count > COLLECT_ANSWERS_MAX)
        collector->read_answer_count = collector->answer_add_count - COLLECT_ANSWERS_MAX;
    *answer = collector->answer[collector->read_answer_count++ % COLLECT_ANSWERS_MAX];
    return true;
}

/* Stores one event for each kind of link fault, with the number of occurrences since the last such
 * event. */
static enum mr_status record_link_faults(struct collector *collector, struct link_state *side,
                                         struct error *error)
{
    enum mr_status status = MR_OK;
    if (!side->has_pending_faults)
        return MR_OK;
    for (unsigned i = 0; i < LINK_FAULT_COUNT && status == MR_OK; i++) {
        struct store_event event = {.session = collector->session,
                                    .boot = side->boot,
                                    .run = side->pending_faults_run,
                                    .board_us = side->pending_faults_us,
                                    .host_us = (int64_t)link_now_us(),
                                    .kind = store_link_error_event_kind((int)side->kind),
                                    .code = i,
                                    .detail = (int64_t)side->pending_faults[i],
                                    .value = (int64_t)side->counted_faults[i],
                                    .links = 1 << side->kind};
        if (side->pending_faults[i] > 0)
            status = store_event_put(collector->store, &event, error);
        side->pending_faults[i] = 0;
    }
    side->has_pending_faults = false;
    return status;
}

/* Discards a partial frame, because data received after a reconnection does not continue it. */
static void discard_partial_frame(struct link_state *side)
{
    if (side->deframer.length > 0)
        side->loss_tracker.counts.bad++;
    mr_deframer_init(&side->deframer);
}

enum mr_status collector_count_link_faults(struct collector *collector, enum link_kind kind,
                                           const struct link_counters *counters,
                                           struct error *error)
{
    struct link_state *side = &collector->side[kind];
    int64_t run = side->current_landing ? side->current_landing->row.id : STORE_NONE;
    enum mr_status status = MR_OK;
    if (kind == LINK_CAN)
        side->loss_tracker.counts.bad = (int64_t)counters->bad_lines;
    if (side->has_pending_faults && side->pending_faults_run != run)
        status = record_link_faults(collector, side, error);
    for (unsigned i = 0; i < LINK_FAULT_COUNT && status == MR_OK; i++) {
        uint64_t more = counters->fault_count[i] - side->counted_faults[i];
        if (more == 0)
            continue;
        if (!side->has_pending_faults) {
            side->has_pending_faults = true;
            side->pending_faults_run = run;
            side->pending_faults_us = side->timebase.is_block_known
                                        ? timebase_now_us(&side->timebase)
                                        : STORE_NONE;
        }
        side->counted_faults[i] = counters->fault_count[i];
        side->pending_faults[i] += more;
        if (i == LINK_BACK)
            discard_partial_frame(side);
        loss_tracker_add_link_fault(&side->loss_tracker, (enum link_fault)i, (int64_t)more);
    }
    return status;
}

enum mr_status collector_handle_clock_jump(struct collector *collector, int64_t jump_us,
                                           struct error *error)
{
    struct store_event event = {.session = collector->session,
                                .run = STORE_NONE,
                                .board_us = STORE_NONE,
                                .host_us = (int64_t)link_now_us(),
                                .kind = "clock-set",
                                .value = jump_us};
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct link_state *side = &collector->side[kind];
        if (side->current_landing)
            event.run = side->current_landing->row.id;
        collect_discard_time_map(side);
    }
    return store_event_put(collector->store, &event, error);
}

enum mr_status collector_end_link(struct collector *collector, enum link_kind kind,
                                  struct error *error)
{
    struct link_state *side = &collector->side[kind];
    if (side->has_ended)
        return MR_OK;
    enum mr_status status = collect_release_held_frames(collector, side, error);
    side->has_ended = true;
    loss_tracker_end(&side->loss_tracker);
    if (status == MR_OK)
        status = collect_store_gaps(collector, side, error);
    if (status == MR_OK)
        status = collect_finish_ended_landings(collector, error);
    if (status == MR_OK && kind == LINK_SERIAL && side->deframer.length > 0) {
        side->loss_tracker.counts.bad++;
        status = error_set(error, MR_TRUNCATED,
                           "the link ended inside a frame: %s; all earlier frames are stored",
                           side->link_spec);
    }
    return status;
}

enum mr_status collector_end(struct collector *collector, const char *ended_by, struct error *error)
{
    enum mr_status status = MR_OK;
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct link_state *side = &collector->side[kind];
        if (!side->has_ended) {
            status = collect_release_held_frames(collector, side, error);
            side->has_ended = true;
            loss_tracker_end(&side->loss_tracker);
            if (status == MR_OK)
                status = collect_store_gaps(collector, side, error);
        }
    }
    for (size_t i = 0; i < LANDING_SLOT_COUNT && status == MR_OK; i++) {
        struct landing_slot *slot = &collector->slot[i];
        if (slot->row.id && !slot->is_finished)
            status = collect_finish_landing(collector, slot, error);
    }
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++)
        status = collect_put_time_map(collector, &collector->side[kind], NULL, error);
    if (status == MR_OK)
        status = collector_store_counts(collector, error);
    if (status == MR_OK)
        status = store_session_end(collector->store, collector->session, (int64_t)link_now_us(),
                                   ended_by, error);
    return status;
}

enum mr_status collector_store_counts(struct collector *collector, struct error *error)
{
    enum mr_status status = MR_OK;
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        struct link_state *side = &collector->side[kind];
        if (side->link_spec)
            status = store_link_put(collector->store, collector->session, kind,
                                    &side->loss_tracker.counts, error);
        for (unsigned place = 0; place < MR_MESSAGE_COUNT && status == MR_OK; place++) {
            if (side->loss_tracker.missing_count[place])
                status = store_missing_put(collector->store, collector->session, kind,
                                           mr_message_name(place),
                                           side->loss_tracker.missing_count[place], error);
        }
        if (status == MR_OK)
            status = record_link_faults(collector, side, error);
    }
    return status;
}

enum link_kind collector_get_lagging_link(const struct collector *collector)
{
    const struct link_state *can = &collector->side[LINK_CAN],
                            *serial = &collector->side[LINK_SERIAL];
    bool can_behind = can->boot == serial->boot
                        ? collect_newest_block(can) <= collect_newest_block(serial)
                        : can->boot < serial->boot;
    return can_behind ? LINK_CAN : LINK_SERIAL;
}

int64_t collector_pop_finished_run(struct collector *collector)
{
    if (collector->finished_run_count == 0)
        return 0;
    int64_t run = collector->finished_runs[0];
    collector->finished_run_count--;
    memmove(collector->finished_runs, collector->finished_runs + 1,
            collector->finished_run_count * sizeof collector->finished_runs[0]);
    return run;
}

static void report_other_board_on_can(const struct collector *collector,
                                      struct collector_progress *progress)
{
    const struct link_state *can = &collector->side[LINK_CAN];
    progress->is_other_board_on_can =
        collector->reported.is_uid_from_serial && !can->own_board_seen &&
        can->other_board_message_count >= COLLECT_OTHER_BOARD_MESSAGES_MIN;
    snprintf(progress->can_uid, sizeof progress->can_uid, "%08X%08X", (unsigned)can->other_uid[0],
             (unsigned)can->other_uid[1]);
    snprintf(progress->serial_uid, sizeof progress->serial_uid, "%08X%08X",
             (unsigned)collector->reported.uid[0], (unsigned)collector->reported.uid[1]);
}

void collector_get_progress(const struct collector *collector, struct collector_progress *progress)
{
    const struct board_report *reported = &collector->reported;
    *progress = (struct collector_progress){
        .hello_received = reported->hello_known,
        .newest_block = -1,
        .board_uid = reported->identity.board_uid,
        .firmware = reported->identity.firmware,
        .landing = reported->landing_known ? &reported->landing : NULL,
        .key = reported->key_known ? &reported->key : NULL,
        .nonce = reported->nonce_known ? reported->nonce : NULL,
        .uid = reported->uid,
        .frames_before_log = collector->side[LINK_CAN].loss_tracker.frames_before_log};
    report_other_board_on_can(collector, progress);
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct link_state *side = &collector->side[kind];
        progress->counts[kind] = side->loss_tracker.counts;
        memcpy(progress->missing_count[kind], side->loss_tracker.missing_count,
               sizeof progress->missing_count[kind]);
        if (collect_newest_block(side) > progress->newest_block)
            progress->newest_block = collect_newest_block(side);
        if (side->current_landing && side->current_landing->row.id > progress->run) {
            progress->run = side->current_landing->row.id;
            progress->landing_state = (unsigned)side->current_landing->row.state;
            progress->edge_count = side->current_landing->edge_count;
        }
    }
}

/* ---- transactions: return to the saved state when a transaction is rolled back ----
 *
 * All state of the collector is one object. Its pointers refer to itself or to objects that
 * outlive it, so a copy of its bytes is valid. */

enum mr_status collector_save_state(struct collector *collector, struct error *error)
{
    if (!collector->saved_state)
        collector->saved_state = malloc(sizeof *collector->saved_state);
    if (!collector->saved_state)
        return error_set(error, MR_FULL, "out of memory, logging to %s; close other programs",
                         store_path(collector->store));
    *collector->saved_state = *collector;
    return MR_OK;
}

void collector_restore_state(struct collector *collector)
{
    struct collector *mark = collector->saved_state;
    if (mark)
        *collector = *mark;
}

void collector_discard_clock_offset(struct collector *collector, enum link_kind kind)
{
    collect_discard_time_map(&collector->side[kind]);
}

void collector_set_store(struct collector *collector, struct store *store)
{
    collector->store = store;
}

enum mr_status collector_reopen(const struct collector *before, struct store *store,
                                bool has_all_data, bool continues_frame,
                                struct collector **collector, struct error *error)
{
    enum mr_status status = collector_open(store, before->side[LINK_CAN].link_spec,
                                           before->can_base, before->side[LINK_SERIAL].link_spec,
                                           collector, error);
    if (status == MR_OK)
        (*collector)->own_commands = before->own_commands;
    if (status == MR_OK && !has_all_data)
        (*collector)->reported = before->reported;
    for (int kind = 0; status == MR_OK && continues_frame && kind < LINK_KINDS; kind++)
        (*collector)->side[kind].deframer = before->side[kind].deframer;
    return status;
}
