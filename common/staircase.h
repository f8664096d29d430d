/* The switch staircase identifies the switch that caused an edge (report 2.7.1: each switch that
 * opens adds a voltage to one circuit).
 *
 * A switch stays open once it has opened, and each adds a step of a different size, so the levels
 * before and after an edge identify the switch. The level is the mean code of the staircase channel
 * in a block. With four blocks on each side, the step is accurate to half a code (noise of 2 codes
 * per conversion); steps differ by at least 8 codes. Pure, no heap. */
#ifndef MATRIG_COMMON_STAIRCASE_H
#define MATRIG_COMMON_STAIRCASE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

#define MR_STAIRCASE_HISTORY_BLOCKS  16u    /* number of blocks in the history */
#define MR_STAIRCASE_SIDE_BLOCKS     4u     /* number of blocks averaged on each side of an edge */
#define MR_STAIRCASE_SETTLE_TICKS    25200u /* 0.3 ms, in which the level settles after an edge */
/* Largest difference between a measured step and that of a switch: half the distance between two
 * designed steps. The nearest step is selected. */
#define MR_STAIRCASE_TOLERANCE_CODES 4.0f

struct mr_staircase {
    /* tick of the first trigger of each block, 1/84 us */
    uint32_t tick[MR_STAIRCASE_HISTORY_BLOCKS];
    float code[MR_STAIRCASE_HISTORY_BLOCKS]; /* mean code of the block */
    /* number of blocks added; the newest is at (block_count - 1) % MR_STAIRCASE_HISTORY_BLOCKS */
    uint32_t block_count;
};

void mr_staircase_init(struct mr_staircase *staircase);
/* Adds the next block. */
void mr_staircase_add(struct mr_staircase *staircase, uint32_t tick, float code);

/* Step of the level at an edge, in codes. MR_TOO_FEW: fewer than MR_STAIRCASE_SIDE_BLOCKS blocks
 * after the edge so far; call again after the next block. MR_NUMERICS: the history no longer has a
 * block before the edge, or the level on one side is not steady because of another edge, so that
 * the step could belong to a wrong switch. */
enum mr_status mr_staircase_find_step(const struct mr_staircase *staircase, uint32_t edge_tick,
                                      float *step_codes);

/* Level before an edge, in codes; false: unknown or not steady. Call when the edge occurs, because
 * the history is short. */
bool mr_staircase_level_before(const struct mr_staircase *staircase, uint32_t edge_tick,
                               float *codes);

/* Level after an edge, in codes. Errors as mr_staircase_find_step. */
enum mr_status mr_staircase_level_after(const struct mr_staircase *staircase, uint32_t edge_tick,
                                        float *codes);

/* Returns the position (from 1) of the switch with the nearest step, among those that have not
 * opened yet (bit p-1 of `opened` is 0); 0 if no step is within MR_STAIRCASE_TOLERANCE_CODES.
 * `count` is at most 32. */
unsigned mr_staircase_identify(float step_codes, const uint16_t *steps_codes, unsigned count,
                               uint32_t opened);

#endif
