/* Firmware images (32-bit little-endian ARM executables): loads them into the memories of this chip
 * and reads their functions (common/symbols.h). */
#ifndef MATRIG_HIL_ELF_H
#define MATRIG_HIL_ELF_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "common/symbols.h"

struct hil_memory;

/* Copies the load segments to their physical addresses, except ELF headers at the start of a
 * segment and bytes below the first address of a memory. On failure `error` describes the fault and
 * memory is unchanged. MR_IO: cannot be read; MR_TOO_LONG; MR_TRUNCATED; MR_MALFORMED: not an ELF
 * file, or not an executable; MR_VERSION: for a different machine, or a segment is outside flash
 * (0x08000000, 1 MiB), SRAM (0x20000000, 128 KiB) and CCM (0x10000000, 64 KiB). */
enum mr_status hil_elf_load(const char *path, struct hil_memory *memory, char *error, size_t size);

/* Address of a function (without its Thumb bit) or variable in the image. MR_UNKNOWN: the image has
 * no such symbol or cannot be read. */
enum mr_status hil_elf_find_symbol(const char *path, const char *name, uint32_t *address);

/* Reads the functions of the ELF file at `path`. The caller frees them with hil_symbols_free, also
 * after a failure. MR_OK, with no functions for a file without symbols; MR_IO, MR_TOO_LONG,
 * MR_MALFORMED, MR_TRUNCATED, with a text in `error`. */
enum mr_status hil_symbols_read(struct mr_symbols *symbols, const char *path, char *error,
                                size_t size);
void hil_symbols_free(struct mr_symbols *symbols);

#endif
