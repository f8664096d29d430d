#include "firmware/braking.h"

#include "firmware/config.h"

void braking_arm(struct braking *braking)
{
    braking->pulse_count = 0;
}

static void report_pulses(struct telemetry *telemetry, uint16_t number, uint32_t tick,
                          uint32_t index)
{
    TELEMETRY_SEND(telemetry, TO_RECORD, braking_edge, BRAKING_EDGE, .number = number, .tick = tick,
                   .block16 = (uint16_t)index);
}

void braking_process_block(struct braking *braking, struct telemetry *telemetry,
                           struct landing *landing, uint32_t index, uint32_t until_tick)
{
    bool recording = landing_is_recording(landing);
    uint32_t ticks[PULSES_PER_BLOCK];
    size_t count = pulses_get(&braking->brake, BOARD_BRAKE_PULSES, config.site[0].brake_edge, index,
                              until_tick, ticks);
    for (size_t i = 0; i < count && recording; i++) {
        landing_set_brake(landing, ticks[i]);
        report_pulses(telemetry, 0, ticks[i], index);
    }
    count = pulses_get(&braking->wheel, BOARD_WHEEL_PULSES, config.site[0].wheel_pulses, index,
                       until_tick, ticks);
    for (size_t i = 0; i < count && recording && braking->pulse_count < UINT16_MAX; i++)
        report_pulses(telemetry, ++braking->pulse_count, ticks[i], index);
}
