/* What is at address 0 (RM0090 9.2.1): the boot pins choose at reset, SYSCFG_MEMRMP after it. */
#include "hil/core/core.h"
#include "hil/core/map.h"
#include "hil/periph/flash.h"

#define MEMRMP     0x00u
#define SYSTEM_ROM 1u

void hil_syscfg_reset(void *device, unsigned unit)
{
    struct hil_flash_device *dev = device;
    (void)unit;
    dev->core->state.bank.boot_rom = hil_flash_boots_rom(dev);
    hil_map_follow_boot_pin(dev->core);
}

uint32_t hil_syscfg_read(void *device, unsigned unit, uint32_t offset)
{
    const struct hil_flash_device *dev = device;
    (void)unit;
    return offset == MEMRMP && dev->core->state.bank.boot_rom ? SYSTEM_ROM : 0;
}

void hil_syscfg_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_flash_device *dev = device;
    (void)unit;
    if (offset != MEMRMP)
        return; /* registers.def leaves nothing of them */
    dev->core->state.bank.boot_rom = (value & SYSTEM_ROM) != 0;
    hil_map_follow_boot_pin(dev->core);
}
