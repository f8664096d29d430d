#include "common/boardtime.h"

static int64_t floor_divide(int64_t value, int64_t by)
{
    return value >= 0 ? value / by : -((-value + by - 1) / by);
}

uint32_t mr_boardtime_tick(uint32_t origin, uint32_t block)
{
    return origin + block * MR_TICKS_PER_BLOCK;
}

uint32_t mr_boardtime_origin(uint32_t block, uint32_t tick)
{
    return tick - block * MR_TICKS_PER_BLOCK;
}

int64_t mr_boardtime_ticks(uint32_t origin, uint32_t block, uint32_t tick)
{
    int32_t since = (int32_t)(tick - mr_boardtime_tick(origin, block));
    return (int64_t)block * (int64_t)MR_TICKS_PER_BLOCK + since;
}

int64_t mr_boardtime_us(int64_t ticks)
{
    return floor_divide(ticks + MR_TICKS_PER_US / 2, MR_TICKS_PER_US);
}

int64_t mr_boardtime_block(int64_t ticks)
{
    return floor_divide(ticks, (int64_t)MR_TICKS_PER_BLOCK);
}
