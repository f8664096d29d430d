/* Power control, and what it and the wait states of flash allow as clock. */
#include "hil/core/core.h"
#include "hil/periph/rcc.h"

#define ACR_LATENCY 7u
#define PWR_VOS     (1u << 14)
#define SCALE_US    40u /* voltage scaling settles within this */

uint32_t hil_power_limit_hz(const struct hil_rcc *rcc)
{
    /* RM0090 table 10, 2.7 to 3.6 V: 30 MHz for each wait state; table 22: scale 2 up to 144
     * MHz. */
    uint32_t flash_hz = 30000000u * ((rcc->flash_acr & ACR_LATENCY) + 1u);
    uint32_t core_hz = (rcc->pwr_cr & PWR_VOS) ? 168000000u : 144000000u;
    return flash_hz < core_hz ? flash_hz : core_hz;
}

uint32_t hil_pwr_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_rcc_device *dev = device;
    const struct hil_rcc *rcc = dev->state;
    (void)unit;
    return offset == 0 ? rcc->pwr_cr
                       : (uint32_t)(hil_now(dev->core) >= rcc->scale_ready_cycle) << 14;
}

void hil_pwr_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_rcc_device *dev = device;
    struct hil_rcc *rcc = dev->state;
    (void)unit;
    if (offset == 4)
        return; /* only status bits are left by registers.def */
    if ((value ^ rcc->pwr_cr) & PWR_VOS)
        rcc->scale_ready_cycle = hil_now(dev->core) +
                                 (uint64_t)dev->core->state.clock.hclk_hz / 1000000u * SCALE_US;
    rcc->pwr_cr = value;
}
