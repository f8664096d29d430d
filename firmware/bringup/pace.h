/* Time by the core's cycle counter, which goes as long as the core does: bounds of all waits here.
 * It wraps after 25 s at 168 MHz. PM0214 has no DWT; ARMv7-M C1.8. */
#ifndef MATRIG_FIRMWARE_BRINGUP_PACE_H
#define MATRIG_FIRMWARE_BRINGUP_PACE_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/f407/regs.h"

/* Starts the counter. `hclk_mhz`: what it counts. */
void pace_start(uint32_t hclk_mhz);
uint32_t pace_hclk_mhz(void);

static inline uint32_t pace_begin(void)
{
    return DWT_CYCCNT;
}
static inline uint32_t pace_cycles(uint32_t begun)
{
    return DWT_CYCCNT - begun;
}
/* So many microseconds have passed, 20 s at most. Feeds the watchdog. */
bool pace_passed(uint32_t begun, uint32_t us);
void pace_wait(uint32_t us);

#endif
