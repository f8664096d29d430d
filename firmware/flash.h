/* The seam to the two flash sectors that hold the configuration: 16 KiB each, erased to ones,
 * programmed in words.
 *
 * The flash has one bank: while an operation lasts, the processor stands still (a sector's erase:
 * 0.25 to 0.5 s, a word: 16 to 100 us). So sampling stops from flash_begin to flash_end, and the
 * blocks lost show as a jump of the index; only while idle. firmware/f407/flash.c implements it;
 * tests link a memory that tears (fake_flash.h). */
#ifndef MATRIG_FIRMWARE_FLASH_H
#define MATRIG_FIRMWARE_FLASH_H

#include <stdbool.h>
#include <stdint.h>

#define FLASH_COPIES     2u
#define FLASH_COPY_BYTES 16384u

/* What a copy's sector holds now, FLASH_COPY_BYTES. */
const uint8_t *flash_copy(unsigned copy);

/* Between these two alone: */
void flash_begin(void);
void flash_end(void);
/* False: it did not work, or not in its time (1 s); what the sector holds then is not known. */
bool flash_erase(unsigned copy);
/* `offset` in bytes, a multiple of 4. Ones become zeroes only. */
bool flash_program(unsigned copy, uint32_t offset, uint32_t word);

#endif
