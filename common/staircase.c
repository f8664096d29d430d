#include "common/staircase.h"

#include <stdbool.h>

#include "common/block.h"

void mr_staircase_init(struct mr_staircase *staircase)
{
    staircase->block_count = 0;
}

void mr_staircase_add(struct mr_staircase *staircase, uint32_t tick, float code)
{
    uint32_t at = staircase->block_count++ % MR_STAIRCASE_HISTORY_BLOCKS;
    staircase->tick[at] = tick;
    staircase->code[at] = code;
}

/* Sum and range of the levels (mean codes) on one side of an edge. */
struct level_mean {
    float sum, min, max;
    unsigned count;
};

static void add_level(struct level_mean *levels, float code)
{
    if (levels->count == 0 || code < levels->min)
        levels->min = code;
    if (levels->count == 0 || code > levels->max)
        levels->max = code;
    levels->sum += code;
    levels->count++;
}

static bool is_level_steady(const struct level_mean *levels)
{
    return levels->max - levels->min < 2.0f * MR_STAIRCASE_TOLERANCE_CODES;
}

/* Number of blocks in the history. */
static uint32_t get_history_length(const struct mr_staircase *staircase)
{
    return staircase->block_count < MR_STAIRCASE_HISTORY_BLOCKS ? staircase->block_count
                                                                : MR_STAIRCASE_HISTORY_BLOCKS;
}

static uint32_t get_history_index(const struct mr_staircase *staircase, uint32_t age)
{
    return (staircase->block_count - 1 - age) % MR_STAIRCASE_HISTORY_BLOCKS;
}

bool mr_staircase_level_before(const struct mr_staircase *staircase, uint32_t edge_tick,
                               float *codes)
{
    struct level_mean before = {0};
    for (uint32_t age = 0;
         age < get_history_length(staircase) && before.count < MR_STAIRCASE_SIDE_BLOCKS; age++) {
        uint32_t at = get_history_index(staircase, age);
        if ((int32_t)(staircase->tick[at] + MR_TICKS_PER_BLOCK - edge_tick) <= 0)
            add_level(&before, staircase->code[at]);
    }
    if (before.count == 0 || !is_level_steady(&before))
        return false;
    *codes = before.sum / (float)before.count;
    return true;
}

enum mr_status mr_staircase_level_after(const struct mr_staircase *staircase, uint32_t edge_tick,
                                        float *codes)
{
    struct level_mean after = {0};
    uint32_t count = 0;
    while (count < get_history_length(staircase) &&
           (int32_t)(staircase->tick[get_history_index(staircase, count)] - edge_tick) >=
               (int32_t)MR_STAIRCASE_SETTLE_TICKS)
        count++;
    if (count < MR_STAIRCASE_SIDE_BLOCKS)
        return MR_TOO_FEW;
    /* Use the earliest MR_STAIRCASE_SIDE_BLOCKS blocks after the edge. */
    for (uint32_t age = count - MR_STAIRCASE_SIDE_BLOCKS; age < count; age++)
        add_level(&after, staircase->code[get_history_index(staircase, age)]);
    if (!is_level_steady(&after))
        return MR_NUMERICS;
    *codes = after.sum / (float)after.count;
    return MR_OK;
}

enum mr_status mr_staircase_find_step(const struct mr_staircase *staircase, uint32_t edge_tick,
                                      float *step_codes)
{
    float before, after;
    enum mr_status status = mr_staircase_level_after(staircase, edge_tick, &after);
    if (status != MR_OK)
        return status;
    if (!mr_staircase_level_before(staircase, edge_tick, &before))
        return MR_NUMERICS;
    *step_codes = after - before;
    return MR_OK;
}

unsigned mr_staircase_identify(float step_codes, const uint16_t *steps_codes, unsigned count,
                               uint32_t opened)
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
