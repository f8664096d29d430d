/* Which boards there are images for: common/boards.def. */
#ifndef MATRIG_COMMON_BOARDS_H
#define MATRIG_COMMON_BOARDS_H

#include <stdint.h>

enum mr_board_number {
#define BOARD(number, NAME, name, part, package, chip, flash_kib, text) MR_BOARD_##NAME = (number),
#include "common/boards.def"
};

struct mr_board {
    const char *name;           /* "zg": of make BOARD=zg and of its folder */
    const char *part, *package; /* of its chip */
    const char *text;
    uint16_t chip;      /* device id */
    uint16_t flash_kib; /* of the chip */
};

/* NULL: there is no such board. Static storage. */
const struct mr_board *mr_board_of(unsigned number);
/* Its number, or -1. */
int mr_board_named(const char *name);

#endif
