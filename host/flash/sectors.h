/* Sectors of the STM32F407's flash, RM0090 3.3 table 5: four of 16 KiB, one of 64, seven of 128.
 * Offsets from 0x08000000. */
#ifndef MATRIG_HOST_FLASH_SECTORS_H
#define MATRIG_HOST_FLASH_SECTORS_H

#include <stdint.h>

#define SECTORS              12u
#define SECTOR_CONFIGURATION 2u /* and the next: kept whatever is flashed */
#define CONFIGURATION_START  0x8000u
#define CONFIGURATION_END    0x10000u

static inline uint32_t sector_start(unsigned sector)
{
    return sector < 5 ? sector * 0x4000u : (sector - 4) * 0x20000u;
}

static inline uint32_t sector_end(unsigned sector)
{
    return sector == 4 ? 0x20000u : sector < 4 ? (sector + 1) * 0x4000u : (sector - 3) * 0x20000u;
}

#endif
