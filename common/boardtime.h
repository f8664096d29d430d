/* Board time in 64 bits: every moment the board tells of is ticks of its one clock (TIM2, 84 MHz)
 * since the scans began.
 *
 * Samples: block b begins, with its first trigger, at 84000 b ticks, which is 1000 b microseconds.
 * Edges, film frames, camera pulses and sync frames are told as TIM2 captured them, modulo 2^32,
 * which comes round every 51.1 s. The block that a capture is told with says which round it was:
 * block indices count milliseconds for 49 days, and the tick at which block 0 began, the origin, is
 * the same for all of them. So no gap of blocks, however long, makes a capture ambiguous, as long
 * as the block it is told with is less than 25.5 s from it. Exact integers; pure. */
#ifndef MATRIG_COMMON_BOARDTIME_H
#define MATRIG_COMMON_BOARDTIME_H

#include <stdint.h>

#include "common/block.h"

#define MR_TICKS_PER_US 84

/* TIM2, modulo 2^32, at the beginning of block 0, from any block's index and first tick. */
uint32_t mr_boardtime_origin(uint32_t block, uint32_t tick);
/* TIM2, modulo 2^32, at the beginning of a block. */
uint32_t mr_boardtime_tick(uint32_t origin, uint32_t block);
/* Ticks since the scans began of a capture less than 25.5 s from the beginning of `block`;
 * negative: before them. */
int64_t mr_boardtime_ticks(uint32_t origin, uint32_t block, uint32_t tick);

#endif
