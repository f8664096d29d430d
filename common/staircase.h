/* The switch staircase identifies the switch that caused an edge (report 2.7.1: each switch that
 * opens adds a voltage to one circuit).
 *
 * Switches latch open, and each adds a step of different size, so the levels before and after an
 * edge identify the switch. The level is the mean code of the staircase channel in a block. With
 * four blocks on each side, the step is accurate to half a code (noise of 2 codes per conversion);
 * steps differ by at least 8 codes. Pure, no heap. */
#ifndef MATRIG_COMMON_STAIRCASE_H
#define MATRIG_COMMON_STAIRCASE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

#define MR_STAIRCASE_HISTORY_BLOCKS  16u    /* number of blocks in the history */
#define MR_STAIRCASE_SIDE_BLOCKS     4u     /* number of blocks averaged on each side of an edge */
#define MR_STAIRCASE_SETTLE_TICKS    25200u /* 0.3 ms until the level has settled after an edge */
/* half the distance of steps that are set by design values; the nearest step is selected */
#define MR_STAIRCASE_TOLERANCE_CODES 4.0f

struct mr_staircase {
    uint32_t tick[MR_STAIRCASE_HISTORY_BLOCKS]; /* first trigger of the block, 1/84 us */
    float code[MR_STAIRCASE_HISTORY_BLOCKS];    /* mean code of the block */
    /* blocks seen; the newest is at (count - 1) % MR_STAIRCASE_HISTORY_BLOCKS */
    uint32_t count;
};

void mr_staircase_init(struct mr_staircase *staircase);
/* Adds the next block. */
void mr_staircase_add(struct mr_staircase *staircase, uint32_t tick, float code);

/* Step of the level at an edge, in codes. MR_OK; MR_TOO_FEW: fewer than MR_STAIRCASE_SIDE_BLOCKS
 * blocks after the edge so far, so call again after the next block; MR_NUMERICS: no block from
 * before the edge is kept, or the level on one side is not steady because another edge is too near;
 * the step could then identify a wrong switch. */
enum mr_status mr_staircase_find_step(const struct mr_staircase *staircase, uint32_t edge_tick,
                                      float *step_codes);

/* Level before an edge, in codes; false: unknown or not steady. Call when the edge occurs, because
 * the history is short. */
bool mr_staircase_level_before(const struct mr_staircase *staircase, uint32_t edge_tick,
                               float *codes);

/* Level after an edge, in codes. Errors as mr_staircase_find_step. */
enum mr_status mr_staircase_level_after(const struct mr_staircase *staircase, uint32_t edge_tick,
                                        float *codes);

/* Position (from 1) of the switch with the nearest step among those not yet in `opened` (bit p-1);
 * 0 if no step is within MR_STAIRCASE_TOLERANCE_CODES. `count` is at most 32. */
unsigned mr_staircase_identify(float step_codes, const uint16_t *steps_codes, unsigned count,
                               uint32_t opened);

#endif
