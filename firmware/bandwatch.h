/* The bands on the board: feeds common/bands.h with each message's tensions and reports its
 * findings. */
#ifndef MATRIG_FIRMWARE_BANDWATCH_H
#define MATRIG_FIRMWARE_BANDWATCH_H

#include "common/bands.h"
#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

/* between two looks at where the wheel is; in between it rolls on */
#define BANDWATCH_WHEEL_BLOCKS 64u

struct bandwatch {
    struct mr_bands bands;
    struct landing_wheel wheel; /* at wheel_block */
    uint32_t wheel_block;
    bool wheel_known; /* looked for since arming */
};

void bandwatch_arm(struct bandwatch *watch);
/* Means of the four blocks up to `block`; while nothing is recorded, only their state is
 * reported. */
void bandwatch_tensions(struct bandwatch *watch, struct telemetry *telemetry,
                        const struct landing *landing, const float tension_lb[MR_GAGES],
                        const struct mr_block *block);
/* The landing ends: reports the figures of each band, if it was armed. */
void bandwatch_end(struct bandwatch *watch, struct telemetry *telemetry);

#endif
