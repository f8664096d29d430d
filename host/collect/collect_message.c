/* Stores the effect of each message on the campaign. Landing state, time and losses are handled
 * first, other topics further below. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/command.h"
#include "host/collect/collect.h"
#include "host/collect/collect_state.h"
#include "host/store/store.h"

/* Functions collect_zone_row(), collect_zone_lead_row(), ..., one for each STORED_ROW of the
 * catalogue. Each sets the fields of the row that the message contains; other fields are not
 * changed. */
#define STORED_ROW(name, NAME, row, ...)                                               \
    static void collect_##name##_row(struct store_##row *r, const struct mr_##name *m) \
    {                                                                                  \
        __VA_ARGS__;                                                                   \
    }
#include "common/catalogue.def"

enum mr_status collect_put_state_event(struct collector *collector, const struct link_state *side,
                                       const struct mr_landing *message, uint64_t host_us,
                                       struct error *error)
{
    return collect_put_event(collector, side, "state", message->block, message->state,
                             message->cause, message->landing, host_us, error);
}

static enum mr_status record_landing(struct collector *collector, struct link_state *side,
                                     const struct mr_landing *message, uint64_t host_us,
                                     struct error *error)
{
    struct landing_slot *before = side->current_landing;
    bool believed;
    enum mr_status status = collect_handle_landing(collector, side, message, host_us, &believed,
                                                   error);
    if (status != MR_OK || !believed || message->cause == MR_LANDING_NO_CHANGE)
        return status;
    struct landing_slot *after = side->current_landing;
    side->current_landing = after ? after
                                  /* the message that ends a landing still belongs to that
                                   * landing */
                                  : before;
    status = collect_put_state_event(collector, side, message, host_us, error);
    side->current_landing = after;
    return status;
}

/* Adds a message to the accounting of losses. The newest known block is at least that of this
 * reading. */
static enum mr_status count_message(struct collector *collector, struct link_state *side,
                                    const struct collector_event *event, struct error *error)
{
    (void)collector, (void)error;
    const struct mr_message *m = event->message;
    unsigned pack = mr_series_pack_find(m->info->id);
    if (pack < MR_SERIES_PACK_COUNT) {
        if (side->current_landing)
            loss_tracker_add_series_message(&side->loss_tracker, pack,
                                            timebase_unwrap(&side->timebase, (uint16_t)m->block16));
    } else if (m->index == MR_INDEX_MESSAGE_COUNT) {
        loss_tracker_apply_message_count(&side->loss_tracker, &m->as.message_count);
    } else if (m->index == MR_INDEX_CAN_HEALTH && side->kind == LINK_CAN) {
        loss_tracker_apply_can_health(&side->loss_tracker, &m->as.can_health,
                                      collect_newest_block(side));
    } else if (m->index == MR_INDEX_SERIAL_HEALTH && side->kind == LINK_SERIAL) {
        loss_tracker_apply_dropped_count(&side->loss_tracker, m->as.serial_health.dropped,
                                         collect_newest_block(side));
    }
    return MR_OK;
}

/* Creates the event that the STORED_EVENT rows of the catalogue define for a message. */
static bool make_event(const struct mr_message *message, struct store_event *event)
{
    switch (message->index) {
/* clang-format off */
#define STORED_EVENT(name, NAME, kind_, code_, detail_, value_)                        \
    case MR_INDEX_##NAME: {                                                            \
        const struct mr_##name *m = &message->as.name;                                 \
        *event = (struct store_event){.kind = kind_, .code = code_, .detail = detail_, \
            .value = value_};                                                          \
        break;                                                                         \
    }
/* clang-format on */
#include "common/catalogue.def"
    default: return false;
    }
    return true;
}

static enum mr_status put_event(struct collector *collector, struct link_state *side,
                                const struct collector_event *event_message, struct error *error)
{
    struct store_event event;
    if (!make_event(event_message->message, &event))
        return MR_OK;
    int64_t block = collect_event_block(side, event_message->message);
    return collect_put_event(collector, side, event.kind, block < 0 ? 0 : block, event.code,
                             event.detail, event.value, event_message->host_us, error);
}

#define ANSWER_REPEAT_MAX_BLOCKS 1000u

static bool is_own_answer(struct collector_own_commands *own, const struct mr_ack *ack)
{
    for (unsigned i = 0; own && i < COLLECTOR_OWN_COMMANDS_MAX && i < own->next_index; i++) {
        bool answered = own->command[i].block >= 0 && own->command[i].block != (int64_t)ack->block;
        if (own->command[i].code == ack->code && own->command[i].tag == ack->tag && !answered) {
            own->command[i].block = ack->block;
            return true;
        }
    }
    return false;
}

/* Records the board's answer to a command, and which program sent it. */
static enum mr_status record_answer(struct collector *collector, struct link_state *side,
                                    const struct mr_ack *ack, uint64_t host_us, struct error *error)
{
    struct landing_slot *current = side->current_landing;
    struct repeated_answer *last = &collector->repeated_answers[ack->code % REPEATED_ANSWERS_MAX];
    if (mr_command_privilege(ack->code) == MR_PRIVILEGE_READ)
        return MR_OK;
    bool own = is_own_answer(collector->own_commands, ack);
    if (last->has_answer && !own && !last->is_own && last->code == ack->code &&
        last->status == ack->status && ack->block - last->block < ANSWER_REPEAT_MAX_BLOCKS) {
        last->repeat_count++;
        return MR_OK;
    }
    if (collector->own_commands)
        collector->answer[collector->answer_add_count++ % COLLECT_ANSWERS_MAX] =
            (struct collector_answer){
                .ack = *ack, .is_own = own, .repeat_count = last->repeat_count};
    *last = (struct repeated_answer){.has_answer = true,
                                     .is_own = own,
                                     .status = ack->status,
                                     .code = ack->code,
                                     .block = ack->block};
    /* the answer to a disarm command arrives after the end of the landing that it ended */
    if (ack->code == MR_COMMAND_DISARM && !current && ack->block == side->state_block)
        side->current_landing = side->last_landing;
    enum mr_status status =
        collect_put_event(collector, side, "order", ack->block, ack->code, ack->status,
                          collector->own_commands ? own : STORE_NONE, host_us, error);
    side->current_landing = current;
    return status;
}

/* Handles landing state, film frames, answers to commands, and board time. */
static enum mr_status handle_state_message(struct collector *collector, struct link_state *side,
                                           const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    uint64_t host_us = event->host_us;
    switch (m->index) {
    case MR_INDEX_LANDING: return record_landing(collector, side, &m->as.landing, host_us, error);
    case MR_INDEX_FILM_FRAME:
        return collect_handle_film_frame(collector, side, &m->as.film_frame, error);
    case MR_INDEX_ACK: return record_answer(collector, side, &m->as.ack, host_us, error);
    case MR_INDEX_SYNC: collect_handle_sync(side, &m->as.sync, host_us); return MR_OK;
    case MR_INDEX_SYNC_AT: collect_handle_sync_at(side, &m->as.sync_at); return MR_OK;
    case MR_INDEX_CLOCK: collect_handle_clock(side, &m->as.clock, host_us); return MR_OK;
    default: return MR_OK;
    }
}

static collect_message_handler collect_gear_message, collect_predict_message, collect_band_message,
    collect_health_message;

/* One function per topic. Each processes the messages of its topic, in addition to the events that
 * they cause. A message without a topic is stored only as a frame. */
static collect_message_handler *const message_handlers[] = {
    count_message,        handle_state_message,    collect_identity_message, collect_health_message,
    collect_gear_message, collect_predict_message, collect_band_message};
enum {
    MESSAGE_HANDLER_COUNT = sizeof message_handlers / sizeof message_handlers[0],
    FIRST_LANDING_HANDLER = 4
};

static enum mr_status run_message_handlers(unsigned first, struct collector *collector,
                                           struct link_state *side,
                                           const struct collector_event *event, struct error *error)
{
    enum mr_status status = put_event(collector, side, event, error);
    for (unsigned i = first; i < MESSAGE_HANDLER_COUNT && status == MR_OK; i++)
        status = message_handlers[i](collector, side, event, error);
    return status;
}

enum mr_status collect_message(struct collector *collector, struct link_state *side,
                               const struct collector_event *event, struct error *error)
{
    return run_message_handlers(0, collector, side, event, error);
}

enum mr_status collect_reprocess_message(struct collector *collector, struct link_state *side,
                                         const struct collector_event *event, struct error *error)
{
    return run_message_handlers(FIRST_LANDING_HANDLER, collector, side, event, error);
}

/* ---- gear: switches, motion, touchdown and stop, zones ahead of the wheel, mat temperature
 * ---- */

static enum mr_status record_edge(struct collector *collector, struct link_state *side,
                                  const struct mr_edge *message, struct error *error)
{
    struct landing_slot *slot = side->current_landing;
    if (!slot)
        return MR_OK;
    if (message->count > slot->edge_count)
        slot->edge_count = message->count;
    if (slot->first_edge_us == 0.0 && side->timebase.is_tick_known)
        slot->first_edge_us = timebase_tick_to_us(&side->timebase, message->tick);
    struct store_edge row = {.board_us = timebase_tick_to_us(&side->timebase, message->tick),
                             .links = collect_link_bit(side)};
    collect_edge_row(&row, message);
    return store_edge_put(collector->store, slot->row.id, &row, error);
}

/* Rejects a switch edge that the board withdrew. An edge that only the board's final fit excluded
 * is kept, because the host's own fit decides about it. */
static enum mr_status record_switch_event(struct collector *collector,
                                          const struct link_state *side,
                                          const struct mr_switch_event *message,
                                          struct error *error)
{
    bool refused = message->count > 0 && message->reason >= MR_SWITCH_OUT_OF_ORDER &&
                   isnan(message->late_ms);
    return side->current_landing && refused
             ? store_edge_reject(collector->store, side->current_landing->row.id, message->count,
                                 error)
             : MR_OK;
}

/* Motion and its errors are two messages with the same block: the first creates the row, the second
 * completes it. The same holds for a zone and its lead time. */
#define DEFINE_TWO_PART_RECORDER(name, NAME, second)                                               \
    static enum mr_status name(struct collector *collector, struct link_state *side,               \
                               const struct mr_message *m, struct error *error)                    \
    {                                                                                              \
        struct store_##name *row = &side->partial_##name;                                          \
        if (m->index == MR_INDEX_##NAME) {                                                         \
            *row = store_blank_##name;                                                             \
            side->partial_##name##_block16 = m->block16;                                           \
            collect_##name##_row(row, &m->as.name);                                                \
        } else if (m->block16 == side->partial_##name##_block16) {                                 \
            collect_##second##_row(row, &m->as.second);                                            \
        } else {                                                                                   \
            return MR_OK;                                                                          \
        }                                                                                          \
        row->block = collect_event_block(side, m);                                                 \
        row->links = collect_link_bit(side);                                                       \
        return side->current_landing && row->block >= 0                                            \
                 ? store_##name##_put(collector->store, side->current_landing->row.id, row, error) \
                 : MR_OK;                                                                          \
    }
DEFINE_TWO_PART_RECORDER(motion, MOTION, motion_error)
DEFINE_TWO_PART_RECORDER(zone, ZONE, zone_lead)

/* Touchdown and stop share a row; either message may arrive first. */
static enum mr_status record_result(struct collector *collector, const struct link_state *side,
                                    const struct mr_message *m, struct error *error)
{
    struct store_result row = store_blank_result;
    row.links = collect_link_bit(side);
    if (m->index == MR_INDEX_TOUCHDOWN)
        collect_touchdown_row(&row, &m->as.touchdown);
    else
        collect_stop_row(&row, &m->as.stop);
    return side->current_landing ? COLLECT_PUT(result, &row) : MR_OK;
}

static enum mr_status record_temperature(struct collector *collector, struct link_state *side,
                                         const struct mr_message *message, struct error *error)
{
    struct store_mat_temperature row = {.block = collect_event_block(side, message),
                                        .links = collect_link_bit(side)};
    collect_temperature_row(&row, &message->as.temperature);
    return side->current_landing && row.block >= 0 ? COLLECT_PUT(mat_temperature, &row) : MR_OK;
}

static enum mr_status collect_gear_message(struct collector *collector, struct link_state *side,
                                           const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->index) {
    case MR_INDEX_EDGE: return record_edge(collector, side, &m->as.edge, error);
    case MR_INDEX_SWITCH_EVENT:
        return record_switch_event(collector, side, &m->as.switch_event, error);
    case MR_INDEX_MOTION:
    case MR_INDEX_MOTION_ERROR: return motion(collector, side, m, error);
    case MR_INDEX_ZONE:
    case MR_INDEX_ZONE_LEAD: return zone(collector, side, m, error);
    case MR_INDEX_TOUCHDOWN:
    case MR_INDEX_STOP: return record_result(collector, side, m, error);
    case MR_INDEX_TEMPERATURE: return record_temperature(collector, side, m, error);
    default: return MR_OK;
    }
}

/* ---- predict: output of the predictor, and the runway and parameters of an armed landing ---- */

static bool has_same_bits(float a, float b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

static enum mr_status record_trust(struct collector *collector, struct link_state *side,
                                   const struct mr_message *m, struct error *error)
{
    struct store_trust row = {.block = collect_event_block(side, m),
                              .links = collect_link_bit(side)};
    collect_trust_row(&row, &m->as.trust);
    return side->current_landing && row.block >= 0 ? COLLECT_PUT(trust, &row) : MR_OK;
}

/* Stores a runway when it is complete: all joints in sequence, and the CRC that the board sent. */
static enum mr_status record_joints(struct collector *collector, struct link_state *side,
                                    const struct mr_runway_joints *m, struct error *error)
{
    struct mr_predictor_state *state = &side->runway;
    if (m->index != 1u + MR_RUNWAY_JOINTS_PER_MESSAGE * side->runway_part_count ||
        side->runway_part_count >= mr_runway_message_count(state))
        return MR_OK;
    mr_runway_apply_message(state, m);
    side->runway_part_count++;
    if (!side->current_landing || side->runway_part_count < mr_runway_message_count(state) ||
        mr_runway_crc(state) != side->runway_store.crc)
        return MR_OK;
    return store_runway_put(collector->store, side->current_landing->row.id, state,
                            side->runway_store.source, error);
}

static void record_runway(struct link_state *side, const struct mr_runway *m)
{
    side->runway = (struct mr_predictor_state){.mats = m->mats <= MR_CHAIN_MATS ? m->mats : 0,
                                               .landing_count = m->landings,
                                               .resistance_scale = m->resistance};
    side->runway_part_count = 0;
}

static void record_runway_state(struct collector *collector, struct link_state *side,
                                const struct mr_runway_store *m)
{
    const struct mr_runway_store *known = &collector->stored_runway;
    side->runway_store = *m;
    collector->stored_runway_changed |= !collector->stored_runway_known ||
                                        known->state != m->state || known->source != m->source ||
                                        known->copy_a != m->copy_a || known->copy_b != m->copy_b;
    collector->stored_runway = *m;
    collector->stored_runway_known = true;
}

static enum mr_status record_item(struct collector *collector, const struct link_state *side,
                                  const struct mr_predict_item *m, struct error *error)
{
    if (m->index >= MR_PREDICT_ITEM_COUNT ||
        (collector->reported.predict_known[m->index] &&
         has_same_bits(collector->reported.predict_item[m->index], m->value)))
        return MR_OK;
    collector->reported.predict_known[m->index] = true;
    collector->reported.predict_item[m->index] = m->value;
    return side->current_landing
             ? COLLECT_PUT(predict_item, (&(struct store_predict_item){m->index, (double)m->value}))
             : MR_OK;
}

enum mr_status collect_write_parameters(struct collector *collector,
                                        const struct landing_slot *slot, struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < MR_PREDICT_ITEM_COUNT && status == MR_OK; i++) {
        if (collector->reported.predict_known[i])
            status = store_predict_item_put(
                collector->store, slot->row.id,
                &(struct store_predict_item){i, (double)collector->reported.predict_item[i]},
                error);
    }
    for (unsigned i = 0; i < MR_RISK_REPORT_ITEM_COUNT && status == MR_OK; i++) {
        if (collector->reported.risk_known[i])
            status = store_risk_item_put(
                collector->store, slot->row.id,
                &(struct store_risk_item){i, (double)collector->reported.risk_item[i]}, error);
    }
    return status;
}

/* Stores one parameter of the risk. Index 0 starts a new list, so items of the previous list count
 * as missing. */
static enum mr_status record_risk_parameter(struct collector *collector,
                                            const struct link_state *side,
                                            const struct mr_risk_item *m, struct error *error)
{
    if (m->index >= MR_RISK_REPORT_ITEM_COUNT)
        return MR_OK;
    if (m->index == 0)
        memset(collector->reported.risk_known, 0, sizeof collector->reported.risk_known);
    collector->reported.risk_known[m->index] = true;
    collector->reported.risk_item[m->index] = m->value;
    return side->current_landing
             ? COLLECT_PUT(risk_item, (&(struct store_risk_item){m->index, (double)m->value}))
             : MR_OK;
}

static enum mr_status record_risk(struct collector *collector, struct link_state *side,
                                  const struct mr_message *m, struct error *error)
{
    struct store_risk part = store_blank_risk;
    part.links = collect_link_bit(side);
    if (m->index == MR_INDEX_RISK)
        collect_risk_row(&part, &m->as.risk);
    else
        collect_risk_lead_row(&part, &m->as.risk_lead);
    part.block = collect_event_block(side, m);
    return side->current_landing && part.block >= 0 ? COLLECT_PUT(risk, &part) : MR_OK;
}

/* Stores a part of a prediction. It has the block of the prediction, which is the newest one or
 * slightly older. */
static enum mr_status record_prediction_part(struct collector *collector, struct link_state *side,
                                             const struct mr_message *m, struct error *error)
{
    struct store_prediction part = store_blank_prediction;
    part.links = collect_link_bit(side);
    switch (m->index) {
    case MR_INDEX_ZONE_ERROR: collect_zone_error_row(&part, &m->as.zone_error); break;
    case MR_INDEX_ZONE_COMING: collect_zone_coming_row(&part, &m->as.zone_coming); break;
    case MR_INDEX_ZONE_PRESS: collect_zone_press_row(&part, &m->as.zone_press); break;
    case MR_INDEX_VERDICT: collect_verdict_row(&part, &m->as.verdict); break;
    default: return MR_OK;
    }
    part.block = collect_event_block(side, m);
    return side->current_landing && part.block >= 0 ? COLLECT_PUT(prediction, &part) : MR_OK;
}

static enum mr_status collect_predict_message(struct collector *collector, struct link_state *side,
                                              const struct collector_event *event,
                                              struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->index) {
    case MR_INDEX_TRUST: return record_trust(collector, side, m, error);
    case MR_INDEX_RUNWAY: record_runway(side, &m->as.runway); return MR_OK;
    case MR_INDEX_RUNWAY_JOINTS: return record_joints(collector, side, &m->as.runway_joints, error);
    case MR_INDEX_RUNWAY_STORE:
        record_runway_state(collector, side, &m->as.runway_store);
        return MR_OK;
    case MR_INDEX_RISK:
    case MR_INDEX_RISK_LEAD: return record_risk(collector, side, m, error);
    case MR_INDEX_RISK_ITEM: return record_risk_parameter(collector, side, &m->as.risk_item, error);
    case MR_INDEX_PREDICT_ITEM: return record_item(collector, side, &m->as.predict_item, error);
    default: return record_prediction_part(collector, side, m, error);
    }
}

/* ---- bands: events, tensions, and shunt calibration of the gages ---- */

/* Returns the full index of a recent block from its low 16 bits; does not change the newest
 * block. */
static int64_t unwrap_block(const struct link_state *side, uint16_t at_block16)
{
    struct timebase copy = side->timebase;
    int64_t block = timebase_unwrap(&copy, at_block16);
    return block < 0 ? STORE_NONE : block;
}

static enum mr_status record_band_message(struct collector *collector,
                                          const struct link_state *side,
                                          const struct mr_band_event *m, struct error *error)
{
    int64_t block = unwrap_block(side, m->at_block16);
    struct store_band_event row = {.block = block == STORE_NONE ? 0 : block,
                                   .links = collect_link_bit(side)};
    collect_band_event_row(&row, m);
    return side->current_landing ? COLLECT_PUT(band_event, &row) : MR_OK;
}

/* Stores the result or the check of a gage. The first of these two messages creates the row, the
 * second completes it. */
static enum mr_status record_shunt(struct collector *collector, struct link_state *side,
                                   const struct mr_message *m, struct error *error)
{
    struct store_shunt *row = &side->shunt_result;
    if (m->index == MR_INDEX_SHUNT) {
        side->shunt = store_blank_shunt;
        side->shunt.links = collect_link_bit(side);
        collect_shunt_row(&side->shunt, &m->as.shunt);
        return MR_OK;
    }
    if (m->index == MR_INDEX_SHUNT_RESULT) {
        *row = side->shunt;
        collect_shunt_result_row(row, &m->as.shunt_result);
    } else if (m->as.shunt_check.gage == row->gage) {
        collect_shunt_check_row(row, &m->as.shunt_check);
    } else {
        return MR_OK;
    }
    if (side->shunt.number == 0) /* logging began during the calibration */
        return MR_OK;
    return store_shunt_put(collector->store, collector->session, side->boot, row, error);
}

/* Stores a band message. Tension before and after, and smallest and largest tension, share a row.
 * Values of a band without a gage are ignored. */
static enum mr_status record_band(struct collector *collector, const struct link_state *side,
                                  const struct mr_message *m, struct error *error)
{
    struct store_band row = store_blank_band;
    const struct mr_band_least *least = &m->as.band_least;
    const struct mr_band_most *most = &m->as.band_most;
    row.links = collect_link_bit(side);
    if (m->index == MR_INDEX_BAND_BEFORE)
        collect_band_before_row(&row, &m->as.band_before);
    else if (m->index == MR_INDEX_BAND_AFTER)
        collect_band_after_row(&row, &m->as.band_after);
    else
        row.band = m->index == MR_INDEX_BAND_LEAST ? least->band : most->band;
    if (m->index == MR_INDEX_BAND_LEAST && least->gage) {
        collect_band_least_row(&row, least);
        row.least_block = unwrap_block(side, least->at_block16);
    }
    if (m->index == MR_INDEX_BAND_MOST && most->gage) {
        collect_band_most_row(&row, most);
        row.most_block = unwrap_block(side, most->at_block16);
    }
    return side->current_landing ? COLLECT_PUT(band, &row) : MR_OK;
}

static enum mr_status collect_band_message(struct collector *collector, struct link_state *side,
                                           const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->index) {
    case MR_INDEX_BAND_EVENT: return record_band_message(collector, side, &m->as.band_event, error);
    case MR_INDEX_BAND_BEFORE:
    case MR_INDEX_BAND_LEAST:
    case MR_INDEX_BAND_MOST:
    case MR_INDEX_BAND_AFTER: return record_band(collector, side, m, error);
    case MR_INDEX_SHUNT:
    case MR_INDEX_SHUNT_RESULT:
    case MR_INDEX_SHUNT_CHECK: return record_shunt(collector, side, m, error);
    default: return MR_OK;
    }
}

/* ---- health: faults, slow log, crash, and CAN as seen by the board ---- */

/* Stores a fault when its count changes; the board repeats faults once a second. */
static enum mr_status record_fault(struct collector *collector, const struct link_state *side,
                                   const struct mr_fault *message, uint64_t host_us,
                                   struct error *error)
{
    if (message->code < MR_FAULT_COUNT) {
        if (collector->fault_count[message->code] == message->count)
            return MR_OK;
        collector->fault_count[message->code] = message->count;
    }
    return collect_put_event(collector, side, "fault", message->block, message->code,
                             message->detail, message->count, host_us, error);
}

static enum mr_status record_quality(struct collector *collector, const struct link_state *side,
                                     const struct mr_channel_quality *message, struct error *error)
{
    struct store_quality row;
    collect_channel_quality_row(&row, message);
    return side->current_landing ? COLLECT_PUT(quality, &row) : MR_OK;
}

/* A row of the slow log consists of six messages; if one of them is lost, the row is discarded. */
static void record_slow_row(struct link_state *side, const struct mr_slow_row *message,
                            uint64_t host_us)
{
    side->slow_row = (struct store_slow){.time_us = (int64_t)host_us,
                                         .block = message->block,
                                         .temperature_c = (double)message->temperature_c};
    side->slow_row_number = message->row;
    side->slow_gage_count = 0;
}

/* Stores a row of the slow log when it is complete. */
static enum mr_status record_slow_tension(struct collector *collector, struct link_state *side,
                                          const struct mr_slow_tension *message,
                                          struct error *error)
{
    const float lb[] = {message->a_lb, message->b_lb, message->c_lb};
    if (!side->slow_row.block || message->row != side->slow_row_number ||
        message->first != side->slow_gage_count + 1u)
        return MR_OK;
    for (unsigned k = 0; k < 3u && side->slow_gage_count < MR_GAGES; k++)
        side->slow_row.tension_lb[side->slow_gage_count++] = (double)lb[k];
    if (side->slow_gage_count < MR_GAGES || !collector->reported.identity.board_uid[0])
        return MR_OK;
    snprintf(side->slow_row.board_uid, sizeof side->slow_row.board_uid, "%s",
             collector->reported.identity.board_uid);
    return store_slow_put(collector->store, &side->slow_row, error);
}

/* Stores one event per word of the report of a processor fault. Both links repeat the report; it is
 * stored once. */
static enum mr_status record_crash(struct collector *collector, const struct link_state *side,
                                   const struct mr_crash *message, uint64_t host_us,
                                   struct error *error)
{
    struct crash_report *report = &collector->crash[side->kind];
    enum mr_status status = MR_OK;
    if (!crash_receive(report, message) ||
        memcmp(report->word, collector->stored_crash.word, sizeof report->word) == 0)
        return MR_OK;
    collector->stored_crash = *report;
    collector->crash_unread = true;
    for (unsigned i = 0; i < MR_CRASH_ITEM_COUNT && status == MR_OK; i++)
        status = collect_put_event(collector, side, "crash", 0, i, report->restart_count,
                                   report->word[i], host_us, error);
    return status;
}

/* Stores the board's CAN state when state or outage count changes; the board sends it every
 * second. */
static enum mr_status record_can_alarm(struct collector *collector, const struct link_state *side,
                                       const struct mr_can_alarm *message, uint64_t host_us,
                                       struct error *error)
{
    int64_t block = collect_newest_block(side);
    struct mr_can_alarm *newest = &collector->alarm;
    bool same = newest->state == message->state && newest->outages == message->outages;
    /* a message with an older state, delayed in the CAN controller */
    bool older = side->kind == LINK_CAN && message->outages < newest->outages;
    if (same || older)
        return MR_OK;
    *newest = *message;
    collector->alarm_unread = true;
    return collect_put_event(collector, side, "can-state", block < 0 ? 0 : block, message->state,
                             message->tec, message->outages, host_us, error);
}

static enum mr_status collect_health_message(struct collector *collector, struct link_state *side,
                                             const struct collector_event *event,
                                             struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->index) {
    case MR_INDEX_CHANNEL_QUALITY:
        return record_quality(collector, side, &m->as.channel_quality, error);
    case MR_INDEX_FAULT: return record_fault(collector, side, &m->as.fault, event->host_us, error);
    case MR_INDEX_CRASH: return record_crash(collector, side, &m->as.crash, event->host_us, error);
    case MR_INDEX_CAN_ALARM:
        return record_can_alarm(collector, side, &m->as.can_alarm, event->host_us, error);
    case MR_INDEX_SLOW_ROW: record_slow_row(side, &m->as.slow_row, event->host_us); return MR_OK;
    case MR_INDEX_SLOW_TENSION:
        return record_slow_tension(collector, side, &m->as.slow_tension, error);
    default: return MR_OK;
    }
}
