/* Flash memory and its interface (RM0090 3): 1 MiB in one bank of twelve sectors (4 x 16, 1 x 64, 7
 * x 128 KiB), option bytes, one-time area.
 *
 * Programming only changes ones to zeroes, in the width of PSIZE. Programming and erasing take the
 * time given in the data sheet (DS8626, flash memory programming, 2.7 to 3.6 V). Until an operation
 * ends the bank cannot be read. Code in flash stalls while virtual time, peripherals and interrupts
 * continue. Code in RAM continues and reads BSY. A DMA controller that needs data from flash waits
 * with all its streams. On hardware a loop in the instruction cache also continues; here it stalls.
 *
 * Flash and option bytes keep their content through resets and power failures. An operation that is
 * interrupted by a reset or a power failure leaves its cells partly changed
 * (hil_cells_change_partly). Interrupted option bytes read as erased: protection level 1, nothing
 * write-protected (RM0090 3.7.1).
 *
 * Refused or not modelled: x64 (needs a supply on VPP that the board does not have), write
 * protection and the hardware watchdog by option bytes, programming the one-time area, stop-mode
 * options (there is no stop mode). At level 1, hardware blocks flash for code in RAM after booting
 * from system memory. This is not modelled; the boot ROM refuses such accesses itself. */
#ifndef MATRIG_HIL_FLASH_H
#define MATRIG_HIL_FLASH_H

#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/options.h"
#include "hil/periph/wire.h"

#define HIL_FLASH_SECTORS         12u
/* option bytes in the layout of FLASH_OPTCR: level 0, no sector protected */
#define HIL_FLASH_OPTIONS_FACTORY 0x0fffaaecu

enum hil_flash_operation {
    HIL_FLASH_IDLE,
    HIL_FLASH_PROGRAM,
    HIL_FLASH_ERASE_SECTOR,
    HIL_FLASH_ERASE_ALL,
    HIL_FLASH_WRITE_OPTIONS,
};

struct hil_flash {
    /* in_rcc: place of the register ACR, which struct hil_rcc holds instead */
    HIL_NAMED_WORDS(word, in_rcc, keyr, optkeyr, sr, cr, optcr);
    uint8_t key_step,
        option_key_step; /* steps of the unlocking sequences (enum of KEY_STEP_LOCKED, ...) */
    enum hil_flash_operation operation;
    /* operation in progress. Program: offset in flash, value, number of bytes. Erase: offset,
     * number of bytes */
    uint32_t address, value, size;
    uint64_t begin_ps, end_ps; /* start and end of the operation */
    /* the following members survive resets */
    uint32_t option_bytes;    /* programmed option bytes, layout of FLASH_OPTCR */
    uint64_t operation_count; /* number of operations begun since creation (words and sectors) */
    uint64_t random_state;
};

struct hil_flash_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_flash *state;
    struct hil_callback on_operation_begin; /* called when an operation has begun */
    struct hil_callback on_bank_ready;      /* called when the bank can be read again */
};

void hil_flash_create(struct hil_flash_device *dev);
/* Sets the state after a system reset. */
void hil_flash_reset(struct hil_flash_device *dev);
/* Functions that bus, event queue and core (hil_bank_calls) call; `device` is a struct
 * hil_flash_device. */

/* SYSCFG, which selects the memory at address 0; `device` is the struct hil_flash_device. */
HIL_DECLARE_BUS_CALLS(syscfg)
void hil_syscfg_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(flash_if)
void hil_flash_event(void *device, uint64_t at);
/* Call when the core stores `size` bytes (1, 2, 4, 8) to a flash address. */
void hil_flash_store(void *device, uint32_t address, unsigned size, uint64_t value);
/* Call when the core loads from a flash address that cannot be read directly now; see struct
 * hil_bank_calls. */
void hil_flash_load(void *device, uint32_t address);
/* Call when the supply fails: an operation in progress is interrupted. */
void hil_flash_interrupt_operation(struct hil_flash_device *dev);

/* Offset of a sector in flash (12: the end). */
uint32_t hil_flash_sector_start(unsigned sector);
/* Option bytes as read from 0x1FFFC000, word 0 to 3. */
uint32_t hil_flash_option_word(const struct hil_flash_device *dev, unsigned word);

/* Timing and interruption of memory cells, for flash and NOR. */

/* Duration of one operation in picoseconds. HIL_TIMES_RANDOM: typical + (maximum - typical) u^8,
 * with u uniform from 0 to 1. */
uint64_t hil_cell_operation_ps(enum hil_cell_times times, uint32_t typical_us, uint32_t maximum_us,
                               uint64_t *random);

/* Computes the content after an operation that was to change the n bytes of `cells` to `target`
 * (NULL: to 0xff) and was interrupted after `permille` of its time. Each bit that was to change has
 * done so with the probability permille / 1000, independently of the others. */
void hil_cells_change_partly(uint8_t *cells, const uint8_t *target, size_t n, unsigned permille,
                             uint64_t *random);

#endif
