#include "hil/core/elf.h"

#include <elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hil/core/file_place.h"
#include "hil/core/core.h"

#define FILE_MAX_BYTES (64u * 1024u * 1024u) /* an image may include debug information */

#define refuse_image(image, ...) hil_file_refuse(&(image)->context, __VA_ARGS__)

struct image {
    struct hil_file_context context;
    union {
        char *text;
        const uint8_t *bytes;
        const Elf32_Ehdr *header;
    };
    size_t size;
};

static enum mr_status check_header(const struct image *image)
{
    const Elf32_Ehdr *h = image->header;
    if (image->size < SELFMAG || memcmp(h->e_ident, ELFMAG, SELFMAG) != 0)
        return refuse_image(image, MR_MALFORMED, "not an ELF file; give the firmware's .elf");
    if (image->size < sizeof *h)
        return refuse_image(image, MR_TRUNCATED, "the file ends inside its ELF header");
    if (h->e_ident[EI_CLASS] != ELFCLASS32 || h->e_ident[EI_DATA] != ELFDATA2LSB ||
        h->e_machine != EM_ARM)
        return refuse_image(image, MR_VERSION,
                            "the image is not for a 32-bit little-endian ARM (class %u, data %u, "
                            "machine %u); give an image for the STM32F407",
                            h->e_ident[EI_CLASS], h->e_ident[EI_DATA], h->e_machine);
    if (h->e_type != ET_EXEC)
        return refuse_image(image, MR_MALFORMED,
                            "the file is an ELF file of type %u, not a linked executable",
                            h->e_type);
    if (h->e_phentsize < sizeof(Elf32_Phdr) || h->e_phnum == 0)
        return refuse_image(image, MR_MALFORMED,
                            "the ELF file has no program headers, so it has no data to load");
    if (h->e_phoff + (uint64_t)h->e_phentsize * h->e_phnum > image->size)
        return refuse_image(image, MR_TRUNCATED, "the file ends inside its program headers");
    return MR_OK;
}

static enum mr_status read_header(struct image *image)
{
    enum mr_status status = hil_file_read(&image->context, FILE_MAX_BYTES,
                                          "build the firmware, or give a different file with --elf",
                                          &image->text, &image->size);
    return status == MR_OK ? check_header(image) : status;
}

/* Returns the number of bytes to skip at the start of a segment: a linker that aligns segments to
 * pages may include the headers of the file before the first section, and these must not be
 * loaded. */
static uint32_t count_header_bytes(const struct image *image, const Elf32_Phdr *s)
{
    static const uint32_t memories[] = {HIL_FLASH_BASE, HIL_SRAM_BASE, HIL_CCM_BASE};
    const Elf32_Ehdr *h = image->header;
    uint32_t end = sizeof *h; /* end of the headers in the file */
    if (h->e_phoff == sizeof *h)
        end += (uint32_t)h->e_phentsize * h->e_phnum;
    bool first = s->p_offset < end;
    if (!first && (s->p_filesz < SELFMAG || memcmp(image->bytes + s->p_offset, ELFMAG, SELFMAG)))
        return 0;
    for (unsigned i = 0; i < sizeof memories / sizeof memories[0]; i++) {
        if (s->p_paddr < memories[i] && memories[i] - s->p_paddr < s->p_filesz)
            return memories[i] - s->p_paddr;
    }
    return first && end - s->p_offset < s->p_filesz ? end - s->p_offset : 0;
}

/* Loads the segments. Called first without `memory`, to check all of them, then with it. */
static enum mr_status load_segments(const struct image *image, struct hil_memory *memory, bool copy)
{
    const Elf32_Ehdr *h = image->header;
    bool flash = false, headers = false;
    for (unsigned i = 0; i < h->e_phnum; i++) {
        Elf32_Phdr s;
        memcpy(&s, image->bytes + h->e_phoff + i * h->e_phentsize, sizeof s);
        if (s.p_type != PT_LOAD || s.p_filesz == 0)
            continue;
        if ((uint64_t)s.p_offset + s.p_filesz > image->size)
            return refuse_image(
                image, MR_TRUNCATED,
                "the file ends inside segment %u (the segment needs %llu bytes, the file has %zu)",
                i, (unsigned long long)s.p_offset + s.p_filesz, image->size);
        uint32_t skipped = count_header_bytes(image, &s);
        headers |= skipped && s.p_paddr == HIL_FLASH_BASE;
        s.p_offset += skipped;
        s.p_paddr += skipped;
        s.p_filesz -= skipped;
        uint8_t *to = hil_memory_host_address(memory, s.p_paddr, s.p_filesz);
        if (!to)
            return refuse_image(image, MR_VERSION,
                                "segment %u at 0x%08x (%u bytes) is outside the memories of the "
                                "STM32F407ZG; give an image for this chip",
                                i, s.p_paddr, s.p_filesz);
        flash |= s.p_paddr == HIL_FLASH_BASE;
        if (copy)
            memcpy(to, image->bytes + s.p_offset, s.p_filesz);
    }
    if (!flash)
        return refuse_image(
            image, MR_VERSION, "the image has no vector table at 0x%08x; %s",
            (unsigned)HIL_FLASH_BASE,
            headers ? "link with -n, because the headers of the file are at that address"
                    : "give an image for this chip");
    return MR_OK;
}

enum mr_status hil_elf_load(const char *path, struct hil_memory *memory, char *error, size_t size)
{
    struct image image = {.context = {path, 0, error, size}};
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

/* Returns the string at offset n of a string table; "" if it does not end inside the file. */
static const char *get_string(const struct image *image, uint64_t table, uint32_t n)
{
    uint64_t at = table + n;
    return at < image->size && memchr(image->bytes + at, 0, image->size - at)
             ? (const char *)image->bytes + at
             : "";
}

static bool find_symbol(const struct image *image, const Elf32_Shdr *table, uint32_t names,
                        const char *name, uint32_t *address)
{
    for (uint32_t i = 0; i + sizeof(Elf32_Sym) <= table->sh_size; i += sizeof(Elf32_Sym)) {
        Elf32_Sym s;
        memcpy(&s, image->bytes + table->sh_offset + i, sizeof s);
        if (s.st_shndx == SHN_UNDEF || strcmp(get_string(image, names, s.st_name), name) != 0)
            continue;
        *address = s.st_value & (ELF32_ST_TYPE(s.st_info) == STT_FUNC ? ~1u : ~0u);
        return true;
    }
    return false;
}

enum mr_status hil_elf_find_symbol(const char *path, const char *name, uint32_t *address)
{
    char error[256];
    struct image image = {.context = {path, 0, error, sizeof error}};
    enum mr_status status = read_header(&image);
    const Elf32_Ehdr *h = image.header;
    bool found = false;
    if (status == MR_OK && h->e_shentsize == sizeof(Elf32_Shdr) &&
        h->e_shoff + (uint64_t)h->e_shnum * sizeof(Elf32_Shdr) <= image.size) {
        for (uint32_t i = 0; !found && i < h->e_shnum; i++) {
            Elf32_Shdr table, names;
            memcpy(&table, image.bytes + h->e_shoff + i * sizeof table, sizeof table);
            if (table.sh_type != SHT_SYMTAB || table.sh_link >= h->e_shnum ||
                (uint64_t)table.sh_offset + table.sh_size > image.size)
                continue;
            memcpy(&names, image.bytes + h->e_shoff + table.sh_link * sizeof names, sizeof names);
            found = find_symbol(&image, &table, names.sh_offset, name, address);
        }
    }
    free(image.text);
    return found ? MR_OK : MR_UNKNOWN;
}

enum mr_status hil_symbols_read(struct mr_symbols *symbols, const char *path, char *error,
                                size_t size)
{
    const struct hil_file_context at = {path, 0, error, size};
    size_t n = 0, room = 0;
    char *bytes;
    *symbols = (struct mr_symbols){0};
    enum mr_status status = hil_file_read(
        &at, FILE_MAX_BYTES, "build the firmware, or give a different file with --elf", &bytes, &n);
    symbols->file = (uint8_t *)bytes;
    if (status != MR_OK)
        return status;
    status = mr_symbols_count(symbols->file, n, &room);
    if (status == MR_OK) {
        symbols->entries = calloc(room + 1, sizeof *symbols->entries);
        status = symbols->entries ? mr_symbols_read(symbols->file, n, symbols->entries, symbols)
                                  : MR_IO;
    }
    if (status == MR_MALFORMED)
        return hil_file_refuse(&at, status,
                               "the file is not a 32-bit ELF file; give the firmware's .elf");
    return status == MR_OK
             ? MR_OK
             : hil_file_refuse(&at, status,
                               "the file ends inside its symbol table; build the firmware again");
}

void hil_symbols_free(struct mr_symbols *symbols)
{
    free(symbols->entries);
    free(symbols->file);
    *symbols = (struct mr_symbols){0};
}
