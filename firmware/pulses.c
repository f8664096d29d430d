#include "firmware/pulses.h"

#include "firmware/health.h"

#define INTERVAL_MIN_TICKS MR_TICKS_PER_BLOCK /* shortest allowed time between two pulses: 1 ms */
#define COMPARABLE_BLOCKS  1000u              /* ticks can be compared within 25 s */
#define DETAIL_TOO_FAST    2u                 /* detail of the fault: pulses too close together */

size_t pulses_get(struct pulses *pulses, enum board_pulse_input input, bool fitted, uint32_t index,
                  uint32_t until_tick, uint32_t ticks[PULSES_PER_BLOCK])
{
    size_t accepted = 0, count = 0;
    if (fitted != pulses->is_capturing)
        board_pulses_enable(input, fitted);
    pulses->is_capturing = fitted;
    if (fitted)
        count = board_pulses_get(input, until_tick, ticks, PULSES_PER_BLOCK);
    for (size_t i = 0; i < count; i++) {
        /* Captures that overran each other may be out of order; one before the last pulse is noise
         * too. */
        if (pulses->has_pulse && index - pulses->block < COMPARABLE_BLOCKS &&
            (int32_t)(ticks[i] - pulses->tick) < (int32_t)INTERVAL_MIN_TICKS) {
            health_count_fault(MR_FAULT_EDGE_OVERRUN, DETAIL_TOO_FAST);
            continue;
        }
        *pulses = (struct pulses){true, true, ticks[i], index};
        ticks[accepted++] = ticks[i];
    }
    return accepted;
}
