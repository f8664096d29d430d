#include "common/boardtime.h"

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
