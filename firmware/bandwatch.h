/* Supervises the bands on the board: passes the tensions of each message to common/bands.h and
 * reports its findings. */
#ifndef MATRIG_FIRMWARE_BANDWATCH_H
#define MATRIG_FIRMWARE_BANDWATCH_H

#include "common/bands.h"
#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

/* interval between computations of the wheel's position, which is extrapolated in between */
#define BANDWATCH_WHEEL_BLOCKS 64u

struct bandwatch {
    struct mr_bands bands;
    struct landing_wheel wheel; /* state of the wheel at block wheel_block */
    uint32_t wheel_block;
    bool is_wheel_known; /* the wheel's position has been determined since arming */
};

void bandwatch_arm(struct bandwatch *watch);
/* Processes the means of the four blocks up to `block`; while nothing is recorded, only the state
 * of the bands is reported. */
void bandwatch_on_tensions(struct bandwatch *watch, struct telemetry *telemetry,
                           const struct landing *landing, const float tension_lb[MR_GAGES],
                           const struct mr_block *block);
/* Call at the end of a landing: reports the figures of each band if the watch was armed. */
void bandwatch_end(struct bandwatch *watch, struct telemetry *telemetry);

#endif
