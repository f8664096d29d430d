/* The switch staircase: which switch made an edge (report 2.7.1: each switch that opens adds a
 * voltage to one circuit).
 *
 * Switches latch open and each adds its own step, so the level before and after an edge names it.
 * The level is the mean code of the staircase channel per block; four blocks on each side make the
 * step good to half a code (noise of 2 codes a conversion), and steps differ by at least 8 codes.
 * Pure, no heap. */
#ifndef MATRIG_COMMON_STAIRCASE_H
#define MATRIG_COMMON_STAIRCASE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

#define MR_STAIRCASE_HISTORY      16u    /* blocks remembered */
#define MR_STAIRCASE_SIDE         4u     /* blocks averaged on each side of an edge */
#define MR_STAIRCASE_SETTLE_TICKS 25200u /* 0.3 ms after an edge the level has settled */
#define MR_STAIRCASE_TOLERANCE_CODES \
    4.0f /* half the difference of two steps that are built to a value; the nearest is named */

struct mr_staircase {
    uint32_t tick[MR_STAIRCASE_HISTORY]; /* first trigger of the block, 1/84 us */
    float code[MR_STAIRCASE_HISTORY];    /* mean code */
    /* blocks seen; the newest is at (count - 1) % MR_STAIRCASE_HISTORY */
    uint32_t count;
};

void mr_staircase_init(struct mr_staircase *staircase);
/* Give the next block. */
void mr_staircase_add(struct mr_staircase *staircase, uint32_t tick, float code);

/* Step of the level at an edge, in codes. MR_OK; MR_TOO_FEW: fewer than MR_STAIRCASE_SIDE blocks
 * after it so far, ask again after the next block; MR_NUMERICS: no block before it is remembered,
 * or the level on one side is not steady (another edge is too near), so that the step would be of
 * no switch or, worse, of a wrong one. */
enum mr_status mr_staircase_step(const struct mr_staircase *staircase, uint32_t edge_tick,
                                 float *step_codes);

/* Level before an edge, in codes; false: not known or not steady. To be asked when the edge comes:
 * it is forgotten. */
bool mr_staircase_before(const struct mr_staircase *staircase, uint32_t edge_tick, float *codes);

/* Level after an edge. Errors as mr_staircase_step. */
enum mr_status mr_staircase_after(const struct mr_staircase *staircase, uint32_t edge_tick,
                                  float *codes);

/* Position (from 1) of the switch not yet in `opened` (bit p-1) whose step is nearest, 0 when none
 * is within MR_STAIRCASE_TOLERANCE_CODES. `count` at most 32. */
unsigned mr_staircase_name(float step_codes, const uint16_t *steps_codes, unsigned count,
                           uint32_t opened);

#endif
