/* What each message of the catalogue does to the campaign. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/command.h"
#include "common/switches.h"
#include "host/board/slow.h"
#include "host/collect/collect_state.h"

#define MISSING ((double)NAN)

static int64_t link_bit(const struct side *side)
{
    return 1 << side->kind;
}

static enum mr_status put_event(struct collector *collector, const struct side *side, const char *kind,
                                int64_t block, int64_t code, int64_t detail, int64_t value, uint64_t host_us,
                                struct error *error)
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
        .links = link_bit(side),
    };
    return store_event_put(collector->store, &event, error);
}

/* ---- identity and configuration ---- */

static enum mr_status hello(struct collector *collector, const struct side *side,
                            const struct mr_hello *message, struct error *error)
{
    if (message->layout != MR_LAYOUT)
        return error_set(
            error, MR_VERSION,
            "the board speaks layout %u, this matrig layout %u: %s; use firmware and matrig of one version",
            message->layout, MR_LAYOUT, side->spec);
    collector->hello = true;
    collector->identity.clock_source = message->clock_source;
    snprintf(collector->identity.firmware, sizeof collector->identity.firmware, "%u.%u.%u", message->major,
             message->minor, message->patch);
    return MR_OK;
}

static void uid_text(struct collector *collector)
{
    snprintf(collector->identity.board_uid, sizeof collector->identity.board_uid, "%08X%08X%08X",
             (unsigned)collector->uid[0], (unsigned)collector->uid[1], (unsigned)collector->uid[2]);
}

/* The identity became better known while a landing is open: its row too. */
static enum mr_status refresh_landing(struct collector *collector, struct side *side, struct error *error)
{
    struct slot *slot = side->current;
    const struct store_landing *identity = &collector->identity;
    if (!slot)
        return MR_OK;
    if (strcmp(slot->row.board_uid, identity->board_uid) == 0 &&
        strcmp(slot->row.firmware, identity->firmware) == 0 && slot->row.image_crc == identity->image_crc &&
        slot->row.config_crc == identity->config_crc && slot->row.touchdown_ft == identity->touchdown_ft &&
        slot->row.switch_error_ft == identity->switch_error_ft &&
        strcmp(slot->row.image_commit, identity->image_commit) == 0)
        return MR_OK;
    memcpy(slot->row.image_commit, identity->image_commit, sizeof slot->row.image_commit);
    memcpy(slot->row.board_uid, identity->board_uid, sizeof slot->row.board_uid);
    memcpy(slot->row.firmware, identity->firmware, sizeof slot->row.firmware);
    slot->row.image_crc = identity->image_crc;
    slot->row.config_crc = identity->config_crc;
    slot->row.clock_source = identity->clock_source;
    slot->row.touchdown_ft = identity->touchdown_ft;
    slot->row.switch_error_ft = identity->switch_error_ft;
    return store_landing_put(collector->store, &slot->row, error);
}

static enum mr_status put_channel(struct collector *collector, const struct slot *slot, unsigned index,
                                  struct error *error)
{
    if (!slot || !collector->channel_known[index] || !collector->zero_known[index])
        return MR_OK;
    return store_channel_put(collector->store, slot->row.id, index, &collector->channel[index], error);
}

static enum mr_status channel(struct collector *collector, const struct side *side,
                              const struct mr_channel *message, struct error *error)
{
    if (message->index >= MR_CHANNELS)
        return MR_OK;
    struct mr_channel_config *known = &collector->channel[message->index];
    if (collector->channel_known[message->index] && known->kind == message->kind &&
        known->unit_per_code == message->unit_per_code &&
        (known->station_ft == message->station_ft ||
         (isnan(known->station_ft) && isnan(message->station_ft))))
        return MR_OK;
    known->kind = message->kind;
    known->station_ft = message->station_ft;
    known->unit_per_code = message->unit_per_code;
    collector->channel_known[message->index] = true;
    return put_channel(collector, side->current, message->index, error);
}

static enum mr_status channel_zero(struct collector *collector, const struct side *side,
                                   const struct mr_channel_zero *message, struct error *error)
{
    if (message->index >= MR_CHANNELS)
        return MR_OK;
    struct mr_channel_config *known = &collector->channel[message->index];
    if (collector->zero_known[message->index] && known->number == message->number &&
        known->band == message->band && known->zero_code == message->zero_code)
        return MR_OK;
    known->number = message->number;
    known->band = message->band;
    known->zero_code = message->zero_code;
    collector->zero_known[message->index] = true;
    return put_channel(collector, side->current, message->index, error);
}

static enum mr_status put_calibration(struct collector *collector, const struct slot *slot, unsigned index, unsigned item,
                                      struct error *error)
{
    if (!slot || !(collector->items_known[index] >> item & 1u))
        return MR_OK;
    return store_calibration_put(collector->store, slot->row.id, index, item,
                                 (double)mr_channel_item(&collector->channel[index], item), error);
}

static enum mr_status calibration(struct collector *collector, const struct side *side,
                                  const struct mr_calibration *message, struct error *error)
{
    if (message->index >= MR_CHANNELS || message->item >= MR_CALIBRATION_ITEMS)
        return MR_OK;
    struct mr_channel_config *known = &collector->channel[message->index];
    uint32_t bit = 1u << message->item;
    if (collector->items_known[message->index] & bit && mr_channel_item(known, message->item) == message->value)
        return MR_OK;
    mr_channel_item_set(known, message->item, message->value);
    collector->items_known[message->index] |= bit;
    return put_calibration(collector, side->current, message->index, message->item, error);
}

static enum mr_status switch_place(struct collector *collector, const struct side *side,
                                   const struct mr_switch_place *message, struct error *error)
{
    if (message->position == 0 || message->position > STORE_SWITCHES_MAX)
        return MR_OK;
    struct store_switch place = {message->position, message->step_codes, (double)message->station_ft};
    struct store_switch *known = &collector->place[message->position - 1];
    if (collector->switch_known[message->position - 1] && known->step_codes == place.step_codes &&
        known->station_ft == place.station_ft)
        return MR_OK;
    *known = place;
    collector->switch_known[message->position - 1] = true;
    return side->current ? store_switch_put(collector->store, side->current->row.id, &place, error) : MR_OK;
}

static enum mr_status slack(struct collector *collector, const struct side *side,
                            const struct mr_slack *message, struct error *error)
{
    if (message->segment >= MR_SEGMENTS)
        return MR_OK;
    struct store_segment segment = {message->segment, message->joints, (double)message->slack_in,
                                    (double)message->start_ft, (double)message->end_ft};
    struct store_segment *known = &collector->segment[message->segment];
    if (collector->segment_known[message->segment] &&
        (known->slack_in == segment.slack_in || (isnan(known->slack_in) && isnan(segment.slack_in))))
        return MR_OK;
    *known = segment;
    collector->segment_known[message->segment] = true;
    return side->current ? store_segment_put(collector->store, side->current->row.id, &segment, error)
                         : MR_OK;
}

enum mr_status collect_write_configuration(struct collector *collector, const struct slot *slot,
                                           struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < MR_CHANNELS && status == MR_OK; i++)
        status = put_channel(collector, slot, i, error);
    for (unsigned i = 0; i < MR_CHANNELS * MR_CALIBRATION_ITEMS && status == MR_OK; i++)
        status = put_calibration(collector, slot, i / MR_CALIBRATION_ITEMS, i % MR_CALIBRATION_ITEMS, error);
    for (unsigned i = 0; i < STORE_SWITCHES_MAX && status == MR_OK; i++) {
        if (collector->switch_known[i])
            status = store_switch_put(collector->store, slot->row.id, &collector->place[i], error);
    }
    for (unsigned i = 0; i < MR_SEGMENTS && status == MR_OK; i++) {
        if (collector->segment_known[i])
            status = store_segment_put(collector->store, slot->row.id, &collector->segment[i], error);
    }
    return status == MR_OK ? collect_write_parameters(collector, slot, error) : status;
}

/* ---- what happens in a landing ---- */

static enum mr_status edge(struct collector *collector, struct side *side, const struct mr_edge *message,
                           struct error *error)
{
    struct slot *slot = side->current;
    if (!slot)
        return MR_OK;
    if (message->count > slot->edges)
        slot->edges = message->count;
    if (slot->first_edge_us == 0.0 && side->time.tick_known)
        slot->first_edge_us = timebase_tick_us(&side->time, message->tick);
    struct store_edge row = {.count = message->count,
                             .position = message->position,
                             .step_codes = (double)message->step_codes,
                             .tick = message->tick,
                             .board_us = timebase_tick_us(&side->time, message->tick),
                             .links = link_bit(side)};
    return store_edge_put(collector->store, slot->row.id, &row, error);
}

/* What the board found wrong with a switch is an event; an edge that it took back is no gate for the host either. One that only
 * the final fit left out stays: the host's own fit finds it. */
static enum mr_status switch_event(struct collector *collector, struct side *side,
                                   const struct mr_switch_event *message, uint64_t host_us, struct error *error)
{
    int64_t block = timebase_unwrap(&side->time, message->block16);
    enum mr_status status = put_event(collector, side, "switch", block < 0 ? 0 : block, message->reason,
                                      message->position, message->count, host_us, error);
    bool refused = message->count > 0 && message->reason >= MR_SWITCH_OUT_OF_ORDER && isnan(message->late_ms);
    if (status == MR_OK && side->current && refused)
        status = store_edge_refuse(collector->store, side->current->row.id, message->count, error);
    return status;
}

/* The channel is the row's value too: what is unique about an event does not include its detail. */
static enum mr_status channel_event(struct collector *collector, struct side *side, const struct mr_channel_event *message,
                                    uint64_t host_us, struct error *error)
{
    return put_event(collector, side, "channel", message->block, message->validity, message->index, message->index, host_us,
                     error);
}

static enum mr_status pushback(struct collector *collector, struct side *side, const struct mr_pushback *message,
                               uint64_t host_us, struct error *error)
{
    int64_t block = timebase_unwrap(&side->time, message->block16);
    return put_event(collector, side, "pushback", block < 0 ? 0 : block, message->position, message->state,
                     message->count, host_us, error);
}

/* Motion and its errors are two messages with the same block; the first is stored at once, the second
 * completes it. */
static enum mr_status put_motion(struct collector *collector, struct side *side,
                                 const struct mr_motion_error *errors, struct error *error)
{
    const struct mr_motion *motion = &side->motion;
    int64_t block = timebase_unwrap(&side->time, motion->block16);
    if (!side->current || block < 0)
        return MR_OK;
    struct store_motion row = {
        .block = block,
        .position_ft = (double)motion->position_ft,
        .speed_ft_s = (double)motion->speed_ft_s,
        .deceleration_ft_s2 = (double)motion->deceleration_ft_s2,
        .position_error_ft = errors ? (double)errors->position_ft : MISSING,
        .speed_error_ft_s = errors ? (double)errors->speed_ft_s : MISSING,
        .deceleration_error_ft_s2 = errors ? (double)errors->deceleration_ft_s2 : MISSING,
        .links = link_bit(side),
    };
    return store_motion_put(collector->store, side->current->row.id, &row, error);
}

static enum mr_status put_zone(struct collector *collector, struct side *side,
                               const struct mr_zone_lead *lead, struct error *error)
{
    const struct mr_zone *zone = &side->zone;
    int64_t block = timebase_unwrap(&side->time, zone->block16);
    if (!side->current || block < 0)
        return MR_OK;
    struct store_zone row = {
        .block = block,
        .mats = zone->mats,
        .start_ft = (double)zone->start_ft,
        .end_ft = (double)zone->end_ft,
        .lead_s = lead ? (double)lead->lead_s : MISSING,
        .wheel_ft = lead ? (double)lead->wheel_ft : MISSING,
        .warning = lead ? lead->warning : STORE_NONE,
        .inferred_percent = lead ? lead->inferred_percent : STORE_NONE,
        .links = link_bit(side),
    };
    return store_zone_put(collector->store, side->current->row.id, &row, error);
}

static enum mr_status put_result(struct collector *collector, const struct side *side,
                                 struct store_result *row, struct error *error)
{
    row->links = link_bit(side);
    return side->current ? store_result_put(collector->store, side->current->row.id, row, error) : MR_OK;
}

static enum mr_status touchdown(struct collector *collector, const struct side *side,
                                const struct mr_touchdown *message, struct error *error)
{
    struct store_result row = {
        .speed_ft_s = (double)message->speed_ft_s,
        .speed_error_ft_s = (double)message->speed_error_ft_s,
        .deceleration_ft_s2 = (double)message->deceleration_ft_s2,
        .deceleration_error_ft_s2 = (double)message->deceleration_error_ft_s2,
        .stop_station_ft = MISSING,
        .stop_station_error_ft = MISSING,
        .after_touchdown_s = MISSING,
        .switches = STORE_NONE,
        .used = STORE_NONE,
    };
    return put_result(collector, side, &row, error);
}

static enum mr_status stop(struct collector *collector, const struct side *side,
                           const struct mr_stop *message, struct error *error)
{
    struct store_result row = {
        .speed_ft_s = MISSING,
        .speed_error_ft_s = MISSING,
        .deceleration_ft_s2 = MISSING,
        .deceleration_error_ft_s2 = MISSING,
        .stop_station_ft = (double)message->station_ft,
        .stop_station_error_ft = (double)message->station_error_ft,
        .after_touchdown_s = (double)message->after_touchdown_s,
        .switches = message->switches,
        .used = message->used,
    };
    return put_result(collector, side, &row, error);
}

enum mr_status collect_state_event(struct collector *collector, const struct side *side, const struct mr_landing *message,
                                   uint64_t host_us, struct error *error)
{
    return put_event(collector, side, "state", message->block, message->state, message->cause, message->landing, host_us, error);
}

static enum mr_status landing(struct collector *collector, struct side *side,
                              const struct mr_landing *message, uint64_t host_us, struct error *error)
{
    struct slot *before = side->current;
    enum mr_status status = collect_landing(collector, side, message, host_us, error);
    if (status != MR_OK || message->cause == 0)
        return status;
    struct slot *after = side->current;
    side->current = after ? after : before; /* the message that ends a landing belongs to it */
    status = collect_state_event(collector, side, message, host_us, error);
    side->current = after;
    return status;
}

/* Faults are repeated once a second; a row is made when one has counted on. */
static enum mr_status fault(struct collector *collector, const struct side *side,
                            const struct mr_fault *message, uint64_t host_us, struct error *error)
{
    if (message->code < MR_FAULT_COUNT) {
        if (collector->fault_count[message->code] == message->count)
            return MR_OK;
        collector->fault_count[message->code] = message->count;
    }
    return put_event(collector, side, "fault", message->block, message->code, message->detail, message->count,
                     host_us, error);
}

static enum mr_status temperature(struct collector *collector, const struct side *side, const struct mr_temperature *message,
                                  struct error *error)
{
    if (!side->current)
        return MR_OK;
    return store_temperature_put(collector->store, side->current->row.id, message->block, (double)message->temperature_c,
                                 (double)message->error_c, link_bit(side), error);
}

#define FRESH_BLOCKS 60000 /* a row that was just made, not one that somebody reads out */

/* A row that is whole is kept, with its time when it was just made. One that the board cannot number is kept of one link. */
static enum mr_status slow_part(struct collector *collector, struct side *side, uint16_t id, const uint8_t *payload, size_t length,
                                uint64_t host_us, struct error *error)
{
    struct store_slow row;
    int64_t time_us = STORE_NONE;
    const struct mr_slowrow *told = &side->slow.row;
    if (mr_slowrow_take(&side->slow, id, payload, length) != MR_OK || !collector->identity.board_uid[0] ||
        (told->seq == 0 && side->kind == LINK_SERIAL && collector->side[LINK_CAN].spec))
        return MR_OK;
    int64_t age = side->time.known ? side->time.block - (int64_t)told->block : -1;
    if (age > -1000 && age < FRESH_BLOCKS) /* the newest block that is known may be 0.1 s old */
        time_us = (int64_t)host_us - 1000 * age;
    slow_row(told, collector->identity.board_uid, time_us, &row);
    return store_slow_put(collector->store, &row, error);
}

/* What a processor fault left behind: an event for each word, once, whichever link brings it and however often. */
static enum mr_status crash(struct collector *collector, const struct side *side, const struct mr_crash *message,
                            uint64_t host_us, struct error *error)
{
    struct crash_report *report = &collector->crash[side->kind];
    enum mr_status status = MR_OK;
    if (!crash_take(report, message) || memcmp(report->word, collector->crashed.word, sizeof report->word) == 0)
        return MR_OK;
    collector->crashed = *report;
    collector->crash_news = true;
    for (unsigned i = 0; i < MR_CRASH_ITEMS && status == MR_OK; i++)
        status = put_event(collector, side, "crash", 0, i, report->age, report->word[i], host_us, error);
    return status;
}

/* The state of CAN as the board sees it is told each second; an event is made when it, or the count of outages, has changed. */
static enum mr_status can_alarm(struct collector *collector, const struct side *side, const struct mr_can_alarm *message,
                                int64_t block, uint64_t host_us, struct error *error)
{
    struct mr_can_alarm *newest = &collector->alarm;
    bool same = newest->state == message->state && newest->outages == message->outages;
    bool older = side->kind == LINK_CAN && message->outages < newest->outages; /* had waited in the controller */
    if (same || older)
        return MR_OK;
    *newest = *message;
    collector->alarm_news = true;
    return put_event(collector, side, "can-state", block < 0 ? 0 : block, message->state, message->tec, message->outages,
                     host_us, error);
}

/* Declares `m`, the message got from its payload. The length has been checked against the catalogue's. */
#define GET(name)                                      \
    struct mr_##name m;                                \
    if (mr_##name##_get(&m, payload, length) != MR_OK) \
    return MR_OK

enum mr_status collect_message(struct collector *collector, struct side *side, uint16_t id,
                               const uint8_t *payload, size_t length, uint64_t host_us, struct error *error)
{
    struct account *account = &side->account;
    int64_t block = side->time.known ? side->time.block : -1;
    enum mr_status status = MR_OK;
    switch (id) {
    case MR_ID_HELLO: {
        GET(hello);
        status = hello(collector, side, &m, error);
        break;
    }
    case MR_ID_BOARD_UID: {
        GET(board_uid);
        collector->uid[0] = m.uid0;
        collector->uid[1] = m.uid1;
        break;
    }
    case MR_ID_BOARD_IMAGE: {
        GET(board_image);
        collector->uid[2] = m.uid2;
        collector->identity.image_crc = m.image_crc;
        uid_text(collector);
        break;
    }
    case MR_ID_IMAGE_COMMIT: {
        GET(image_commit);
        mr_image_commit_text(m.commit, m.commit_more, m.changed != 0, collector->identity.image_commit);
        break;
    }
    case MR_ID_BOARD_CONFIG: {
        GET(board_config);
        collector->identity.config_crc = m.config_crc;
        break;
    }
    case MR_ID_CONFIG_IMAGE: {
        GET(config_image);
        status = collect_config_word(collector, side, &m, error);
        break;
    }
    case MR_ID_SITE: {
        GET(site);
        collector->identity.touchdown_ft = (double)m.touchdown_ft;
        collector->identity.switch_error_ft = (double)m.switch_error_ft;
        status = refresh_landing(collector, side, error);
        break;
    }
    case MR_ID_CHANNEL: {
        GET(channel);
        status = channel(collector, side, &m, error);
        break;
    }
    case MR_ID_CHANNEL_ZERO: {
        GET(channel_zero);
        status = channel_zero(collector, side, &m, error);
        break;
    }
    case MR_ID_CALIBRATION: {
        GET(calibration);
        status = calibration(collector, side, &m, error);
        break;
    }
    case MR_ID_SWITCH_PLACE: {
        GET(switch_place);
        status = switch_place(collector, side, &m, error);
        break;
    }
    case MR_ID_SLACK: {
        GET(slack);
        status = slack(collector, side, &m, error);
        break;
    }
    case MR_ID_LANDING: {
        GET(landing);
        status = landing(collector, side, &m, host_us, error);
        break;
    }
    case MR_ID_EDGE: {
        GET(edge);
        status = edge(collector, side, &m, error);
        break;
    }
    case MR_ID_SWITCH_EVENT: {
        GET(switch_event);
        status = switch_event(collector, side, &m, host_us, error);
        break;
    }
    case MR_ID_PUSHBACK: {
        GET(pushback);
        status = pushback(collector, side, &m, host_us, error);
        break;
    }
    case MR_ID_CHANNEL_EVENT: {
        GET(channel_event);
        status = channel_event(collector, side, &m, host_us, error);
        break;
    }
    case MR_ID_CHANNEL_QUALITY: {
        GET(channel_quality);
        if (side->current)
            status = store_quality_put(collector->store, side->current->row.id, &m, error);
        break;
    }
    case MR_ID_MOTION: {
        GET(motion);
        side->motion = m;
        status = put_motion(collector, side, NULL, error);
        break;
    }
    case MR_ID_MOTION_ERROR: {
        GET(motion_error);
        if (m.block16 == side->motion.block16)
            status = put_motion(collector, side, &m, error);
        break;
    }
    case MR_ID_ZONE: {
        GET(zone);
        side->zone = m;
        status = put_zone(collector, side, NULL, error);
        break;
    }
    case MR_ID_ZONE_LEAD: {
        GET(zone_lead);
        if (m.block16 == side->zone.block16)
            status = put_zone(collector, side, &m, error);
        break;
    }
    case MR_ID_TOUCHDOWN: {
        GET(touchdown);
        status = touchdown(collector, side, &m, error);
        break;
    }
    case MR_ID_STOP: {
        GET(stop);
        status = stop(collector, side, &m, error);
        break;
    }
    case MR_ID_MARK: {
        GET(mark);
        status = put_event(collector, side, "mark", m.block, m.number, 0, m.landing, host_us, error);
        break;
    }
    case MR_ID_SYNC: {
        GET(sync);
        collect_sync(side, &m, host_us);
        break;
    }
    case MR_ID_SYNC_AT: {
        GET(sync_at);
        collect_sync_at(side, &m);
        break;
    }
    case MR_ID_CLOCK: {
        GET(clock);
        collect_clock(side, &m, host_us);
        break;
    }
    case MR_ID_FILM_FRAME: {
        GET(film_frame);
        status = collect_film_frame(collector, side, &m, error);
        break;
    }
    case MR_ID_CAMERA: {
        GET(camera);
        int64_t camera_block = timebase_unwrap(&side->time, m.block16);
        status = put_event(collector, side, "camera", camera_block < 0 ? 0 : camera_block, m.cause, 0, m.tick, host_us, error);
        break;
    }
    case MR_ID_ACK: {
        GET(ack);
        if (m.code == MR_COMMAND_ARM || m.code == MR_COMMAND_DISARM) {
            collector->answer = m;
            collector->answer_news = true;
        }
        status = put_event(collector, side, "ack", m.block, m.code, m.status, m.tag, host_us, error);
        break;
    }
    case MR_ID_FAULT: {
        GET(fault);
        status = fault(collector, side, &m, host_us, error);
        break;
    }
    case MR_ID_TEMPERATURE: {
        GET(temperature);
        status = temperature(collector, side, &m, error);
        break;
    }
    case MR_ID_SLOW_ROW:
    case MR_ID_SLOW_STATE:
    case MR_ID_SLOW_DISPLACEMENT:
    case MR_ID_SLOW_TENSION:
        status = slow_part(collector, side, id, payload, length, host_us, error);
        break;
    case MR_ID_CRASH: {
        GET(crash);
        status = crash(collector, side, &m, host_us, error);
        break;
    }
    case MR_ID_CAN_ALARM: {
        GET(can_alarm);
        status = can_alarm(collector, side, &m, block, host_us, error);
        break;
    }
    case MR_ID_CAN_HEALTH: {
        GET(can_health);
        if (side->kind == LINK_CAN)
            account_can_health(account, &m, block);
        break;
    }
    case MR_ID_MESSAGE_COUNT: {
        GET(message_count);
        account_message_count(account, &m);
        break;
    }
    case MR_ID_SERIAL_HEALTH: {
        GET(serial_health);
        if (side->kind == LINK_SERIAL)
            account_dropped(account, m.dropped, block);
        break;
    }
    case MR_ID_DISPLACEMENT_1_3:
    case MR_ID_DISPLACEMENT_4_6:
    case MR_ID_DISPLACEMENT_7_8:
    case MR_ID_TENSION_1_3:
    case MR_ID_TENSION_4_6:
    case MR_ID_TENSION_7_9:
    case MR_ID_TENSION_10_12:
    case MR_ID_TENSION_13_14:
        /* All of these end with block16, and the newest block has just been brought up to it. */
        if (side->current)
            account_step(
                account, id,
                timebase_unwrap(&side->time, (uint16_t)(payload[length - 2] | payload[length - 1] << 8)));
        break;
    default: status = collect_predict_message(collector, side, id, payload, length, host_us, error); break;
    }
    return status;
}
