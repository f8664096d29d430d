#include "firmware/bringup/pace.h"

#include "firmware/f407/drivers.h"

static uint32_t mhz = 16;

void pace_start(uint32_t hclk_mhz)
{
    mhz = hclk_mhz;
    SCB_DEMCR |= SCB_DEMCR_TRCENA;
    DWT_CTRL |= DWT_CTRL_CYCCNTENA;
}

uint32_t pace_hclk_mhz(void)
{
    return mhz;
}

bool pace_passed(uint32_t begun, uint32_t us)
{
    watchdog_feed();
    return pace_cycles(begun) / mhz >= us;
}

void pace_wait(uint32_t us)
{
    uint32_t begun = pace_begin();
    while (!pace_passed(begun, us)) {
    }
}
