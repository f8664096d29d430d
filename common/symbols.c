#include "common/symbols.h"

#include <stdlib.h>
#include <string.h>

#define HEADER_BYTES    52u
#define SECTION_BYTES   40u
#define SYMBOL_BYTES    16u
#define SECTION_SYMBOLS 2u
#define SYMBOL_FUNCTION 2u

/* Position of the symbol table and its names in the file. */
struct symbol_table {
    const uint8_t *symbols;
    size_t count;
    uint64_t names, names_bytes; /* offset in the file */
};

static uint32_t read_u16(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8;
}
static uint32_t read_u32(const uint8_t *p)
{
    return read_u16(p) | read_u16(p + 2) << 16;
}

static enum mr_status read_symbol_table(const uint8_t *file, size_t length, const uint8_t *section,
                                        const uint8_t *strings, struct symbol_table *table)
{
    uint64_t at = read_u32(section + 16), bytes = read_u32(section + 20);
    uint64_t names = read_u32(strings + 16), names_bytes = read_u32(strings + 20);
    if (at + bytes > length || names + names_bytes > length)
        return MR_TRUNCATED;
    *table = (struct symbol_table){file + at, (size_t)(bytes / SYMBOL_BYTES), names, names_bytes};
    return MR_OK;
}

/* Finds the file's first symbol table; empty if there is none. */
static enum mr_status find_symbol_table(const uint8_t *file, size_t length,
                                        struct symbol_table *table)
{
    *table = (struct symbol_table){0};
    if (length < HEADER_BYTES || memcmp(file, "\177ELF\1\1", 6) != 0)
        return MR_MALFORMED;
    uint64_t sections = read_u32(file + 32);
    uint32_t step = read_u16(file + 46), count = read_u16(file + 48);
    if (count && (step < SECTION_BYTES || sections + (uint64_t)step * count > length))
        return MR_TRUNCATED;
    for (uint32_t i = 0; i < count; i++) {
        const uint8_t *section = file + sections + (uint64_t)i * step;
        if (read_u32(section + 4) == SECTION_SYMBOLS && read_u32(section + 24) < count)
            return read_symbol_table(file, length, section,
                                     file + sections + (uint64_t)read_u32(section + 24) * step,
                                     table);
    }
    return MR_OK;
}

/* Orders symbols by address; at equal addresses first those with a size, then by name. */
static int compare_symbols(const void *a, const void *b)
{
    const struct mr_symbol *x = a, *y = b;
    if (x->address != y->address)
        return x->address < y->address ? -1 : 1;
    if (!x->size != !y->size)
        return x->size ? -1 : 1;
    return strcmp(x->name, y->name);
}

/* Keeps one symbol per address and gives each a size. */
static void remove_duplicates(struct mr_symbols *symbols)
{
    size_t kept = 0;
    qsort(symbols->entries, symbols->entry_count, sizeof *symbols->entries, compare_symbols);
    for (size_t i = 0; i < symbols->entry_count; i++) {
        if (!kept || symbols->entries[kept - 1].address != symbols->entries[i].address)
            symbols->entries[kept++] = symbols->entries[i];
    }
    symbols->entry_count = kept;
    for (size_t i = 0; i < kept; i++) {
        struct mr_symbol *symbol = &symbols->entries[i];
        uint32_t room = i + 1 < kept ? symbol[1].address - symbol->address
                                     : symbol->size + 2u * !symbol->size;
        if (!symbol->size || symbol->size > room)
            symbol->size = room;
    }
}

enum mr_status mr_symbols_count(const uint8_t *file, size_t length, size_t *entry_count)
{
    struct symbol_table table;
    enum mr_status status = find_symbol_table(file, length, &table);
    *entry_count = status == MR_OK ? table.count : 0;
    return status;
}

enum mr_status mr_symbols_read(const uint8_t *file, size_t length, struct mr_symbol *all,
                               struct mr_symbols *symbols)
{
    struct symbol_table table;
    enum mr_status status = find_symbol_table(file, length, &table);
    symbols->entries = all;
    symbols->entry_count = 0;
    for (size_t i = 0; status == MR_OK && i < table.count; i++) {
        const uint8_t *s = table.symbols + SYMBOL_BYTES * i;
        if ((s[12] & 15u) != SYMBOL_FUNCTION || read_u16(s + 14) == 0 ||
            read_u32(s) >= table.names_bytes)
            continue;
        const uint8_t *name = file + table.names + read_u32(s);
        if (!memchr(name, 0, length - (size_t)(name - file)))
            status = MR_TRUNCATED;
        else
            all[symbols->entry_count++] = (struct mr_symbol){read_u32(s + 4) & ~1u, read_u32(s + 8),
                                                             (const char *)name};
    }
    if (status == MR_OK)
        remove_duplicates(symbols);
    else
        symbols->entry_count = 0;
    return status;
}

const struct mr_symbol *mr_symbols_by_address(const struct mr_symbols *symbols, uint32_t address)
{
    size_t low = 0, high = symbols->entry_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (symbols->entries[middle].address <= address)
            low = middle + 1;
        else
            high = middle;
    }
    if (!low)
        return NULL;
    const struct mr_symbol *symbol = &symbols->entries[low - 1];
    return address - symbol->address < symbol->size ? symbol : NULL;
}

const struct mr_symbol *mr_symbols_by_name(const struct mr_symbols *symbols, const char *name)
{
    for (size_t i = 0; i < symbols->entry_count; i++) {
        if (strcmp(symbols->entries[i].name, name) == 0)
            return &symbols->entries[i];
    }
    return NULL;
}
