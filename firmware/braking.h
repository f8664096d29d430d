/* The signal "brake applied" and the pick-up of wheel speed. While a landing is recorded, the board
 * reports each edge of the brake signal and each pulse of the pick-up.
 *
 * At most 16 pulses per revolution keep a wheel at 46 ft/s below 500 pulses per second: 6 % of the
 * CAN bus. With site.brake_edge and site.wheel_pulses 0 nothing is captured or sent. */
#ifndef MATRIG_FIRMWARE_BRAKING_H
#define MATRIG_FIRMWARE_BRAKING_H

#include "common/onboard/landing.h"
#include "firmware/pulses.h"
#include "firmware/telemetry.h"

struct braking {
    struct pulses brake, wheel;
    uint16_t pulse_count; /* number of wheel pulses since arming */
};

/* Call when a landing is armed. */
void braking_arm(struct braking *braking);
/* Call in each block, after landing_on_block. `until_tick`: captures up to this tick belong to the
 * block. */
void braking_process_block(struct braking *braking, struct telemetry *telemetry,
                           struct landing *landing, uint32_t index, uint32_t until_tick);

#endif
