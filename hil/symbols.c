#include "hil/symbols.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FILE_MAX (64L * 1024L * 1024L)

static enum mr_status read_whole(const char *path, uint8_t **bytes, size_t *n, char *error, size_t size)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        snprintf(error, size, "%s: %s; build the firmware or give another --elf", path, strerror(errno));
        return MR_IO;
    }
    long length = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    enum mr_status status = length >= 0 && length <= FILE_MAX ? MR_OK : MR_IO;
    if (status == MR_OK) {
        rewind(file);
        *bytes = malloc((size_t)length + 1);
        *n = *bytes ? fread(*bytes, 1, (size_t)length, file) : 0;
        if (!*bytes || *n != (size_t)length)
            status = MR_IO;
    }
    fclose(file);
    if (status != MR_OK)
        snprintf(error, size, "%s: cannot be read; build it again or give another --elf", path);
    return status;
}

enum mr_status hil_symbols_read(struct mr_symbols *symbols, const char *path, char *error, size_t size)
{
    size_t n = 0, room = 0;
    *symbols = (struct mr_symbols){0};
    enum mr_status status = read_whole(path, &symbols->file, &n, error, size);
    if (status != MR_OK)
        return status;
    status = mr_symbols_room(symbols->file, n, &room);
    if (status == MR_OK) {
        symbols->all = calloc(room + 1, sizeof *symbols->all);
        status = symbols->all ? mr_symbols_take(symbols->file, n, symbols->all, symbols) : MR_IO;
    }
    if (status == MR_MALFORMED)
        snprintf(error, size, "%s: not a 32-bit ELF file; give the firmware's .elf", path);
    else if (status != MR_OK)
        snprintf(error, size, "%s: ends inside its symbol table; build it again", path);
    return status;
}

void hil_symbols_free(struct mr_symbols *symbols)
{
    free(symbols->all);
    free(symbols->file);
    *symbols = (struct mr_symbols){0};
}
