/* The chip's own memories, and where they are (RM0090 2.3). */
#ifndef MATRIG_HIL_MEMORY_H
#define MATRIG_HIL_MEMORY_H

#include <stdbool.h>
#include <stdint.h>

#define HIL_FLASH_BASE 0x08000000u
#define HIL_FLASH_SIZE 0x00100000u
#define HIL_SRAM_BASE  0x20000000u /* SRAM1 112 KiB and SRAM2 16 KiB, contiguous */
#define HIL_SRAM_SIZE  0x00020000u
#define HIL_CCM_BASE   0x10000000u
#define HIL_CCM_SIZE   0x00010000u

struct hil_memory {
    uint8_t flash[HIL_FLASH_SIZE];
    uint8_t sram[HIL_SRAM_SIZE];
    uint8_t ccm[HIL_CCM_SIZE];
};

/* The bank of flash as the core meets it. Whoever models the flash interface keeps it true. */
struct hil_bank {
    bool busy;     /* an operation is in progress: the bank cannot be read before its end */
    bool erases;   /* that operation is an erase, of a sector, of all or of option bytes */
    bool boot_rom; /* system memory, not flash, is at address 0 */
};

/* The same, as calls. `wait` holds the bus until the operation in progress has ended: virtual time
 * jumps. */
struct hil_bank_calls {
    void *who;
    /* 1, 2, 4, 8 bytes */
    void (*store)(void *who, uint32_t address, unsigned size, uint64_t value);
    void (*wait)(void *who);
};

#endif
