/* Time sync over CAN, in two steps: once a second a sync frame, and 10 ms later what the board's
 * clock was when that frame had left. However long the frame waited for the bus, whoever noted when
 * it came has a pair of times. */
#ifndef MATRIG_FIRMWARE_TIMESYNC_H
#define MATRIG_FIRMWARE_TIMESYNC_H

#include "firmware/telemetry.h"

struct timesync {
    bool due;       /* sync_at is still to follow */
    uint32_t block; /* of the sync frame */
};

/* Each block, before anything else is said of it: the queue is as empty as it gets. */
void timesync_block(struct timesync *timesync, struct telemetry *telemetry, uint32_t index,
                    uint32_t tick);

#endif
