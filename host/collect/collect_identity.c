/* Stores the identity and the configuration that the board reports. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/collect/collect.h"
#include "host/collect/collect_state.h"
#include "host/board/config_text.h"

/* Rejects a message of a board other than the known one. On serial this ends the log. On CAN the
 * message may come from another node. The log ends only if several such messages arrive in a row
 * after serial, which could identify the board, has ended. */
static enum mr_status reject_other_board(struct collector *collector, struct link_state *side,
                                         enum mr_status why, const char *now, struct error *error)
{
    if (side->kind == LINK_CAN) {
        side->other_board_message_count++;
        if (!collector->side[LINK_SERIAL].has_ended ||
            side->other_board_message_count < COLLECT_OTHER_BOARD_MESSAGES_MIN)
            return MR_OK;
    }
    return error_set(error, why,
                     "the link now has a different board than at the start of this log (%s): %s; "
                     "end this log and start a new one",
                     now, side->link_spec);
}

static enum mr_status handle_hello(struct collector *collector, struct link_state *side,
                                   const struct mr_hello *message, struct error *error)
{
    bool serial_will_say = side->kind == LINK_CAN && !collector->side[LINK_SERIAL].has_ended &&
                           side->other_board_message_count + 1 < COLLECT_OTHER_BOARD_MESSAGES_MIN;
    if (message->layout != MR_LAYOUT && (collector->reported.hello_known || serial_will_say)) {
        char now[60];
        snprintf(now, sizeof now, "layout %u, not %u", message->layout, MR_LAYOUT);
        return reject_other_board(collector, side, MR_VERSION, now, error);
    }
    if (message->layout != MR_LAYOUT)
        return error_set(error, MR_VERSION,
                         "the board uses layout %u, but this matrig uses layout %u: %s; use "
                         "firmware and matrig of the same version",
                         message->layout, MR_LAYOUT, side->link_spec);
    collector->reported.hello_known = true;
    collector->reported.identity.clock_source = message->clock_source;
    snprintf(collector->reported.identity.firmware, sizeof collector->reported.identity.firmware,
             "%u.%u.%u", message->major, message->minor, message->patch);
    return MR_OK;
}

/* Handles words `part` of the chip's unique id. Returns false if they belong to another board; sets
 * `error` if the log cannot continue. */
static bool handle_uid(struct collector *collector, struct link_state *side, unsigned part,
                       const uint32_t *words, size_t count, struct error *error)
{
    uint32_t *known = &collector->reported.uid[part == 1 ? 0 : 2];
    bool vouched = side->kind == LINK_SERIAL;
    bool same = memcmp(known, words, count * sizeof *words) == 0;
    if (!(collector->reported.uid_parts & part) || same ||
        (vouched && !collector->reported.is_uid_from_serial)) {
        if (vouched && !same) /* the CAN data received so far came from another board */
            collector->side[LINK_CAN].own_board_seen = false;
        memcpy(known, words, count * sizeof *words);
        collector->reported.uid_parts |= part;
        side->other_board_message_count = part == 1 ? 0 : side->other_board_message_count;
        side->own_board_seen |= part == 1;
        return true;
    }
    char now[60];
    if (part == 1)
        memcpy(side->other_uid, words, sizeof side->other_uid);
    snprintf(now, sizeof now, "the UID of the board contains %08X instead of %08X",
             (unsigned)words[0], (unsigned)known[0]);
    reject_other_board(collector, side, MR_IO, now, error);
    return false;
}

/* Updates the row of an open landing with the identity received since its beginning. */
static enum mr_status update_landing_identity(struct collector *collector, struct link_state *side,
                                              struct error *error)
{
    struct landing_slot *slot = side->current_landing;
    if (!slot)
        return MR_OK;
    struct store_landing row = collector->reported.identity, *was = &slot->row;
    row.id = was->id;
    row.session = was->session;
    row.boot = was->boot;
    row.board_landing = was->board_landing;
    row.armed_block = was->armed_block;
    row.armed_us = was->armed_us;
    row.state = was->state;
    if (memcmp(&row, was, sizeof row) == 0)
        return MR_OK;
    *was = row;
    return store_landing_put(collector->store, was, error);
}

static enum mr_status put_channel(struct collector *collector, const struct landing_slot *slot,
                                  unsigned index, struct error *error)
{
    if (!slot || !collector->reported.channel_known[index] ||
        !collector->reported.zero_known[index])
        return MR_OK;
    return store_channel_put(collector->store, slot->row.id, index,
                             &collector->reported.channel[index], error);
}

static enum mr_status handle_channel(struct collector *collector, const struct link_state *side,
                                     const struct mr_channel *message, struct error *error)
{
    if (message->index >= MR_CHANNELS)
        return MR_OK;
    struct mr_channel_config *known = &collector->reported.channel[message->index];
    if (collector->reported.channel_known[message->index] && known->kind == message->kind &&
        known->unit_per_code == message->unit_per_code &&
        (known->station_ft == message->station_ft ||
         (isnan(known->station_ft) && isnan(message->station_ft))))
        return MR_OK;
    known->kind = message->kind;
    known->station_ft = message->station_ft;
    known->unit_per_code = message->unit_per_code;
    collector->reported.channel_known[message->index] = true;
    return put_channel(collector, side->current_landing, message->index, error);
}

static enum mr_status handle_channel_zero(struct collector *collector,
                                          const struct link_state *side,
                                          const struct mr_channel_zero *message,
                                          struct error *error)
{
    if (message->index >= MR_CHANNELS)
        return MR_OK;
    struct mr_channel_config *known = &collector->reported.channel[message->index];
    if (collector->reported.zero_known[message->index] && known->number == message->number &&
        known->band == message->band && known->zero_code == message->zero_code)
        return MR_OK;
    known->number = message->number;
    known->band = message->band;
    known->zero_code = message->zero_code;
    collector->reported.zero_known[message->index] = true;
    return put_channel(collector, side->current_landing, message->index, error);
}

static enum mr_status put_calibration(struct collector *collector, const struct landing_slot *slot,
                                      unsigned index, unsigned item, struct error *error)
{
    if (!slot || !(collector->reported.items_known[index] >> item & 1u))
        return MR_OK;
    return store_calibration_put(
        collector->store, slot->row.id,
        &(struct store_calibration){
            index, item, (double)mr_channel_get_item(&collector->reported.channel[index], item)},
        error);
}

static enum mr_status handle_calibration(struct collector *collector, const struct link_state *side,
                                         const struct mr_calibration *message, struct error *error)
{
    if (message->index >= MR_CHANNELS || message->item >= MR_CALIBRATION_ITEM_COUNT)
        return MR_OK;
    struct mr_channel_config *known = &collector->reported.channel[message->index];
    uint32_t bit = 1u << message->item;
    if (collector->reported.items_known[message->index] & bit &&
        mr_channel_get_item(known, message->item) == message->value)
        return MR_OK;
    mr_channel_set_item(known, message->item, message->value);
    collector->reported.items_known[message->index] |= bit;
    return put_calibration(collector, side->current_landing, message->index, message->item, error);
}

static enum mr_status handle_switch_place(struct collector *collector,
                                          const struct link_state *side,
                                          const struct mr_switch_place *message,
                                          struct error *error)
{
    if (message->position == 0 || message->position > STORE_SWITCHES_MAX)
        return MR_OK;
    struct store_switch place = {message->position, message->step_codes,
                                 (double)message->station_ft};
    struct store_switch *known = &collector->reported.switch_place[message->position - 1];
    if (collector->reported.switch_known[message->position - 1] &&
        known->step_codes == place.step_codes && known->station_ft == place.station_ft)
        return MR_OK;
    *known = place;
    collector->reported.switch_known[message->position - 1] = true;
    return side->current_landing ? COLLECT_PUT(switch, &place) : MR_OK;
}

static enum mr_status handle_slack(struct collector *collector, const struct link_state *side,
                                   const struct mr_slack *message, struct error *error)
{
    if (message->segment >= MR_SEGMENTS)
        return MR_OK;
    struct store_segment segment = {message->segment, message->joints, (double)message->slack_in,
                                    (double)message->start_ft, (double)message->end_ft};
    struct store_segment *known = &collector->reported.segment[message->segment];
    if (collector->reported.segment_known[message->segment] &&
        (known->slack_in == segment.slack_in ||
         (isnan(known->slack_in) && isnan(segment.slack_in))))
        return MR_OK;
    /* A board that restarts during a landing loses its survey, but the survey stored for the
     * landing is still valid. */
    bool forgotten = collector->reported.segment_known[message->segment] &&
                     !isnan(known->slack_in) && isnan(segment.slack_in);
    *known = segment;
    collector->reported.segment_known[message->segment] = true;
    return side->current_landing && !forgotten ? COLLECT_PUT(segment, &segment) : MR_OK;
}

enum mr_status collect_write_configuration(struct collector *collector,
                                           const struct landing_slot *slot, struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < MR_CHANNELS && status == MR_OK; i++)
        status = put_channel(collector, slot, i, error);
    for (unsigned i = 0; i < MR_CHANNELS * MR_CALIBRATION_ITEM_COUNT && status == MR_OK; i++)
        status = put_calibration(collector, slot, i / MR_CALIBRATION_ITEM_COUNT,
                                 i % MR_CALIBRATION_ITEM_COUNT, error);
    for (unsigned i = 0; i < STORE_SWITCHES_MAX && status == MR_OK; i++) {
        if (collector->reported.switch_known[i])
            status = store_switch_put(collector->store, slot->row.id,
                                      &collector->reported.switch_place[i], error);
    }
    for (unsigned i = 0; i < MR_SEGMENTS && status == MR_OK; i++) {
        if (collector->reported.segment_known[i])
            status = store_segment_put(collector->store, slot->row.id,
                                       &collector->reported.segment[i], error);
    }
    return status == MR_OK ? collect_write_parameters(collector, slot, error) : status;
}

static enum mr_status handle_site(struct collector *collector, struct link_state *side,
                                  const struct mr_site *message, struct error *error)
{
    collector->reported.identity.touchdown_ft = (double)message->touchdown_ft;
    collector->reported.identity.switch_error_ft = (double)message->switch_error_ft;
    return update_landing_identity(collector, side, error);
}

static enum mr_status handle_board_uid(struct collector *collector, struct link_state *side,
                                       const struct mr_board_uid *message, struct error *error)
{
    const uint32_t words[2] = {message->uid0, message->uid1};
    handle_uid(collector, side, 1, words, 2, error);
    return error->status;
}

static enum mr_status handle_board_image(struct collector *collector, struct link_state *side,
                                         const struct mr_board_image *message, struct error *error)
{
    if (!handle_uid(collector, side, 2, &message->uid2, 1, error))
        return error->status;
    collector->reported.is_uid_from_serial |= side->kind == LINK_SERIAL;
    collector->reported.identity.image_crc = message->image_crc;
    snprintf(collector->reported.identity.board_uid, sizeof collector->reported.identity.board_uid,
             "%08X%08X%08X", (unsigned)collector->reported.uid[0],
             (unsigned)collector->reported.uid[1], (unsigned)collector->reported.uid[2]);
    return MR_OK;
}

/* Stores an event when the state of the board's key changes. */
static enum mr_status handle_bus_key(struct collector *collector, struct link_state *side,
                                     const struct mr_bus_key *message, uint64_t host_us,
                                     struct error *error)
{
    bool same = collector->reported.key_known && collector->reported.key.state == message->state;
    int64_t block = collect_newest_block(side);
    collector->reported.key = *message;
    collector->reported.key_known = true;
    return same ? MR_OK
                : collect_put_event(collector, side, "key", block < 0 ? 0 : block, message->state,
                                    message->changes, STORE_NONE, host_us, error);
}

static void handle_nonce(struct collector *collector, const struct mr_nonce *message)
{
    mr_nonce_put(message, collector->reported.nonce);
    collector->reported.nonce_known = true;
}

/* ---- config: the configuration, which the board sends word by word ---- */

static enum mr_status handle_config_word(struct collector *collector, struct link_state *side,
                                         const struct mr_config_image *word, struct error *error)
{
    struct mr_config config;
    if (!config_words_add(&side->config, word, &config))
        return MR_OK;
    char *text = config_text_write(&config);
    /* the last word is the CRC */
    enum mr_status status = store_configuration_put(collector->store, word->value, text, error);
    free(text);
    if (status == MR_OK) {
        collector->config_stored = true;
        collector->config_stored_crc = word->value;
    }
    return status;
}

bool collector_needs_configuration(const struct collector *collector)
{
    bool known = collector->reported.hello_known &&
                 collector->reported.identity.config_crc != STORE_NONE;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        if (collector->side[kind].current_landing)
            /* from arming to the end of the landing the board does not send its configuration */
            return false;
    }
    return known &&
           !(collector->config_stored &&
             collector->config_stored_crc == (uint32_t)collector->reported.identity.config_crc);
}

enum mr_status collect_identity_message(struct collector *collector, struct link_state *side,
                                        const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->index) {
    case MR_INDEX_HELLO: return handle_hello(collector, side, &m->as.hello, error);
    case MR_INDEX_BOARD_UID: return handle_board_uid(collector, side, &m->as.board_uid, error);
    case MR_INDEX_BOARD_IMAGE:
        return handle_board_image(collector, side, &m->as.board_image, error);
    case MR_INDEX_IMAGE_COMMIT:
        mr_image_commit_text(m->as.image_commit.commit, m->as.image_commit.commit_more,
                             m->as.image_commit.changed != 0,
                             collector->reported.identity.image_commit);
        return MR_OK;
    case MR_INDEX_BUS_KEY:
        return handle_bus_key(collector, side, &m->as.bus_key, event->host_us, error);
    case MR_INDEX_NONCE: handle_nonce(collector, &m->as.nonce); return MR_OK;
    case MR_INDEX_BOARD_CONFIG:
        collector->reported.identity.config_crc = m->as.board_config.config_crc;
        return MR_OK;
    case MR_INDEX_CONFIG_IMAGE:
        return handle_config_word(collector, side, &m->as.config_image, error);
    case MR_INDEX_SITE: return handle_site(collector, side, &m->as.site, error);
    case MR_INDEX_CHANNEL: return handle_channel(collector, side, &m->as.channel, error);
    case MR_INDEX_CHANNEL_ZERO:
        return handle_channel_zero(collector, side, &m->as.channel_zero, error);
    case MR_INDEX_CALIBRATION:
        return handle_calibration(collector, side, &m->as.calibration, error);
    case MR_INDEX_SWITCH_PLACE:
        return handle_switch_place(collector, side, &m->as.switch_place, error);
    case MR_INDEX_SLACK: return handle_slack(collector, side, &m->as.slack, error);
    default: return MR_OK;
    }
}
