#include "firmware/landinglink.h"

#include "common/catalogue.h"
#include "firmware/health.h"
#include "firmware/schedule.h"
#include "firmware/configround.h"

#define INTERNAL_CLOCK_ERROR 0.01 /* relative error of the internal oscillator */

void landinglink_send_block(struct telemetry *telemetry, const struct mr_block *block)
{
    uint8_t record[MR_BLOCK_BYTES_MAX];
    telemetry_send(telemetry, TO_SERIAL, MR_ID_BLOCK, record, mr_block_encode(block, record));
}

/* True if any of the `count` inputs from `first` on is fitted. */
static bool has_any_channel(uint32_t fitted, unsigned first, unsigned count)
{
    return (fitted >> first & ((1u << count) - 1u)) != 0;
}

static void send_series(struct telemetry *telemetry, enum mr_series_number series,
                        const float *readings, uint32_t fitted, uint32_t index)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    for (unsigned i = 0; i < MR_SERIES_PACK_COUNT; i++) {
        const struct mr_series_pack *pack = mr_series_pack_at(i);
        if (pack->series == series &&
            has_any_channel(fitted, pack->first_reading - 1u, pack->reading_count))
            telemetry_send(telemetry, TO_CAN, pack->id, payload,
                           mr_series_pack_put(pack, readings, index, payload));
    }
}

void landinglink_send_displacements(struct telemetry *telemetry, const float v[MR_TRANSDUCERS],
                                    uint32_t fitted, uint32_t index)
{
    send_series(telemetry, MR_SERIES_DISPLACEMENT, v, fitted, index);
}

void landinglink_send_tensions(struct telemetry *telemetry, const float v[MR_GAGES],
                               uint32_t fitted, uint32_t index)
{
    send_series(telemetry, MR_SERIES_TENSION, v, fitted, index);
}

void landinglink_send_state(struct telemetry *telemetry, const struct landing *landing)
{
    TELEMETRY_SEND(telemetry, TO_RECORD, landing, LANDING, .state = (uint8_t)landing->state,
                   .cause = (uint8_t)landing->cause, .landing = landing->number,
                   .block = landing->changed_block);
}

static void report_pushback(struct telemetry *telemetry, const struct landing *landing,
                            uint32_t index)
{
    const struct mr_passage *passage = &landing->passage;
    TELEMETRY_SEND(telemetry, TO_RECORD, pushback, PUSHBACK, .count = passage->pushback_count,
                   .position = passage->pushback_position, .state = (uint8_t)landing->state,
                   .speed_ft_s = (float)passage->pushback_speed_ft_s, .block16 = (uint16_t)index);
}

/* Returns the standard error including that of the clock, which affects a speed once and a
 * deceleration twice. The internal oscillator may be off by 1 %. */
static float add_clock_error(const struct telemetry *telemetry, const struct mr_estimate *estimate,
                             double times)
{
    double error = estimate->error;
    if (telemetry->identity.clock_source != MR_CLOCK_CRYSTAL) {
        double clock = INTERNAL_CLOCK_ERROR * times * estimate->value;
        error = __builtin_sqrt(error * error + clock * clock);
    }
    return (float)error;
}

void landinglink_send_motion(struct telemetry *telemetry, const struct mr_motion_estimate *motion,
                             uint32_t index)
{
    TELEMETRY_SEND(
        telemetry, TO_RECORD, motion, MOTION, .position_ft = (float)motion->position_ft.value,
        .speed_ft_s = (float)motion->speed_ft_s.value,
        .deceleration_ft_s2 = (float)motion->deceleration_ft_s2.value, .block16 = (uint16_t)index);
    TELEMETRY_SEND(
        telemetry, TO_RECORD, motion_error, MOTION_ERROR,
        .position_ft = (float)motion->position_ft.error,
        .speed_ft_s = add_clock_error(telemetry, &motion->speed_ft_s, 1.0),
        .deceleration_ft_s2 = add_clock_error(telemetry, &motion->deceleration_ft_s2, 2.0),
        .block16 = (uint16_t)index);
}

void landinglink_send_summary(struct telemetry *telemetry, const struct mr_gates_summary *summary)
{
    TELEMETRY_SEND(
        telemetry, TO_RECORD, touchdown, TOUCHDOWN,
        .speed_ft_s = (float)summary->touchdown_speed_ft_s.value,
        .speed_error_ft_s = add_clock_error(telemetry, &summary->touchdown_speed_ft_s, 1.0),
        .deceleration_ft_s2 = (float)summary->mean_deceleration_ft_s2.value,
        .deceleration_error_ft_s2 = add_clock_error(telemetry, &summary->mean_deceleration_ft_s2,
                                                    2.0));
    TELEMETRY_SEND(
        telemetry, TO_RECORD, stop, STOP, .station_ft = (float)summary->stop_station_ft.value,
        .station_error_ft = (float)summary->stop_station_ft.error,
        .after_touchdown_s = (float)(summary->stop_t_s.value - summary->touchdown_t_s.value),
        .switches = (uint8_t)summary->gate_count, .used = (uint8_t)summary->gates_used_for_stop);
}

void landinglink_send_changes(struct telemetry *telemetry, const struct landing *landing,
                              const struct landing_block_changes *changes, uint32_t index)
{
    for (unsigned i = 0; i < changes->edge_count; i++)
        TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, edge, EDGE, &landing->edge[i]);
    for (unsigned i = 0; i < changes->event_count; i++)
        TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, switch_event, SWITCH_EVENT,
                               &landing->event[i]);
    if (changes->has_new_pushback)
        report_pushback(telemetry, landing, index);
    if (changes->has_new_motion)
        landinglink_send_motion(telemetry, &landing->motion, index);
    if (changes->has_new_summary)
        landinglink_send_summary(telemetry, &landing->summary);
    if (changes->fit_status != MR_OK)
        health_count_fault(MR_FAULT_NO_FIT, (uint8_t)-changes->fit_status);
    if (changes->has_new_state)
        landinglink_send_state(telemetry, landing);
}

/* ---- live mode ---- */

enum mr_status live_begin(struct live *live, struct landing *landing,
                          const struct mr_command *command, uint32_t index)
{
    if (command->argument < 0 || command->argument > LIVE_MAX_S)
        return MR_USAGE;
    live->until_block = index + 1000u * (uint32_t)command->argument;
    landing->is_live = command->argument > 0;
    return MR_OK;
}

void live_on_block(struct live *live, struct landing *landing, struct telemetry *telemetry,
                   const struct mr_block *block)
{
    if (!landing->is_live)
        return;
    if ((int32_t)(block->index - live->until_block) >= 0)
        landing->is_live = false;
    else if (DUE(LIVE, block->index))
        landinglink_send_block(telemetry, block);
}

/* ---- regular messages ---- */

static void send_can_health(struct telemetry *telemetry)
{
    const struct canwatch *can = &telemetry->can;
    uint32_t dropped = (uint32_t)can->drop_count.queue_full + can->drop_count.bus_off +
                       can->drop_count.timeout;
    struct board_can_errors errors;
    board_can_get_errors(&errors);
    TELEMETRY_SEND(telemetry, TO_LINKS, can_health, CAN_HEALTH,
                   .sent = telemetry->can_sent - errors.removed_count,
                   .dropped = dropped > UINT16_MAX ? UINT16_MAX : (uint16_t)dropped,
                   .tec = errors.tec, .rec = errors.rec);
}

static void send_faults(struct telemetry *telemetry, bool all)
{
    for (unsigned fault = 0; fault < MR_FAULT_COUNT; fault++) {
        struct health_counter counter = health_get_counter((enum mr_fault_code)fault);
        if (counter.changed || (all && counter.count))
            TELEMETRY_SEND(telemetry, TO_RECORD, fault, FAULT, .code = (uint8_t)fault,
                           .detail = counter.detail, .count = counter.count,
                           .block = counter.block);
    }
}

/* Sends the count of one kind of message, so that the host knows which messages it lost, not only
 * how many frames. Each link gets a message with its own count; both counts are taken before either
 * message is sent. */
static void send_count(struct telemetry *telemetry)
{
    unsigned place = telemetry->count_index;
    uint16_t id = mr_message_id_at(place);
    TELEMETRY_SEND(telemetry, TO_CAN, message_count, MESSAGE_COUNT, .id = id,
                   .count = telemetry->sent_counts[TELEMETRY_CAN][place]);
    TELEMETRY_SEND(telemetry, TO_SERIAL, message_count, MESSAGE_COUNT, .id = id,
                   .count = telemetry->sent_counts[TELEMETRY_SERIAL][place]);
    telemetry->count_index = (place + 1) % MR_MESSAGE_COUNT;
}

void landinglink_send_regular(struct telemetry *telemetry, const struct landing *landing,
                              const float *slack_in, uint32_t index, uint32_t tick)
{
    if (DUE(CLOCK, index))
        TELEMETRY_SEND(telemetry, TO_LINKS, clock, CLOCK, .block = index, .tick = tick);
    if (DUE(HEALTH, index))
        TELEMETRY_SEND(telemetry, TO_LINKS, health, HEALTH, .faults = health_get_faults(),
                       .load_permille = board_load_permille(),
                       .blocks_lost = telemetry->blocks_lost);
    if (DUE(CAN_HEALTH, index))
        send_can_health(telemetry);
    if (DUE(SERIAL_HEALTH, index))
        TELEMETRY_SEND(telemetry, TO_LINKS, serial_health, SERIAL_HEALTH,
                       .sent = telemetry->serial_sent, .dropped = telemetry->serial_dropped,
                       .bad = telemetry->serial_refused_count);
    if (DUE(FAULTS, index))
        send_faults(telemetry, DUE(ALL_FAULTS, index));
    if (DUE(COUNT, index))
        send_count(telemetry);
    if (DUE(HELLO, index))
        configround_send_hello(telemetry, TO_LINKS, landing);
    if (DUE(STATE, index))
        landinglink_send_state(telemetry, landing);
    configround_on_block(telemetry, slack_in, index);
}
