/* The zero of a landing's movement: while it is armed and nothing rolls, the mean of each full
 * group of blocks; the newest one before the first edge stands. Where no switch works, there is
 * none: what has moved is held (predict_feed.h). Pure. */
#ifndef MATRIG_COMMON_ONBOARD_BASELINE_H
#define MATRIG_COMMON_ONBOARD_BASELINE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"

#define BASELINE_BLOCKS 256u

struct baseline {
    float sum_in[MR_TRANSDUCERS];
    unsigned blocks;
    float in[MR_TRANSDUCERS]; /* NaN until BASELINE_BLOCKS have passed since arming */
};

void baseline_forget(struct baseline *baseline);
/* A block's readings; NaN: missing. Not `quiet`: the group that was being summed ends with
 * something that may move the mat. Transducers of the bits `held` keep the zero they have. */
void baseline_follow(struct baseline *baseline, const float *displacement_in, bool quiet,
                     uint32_t held);

#endif
