#include "hil/symbols.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEADER_BYTES 52u
#define SECTION_BYTES 40u
#define SYMBOL_BYTES 16u
#define SECTION_SYMBOLS 2u
#define SYMBOL_FUNCTION 2u
#define FILE_MAX (64L * 1024L * 1024L)

static uint32_t u16(const uint8_t *p) { return (uint32_t)p[0] | (uint32_t)p[1] << 8; }
static uint32_t u32(const uint8_t *p) { return u16(p) | u16(p + 2) << 16; }

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
        else
            (*bytes)[*n] = 0; /* the last name ends */
    }
    fclose(file);
    if (status != MR_OK)
        snprintf(error, size, "%s: cannot be read; build it again or give another --elf", path);
    return status;
}

/* By address; of several names for one, those with a size first, then by name. */
static int by_address(const void *a, const void *b)
{
    const struct hil_symbol *x = a, *y = b;
    if (x->address != y->address)
        return x->address < y->address ? -1 : 1;
    if (!x->size != !y->size)
        return x->size ? -1 : 1;
    return strcmp(x->name, y->name);
}

static void sort_out(struct hil_symbols *symbols)
{
    size_t kept = 0;
    qsort(symbols->all, symbols->count, sizeof *symbols->all, by_address);
    for (size_t i = 0; i < symbols->count; i++) {
        if (!kept || symbols->all[kept - 1].address != symbols->all[i].address)
            symbols->all[kept++] = symbols->all[i];
    }
    symbols->count = kept;
    for (size_t i = 0; i < kept; i++) {
        struct hil_symbol *symbol = &symbols->all[i];
        uint32_t room = i + 1 < kept ? symbol[1].address - symbol->address : symbol->size + 2u * !symbol->size;
        if (!symbol->size || symbol->size > room)
            symbol->size = room;
    }
}

static enum mr_status take_table(struct hil_symbols *symbols, size_t n, const uint8_t *section,
                                 const uint8_t *strings)
{
    uint64_t at = u32(section + 16), bytes = u32(section + 20);
    uint64_t names = u32(strings + 16), names_bytes = u32(strings + 20);
    if (at + bytes > n || names + names_bytes > n)
        return MR_TRUNCATED;
    symbols->all = calloc(bytes / SYMBOL_BYTES + 1, sizeof *symbols->all);
    if (!symbols->all)
        return MR_IO;
    for (uint64_t i = 0; i + SYMBOL_BYTES <= bytes; i += SYMBOL_BYTES) {
        const uint8_t *s = symbols->file + at + i;
        if ((s[12] & 15u) != SYMBOL_FUNCTION || u16(s + 14) == 0 || u32(s) >= names_bytes)
            continue;
        symbols->all[symbols->count++] = (struct hil_symbol){
            u32(s + 4) & ~1u, u32(s + 8), (const char *)symbols->file + names + u32(s)};
    }
    sort_out(symbols);
    return MR_OK;
}

enum mr_status hil_symbols_read(struct hil_symbols *symbols, const char *path, char *error, size_t size)
{
    size_t n = 0;
    *symbols = (struct hil_symbols){0};
    enum mr_status status = read_whole(path, &symbols->file, &n, error, size);
    if (status != MR_OK)
        return status;
    const uint8_t *h = symbols->file;
    if (n < HEADER_BYTES || memcmp(h, "\177ELF\1\1", 6) != 0) {
        snprintf(error, size, "%s: not a 32-bit ELF file; give the firmware's .elf", path);
        return MR_MALFORMED;
    }
    uint64_t sections = u32(h + 32);
    uint32_t step = u16(h + 46), count = u16(h + 48);
    if (count && (step < SECTION_BYTES || sections + (uint64_t)step * count > n))
        status = MR_TRUNCATED;
    for (uint32_t i = 0; i < count && status == MR_OK; i++) {
        const uint8_t *section = h + sections + (uint64_t)i * step;
        if (u32(section + 4) == SECTION_SYMBOLS && u32(section + 24) < count) {
            status = take_table(symbols, n, section, h + sections + (uint64_t)u32(section + 24) * step);
            break;
        }
    }
    if (status != MR_OK)
        snprintf(error, size, "%s: ends inside its symbol table; build it again", path);
    return status;
}

void hil_symbols_free(struct hil_symbols *symbols)
{
    free(symbols->all);
    free(symbols->file);
    *symbols = (struct hil_symbols){0};
}

const struct hil_symbol *hil_symbols_at(const struct hil_symbols *symbols, uint32_t address)
{
    size_t low = 0, high = symbols->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (symbols->all[middle].address <= address)
            low = middle + 1;
        else
            high = middle;
    }
    if (!low)
        return NULL;
    const struct hil_symbol *symbol = &symbols->all[low - 1];
    return address - symbol->address < symbol->size ? symbol : NULL;
}

const struct hil_symbol *hil_symbols_named(const struct hil_symbols *symbols, const char *name)
{
    for (size_t i = 0; i < symbols->count; i++) {
        if (strcmp(symbols->all[i].name, name) == 0)
            return &symbols->all[i];
    }
    return NULL;
}
