#include "hil/symbols.h"

#include <stdlib.h>

#include "hil/core/file_place.h"

#define FILE_MAX (64u * 1024u * 1024u)

enum mr_status hil_symbols_read(struct mr_symbols *symbols, const char *path, char *error,
                                size_t size)
{
    const struct hil_file_place at = {path, 0, error, size};
    size_t n = 0, room = 0;
    char *bytes;
    *symbols = (struct mr_symbols){0};
    enum mr_status status = hil_file_read(&at, FILE_MAX, "build the firmware or give another --elf",
                                          &bytes, &n);
    symbols->file = (uint8_t *)bytes;
    if (status != MR_OK)
        return status;
    status = mr_symbols_room(symbols->file, n, &room);
    if (status == MR_OK) {
        symbols->all = calloc(room + 1, sizeof *symbols->all);
        status = symbols->all ? mr_symbols_take(symbols->file, n, symbols->all, symbols) : MR_IO;
    }
    if (status == MR_MALFORMED)
        return hil_file_refuse(&at, status, "not a 32-bit ELF file; give the firmware's .elf");
    return status == MR_OK
             ? MR_OK
             : hil_file_refuse(&at, status, "ends inside its symbol table; build it again");
}

void hil_symbols_free(struct mr_symbols *symbols)
{
    free(symbols->all);
    free(symbols->file);
    *symbols = (struct mr_symbols){0};
}
