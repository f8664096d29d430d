#include "firmware/schedule.h"

bool schedule_due_without_scans(uint32_t phase)
{
    bool due = false;
#define BLOCKS(NAME, period, phase_, stalled, who, why) due |= (stalled) && DUE(NAME, phase);
#define TICKS(NAME, period, phase_, who, why)
#include "firmware/schedule.def"
    return due;
}

#define BLOCKS(NAME, period, phase, stalled, who, why)           \
    _Static_assert(!(stalled) || SCHEDULE_ROUND % (period) == 0, \
                   #NAME " does not go into a round without scans");
#include "firmware/schedule.def"

/* What goes with another row: its blocks are among those of that one. */
#define WITHIN(NAME, OTHER)                                                     \
    _Static_assert(SCHEDULE_##NAME##_PERIOD % SCHEDULE_##OTHER##_PERIOD == 0 && \
                       SCHEDULE_##NAME##_PHASE % SCHEDULE_##OTHER##_PERIOD ==   \
                           SCHEDULE_##OTHER##_PHASE,                            \
                   #NAME " without " #OTHER)
WITHIN(BANDS, TENSIONS);
WITHIN(BANDS_IDLE, TENSIONS_IDLE);
WITHIN(SAY, LOOK);
WITHIN(ALL_FAULTS, FAULTS);
