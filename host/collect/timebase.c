#include "host/collect/timebase.h"

#include <math.h>

#include "common/boardtime.h"

#define RESTART_BLOCKS 1000

bool timebase_block(struct timebase *timebase, uint32_t block)
{
    if (timebase->known && (int64_t)block + RESTART_BLOCKS < timebase->block)
        return true;
    if (!timebase->known || block > timebase->block)
        timebase->block = block;
    timebase->known = true;
    return false;
}

bool timebase_clock(struct timebase *timebase, uint32_t block, uint32_t tick)
{
    if (timebase_block(timebase, block))
        return true;
    timebase->tick_known = true;
    timebase->origin = mr_boardtime_origin(block, tick);
    return false;
}

int64_t timebase_unwrap(struct timebase *timebase, uint16_t block16)
{
    if (!timebase->known)
        return -1;
    int64_t block = timebase->block + (int16_t)(uint16_t)(block16 - (uint16_t)timebase->block);
    if (block < 0)
        return -1;
    if (block > timebase->block)
        timebase->block = block;
    return block;
}

int64_t timebase_now_us(const struct timebase *timebase)
{
    return timebase->known ? 1000 * timebase->block : -1;
}

int64_t timebase_ticks(const struct timebase *timebase, uint32_t tick)
{
    return mr_boardtime_ticks(timebase->origin, (uint32_t)timebase->block, tick);
}

double timebase_tick_us(const struct timebase *timebase, uint32_t tick)
{
    return timebase->tick_known ? (double)timebase_ticks(timebase, tick) / MR_TICKS_PER_US : (double)NAN;
}
