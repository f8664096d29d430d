/* Firmware images, 32-bit little-endian ARM executables: into the memories of this chip, and their
 * functions (common/symbols.h). */
#ifndef MATRIG_HIL_ELF_H
#define MATRIG_HIL_ELF_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "common/symbols.h"

struct hil_memory;

/* Copy the load segments to their physical addresses, without the file's own headers when a segment
 * begins with them, and without the bytes beside them below a memory. On failure `error` describes
 * the fault, and memory is unchanged. MR_IO: cannot be read; MR_TOO_LONG; MR_TRUNCATED;
 * MR_MALFORMED: no ELF, or not an executable; MR_VERSION: for another machine, or a segment outside
 * flash (0x08000000, 1 MiB), SRAM (0x20000000, 128 KiB) and CCM (0x10000000, 64 KiB). */
enum mr_status hil_elf_load(const char *path, struct hil_memory *memory, char *error, size_t size);

/* Address of a function (without its Thumb bit) or variable of that image. MR_UNKNOWN: it has no
 * such symbol, or cannot be read. */
enum mr_status hil_elf_symbol(const char *path, const char *name, uint32_t *address);

/* Read the functions of the ELF at `path`. The caller frees them with hil_symbols_free, also after
 * a failure. MR_IO, MR_TOO_LONG, MR_MALFORMED, MR_TRUNCATED, with `error` in words; a file without
 * symbols is MR_OK with none. */
enum mr_status hil_symbols_read(struct mr_symbols *symbols, const char *path, char *error,
                                size_t size);
void hil_symbols_free(struct mr_symbols *symbols);

#endif
