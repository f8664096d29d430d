/* A NOR memory for tests: programming only clears bits, a power cut leaves an operation half done,
 * blocks go bad in five ways.
 *
 * Time is the test's: an operation ends when fake_nor.now_us has passed its end. Reads are over at
 * once. */
#ifndef MATRIG_TESTS_FIRMWARE_FAKE_NOR_H
#define MATRIG_TESTS_FIRMWARE_FAKE_NOR_H

#include "firmware/board.h"

#define FAKE_NOR_SIZE (NOR_CHIP_SECTORS * NOR_SECTOR_BYTES)

enum fake_nor_fault {
    /* busy for ten times as long, then half of the bits are programmed */
    FAKE_NOR_PROGRAM_ERROR = 1,
    FAKE_NOR_ERASE_ERROR = 2,    /* likewise */
    FAKE_NOR_READ_ERROR = 4,     /* a wrong bit in each page read */
    FAKE_NOR_PROGRAM_SILENT = 8, /* seems to work, changes nothing */
    FAKE_NOR_ERASE_SILENT = 16,
};

struct fake_nor {
    bool present;
    bool stuck; /* it answers, but stays busy */
    uint8_t cell[FAKE_NOR_SIZE];
    uint64_t now_us;
    uint32_t program_us, erase_us;

    unsigned operation; /* 0 none, 1 program, 2 erase */
    uint32_t address;
    const uint8_t *page;
    uint64_t end_us;
    uint64_t operations;          /* programs and erases begun */
    uint64_t erases, overwritten; /* programs that would have had to set a bit */
    uint64_t cut_at;              /* the power goes in this operation; 0: never */
    unsigned cut_permille;
    bool dark; /* it went: nothing happens any more */
    unsigned faults;
    uint32_t from, to; /* addresses that suffer them */
    uint32_t random;
};

extern struct fake_nor fake_nor;

/* A new, erased chip with typical times. */
void fake_nor_reset(void);
/* The supply comes back. */
void fake_nor_power(void);

#endif
