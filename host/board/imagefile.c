#include "host/board/imagefile.h"

#include <elf.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/crc32.h"
#include "common/wire.h"
#include "host/base/xmalloc.h"

#define FILE_BYTES_MAX (64u << 20) /* large enough for an ELF file with debug information */

struct image_source {
    const char *path;
    uint8_t *bytes;
    size_t length;
};

static enum mr_status read_source(struct image_source *source, struct error *error)
{
    FILE *file = fopen(source->path, "rb");
    if (!file)
        return error_set(error, MR_IO, "no firmware image (%s): %s; build the image with make all",
                         strerror(errno), source->path);
    source->bytes = xmalloc(FILE_BYTES_MAX);
    source->length = fread(source->bytes, 1, FILE_BYTES_MAX, file);
    bool failed = ferror(file) != 0;
    fclose(file);
    if (failed)
        return error_set(error, MR_IO, "cannot read the image (%s): %s; give the name of a file",
                         strerror(errno), source->path);
    if (source->length == FILE_BYTES_MAX)
        return error_set(
            error, MR_TOO_LONG,
            "larger than any firmware image: %s; give the .elf or .bin of the firmware",
            source->path);
    if (source->length == 0)
        return error_set(error, MR_TRUNCATED, "the image file is empty: %s; build the image again",
                         source->path);
    return MR_OK;
}

/* Adds one byte to the image. `place`: its position in the file, for error messages. */
static enum mr_status add_byte(struct imagefile *image, uint64_t address, uint8_t byte,
                               const char *place, struct error *error)
{
    uint64_t at = address - MR_FLASH;
    if (address < MR_FLASH || at >= IMAGEFILE_BYTES)
        return error_set(
            error, MR_MALFORMED,
            "data outside the flash (address 0x%08llx): %s of %s; give the image for this board",
            (unsigned long long)address, place, image->path);
    if (at >= IMAGEFILE_CONFIGURATION_START && at < IMAGEFILE_CONFIGURATION_END)
        return error_set(error, MR_MALFORMED,
                         "the image has data at 0x%08llx, inside the configuration area (0x%08x to "
                         "0x%08x): %s of %s; flash the unmodified image",
                         (unsigned long long)address, (unsigned)MR_CONFIGURATION,
                         (unsigned)(MR_CONFIGURATION + MR_CONFIGURATION_BYTES - 1), place,
                         image->path);
    if (image->is_present[at] && image->bytes[at] != byte)
        return error_set(error, MR_MALFORMED,
                         "two sections have different contents for address 0x%08llx: %s of %s; "
                         "build the image again",
                         (unsigned long long)address, place, image->path);
    image->present_count += !image->is_present[at];
    image->is_present[at] = 1;
    image->bytes[at] = byte;
    return MR_OK;
}

/* ---- ELF ---- */

static enum mr_status add_segment(struct imagefile *image, const struct image_source *source,
                                  const Elf32_Phdr *part, unsigned number, struct error *error)
{
    char place[40];
    enum mr_status status = MR_OK;
    snprintf(place, sizeof place, "segment %u", number);
    if (part->p_offset > source->length || part->p_filesz > source->length - part->p_offset)
        return error_set(error, MR_TRUNCATED, "the file ends inside %s: %s; build the image again",
                         place, source->path);
    for (uint32_t i = 0; status == MR_OK && i < part->p_filesz; i++)
        status = add_byte(image, (uint64_t)part->p_paddr + i, source->bytes[part->p_offset + i],
                          place, error);
    return status;
}

static enum mr_status read_elf(struct imagefile *image, const struct image_source *source,
                               struct error *error)
{
    Elf32_Ehdr head;
    enum mr_status status = MR_OK;
    if (source->length < sizeof head)
        return error_set(error, MR_TRUNCATED,
                         "the file ends inside its header: %s; build the image again",
                         source->path);
    memcpy(&head, source->bytes, sizeof head);
    if (head.e_ident[EI_CLASS] != ELFCLASS32 || head.e_ident[EI_DATA] != ELFDATA2LSB ||
        head.e_machine != EM_ARM)
        return error_set(error, MR_MALFORMED,
                         "program for a different machine (ELF class %u and machine %u, but 32-bit "
                         "ARM has 1 and 40): %s; give the .elf of the firmware",
                         head.e_ident[EI_CLASS], head.e_machine, source->path);
    if (head.e_type != ET_EXEC)
        return error_set(error, MR_MALFORMED,
                         "not a linked program (ELF type %u): %s; give the .elf of the firmware",
                         head.e_type, source->path);
    if (head.e_phentsize != sizeof(Elf32_Phdr) || head.e_phoff > source->length ||
        (uint64_t)head.e_phnum * sizeof(Elf32_Phdr) > source->length - head.e_phoff)
        return error_set(error, MR_TRUNCATED,
                         "the file ends inside its table of segments: %s; build the image again",
                         source->path);
    for (unsigned i = 0; status == MR_OK && i < head.e_phnum; i++) {
        Elf32_Phdr part;
        memcpy(&part, source->bytes + head.e_phoff + i * sizeof part, sizeof part);
        if (part.p_type == PT_LOAD)
            status = add_segment(image, source, &part, i, error);
    }
    return status;
}

/* ---- raw ---- */

static enum mr_status read_bin(struct imagefile *image, const struct image_source *source,
                               struct error *error)
{
    enum mr_status status = MR_OK;
    size_t low = source->length < IMAGEFILE_CONFIGURATION_START ? source->length
                                                                : IMAGEFILE_CONFIGURATION_START;
    if (source->length > IMAGEFILE_BYTES)
        return error_set(
            error, MR_TOO_LONG,
            "the image has %zu bytes, but the flash holds only %u: %s; give a firmware image",
            source->length, IMAGEFILE_BYTES, source->path);
    while (low && source->bytes[low - 1] == 0xff)
        low--;
    for (size_t i = 0; status == MR_OK && i < source->length; i++) {
        bool spared = i >= low && i < IMAGEFILE_CONFIGURATION_END && source->bytes[i] == 0xff;
        if (!spared)
            status = add_byte(image, MR_FLASH + i, source->bytes[i], "a byte", error);
    }
    return status;
}

/* ---- checks ---- */

static enum mr_status check_vectors(const struct imagefile *image, struct error *error)
{
    const uint8_t *p = image->bytes;
    uint32_t stack = mr_get_u32(&p), entry = mr_get_u32(&p);
    uint32_t at = (entry & ~1u) - MR_FLASH;
    bool in_ram = (stack > MR_RAM && stack <= MR_RAM + MR_RAM_BYTES) ||
                  (stack > MR_CCM && stack <= MR_CCM + MR_CCM_BYTES);
    if (!image->is_present[0] || !image->is_present[7] || !in_ram || !(entry & 1u) ||
        at >= IMAGEFILE_BYTES || !image->is_present[at])
        return error_set(error, MR_MALFORMED,
                         "no valid vectors of an STM32F407 (stack 0x%08x, entry 0x%08x): %s; give "
                         "the image of the firmware",
                         (unsigned)stack, (unsigned)entry, image->path);
    return MR_OK;
}

static enum mr_status check_header(struct imagefile *image, struct error *error)
{
    enum mr_status status = mr_image_decode(&image->header, image->bytes);
    if (status == MR_UNKNOWN)
        return MR_OK;
    if (status == MR_VERSION)
        return error_set(error, MR_VERSION,
                         "image header of a different format: %s; use the matrig version that "
                         "belongs to the image",
                         image->path);
    if (status != MR_OK)
        return error_set(error, MR_CRC,
                         "the vectors or the header are damaged: %s; build or copy the image again",
                         image->path);
    uint32_t start = image->header.program_start - MR_FLASH,
             end = image->header.program_end - MR_FLASH;
    uint32_t crc = mr_crc32(0, image->bytes + start, end - start);
    if (crc != image->header.program_crc)
        return error_set(error, MR_CRC,
                         "the program's CRC is %08x, but the header states %08x: %s; the image is "
                         "damaged or truncated, build or copy it again",
                         (unsigned)crc, (unsigned)image->header.program_crc, image->path);
    image->has_header = true;
    return MR_OK;
}

static bool has_bin_extension(const char *path)
{
    size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".bin") == 0;
}

enum mr_status imagefile_read(const char *path, struct imagefile *image, struct error *error)
{
    struct image_source source = {.path = path};
    *image = (struct imagefile){
        .path = path, .bytes = xmalloc(IMAGEFILE_BYTES), .is_present = xcalloc(IMAGEFILE_BYTES, 1)};
    memset(image->bytes, 0xff, IMAGEFILE_BYTES);
    enum mr_status status = read_source(&source, error);
    if (status == MR_OK && source.length >= SELFMAG && memcmp(source.bytes, ELFMAG, SELFMAG) == 0)
        status = read_elf(image, &source, error);
    else if (status == MR_OK && has_bin_extension(path))
        status = read_bin(image, &source, error);
    else if (status == MR_OK)
        status = error_set(
            error, MR_MALFORMED,
            "neither an ELF file nor named .bin: %s; give the .elf or .bin of the firmware", path);
    free(source.bytes);
    if (status == MR_OK)
        status = check_vectors(image, error);
    return status ?: check_header(image, error);
}

void imagefile_free(struct imagefile *image)
{
    free(image->bytes);
    free(image->is_present);
    image->bytes = image->is_present = NULL;
}
