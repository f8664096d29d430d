#include "host/board/image_symbols.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FILE_BYTES_MAX (64u << 20) /* of an ELF most is for the debugger */

static enum mr_status read_all(const char *elf, uint8_t **bytes, size_t *length,
                               struct error *error)
{
    FILE *file = fopen(elf, "rb");
    if (!file)
        return error_set(error, MR_IO, "%s: %s; build the firmware or give another --elf", elf,
                         strerror(errno));
    *bytes = malloc(FILE_BYTES_MAX);
    if (!*bytes)
        abort();
    *length = fread(*bytes, 1, FILE_BYTES_MAX, file);
    bool failed = ferror(file) != 0 || *length == FILE_BYTES_MAX;
    fclose(file);
    return failed ? error_set(error, MR_IO,
                              "%s: cannot be read; build it again or give another --elf", elf)
                  : MR_OK;
}

enum mr_status image_symbols_read(struct mr_symbols *symbols, const char *elf, struct error *error)
{
    size_t length = 0, room = 0;
    *symbols = (struct mr_symbols){0};
    if (!elf)
        return MR_OK;
    enum mr_status status = read_all(elf, &symbols->file, &length, error);
    if (status != MR_OK)
        return status;
    status = mr_symbols_room(symbols->file, length, &room);
    if (status == MR_OK) {
        symbols->all = calloc(room + 1, sizeof *symbols->all);
        if (!symbols->all)
            abort();
        status = mr_symbols_take(symbols->file, length, symbols->all, symbols);
    }
    if (status == MR_MALFORMED)
        return error_set(error, status, "%s: not a 32-bit ELF file; give the firmware's .elf", elf);
    if (status != MR_OK)
        return error_set(error, status, "%s: ends inside its symbol table; build it again", elf);
    return symbols->count
             ? MR_OK
             : error_set(error, MR_MALFORMED,
                         "no symbols in the image: %s; give the .elf as it was linked", elf);
}

void image_symbols_free(struct mr_symbols *symbols)
{
    free(symbols->all);
    free(symbols->file);
    *symbols = (struct mr_symbols){0};
}
