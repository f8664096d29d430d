/* The configuration's two flash sectors for tests: programming only clears bits, and a power cut
 * leaves an operation half done. */
#ifndef MATRIG_TESTS_FIRMWARE_FAKE_FLASH_H
#define MATRIG_TESTS_FIRMWARE_FAKE_FLASH_H

#include "firmware/board.h"

struct fake_flash {
    uint8_t cell[FLASH_COPIES][FLASH_COPY_BYTES];
    uint64_t operations; /* erases and words begun */
    /* operations outside begin and end, or that had to set a bit */
    uint64_t erases[FLASH_COPIES], stray;
    uint64_t cut_at;       /* the power goes in this operation; 0: never */
    unsigned cut_permille; /* so far into it */
    bool dark;             /* it went: nothing happens any more */
    bool broken;           /* everything fails */
    bool open;
    uint32_t random;
};

extern struct fake_flash fake_flash;

/* Both sectors erased. */
void fake_flash_reset(void);

#endif
