/* The schedule (schedule.def) as constants, for example SCHEDULE_CLOCK_PERIOD and
 * SCHEDULE_CLOCK_PHASE, and the predicate DUE(CLOCK, index). */
#ifndef MATRIG_FIRMWARE_SCHEDULE_H
#define MATRIG_FIRMWARE_SCHEDULE_H

#include <stdint.h>

#include "common/onboard/landing.h"
#include "common/onboard/predict_feed.h"

enum schedule_constants {
#define BLOCKS(NAME, period, phase, stalled, who, why) \
    SCHEDULE_##NAME##_PERIOD = (period), SCHEDULE_##NAME##_PHASE = (phase),
#include "firmware/schedule.def"
};

#define BLOCKS(NAME, period, phase, stalled, who, why) \
    _Static_assert((phase) < (period), #NAME " is never due");
#include "firmware/schedule.def"

/* True if the row NAME is due in this block or tick. */
#define DUE(NAME, index) \
    ((index) % (uint32_t)SCHEDULE_##NAME##_PERIOD == (uint32_t)SCHEDULE_##NAME##_PHASE)
/* Blocks until the row NAME is due; 0: it is due in this block. */
#define BLOCKS_UNTIL(NAME, index)                                              \
    (((uint32_t)SCHEDULE_##NAME##_PHASE + (uint32_t)SCHEDULE_##NAME##_PERIOD - \
      (index) % (uint32_t)SCHEDULE_##NAME##_PERIOD) %                          \
     (uint32_t)SCHEDULE_##NAME##_PERIOD)

/* number of phases of the round that replaces blocks without scans; a multiple of the periods in
 * it */
#define SCHEDULE_ROUND 1000u

#endif
