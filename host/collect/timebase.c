#include "host/collect/timebase.h"

#include <math.h>

#include "common/block.h"

#define RESTART_MIN_BLOCKS     1000
/* Clock messages arrive every 100 blocks. The limit must be below RESTART_MIN_BLOCKS; otherwise a
 * block of another node could be mistaken for a restart. */
#define CLOCK_STEP_MAX_BLOCKS  500
/* Block records and messages can overtake each other in the board's serial queues by this much. */
#define REORDERING_MAX_BLOCKS  100
/* 0.1 ms; the tick at block 0 is constant while the board runs */
#define ORIGIN_TOLERANCE_TICKS 8400

bool timebase_apply_block(struct timebase *timebase, uint32_t block)
{
    if (timebase->is_block_known && (int64_t)block + RESTART_MIN_BLOCKS < timebase->newest_block)
        return true;
    if (!timebase->is_block_known || block > timebase->newest_block)
        timebase->newest_block = block;
    timebase->is_block_known = true;
    return false;
}

bool timebase_apply_clock(struct timebase *timebase, uint32_t block, uint32_t tick)
{
    if (timebase_apply_block(timebase, block))
        return true;
    timebase->is_tick_known = true;
    timebase->newest_clock_block = block;
    timebase->origin = mr_boardtime_origin_tick(block, tick);
    return false;
}

bool timebase_is_restart(const struct timebase *timebase, uint32_t block)
{
    return timebase->is_block_known &&
           (int64_t)block + REORDERING_MAX_BLOCKS < timebase->newest_block;
}

static bool has_same_origin(uint32_t a, uint32_t b)
{
    int32_t apart = (int32_t)(a - b);
    return apart > -ORIGIN_TOLERANCE_TICKS && apart < ORIGIN_TOLERANCE_TICKS;
}

enum timebase_result timebase_check_clock(struct timebase *timebase,
                                          struct timebase_candidate *doubt, uint32_t block,
                                          uint32_t tick, bool hello)
{
    uint32_t origin = mr_boardtime_origin_tick(block, tick);
    bool first = !timebase->is_block_known || !timebase->is_tick_known;
    int64_t least = hello ? timebase->newest_clock_block
                          : timebase->newest_block - RESTART_MIN_BLOCKS;
    bool goes_on = has_same_origin(origin, timebase->origin) && (int64_t)block >= least;
    bool confirms = doubt->is_pending && has_same_origin(origin, doubt->origin) &&
                    block > doubt->block;
    if (first || goes_on || confirms) {
        bool back = hello && !first && !goes_on &&
                    (int64_t)doubt->block < timebase->newest_clock_block;
        doubt->is_pending = false;
        if (back)
            return TIMEBASE_RESTARTED;
        return timebase_apply_clock(timebase, block, tick) ? TIMEBASE_RESTARTED
                                                           : TIMEBASE_CONTINUES;
    }
    doubt->is_pending = true;
    doubt->block = block;
    doubt->origin = origin;
    return TIMEBASE_UNCONFIRMED;
}

int64_t timebase_unwrap(struct timebase *timebase, uint16_t block16)
{
    if (!timebase->is_block_known)
        return -1;
    int64_t block = timebase->newest_block +
                    (int16_t)(uint16_t)(block16 - (uint16_t)timebase->newest_block);
    if (block < 0)
        return -1;
    if (block > timebase->newest_block && block - timebase->newest_block < CLOCK_STEP_MAX_BLOCKS)
        timebase->newest_block = block;
    return block;
}

int64_t timebase_now_us(const struct timebase *timebase)
{
    return timebase->is_block_known ? 1000 * timebase->newest_block : -1;
}

double timebase_tick_to_us(const struct timebase *timebase, uint32_t tick)
{
    int64_t ticks = mr_boardtime_unwrap(timebase->origin, (uint32_t)timebase->newest_block, tick);
    return timebase->is_tick_known ? (double)ticks / MR_TICKS_PER_US : (double)NAN;
}
