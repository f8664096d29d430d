/* Flash memory and its interface (RM0090 3): 1 MiB in one bank of twelve sectors (4 x 16, 1 x 64, 7
 * x 128 KiB), option bytes, one-time area.
 *
 * Programming only turns ones into zeroes, in the width of PSIZE; it and erasing take the time of
 * the data sheet (DS8626, flash memory programming, 2.7 to 3.6 V). Until an operation ends the bank
 * cannot be read: code in flash stands still while virtual time, peripherals and interrupts go on,
 * code in RAM runs on and sees BSY, and a DMA controller that wants data from flash waits with all
 * its streams. On hardware a loop in the instruction cache also runs on; here it stands still.
 *
 * Flash and option bytes keep their content through resets and power cuts. An operation that a
 * reset or a power cut ends early leaves cells half changed (below); option bytes cut off read as
 * erased: protection level 1, nothing write-protected (RM0090 3.7.1).
 *
 * Refused or not modelled: x64 (needs a supply on VPP that the board does not have), write
 * protection and the hardware watchdog by option bytes, programming the one-time area, stop-mode
 * options (there is no stop mode). The hardware's block on flash at level 1 for code in RAM after
 * booting from system memory is not modelled: the boot ROM itself refuses. */
#ifndef MATRIG_HIL_FLASH_H
#define MATRIG_HIL_FLASH_H

#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/options.h"
#include "hil/periph/wire.h"

#define HIL_FLASH_SECTORS         12u
/* layout of FLASH_OPTCR: level 0, no sector protected */
#define HIL_FLASH_OPTIONS_FACTORY 0x0fffaaecu

enum hil_flash_operation {
    HIL_FLASH_IDLE,
    HIL_FLASH_PROGRAM,
    HIL_FLASH_ERASE_SECTOR,
    HIL_FLASH_ERASE_ALL,
    HIL_FLASH_OPTIONS,
};

struct hil_flash {
    HIL_WORDS(word, in_rcc, keyr, optkeyr, sr, cr, optcr); /* ACR is in struct hil_rcc */
    uint8_t key_step, option_key_step; /* of the unlocking sequences; see unlock() */
    enum hil_flash_operation operation;
    /* program: offset in flash, bytes; erase: offset and bytes */
    uint32_t address, value, size;
    uint64_t begin_ps, end_ps; /* of the operation */
    /* survive resets */
    uint32_t options;    /* programmed option bytes, layout of FLASH_OPTCR */
    uint64_t operations; /* begun since creation: words and sectors alike */
    uint64_t random;
};

struct hil_flash_device {
    HIL_NEIGHBOURS;
    struct hil_flash *state;
    struct hil_call began; /* an operation has begun */
    struct hil_call ready; /* the bank can be read again */
};

void hil_flash_create(struct hil_flash_device *dev);
/* System reset. */
void hil_flash_reset(struct hil_flash_device *dev);
/* For the bus, the event queue and the core (hil_bank_calls); `device` is a struct
 * hil_flash_device. */

/* What is at address 0: `device` is the flash's. */
HIL_ON_BUS(syscfg)
void hil_syscfg_reset(void *device, unsigned unit);
HIL_ON_BUS(flash_if)
void hil_flash_event(void *device, uint64_t at);
/* The core stores `size` bytes (1, 2, 4, 8) to a flash address. */
void hil_flash_store(void *device, uint32_t address, unsigned size, uint64_t value);
/* The core loads from a flash address while that is no plain matter: see struct hil_bank_calls. */
void hil_flash_load(void *device, uint32_t address);
/* The supply went: an operation in progress stays where it is. */
void hil_flash_power_lost(struct hil_flash_device *dev);

/* Where a sector begins in flash (12: the end). */
uint32_t hil_flash_sector_start(unsigned sector);
/* Option bytes as memory shows them from 0x1FFFC000, word 0 to 3. */
uint32_t hil_flash_option_word(const struct hil_flash_device *dev, unsigned word);

/* Memory cells that take their time, of flash and NOR. */

/* Duration of one operation in picoseconds. Spread: typical + (maximum - typical) u^8, u uniform
 * from 0 to 1. */
uint64_t hil_cell_time_ps(enum hil_cell_times times, uint32_t typical_us, uint32_t maximum_us,
                          uint64_t *random);

/* What an operation leaves that was to turn the n bytes of `cells` into `wanted` (or all into 0xff:
 * NULL) and was cut off after `permille` of its time: each bit that was to change has changed with
 * that probability, independently. At 1000 all have, at 0 none. */
void hil_cells_tear(uint8_t *cells, const uint8_t *wanted, size_t n, unsigned permille,
                    uint64_t *random);

#endif
