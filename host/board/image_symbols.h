/* The functions of a firmware image by name (common/symbols.h), from its ELF file: where a board
 * stopped. */
#ifndef MATRIG_HOST_IMAGE_SYMBOLS_H
#define MATRIG_HOST_IMAGE_SYMBOLS_H

#include "common/symbols.h"
#include "host/base/error.h"

/* Of the ELF at the path `elf`; NULL: none are known. MR_IO; MR_MALFORMED: no ELF, or one without
 * names; MR_TRUNCATED. The caller frees them with image_symbols_free, also after a failure. */
enum mr_status image_symbols_read(struct mr_symbols *symbols, const char *elf, struct error *error);
void image_symbols_free(struct mr_symbols *symbols);

#endif
