/* Flash memory and its interface (RM0090 3): 1 MiB in one bank of twelve sectors (4 x 16, 1 x 64, 7 x 128 KiB), option
 * bytes, one-time area.
 *
 * Programming only turns ones into zeroes, in the width that PSIZE says; it and erasing take the time of the data
 * sheet (DS8626, flash memory programming, 2.7 to 3.6 V). Until an operation ends the bank cannot be read: code in
 * flash stands still while virtual time, peripherals and interrupts go on, code in RAM runs on and sees BSY, and a
 * DMA controller that wants data from flash waits with all its streams. On silicon a loop that sits in the
 * instruction cache also runs on; here it stands still.
 *
 * Flash and option bytes keep their content through resets and power cuts. An operation that a reset or a power cut
 * ends early leaves cells half changed (hil/periph/cells.h); option bytes cut off read as erased: protection level 1, nothing
 * write-protected (RM0090 3.7.1).
 *
 * Refused or not modelled: x64 (needs a supply on VPP that the board does not have), the hardware watchdog option,
 * programming the one-time area, stop-mode options (there is no stop mode). The block on flash that silicon has at
 * level 1 for code in RAM after booting from system memory is not modelled: the boot ROM itself refuses. */
#ifndef MATRIG_HIL_FLASH_H
#define MATRIG_HIL_FLASH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct hil_board;

#define HIL_FLASH_SECTORS 12u
#define HIL_FLASH_OPTIONS_FACTORY 0x0fffaaecu /* layout of FLASH_OPTCR: level 0, no sector protected */

enum hil_flash_operation {
    HIL_FLASH_IDLE,
    HIL_FLASH_PROGRAM,
    HIL_FLASH_ERASE_SECTOR,
    HIL_FLASH_ERASE_ALL,
    HIL_FLASH_OPTIONS,
};

struct hil_flash {
    uint32_t sr, cr, optcr;
    uint8_t key_step, option_key_step; /* of the unlocking sequences; see unlock() */
    enum hil_flash_operation operation;
    uint32_t address, value, size;     /* program: offset in flash, bytes; erase: offset and bytes */
    uint64_t begin_ps, end_ps;         /* of the operation */
    /* survive resets */
    uint32_t options;                  /* programmed option bytes, layout of FLASH_OPTCR */
    uint64_t operations;               /* begun since creation: words and sectors alike */
    uint64_t cut_at;                   /* the operation that a power cut ends; 0: none */
    unsigned cut_permille;
    uint64_t random;
    bool boot_rom;                     /* system memory, not flash, is at address 0 */
};

void hil_flash_create(struct hil_board *board);
/* System reset. */
void hil_flash_reset(struct hil_board *board);
uint32_t hil_flash_if_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_flash_if_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
void hil_flash_event(struct hil_board *board, uint64_t at);
void hil_flash_cut_event(struct hil_board *board, uint64_t at);

/* The core stores `size` bytes (1, 2, 4, 8) to a flash address. */
void hil_flash_store(struct hil_board *board, uint32_t address, unsigned size, uint64_t value);
bool hil_flash_busy(const struct hil_board *board);
/* An erase, of a sector, of all or of option bytes, is in progress. */
bool hil_flash_erases(const struct hil_board *board);
/* Is this address one that cannot be read before the operation in progress ends? */
bool hil_flash_stalls(const struct hil_board *board, uint32_t address);
/* Hold the bus until the operation in progress has ended: virtual time jumps. */
void hil_flash_wait(struct hil_board *board);
/* The supply went: an operation in progress stays where it is. */
void hil_flash_power_lost(struct hil_board *board);

/* Sector at an offset in flash, and where a sector begins (12: the end). */
unsigned hil_flash_sector(uint32_t offset);
uint32_t hil_flash_sector_start(unsigned sector);
/* 0, 1 or 2, from the programmed option bytes. */
unsigned hil_flash_protection_level(const struct hil_board *board);
/* Option bytes as memory shows them from 0x1FFFC000, word 0 to 3. */
uint32_t hil_flash_option_word(const struct hil_board *board, unsigned word);

#endif
