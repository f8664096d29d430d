#include "common/onboard/baseline.h"

#include "common/wire.h"

static void begin_group(struct baseline *baseline)
{
    baseline->blocks = 0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        baseline->sum_in[i] = 0.0f;
}

void baseline_forget(struct baseline *baseline)
{
    begin_group(baseline);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        baseline->in[i] = MR_NAN;
}

void baseline_follow(struct baseline *baseline, const float *displacement_in, bool quiet,
                     uint32_t held)
{
    if (!quiet) {
        begin_group(baseline);
        return;
    }
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        baseline->sum_in[i] += displacement_in[i];
    if (++baseline->blocks < BASELINE_BLOCKS)
        return;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        baseline->in[i] = held >> i & 1u ? baseline->in[i]
                                         : baseline->sum_in[i] / (float)BASELINE_BLOCKS;
    begin_group(baseline);
}
