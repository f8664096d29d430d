#include "hil/core/elf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hil/core/file_place.h"
#include "hil/core/state.h"

#define HEADER_BYTES         52u
#define PROGRAM_HEADER_BYTES 32u
#define FILE_MAX             (64u * 1024u * 1024u) /* debug information included */
#define TYPE_EXECUTABLE      2u
#define MACHINE_ARM          40u
#define SEGMENT_LOAD         1u
#define SECTION_HEADER_BYTES 40u
#define SECTION_SYMBOLS      2u
#define SYMBOL_BYTES         16u
#define SYMBOL_FUNCTION      2u

#define refuse(image, ...) hil_file_refuse(&(image)->at, __VA_ARGS__)

struct image {
    struct hil_file_place at;
    union {
        char *text;
        const uint8_t *bytes;
    };
    size_t size;
};

struct segment {
    uint32_t offset, address, file_bytes;
};

static uint32_t u16(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8;
}
static uint32_t u32(const uint8_t *p)
{
    return u16(p) | u16(p + 2) << 16;
}

static enum mr_status check_header(const struct image *image)
{
    const uint8_t *h = image->bytes;
    if (image->size < 4 || memcmp(h, "\177ELF", 4) != 0)
        return refuse(image, MR_MALFORMED, "not an ELF file; give the firmware's .elf");
    if (image->size < HEADER_BYTES)
        return refuse(image, MR_TRUNCATED, "ends inside its ELF header");
    if (h[4] != 1 || h[5] != 1 || u16(h + 18) != MACHINE_ARM)
        return refuse(image, MR_VERSION,
                      "not for a 32-bit little-endian ARM (class %u, data %u, machine %u); "
                      "this board is an STM32F407",
                      h[4], h[5], (unsigned)u16(h + 18));
    if (u16(h + 16) != TYPE_EXECUTABLE)
        return refuse(image, MR_MALFORMED, "an ELF of type %u, not a linked executable",
                      (unsigned)u16(h + 16));
    if (u16(h + 42) < PROGRAM_HEADER_BYTES || u16(h + 44) == 0)
        return refuse(image, MR_MALFORMED, "has no program headers, so nothing to load");
    uint64_t end = (uint64_t)u32(h + 28) + (uint64_t)u16(h + 42) * u16(h + 44);
    if (end > image->size)
        return refuse(image, MR_TRUNCATED, "ends inside its program headers");
    return MR_OK;
}

static enum mr_status read_header(struct image *image)
{
    enum mr_status status = hil_file_read(&image->at, FILE_MAX,
                                          "build the firmware or give another --elf", &image->text,
                                          &image->size);
    return status == MR_OK ? check_header(image) : status;
}

static uint8_t *place(struct hil_memory *memory, uint32_t address, uint32_t n)
{
    if (address - HIL_FLASH_BASE < HIL_FLASH_SIZE &&
        n <= HIL_FLASH_SIZE - (address - HIL_FLASH_BASE))
        return memory->flash + (address - HIL_FLASH_BASE);
    if (address - HIL_SRAM_BASE < HIL_SRAM_SIZE && n <= HIL_SRAM_SIZE - (address - HIL_SRAM_BASE))
        return memory->sram + (address - HIL_SRAM_BASE);
    if (address - HIL_CCM_BASE < HIL_CCM_SIZE && n <= HIL_CCM_SIZE - (address - HIL_CCM_BASE))
        return memory->ccm + (address - HIL_CCM_BASE);
    return NULL;
}

/* First without `memory`, to check everything, then with it. */
static enum mr_status load_segments(const struct image *image, struct hil_memory *memory, bool copy)
{
    const uint8_t *h = image->bytes;
    bool flash = false;
    for (unsigned i = 0; i < u16(h + 44); i++) {
        const uint8_t *p = h + u32(h + 28) + i * u16(h + 42);
        struct segment s = {u32(p + 4), u32(p + 12), u32(p + 16)};
        if (u32(p) != SEGMENT_LOAD || s.file_bytes == 0)
            continue;
        if ((uint64_t)s.offset + s.file_bytes > image->size)
            return refuse(image, MR_TRUNCATED, "ends inside segment %u (needs %llu bytes, has %zu)",
                          i, (unsigned long long)s.offset + s.file_bytes, image->size);
        uint8_t *to = place(memory, s.address, s.file_bytes);
        if (!to)
            return refuse(
                image, MR_VERSION,
                "segment %u at 0x%08x (%u bytes) lies outside the STM32F407ZG's memories; "
                "is it for another chip?",
                i, (unsigned)s.address, (unsigned)s.file_bytes);
        flash |= s.address == HIL_FLASH_BASE;
        if (copy)
            memcpy(to, image->bytes + s.offset, s.file_bytes);
    }
    if (!flash)
        return refuse(image, MR_VERSION, "has no vector table at 0x%08x; is it for another chip?",
                      (unsigned)HIL_FLASH_BASE);
    return MR_OK;
}

enum mr_status hil_elf_load(const char *path, struct hil_memory *memory, char *error, size_t size)
{
    struct image image = {.at = {path, 0, error, size}};
    enum mr_status status = read_header(&image);
    if (status == MR_OK)
        status = load_segments(&image, memory, false);
    if (status == MR_OK) {
        memset(memory->flash, 0xff, sizeof memory->flash);
        status = load_segments(&image, memory, true);
    }
    free(image.text);
    return status;
}

/* Name n of a string table, or "" when it does not end inside the file. */
static const char *string_at(const struct image *image, uint64_t table, uint32_t n)
{
    uint64_t at = table + n;
    return at < image->size && memchr(image->bytes + at, 0, image->size - at)
             ? (const char *)image->bytes + at
             : "";
}

static bool find_symbol(const struct image *image, const uint8_t *section, const uint8_t *sections,
                        uint32_t count, const char *name, uint32_t *address)
{
    uint32_t offset = u32(section + 16), bytes = u32(section + 20), link = u32(section + 24);
    if ((uint64_t)offset + bytes > image->size || link >= count)
        return false;
    uint32_t names = u32(sections + link * SECTION_HEADER_BYTES + 16);
    for (uint32_t i = 0; i + SYMBOL_BYTES <= bytes; i += SYMBOL_BYTES) {
        const uint8_t *symbol = image->bytes + offset + i;
        if (u16(symbol + 14) == 0 || strcmp(string_at(image, names, u32(symbol)), name) != 0)
            continue;
        *address = u32(symbol + 4) & ((symbol[12] & 15u) == SYMBOL_FUNCTION ? ~1u : ~0u);
        return true;
    }
    return false;
}

enum mr_status hil_elf_symbol(const char *path, const char *name, uint32_t *address)
{
    char error[256];
    struct image image = {.at = {path, 0, error, sizeof error}};
    enum mr_status status = read_header(&image);
    bool found = false;
    if (status == MR_OK && u16(image.bytes + 46) == SECTION_HEADER_BYTES) {
        uint32_t at = u32(image.bytes + 32), count = u16(image.bytes + 48);
        const uint8_t *sections = image.bytes + at;
        bool whole = (uint64_t)at + (uint64_t)count * SECTION_HEADER_BYTES <= image.size;
        for (uint32_t i = 0; whole && !found && i < count; i++) {
            const uint8_t *section = sections + i * SECTION_HEADER_BYTES;
            if (u32(section + 4) == SECTION_SYMBOLS)
                found = find_symbol(&image, section, sections, count, name, address);
        }
    }
    free(image.text);
    return found ? MR_OK : MR_UNKNOWN;
}

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
