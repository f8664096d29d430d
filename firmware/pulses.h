/* Pulses from outside the board: frames of the camera, the brake, the wheel. A pulse less than a
 * millisecond after the previous one is noise: it is refused and counted. An input that is not
 * fitted is not captured. */
#ifndef MATRIG_FIRMWARE_PULSES_H
#define MATRIG_FIRMWARE_PULSES_H

#include "firmware/board.h"

/* maximum number of pulses processed per block: up to a thousand per second, even if 2 ms of blocks
 * are waiting */
#define PULSES_PER_BLOCK 8u

struct pulses {
    bool is_capturing;
    bool has_pulse;       /* there is an accepted pulse */
    uint32_t tick, block; /* last accepted pulse */
};

/* Captures the input while it is fitted, and processes the pulses up to a tick. Call in each block;
 * `index` is its number. Returns the number of accepted pulses. */
size_t pulses_get(struct pulses *pulses, enum board_pulse_input input, bool fitted, uint32_t index,
                  uint32_t until_tick, uint32_t ticks[PULSES_PER_BLOCK]);

#endif
