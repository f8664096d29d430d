#include "firmware/configround.h"

#include "common/channels.h"
#include "common/closure.h"
#include "common/runway.h"
#include "common/version.h"
#include "firmware/config.h"
#include "firmware/schedule.h"
#include "firmware/channels.h"

/* Numbers of the items. A calibration is sent in parts of two values each, its table only up to the
 * last point in use. Parameters exist only with a predictor. */
#define FIRST_SWITCH          MR_CHANNELS
#define FIRST_SEGMENT         (FIRST_SWITCH + MR_CONFIG_SWITCHES)
#define FIRST_CALIBRATION     (FIRST_SEGMENT + MR_SEGMENTS)
#define PARTS_PER_CALIBRATION (MR_CALIBRATION_ITEM_COUNT / 2)
#define FIRST_PARAMETER       (FIRST_CALIBRATION + MR_CHANNELS * PARTS_PER_CALIBRATION)
#define ITEM_COUNT            (FIRST_PARAMETER + MR_PREDICT_ITEM_COUNT)

static unsigned count_calibration_items(const struct mr_channel_config *channel)
{
    unsigned points = channel->points < MR_CONFIG_POINTS ? channel->points : MR_CONFIG_POINTS;
    if (channel->kind == MR_KIND_REFERENCE)
        return MR_CALIBRATION_GAIN_ERROR + 1;
    return mr_channel_is_sensor(channel) ? MR_CALIBRATION_FIRST_POINT_ITEM + 2 * points : 0;
}

void configround_send_hello(struct telemetry *telemetry, unsigned sinks,
                            const struct landing *landing)
{
    const struct board_identity *identity = &telemetry->identity;
    TELEMETRY_SEND(telemetry, sinks, hello, HELLO, .layout = MR_LAYOUT, .major = FIRMWARE_MAJOR,
                   .minor = FIRMWARE_MINOR, .patch = FIRMWARE_PATCH,
                   .clock_source = identity->clock_source, .reset_cause = identity->reset_cause,
                   .state = (uint8_t)landing->state);
    TELEMETRY_SEND(telemetry, sinks, board_uid, BOARD_UID, .uid0 = identity->uid[0],
                   .uid1 = identity->uid[1]);
    TELEMETRY_SEND(telemetry, sinks, board_image, BOARD_IMAGE, .uid2 = identity->uid[2],
                   .image_crc = identity->image_crc);
    TELEMETRY_SEND(telemetry, sinks, image_commit, IMAGE_COMMIT, .commit = identity->image.commit,
                   .commit_more = identity->image.commit_more,
                   .changed = identity->image.is_modified, .state = identity->image_state);
    TELEMETRY_SEND(telemetry, sinks, image_header, IMAGE_HEADER,
                   .program_crc = identity->image.program_crc,
                   .header_crc = identity->image.header_crc);
    TELEMETRY_SEND(telemetry, sinks, board_config, BOARD_CONFIG,
                   .config_crc = telemetry->config_crc, .channels = MR_CHANNELS,
                   .switches = MR_CONFIG_SWITCHES, .segments = MR_SEGMENTS,
                   .warning_mats = MR_PREDICTOR_WARNING_MATS);
    if (!(sinks & TO_CONFIGURATION)) {
        const struct mr_config_state *stored = &telemetry->config_state;
        TELEMETRY_SEND(telemetry, sinks, config_state, CONFIG_STATE, .revision = stored->revision,
                       .source = stored->source, .copy_a = stored->copy_a, .copy_b = stored->copy_b,
                       .board = identity->board);
        TELEMETRY_SEND_MESSAGE(telemetry, sinks, bus_key, BUS_KEY, &telemetry->bus_key);
    }
    TELEMETRY_SEND(telemetry, sinks, site, SITE, .touchdown_ft = config.site[0].touchdown_ft,
                   .switch_error_ft = config.site[0].switch_error_ft);
    TELEMETRY_SEND(telemetry, sinks, wheel, WHEEL, .ahead_ft = config.site[0].wheel_ahead_ft,
                   .wheel = config.site[0].wheel);
}

/* True if the item is not fitted. A burst includes such items, so that a host that has them as
 * fitted is corrected; in all other cases they are not sent. */
static bool is_not_fitted(unsigned item)
{
    if (item < FIRST_SWITCH)
        return config.channel[item].kind == MR_KIND_NONE;
    return item < FIRST_SEGMENT && config.gate[item - FIRST_SWITCH].step_codes == 0;
}

/* Returns the next item after `item` that has content; 0 after the last one. */
static unsigned find_next_item(unsigned item)
{
    for (item++; item < ITEM_COUNT; item++) {
        unsigned part = item - FIRST_CALIBRATION;
        if (item < FIRST_CALIBRATION || (item >= FIRST_PARAMETER && config.predict[0].fitted))
            return item;
        if (item < FIRST_PARAMETER &&
            2 * (part % PARTS_PER_CALIBRATION) <
                count_calibration_items(&config.channel[part / PARTS_PER_CALIBRATION]))
            return item;
    }
    return 0;
}

static void send_channel(struct telemetry *telemetry, unsigned sinks, unsigned i)
{
    const struct mr_channel_config *channel = &config.channel[i];
    TELEMETRY_SEND(telemetry, sinks, channel, CHANNEL, .index = (uint8_t)i, .kind = channel->kind,
                   .station_ft = channel->station_ft, .unit_per_code = channel->unit_per_code);
    if (channel->kind != MR_KIND_NONE)
        TELEMETRY_SEND(telemetry, sinks, channel_zero, CHANNEL_ZERO, .index = (uint8_t)i,
                       .number = channel->number, .band = channel->band,
                       .measured = zero_is_measured(i), .zero_code = channel->zero_code);
}

static void send_calibration(struct telemetry *telemetry, unsigned sinks, unsigned part)
{
    unsigned i = part / PARTS_PER_CALIBRATION, first = 2 * (part % PARTS_PER_CALIBRATION);
    for (unsigned item = first;
         item < first + 2 && item < count_calibration_items(&config.channel[i]); item++)
        TELEMETRY_SEND(telemetry, sinks, calibration, CALIBRATION, .index = (uint8_t)i,
                       .item = (uint8_t)item,
                       .value = mr_channel_get_item(&config.channel[i], item));
}

static void send_parameter(struct telemetry *telemetry, unsigned sinks, unsigned i)
{
    struct mr_predictor_config predictor;
    mr_config_get_predictor(&config, &predictor);
    TELEMETRY_SEND(telemetry, sinks, predict_item, PREDICT_ITEM, .index = (uint8_t)i,
                   .items = MR_PREDICT_ITEM_COUNT, .value = mr_predict_get_item(&predictor, i));
}

static void send_item(struct telemetry *telemetry, unsigned sinks, unsigned item,
                      const float *slack_in)
{
    if (item < FIRST_SWITCH) {
        send_channel(telemetry, sinks, item);
    } else if (item < FIRST_SEGMENT) {
        unsigned i = item - FIRST_SWITCH;
        TELEMETRY_SEND(telemetry, sinks, switch_place, SWITCH_PLACE, .position = (uint8_t)(i + 1),
                       .step_codes = config.gate[i].step_codes,
                       .station_ft = mr_config_gate_ft(&config, i));
    } else if (item < FIRST_CALIBRATION) {
        unsigned segment = item - FIRST_SEGMENT;
        TELEMETRY_SEND(telemetry, sinks, slack, SLACK, .segment = (uint8_t)segment,
                       .joints = MR_MATS_PER_SEGMENT, .slack_in = slack_in[segment],
                       .start_ft = MR_SEGMENT_LENGTH_FT * (float)segment,
                       .end_ft = MR_SEGMENT_LENGTH_FT * (float)(segment + 1));
    } else if (item < FIRST_PARAMETER) {
        send_calibration(telemetry, sinks, item - FIRST_CALIBRATION);
    } else {
        send_parameter(telemetry, sinks, item - FIRST_PARAMETER);
    }
}

void configround_start_burst(struct telemetry *telemetry, const struct landing *landing)
{
    telemetry->round.item = 0;
    telemetry->round.is_bursting = true;
    configround_send_hello(telemetry, TO_LINKS, landing);
}

void configround_on_block(struct telemetry *telemetry, const float *slack_in, uint32_t index)
{
    unsigned item = telemetry->round.item;
    bool bursting = telemetry->round.is_bursting;
    if (bursting ? !telemetry_can_burst(telemetry) : !DUE(ITEM, index))
        return;
    for (unsigned n = 0; !bursting && n < ITEM_COUNT && is_not_fitted(item); n++)
        item = find_next_item(item);
    send_item(telemetry, TO_LINKS, item, slack_in);
    telemetry->round.item = find_next_item(item);
    telemetry->round.is_bursting = bursting && telemetry->round.item != 0;
}

void configround_store(struct telemetry *telemetry, const struct landing *landing,
                       const float *slack_in)
{
    configround_send_hello(telemetry, TO_CONFIGURATION, landing);
    for (unsigned item = 0; item < FIRST_SEGMENT; item++) {
        if (!is_not_fitted(item))
            send_item(telemetry, TO_CONFIGURATION, item, slack_in);
    }
    for (unsigned segment = 0; segment < MR_SEGMENTS; segment++) {
        if (!__builtin_isnan(slack_in[segment]))
            send_item(telemetry, TO_CONFIGURATION, FIRST_SEGMENT + segment, slack_in);
    }
    for (unsigned item = find_next_item(FIRST_CALIBRATION - 1); item != 0;
         item = find_next_item(item))
        send_item(telemetry, TO_CONFIGURATION, item, slack_in);
}
