/* The seam to the NOR memory of the black box: 16 MiB, pages of 256 bytes, sectors of 4 KiB that
 * are erased to ones.
 *
 * One operation at a time: begin it when nor_poll says idle, then poll. Nothing waits; buffers stay
 * the driver's until the poll says idle or failed. firmware/f407/nor.c implements it; tests link a
 * memory that wears, tears and fails (fake_nor.h). */
#ifndef MATRIG_FIRMWARE_NOR_H
#define MATRIG_FIRMWARE_NOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define NOR_PAGE             256u
#define NOR_SECTOR           4096u
#define NOR_CHIP_SECTORS     4096u
/* the last ones are the predictor's runway's (runwaystore.h), a sector each, */
#define RUNWAY_COPIES        2u
/* the rest the black box's */
#define NOR_SECTORS          (NOR_CHIP_SECTORS - RUNWAY_COPIES)
#define RUNWAY_FIRST_SECTOR  (NOR_CHIP_SECTORS - RUNWAY_COPIES)
#define NOR_PAGES_PER_SECTOR (NOR_SECTOR / NOR_PAGE)

enum nor_status {
    NOR_IDLE, /* the last operation is over; whether it did what it should, only reading tells */
    NOR_BUSY,
    NOR_FAILED,  /* the last operation did not end in its time; the next may be tried */
    NOR_MISSING, /* no chip, or not the one expected: stays so */
};

enum nor_status nor_poll(void);
/* Ask the chip who it is: NOR_IDLE: the one expected; NOR_BUSY: ask later; NOR_MISSING. Nothing
 * else is disturbed. */
enum nor_status nor_identify(void);
/* At most NOR_PAGE bytes. */
void nor_begin_read(uint32_t address, uint8_t *bytes, size_t length);
/* A whole page; bytes of 0xff leave what is there. */
void nor_begin_program(uint32_t address, const uint8_t page[NOR_PAGE]);
void nor_begin_erase(uint32_t address);

#endif
