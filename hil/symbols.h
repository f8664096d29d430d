/* Names of a firmware image's functions, from its ELF symbol table. */
#ifndef MATRIG_HIL_SYMBOLS_H
#define MATRIG_HIL_SYMBOLS_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

struct hil_symbol {
    uint32_t address; /* without the Thumb bit */
    uint32_t size;    /* bytes; of a symbol without size: up to the next */
    const char *name; /* in the table's own storage */
};

struct hil_symbols {
    struct hil_symbol *all; /* by address, one for each */
    size_t count;           /* 0: a stripped image */
    uint8_t *file;
};

/* Read the functions of the ELF at `path`. The caller frees them with hil_symbols_free, also after a failure.
 * MR_IO, MR_MALFORMED, MR_TRUNCATED; a file without symbols is MR_OK with none. */
enum mr_status hil_symbols_read(struct hil_symbols *symbols, const char *path, char *error, size_t size);
void hil_symbols_free(struct hil_symbols *symbols);
/* The function that `address` lies in, and the one of that name; NULL: none. */
const struct hil_symbol *hil_symbols_at(const struct hil_symbols *symbols, uint32_t address);
const struct hil_symbol *hil_symbols_named(const struct hil_symbols *symbols, const char *name);

#endif
