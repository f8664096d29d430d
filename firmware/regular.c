#include "firmware/regular.h"

#include "firmware/health.h"
#include "firmware/landinglink.h"
#include "firmware/schedule.h"

static void send_can_health(struct telemetry *telemetry)
{
    const struct canwatch *can = &telemetry->can;
    uint32_t dropped = (uint32_t)can->drops.queue_full + can->drops.bus_off + can->drops.timeout;
    struct board_can_errors errors;
    board_can_state(&errors);
    TELL(telemetry, TO_LINKS, can_health, CAN_HEALTH, .sent = telemetry->can_sent - errors.removed,
         .dropped = dropped > UINT16_MAX ? UINT16_MAX : (uint16_t)dropped, .tec = errors.tec,
         .rec = errors.rec);
}

static void send_faults(struct telemetry *telemetry, bool all)
{
    for (unsigned fault = 0; fault < MR_FAULT_COUNT; fault++) {
        struct health_counter counter = health_take((enum mr_fault_code)fault);
        if (counter.changed || (all && counter.count))
            TELL(telemetry, TO_RECORD, fault, FAULT, .code = (uint8_t)fault,
                 .detail = counter.detail, .count = counter.count, .block = counter.block);
    }
}

/* By these counts the host knows which messages it lost, not only how many frames. Always as many,
 * whatever was said: each link has its own, as they stand before either is told. */
static void send_count(struct telemetry *telemetry)
{
    unsigned place = telemetry->count_place;
    uint16_t id = mr_message_at(place);
    TELL(telemetry, TO_CAN, message_count, MESSAGE_COUNT, .id = id,
         .count = telemetry->said[TELEMETRY_CAN][place]);
    TELL(telemetry, TO_SERIAL, message_count, MESSAGE_COUNT, .id = id,
         .count = telemetry->said[TELEMETRY_SERIAL][place]);
    telemetry->count_place = (place + 1) % MR_PLACES;
}

void regular_block(struct telemetry *telemetry, const struct landing *landing,
                   const float *slack_in, uint32_t index, uint32_t tick)
{
    if (DUE(CLOCK, index))
        TELL(telemetry, TO_LINKS, clock, CLOCK, .block = index, .tick = tick);
    if (DUE(HEALTH, index))
        TELL(telemetry, TO_LINKS, health, HEALTH, .faults = health_faults(),
             .load_permille = board_load_permille(), .blocks_lost = telemetry->blocks_lost);
    if (DUE(CAN_HEALTH, index))
        send_can_health(telemetry);
    if (DUE(SERIAL_HEALTH, index))
        TELL(telemetry, TO_LINKS, serial_health, SERIAL_HEALTH, .sent = telemetry->serial_sent,
             .dropped = telemetry->serial_dropped, .bad = telemetry->serial_bad);
    if (DUE(FAULTS, index))
        send_faults(telemetry, DUE(ALL_FAULTS, index));
    if (DUE(COUNT, index))
        send_count(telemetry);
    if (DUE(HELLO, index))
        configround_hello(telemetry, TO_LINKS, landing);
    if (DUE(STATE, index))
        landinglink_state(telemetry, landing);
    configround_block(telemetry, slack_in, index);
}
