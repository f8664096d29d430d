#include "firmware/telemetry.h"

#include <string.h>

#include "common/channels.h"
#include "common/framing.h"
#include "common/runway.h"
#include "common/series.h"
#include "common/version.h"
#include "common/wire.h"
#include "firmware/config.h"
#include "firmware/health.h"
#include "firmware/schedule.h"
#include "firmware/zero.h"

/* The configuration as a round of items: channels (two messages each), switches, survey segments, calibrations (two values each;
 * tables only as far as they are in use), parameters of the predictor (when there is one). */
#define FIRST_SWITCH MR_CHANNELS
#define FIRST_SEGMENT (FIRST_SWITCH + MR_CONFIG_SWITCHES)
#define FIRST_CALIBRATION (FIRST_SEGMENT + MR_SEGMENTS)
#define PARTS_PER_CALIBRATION (MR_CALIBRATION_ITEMS / 2)
#define FIRST_PARAMETER (FIRST_CALIBRATION + MR_CHANNELS * PARTS_PER_CALIBRATION)
#define ITEMS (FIRST_PARAMETER + MR_PREDICT_ITEMS)
#define CLOCK_ERROR 0.01    /* relative, of the internal oscillator */

enum { ON_CAN, ON_SERIAL };

static void count_drop(uint16_t *dropped, enum mr_fault_code fault)
{
    if (*dropped < UINT16_MAX)
        (*dropped)++;
    health_count(fault, 0);
}

static void send_can(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length)
{
    struct board_can_frame frame = {.id = id, .length = (uint8_t)length};
    if (!telemetry->can.silent)
        telemetry->said[ON_CAN][mr_message_place(id)]++;
    memcpy(frame.data, payload, length);
    if (!canwatch_takes(&telemetry->can))
        return;
    if (board_can_send(&frame)) {
        telemetry->can_sent++;
    } else {
        health_count(MR_FAULT_CAN_QUEUE_FULL, 0);
        canwatch_full(&telemetry->can);
    }
}

static void send_serial(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length)
{
    uint8_t frame[MR_FRAME_MAX];
    telemetry->said[ON_SERIAL][mr_message_place(id)]++;
    size_t size = mr_frame_encode(telemetry->serial_seq, id, payload, length, frame);
    if (board_serial_send(frame, size)) {
        telemetry->serial_seq++;
        telemetry->serial_sent++;
    } else {
        count_drop(&telemetry->serial_dropped, MR_FAULT_SERIAL_QUEUE_FULL);
    }
}

/* Zones and the warning, edges, motion, states, results, marks, acknowledgements, what channels are worth, what befell a band, the
 * temperature, and faults. */
static bool belongs_to_record(uint16_t id)
{
    return (id >= MR_ID_ZONE && id <= MR_ID_BACKLOG) || id == MR_ID_FAULT || id == MR_ID_CHANNEL_EVENT ||
           id == MR_ID_CHANNEL_QUALITY || id == MR_ID_BAND_EVENT || id == MR_ID_TEMPERATURE ||
           (id >= MR_ID_BAND_BEFORE && id <= MR_ID_BAND_AFTER) || (id >= MR_ID_EDGE && id < MR_ID_BOX_STATE);
}

static void send_both(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length)
{
    if (telemetry->to_box) {
        blackbox_configure(telemetry->box, id, payload, length);
        return;
    }
    if (telemetry->box && belongs_to_record(id))
        blackbox_note(telemetry->box, id, payload, length);
    send_can(telemetry, id, payload, length);
    send_serial(telemetry, id, payload, length);
}

void telemetry_send(struct telemetry *telemetry, enum telemetry_way way, uint16_t id, const uint8_t *payload, size_t length)
{
    if (way != TELEMETRY_CAN)
        send_serial(telemetry, id, payload, length);
    if (way != TELEMETRY_SERIAL)
        send_can(telemetry, id, payload, length);
}

bool telemetry_probe(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length)
{
    struct board_can_frame frame = {.id = id, .length = (uint8_t)length};
    memcpy(frame.data, payload, length);
    telemetry->said[ON_CAN][mr_message_place(id)]++;
    bool queued = board_can_send(&frame);
    telemetry->can_sent += queued;
    return queued;
}

/* Build a message of the catalogue on the spot and send it: SEND(both, telemetry, mark, MARK, .number = 1). */
#define SEND(way, telemetry, name, NAME, ...)                             \
    do {                                                                  \
        uint8_t payload_[MR_MESSAGE_MAX];                                 \
        const struct mr_##name message_ = {__VA_ARGS__};                  \
        size_t length_ = mr_##name##_put(&message_, payload_);            \
        send_##way(telemetry, MR_ID_##NAME, payload_, length_);           \
    } while (0)

static struct mr_channel channel_message(unsigned i)
{
    const struct mr_channel_config *channel = &config.channel[i];
    return (struct mr_channel){.index = (uint8_t)i, .kind = channel->kind, .station_ft = channel->station_ft,
                               .unit_per_code = channel->unit_per_code};
}

static struct mr_channel_zero channel_zero_message(unsigned i)
{
    const struct mr_channel_config *channel = &config.channel[i];
    return (struct mr_channel_zero){.index = (uint8_t)i, .number = channel->number, .band = channel->band,
                                    .measured = zero_is_measured(i), .zero_code = channel->zero_code};
}

static struct mr_switch_place switch_message(unsigned i)
{
    return (struct mr_switch_place){.position = (uint8_t)(i + 1), .step_codes = config.gate[i].step_codes,
                                    .station_ft = mr_config_gate_ft(&config, i)};
}

static unsigned calibration_items(const struct mr_channel_config *channel)
{
    unsigned points = channel->points < MR_CONFIG_POINTS ? channel->points : MR_CONFIG_POINTS;
    if (channel->kind == MR_KIND_REFERENCE)
        return MR_CALIBRATION_GAIN_ERROR + 1;
    return mr_channel_measures(channel) ? MR_CALIBRATION_TABLE + 2 * points : 0;
}

static struct mr_calibration calibration_message(unsigned i, unsigned item)
{
    return (struct mr_calibration){.index = (uint8_t)i, .item = (uint8_t)item,
                                   .value = mr_channel_item(&config.channel[i], item)};
}

void telemetry_start(struct telemetry *telemetry)
{
    memset(telemetry, 0, sizeof *telemetry);
    board_identify(&telemetry->identity);
    bool silent = telemetry->identity.clock_source != BOARD_CLOCK_CRYSTAL;
    canwatch_start(&telemetry->can, silent);
    if (silent)
        health_count(MR_FAULT_CAN_SILENT, 0);
}

static void send_hello(struct telemetry *telemetry, const struct landing *landing)
{
    const struct board_identity *identity = &telemetry->identity;
    SEND(both, telemetry, hello, HELLO, .layout = MR_LAYOUT, .major = FIRMWARE_MAJOR, .minor = FIRMWARE_MINOR,
         .patch = FIRMWARE_PATCH, .clock_source = identity->clock_source, .reset_cause = identity->reset_cause,
         .state = (uint8_t)landing->state);
    SEND(both, telemetry, board_uid, BOARD_UID, .uid0 = identity->uid[0], .uid1 = identity->uid[1]);
    SEND(both, telemetry, board_image, BOARD_IMAGE, .uid2 = identity->uid[2], .image_crc = identity->image_crc);
    SEND(both, telemetry, image_commit, IMAGE_COMMIT, .commit = identity->image.commit,
         .commit_more = identity->image.commit_more, .changed = identity->image.changed, .state = identity->image_state);
    SEND(both, telemetry, image_header, IMAGE_HEADER, .program_crc = identity->image.program_crc,
         .header_crc = identity->image.header_crc);
    SEND(both, telemetry, board_config, BOARD_CONFIG, .config_crc = telemetry->config_crc, .channels = MR_CHANNELS,
         .switches = MR_CONFIG_SWITCHES, .segments = MR_SEGMENTS, .warning_mats = MR_PREDICTOR_WARNING_MATS);
    if (!telemetry->to_box) {
        const struct mr_config_state *stored = &telemetry->config_state;
        SEND(both, telemetry, config_state, CONFIG_STATE, .revision = stored->revision, .source = stored->source,
             .copy_a = stored->copy_a, .copy_b = stored->copy_b);
    }
    SEND(both, telemetry, site, SITE, .touchdown_ft = config.site[0].touchdown_ft,
         .switch_error_ft = config.site[0].switch_error_ft);
    SEND(both, telemetry, wheel, WHEEL, .ahead_ft = config.site[0].wheel_ahead_ft, .wheel = config.site[0].wheel);
}

/* Said in a burst, so that who knew it as fitted hears of it; neither repeated nor stored. */
static bool is_not_fitted(unsigned item)
{
    if (item < FIRST_SWITCH)
        return config.channel[item].kind == MR_KIND_NONE;
    return item < FIRST_SEGMENT && config.gate[item - FIRST_SWITCH].step_codes == 0;
}

/* The one after an item that has anything to say; 0 after the last. */
static unsigned next_item(unsigned item)
{
    for (item++; item < ITEMS; item++) {
        unsigned part = item - FIRST_CALIBRATION;
        if (item < FIRST_CALIBRATION || (item >= FIRST_PARAMETER && config.predict[0].fitted))
            return item;
        if (item < FIRST_PARAMETER && 2 * (part % PARTS_PER_CALIBRATION) < calibration_items(&config.channel[part / PARTS_PER_CALIBRATION]))
            return item;
    }
    return 0;
}

static void skip_what_is_not_fitted(struct telemetry *telemetry)
{
    for (unsigned n = 0; n < ITEMS && is_not_fitted(telemetry->item); n++)
        telemetry->item = next_item(telemetry->item);
}

static void send_item(struct telemetry *telemetry, const float *slack_in)
{
    unsigned item = telemetry->item;
    uint8_t payload[MR_MESSAGE_MAX];
    if (item < FIRST_SWITCH) {
        struct mr_channel channel = channel_message(item);
        struct mr_channel_zero zero = channel_zero_message(item);
        send_both(telemetry, MR_ID_CHANNEL, payload, mr_channel_put(&channel, payload));
        if (channel.kind != MR_KIND_NONE)
            send_both(telemetry, MR_ID_CHANNEL_ZERO, payload, mr_channel_zero_put(&zero, payload));
    } else if (item < FIRST_SEGMENT) {
        struct mr_switch_place place = switch_message(item - FIRST_SWITCH);
        send_both(telemetry, MR_ID_SWITCH_PLACE, payload, mr_switch_place_put(&place, payload));
    } else if (item >= FIRST_PARAMETER) {
        struct mr_predictor_config predictor;
        mr_config_predictor(&config, &predictor);
        SEND(both, telemetry, predict_item, PREDICT_ITEM, .index = (uint8_t)(item - FIRST_PARAMETER), .items = MR_PREDICT_ITEMS,
             .value = mr_predict_item(&predictor, item - FIRST_PARAMETER));
    } else if (item >= FIRST_CALIBRATION) {
        unsigned channel = (item - FIRST_CALIBRATION) / PARTS_PER_CALIBRATION;
        unsigned first = 2 * ((item - FIRST_CALIBRATION) % PARTS_PER_CALIBRATION);
        for (unsigned i = first; i < first + 2 && i < calibration_items(&config.channel[channel]); i++) {
            struct mr_calibration calibration = calibration_message(channel, i);
            send_both(telemetry, MR_ID_CALIBRATION, payload, mr_calibration_put(&calibration, payload));
        }
    } else {
        unsigned segment = item - FIRST_SEGMENT;
        SEND(both, telemetry, slack, SLACK, .segment = (uint8_t)segment, .joints = MR_MATS_PER_SEGMENT,
             .slack_in = slack_in[segment], .start_ft = MR_SEGMENT_LENGTH_FT * (float)segment,
             .end_ft = MR_SEGMENT_LENGTH_FT * (float)(segment + 1));
    }
    telemetry->item = next_item(item);
}

static void send_faults(struct telemetry *telemetry, bool all)
{
    for (unsigned fault = 0; fault < MR_FAULT_COUNT; fault++) {
        struct health_counter counter = health_take((enum mr_fault_code)fault);
        if (counter.changed || (all && counter.count))
            SEND(both, telemetry, fault, FAULT, .code = (uint8_t)fault, .detail = counter.detail,
                 .count = counter.count, .block = counter.block);
    }
}

static void send_can_health(struct telemetry *telemetry)
{
    const struct canwatch *can = &telemetry->can;
    uint32_t dropped = (uint32_t)can->drops.queue_full + can->drops.bus_off + can->drops.timeout;
    struct board_can_errors errors;
    board_can_state(&errors);
    SEND(both, telemetry, can_health, CAN_HEALTH, .sent = telemetry->can_sent - errors.removed,
         .dropped = dropped > UINT16_MAX ? UINT16_MAX : (uint16_t)dropped, .tec = errors.tec, .rec = errors.rec);
}

/* By these counts the host knows which messages it lost, not only how many frames. Always as many, whatever was said. */
static void send_count(struct telemetry *telemetry)
{
    uint16_t id = mr_message_at(telemetry->count_place);
    const uint32_t *said[2] = {telemetry->said[ON_CAN], telemetry->said[ON_SERIAL]};
    SEND(can, telemetry, message_count, MESSAGE_COUNT, .id = id, .count = said[ON_CAN][telemetry->count_place]);
    SEND(serial, telemetry, message_count, MESSAGE_COUNT, .id = id, .count = said[ON_SERIAL][telemetry->count_place]);
    telemetry->count_place = (telemetry->count_place + 1) % MR_PLACES;
}

void telemetry_regular(struct telemetry *telemetry, const struct landing *landing, const float *slack_in,
                       uint32_t index, uint32_t tick)
{
    if (DUE(CLOCK, index))
        SEND(both, telemetry, clock, CLOCK, .block = index, .tick = tick);
    if (DUE(HEALTH, index))
        SEND(both, telemetry, health, HEALTH, .faults = health_faults(), .load_permille = board_load_permille(),
             .blocks_lost = telemetry->blocks_lost);
    if (DUE(CAN_HEALTH, index))
        send_can_health(telemetry);
    if (DUE(SERIAL_HEALTH, index))
        SEND(both, telemetry, serial_health, SERIAL_HEALTH, .sent = telemetry->serial_sent,
             .dropped = telemetry->serial_dropped, .bad = telemetry->serial_bad);
    if (DUE(FAULTS, index))
        send_faults(telemetry, DUE(ALL_FAULTS, index));
    if (DUE(COUNT, index))
        send_count(telemetry);
    if (DUE(HELLO, index))
        send_hello(telemetry, landing);
    if (DUE(STATE, index))
        telemetry_state(telemetry, landing);
    if (telemetry->bursting) {
        send_item(telemetry, slack_in);
        telemetry->bursting = telemetry->item != 0;
    } else if (DUE(ITEM, index)) {
        skip_what_is_not_fitted(telemetry);
        send_item(telemetry, slack_in);
    }
}

void telemetry_burst(struct telemetry *telemetry, const struct landing *landing)
{
    telemetry->item = 0;
    telemetry->bursting = true;
    send_hello(telemetry, landing);
}

void telemetry_put(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length)
{
    send_both(telemetry, id, payload, length);
}

void telemetry_block(struct telemetry *telemetry, const struct mr_block *block)
{
    uint8_t record[MR_BLOCK_BYTES_MAX];
    send_serial(telemetry, MR_ID_BLOCK, record, mr_block_put(block, record));
}

/* Some of `count` from `first` on is fitted. */
static bool any_of(uint32_t fitted, unsigned first, unsigned count)
{
    return (fitted >> first & ((1u << count) - 1u)) != 0;
}

static void send_series(struct telemetry *telemetry, enum mr_series_number series, const float *readings, uint32_t fitted, uint32_t index)
{
    uint8_t payload[MR_MESSAGE_MAX];
    for (unsigned i = 0; i < MR_SERIES_PACKS; i++) {
        const struct mr_series_pack *pack = mr_series_pack_at(i);
        if (pack->series == series && any_of(fitted, pack->first - 1u, pack->count))
            send_can(telemetry, pack->id, payload, mr_series_pack_put(pack, readings, index, payload));
    }
}

void telemetry_displacements(struct telemetry *telemetry, const float v[MR_TRANSDUCERS], uint32_t fitted, uint32_t index)
{
    send_series(telemetry, MR_SERIES_DISPLACEMENT, v, fitted, index);
}

void telemetry_tensions(struct telemetry *telemetry, const float v[MR_GAGES], uint32_t fitted, uint32_t index)
{
    send_series(telemetry, MR_SERIES_TENSION, v, fitted, index);
}

void telemetry_state(struct telemetry *telemetry, const struct landing *landing)
{
    SEND(both, telemetry, landing, LANDING, .state = (uint8_t)landing->state, .cause = (uint8_t)landing->cause,
         .landing = landing->number, .block = landing->changed_block);
}

void telemetry_edge(struct telemetry *telemetry, const struct mr_edge *edge)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_EDGE, payload, mr_edge_put(edge, payload));
}

void telemetry_switch(struct telemetry *telemetry, const struct mr_switch_event *event)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_SWITCH_EVENT, payload, mr_switch_event_put(event, payload));
}

void telemetry_pushback(struct telemetry *telemetry, const struct landing *landing, uint32_t index)
{
    const struct mr_passage *passage = &landing->passage;
    SEND(both, telemetry, pushback, PUSHBACK, .count = passage->pushbacks, .position = passage->pushed_position,
         .state = (uint8_t)landing->state, .speed_ft_s = (float)passage->pushed_ft_s, .block16 = (uint16_t)index);
}

/* Standard error of a quantity that goes with the clock's error, once (speed) or twice (deceleration). The internal oscillator
 * may be 1 % out. */
static float error_of(const struct telemetry *telemetry, const struct mr_estimate *estimate, double times)
{
    double error = estimate->error;
    if (telemetry->identity.clock_source != BOARD_CLOCK_CRYSTAL) {
        double clock = CLOCK_ERROR * times * estimate->value;
        error = __builtin_sqrt(error * error + clock * clock);
    }
    return (float)error;
}

void telemetry_motion(struct telemetry *telemetry, const struct mr_motion_estimate *motion, uint32_t index)
{
    SEND(both, telemetry, motion, MOTION, .position_ft = (float)motion->position_ft.value,
         .speed_ft_s = (float)motion->speed_ft_s.value,
         .deceleration_ft_s2 = (float)motion->deceleration_ft_s2.value, .block16 = (uint16_t)index);
    SEND(both, telemetry, motion_error, MOTION_ERROR, .position_ft = (float)motion->position_ft.error,
         .speed_ft_s = error_of(telemetry, &motion->speed_ft_s, 1.0),
         .deceleration_ft_s2 = error_of(telemetry, &motion->deceleration_ft_s2, 2.0), .block16 = (uint16_t)index);
}

void telemetry_summary(struct telemetry *telemetry, const struct mr_gates_summary *summary)
{
    SEND(both, telemetry, touchdown, TOUCHDOWN, .speed_ft_s = (float)summary->touchdown_speed_ft_s.value,
         .speed_error_ft_s = error_of(telemetry, &summary->touchdown_speed_ft_s, 1.0),
         .deceleration_ft_s2 = (float)summary->mean_deceleration_ft_s2.value,
         .deceleration_error_ft_s2 = error_of(telemetry, &summary->mean_deceleration_ft_s2, 2.0));
    SEND(both, telemetry, stop, STOP, .station_ft = (float)summary->stop_station_ft.value,
         .station_error_ft = (float)summary->stop_station_ft.error,
         .after_touchdown_s = (float)(summary->stop_t_s.value - summary->touchdown_t_s.value),
         .switches = (uint8_t)summary->count, .used = (uint8_t)summary->used_for_stop);
}

void telemetry_channel_event(struct telemetry *telemetry, const struct mr_channel_event *event)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_CHANNEL_EVENT, payload, mr_channel_event_put(event, payload));
}

void telemetry_channel_quality(struct telemetry *telemetry, const struct mr_channel_quality *quality)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_CHANNEL_QUALITY, payload, mr_channel_quality_put(quality, payload));
}

void telemetry_mark(struct telemetry *telemetry, const struct mr_mark *mark)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_MARK, payload, mr_mark_put(mark, payload));
}

void telemetry_sync(struct telemetry *telemetry, const struct mr_sync *sync)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_can(telemetry, MR_ID_SYNC, payload, mr_sync_put(sync, payload));
}

void telemetry_sync_at(struct telemetry *telemetry, const struct mr_sync_at *sync_at)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_can(telemetry, MR_ID_SYNC_AT, payload, mr_sync_at_put(sync_at, payload));
}

void telemetry_film_frame(struct telemetry *telemetry, const struct mr_film_frame *frame)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_FILM_FRAME, payload, mr_film_frame_put(frame, payload));
}

void telemetry_camera(struct telemetry *telemetry, const struct mr_camera *camera)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_CAMERA, payload, mr_camera_put(camera, payload));
}

void telemetry_ack(struct telemetry *telemetry, const struct mr_ack *ack)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_ACK, payload, mr_ack_put(ack, payload));
}

void telemetry_to_box(struct telemetry *telemetry, bool to_box)
{
    telemetry->to_box = to_box && telemetry->box != NULL && !telemetry->box->left_out;
}

void telemetry_store_configuration(struct telemetry *telemetry, const struct landing *landing, const float *slack_in)
{
    unsigned item = telemetry->item;
    telemetry_to_box(telemetry, true);
    if (!telemetry->to_box)
        return;
    send_hello(telemetry, landing);
    for (unsigned i = 0; i < FIRST_SEGMENT; i++) {
        telemetry->item = i;
        if (!is_not_fitted(i))
            send_item(telemetry, slack_in);
    }
    for (unsigned segment = 0; segment < MR_SEGMENTS; segment++) {
        telemetry->item = FIRST_SEGMENT + segment;
        if (!__builtin_isnan(slack_in[segment]))
            send_item(telemetry, slack_in);
    }
    for (telemetry->item = next_item(FIRST_CALIBRATION - 1); telemetry->item != 0;)
        send_item(telemetry, slack_in);
    telemetry->item = item;
    telemetry_to_box(telemetry, false);
}

void telemetry_box(struct telemetry *telemetry, const struct mr_box_state *state, const struct mr_box_space *space)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_BOX_STATE, payload, mr_box_state_put(state, payload));
    send_both(telemetry, MR_ID_BOX_SPACE, payload, mr_box_space_put(space, payload));
}

void telemetry_box_record(struct telemetry *telemetry, const struct mr_box_record *record, const struct mr_box_span *span)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_BOX_RECORD, payload, mr_box_record_put(record, payload));
    if (record->record)
        send_both(telemetry, MR_ID_BOX_SPAN, payload, mr_box_span_put(span, payload));
}

void telemetry_box_end(struct telemetry *telemetry, const struct mr_box_end *end)
{
    uint8_t payload[MR_MESSAGE_MAX];
    send_both(telemetry, MR_ID_BOX_END, payload, mr_box_end_put(end, payload));
}

void telemetry_box_part(struct telemetry *telemetry, const uint8_t *payload, size_t length)
{
    send_serial(telemetry, MR_ID_BOX_PART, payload, length);
}

void telemetry_temperature(struct telemetry *telemetry, float temperature_c, float error_c, uint32_t index)
{
    SEND(both, telemetry, temperature, TEMPERATURE, .temperature_c = temperature_c, .error_c = error_c, .block = index);
}

void telemetry_slow(struct telemetry *telemetry, uint16_t id, const uint8_t *payload, size_t length)
{
    send_both(telemetry, id, payload, length);
}
