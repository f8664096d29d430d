/* The functions of a firmware image (common/symbols.h), read from its ELF file. */
#ifndef MATRIG_HIL_SYMBOLS_H
#define MATRIG_HIL_SYMBOLS_H

#include "common/symbols.h"

/* Read the functions of the ELF at `path`. The caller frees them with hil_symbols_free, also after
 * a failure. MR_IO, MR_TOO_LONG, MR_MALFORMED, MR_TRUNCATED, with `error` in words; a file without
 * symbols is MR_OK with none. */
enum mr_status hil_symbols_read(struct mr_symbols *symbols, const char *path, char *error,
                                size_t size);
void hil_symbols_free(struct mr_symbols *symbols);

#endif
