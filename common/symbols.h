/* Names of the functions in a firmware image, from the symbol table of its ELF file (32 bits,
 * little-endian; Tool Interface Standard, Executable and Linking Format 1.2, book I, "Symbol
 * Table"). Pure: works on bytes that the caller has read. */
#ifndef MATRIG_COMMON_SYMBOLS_H
#define MATRIG_COMMON_SYMBOLS_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

struct mr_symbol {
    uint32_t address; /* address without the Thumb bit */
    uint32_t size;    /* bytes; for a symbol without a size, up to the next symbol */
    const char *name; /* points into the bytes of the file */
};

struct mr_symbols {
    /* one entry per address, in ascending order; the caller owns the memory */
    struct mr_symbol *entries;
    size_t entry_count; /* number of functions; 0 for a stripped image */
    /* bytes of the file, if the caller wants to keep them here; it must free them */
    uint8_t *file;
};

/* Computes in `entry_count` the number of entries that mr_symbols_read needs for the `length` bytes
 * at `file`; 0 without a table. MR_MALFORMED: not a 32-bit little-endian ELF file; MR_TRUNCATED:
 * the table extends beyond the file. */
enum mr_status mr_symbols_count(const uint8_t *file, size_t length, size_t *entry_count);
/* Reads the functions of the table into `all`, which has the number of entries from
 * mr_symbols_count. `file` and `all` must stay valid as long as `symbols` is used. Errors as
 * mr_symbols_count; also MR_TRUNCATED when a name does not end inside the file. On failure
 * `symbols` is empty. symbols->file is unchanged. */
enum mr_status mr_symbols_read(const uint8_t *file, size_t length, struct mr_symbol *all,
                               struct mr_symbols *symbols);
/* Function that contains `address`, and function with this name; NULL: none. */
const struct mr_symbol *mr_symbols_by_address(const struct mr_symbols *symbols, uint32_t address);
const struct mr_symbol *mr_symbols_by_name(const struct mr_symbols *symbols, const char *name);

#endif
