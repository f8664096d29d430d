#include "common/staircase.h"

#include <stdbool.h>

#include "common/block.h"

void mr_staircase_init(struct mr_staircase *staircase)
{
    staircase->count = 0;
}

void mr_staircase_add(struct mr_staircase *staircase, uint32_t tick, float code)
{
    uint32_t at = staircase->count++ % MR_STAIRCASE_HISTORY;
    staircase->tick[at] = tick;
    staircase->code[at] = code;
}

/* Mean and spread of the levels of one side of an edge. */
struct side {
    float sum, least, most;
    unsigned count;
};

static void take(struct side *side, float code)
{
    if (side->count == 0 || code < side->least)
        side->least = code;
    if (side->count == 0 || code > side->most)
        side->most = code;
    side->sum += code;
    side->count++;
}

static bool steady(const struct side *side)
{
    return side->most - side->least < 2.0f * MR_STAIRCASE_TOLERANCE_CODES;
}

enum mr_status mr_staircase_step(const struct mr_staircase *staircase, uint32_t edge_tick, float *step_codes)
{
    struct side before = {0}, after = {0};
    unsigned after_count = 0;
    uint32_t known = staircase->count < MR_STAIRCASE_HISTORY ? staircase->count : MR_STAIRCASE_HISTORY;

    /* From the newest block back: first those after the edge (the earliest four count), then those before it. */
    for (uint32_t age = 0; age < known && before.count < MR_STAIRCASE_SIDE; age++) {
        uint32_t at = (staircase->count - 1 - age) % MR_STAIRCASE_HISTORY;
        int32_t after_edge = (int32_t)(staircase->tick[at] - edge_tick);
        if (after_edge >= (int32_t)MR_STAIRCASE_SETTLE_TICKS) {
            after_count++;
        } else if (after_edge + (int32_t)MR_TICKS_PER_BLOCK <= 0) {
            take(&before, staircase->code[at]);
        }
    }
    if (after_count < MR_STAIRCASE_SIDE)
        return MR_TOO_FEW;
    if (before.count == 0)
        return MR_NUMERICS;
    for (uint32_t age = after_count - MR_STAIRCASE_SIDE; age < after_count; age++)
        take(&after, staircase->code[(staircase->count - 1 - age) % MR_STAIRCASE_HISTORY]);
    if (!steady(&before) || !steady(&after))
        return MR_NUMERICS;
    *step_codes = after.sum / (float)after.count - before.sum / (float)before.count;
    return MR_OK;
}

unsigned mr_staircase_name(float step_codes, const uint16_t *steps_codes, unsigned count, uint32_t opened)
{
    float nearest = MR_STAIRCASE_TOLERANCE_CODES;
    unsigned position = 0;
    for (unsigned i = 0; i < count; i++) {
        float distance = step_codes - (float)steps_codes[i];
        if (distance < 0.0f)
            distance = -distance;
        if (!(opened & 1u << i) && distance < nearest) {
            nearest = distance;
            position = i + 1;
        }
    }
    return position;
}
