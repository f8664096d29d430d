/* Names of a firmware image's functions, from the symbol table of its ELF file (32 bits,
 * little-endian: Tool Interface Standard, Executable and Linking Format 1.2, book I, "Symbol
 * Table"). Pure: works on bytes that the caller has read. */
#ifndef MATRIG_COMMON_SYMBOLS_H
#define MATRIG_COMMON_SYMBOLS_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

struct mr_symbol {
    uint32_t address; /* without the Thumb bit */
    uint32_t size;    /* bytes; of a symbol without size: up to the next */
    const char *name; /* in the file's own bytes */
};

struct mr_symbols {
    struct mr_symbol *all; /* by address, one for each; storage of the caller */
    size_t count;          /* 0: a stripped image */
    uint8_t *file;         /* for the caller, who has to free the bytes: not looked at here */
};

/* How many symbols the table of the `length` bytes at `file` can hold at most: the room that
 * mr_symbols_take needs. MR_OK, 0 without a table; MR_MALFORMED: not a 32-bit little-endian ELF;
 * MR_TRUNCATED: the table ends outside. */
enum mr_status mr_symbols_room(const uint8_t *file, size_t length, size_t *room);
/* The functions of the table, into `all` of so much room. Both are used as long as `symbols` is. As
 * mr_symbols_room; MR_TRUNCATED too when a name does not end inside the file. On failure there are
 * none. Leaves symbols->file as it is. */
enum mr_status mr_symbols_take(const uint8_t *file, size_t length, struct mr_symbol *all,
                               struct mr_symbols *symbols);
/* The function that `address` lies in, and the one of that name; NULL: none. */
const struct mr_symbol *mr_symbols_at(const struct mr_symbols *symbols, uint32_t address);
const struct mr_symbol *mr_symbols_named(const struct mr_symbols *symbols, const char *name);

#endif
