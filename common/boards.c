#include "common/boards.h"

#include <stddef.h>
#include <string.h>

static const struct mr_board boards[] = {
#define BOARD(number, NAME, name, part, package, chip, flash_kib, text) \
    [number] = {#name, part, package, text, chip, flash_kib},
#include "common/boards.def"
};
#define BOARDS (sizeof boards / sizeof boards[0])

const struct mr_board *mr_board_of(unsigned number)
{
    return number < BOARDS && boards[number].name ? &boards[number] : NULL;
}

int mr_board_named(const char *name)
{
    for (unsigned i = 0; i < BOARDS; i++) {
        if (boards[i].name && strcmp(boards[i].name, name) == 0)
            return (int)i;
    }
    return -1;
}
