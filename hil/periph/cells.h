/* Memory cells that take their time: how long an operation lasts, and what is left of one that was
 * cut short. */
#ifndef MATRIG_HIL_CELLS_H
#define MATRIG_HIL_CELLS_H

#include <stddef.h>
#include <stdint.h>

#include "common/splitmix.h"

/* Where in the range of its data sheet the duration of a flash or NOR operation lies. */
enum hil_cell_times {
    HIL_TIMES_SPREAD, /* drawn: mostly near typical, at times up to the maximum */
    HIL_TIMES_TYPICAL,
    HIL_TIMES_MAXIMUM,
};

/* Next number of a seeded sequence (splitmix64). */
static inline uint64_t hil_random(uint64_t *state)
{
    return mr_splitmix64(state);
}

/* Duration of one operation in picoseconds. Spread: typical + (maximum - typical) u^8, u uniform
 * from 0 to 1. */
uint64_t hil_cell_time_ps(enum hil_cell_times times, uint32_t typical_us, uint32_t maximum_us,
                          uint64_t *random);

/* What an operation leaves that was to turn the n bytes of `cells` into `wanted` (or all into 0xff:
 * NULL) and was cut off after `permille` of its time: each bit that was to change has changed with
 * that probability, independently. At 1000 all have, at 0 none. */
void hil_cells_tear(uint8_t *cells, const uint8_t *wanted, size_t n, unsigned permille,
                    uint64_t *random);

#endif
