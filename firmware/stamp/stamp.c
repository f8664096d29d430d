/* Completes the header of a linked image (common/image.h): CRCs and commit. usage: stamp ELF
 * COMMIT, where COMMIT is the output of `git describe --always --dirty` with 12 digits, or
 * "unknown" */
#include <elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/image.h"
#include "common/crc32.h"

/* largest accepted file; most of it is debug information */
#define FILE_MAX (32u << 20)

static uint8_t file[FILE_MAX];
static size_t file_bytes;

static int fail(const char *what, const char *where)
{
    fprintf(stderr, "stamp: %s: %s; build it again\n", what, where);
    return 1;
}

/* Returns the `length` bytes of the file that are loaded at `address`; NULL if no segment contains
 * them all. */
static uint8_t *find_segment_bytes(uint32_t address, size_t length)
{
    Elf32_Ehdr head;
    memcpy(&head, file, sizeof head);
    for (unsigned i = 0; i < head.e_phnum; i++) {
        Elf32_Phdr part;
        memcpy(&part, file + head.e_phoff + i * sizeof part, sizeof part);
        if (part.p_type == PT_LOAD && address >= part.p_paddr &&
            address - part.p_paddr + length <= part.p_filesz)
            return file + part.p_offset + (address - part.p_paddr);
    }
    return NULL;
}

/* CRC over consecutive segments; gaps between them count as erased flash. */
static uint32_t compute_program_crc(uint32_t start, uint32_t end)
{
    uint32_t crc = 0;
    for (uint32_t at = start; at < end; at++) {
        static const uint8_t erased = 0xff;
        const uint8_t *byte = find_segment_bytes(at, 1);
        crc = mr_crc32(crc, byte ? byte : &erased, 1);
    }
    return crc;
}

static int read_file(const char *path)
{
    FILE *from = fopen(path, "rb");
    file_bytes = from ? fread(file, 1, sizeof file, from) : 0;
    if (from)
        fclose(from);
    return file_bytes > sizeof(Elf32_Ehdr) && file_bytes < sizeof file &&
           memcmp(file, ELFMAG, SELFMAG) == 0;
}

static int write_file(const char *path)
{
    FILE *to = fopen(path, "r+b");
    int written = to && fwrite(file, 1, file_bytes, to) == file_bytes;
    return to && fclose(to) == 0 && written;
}

/* Accepts 12 hexadecimal digits, optionally with "-dirty", or "unknown". */
static int parse_commit(struct mr_image *image, const char *text)
{
    unsigned long long value = strtoull(text, NULL, 16);
    bool unknown = strcmp(text, "unknown") == 0;
    size_t digits = strspn(text, "0123456789abcdef");
    image->commit = unknown ? 0 : (uint32_t)(value >> 16);
    image->commit_more = unknown ? 0 : (uint16_t)value;
    image->is_modified = !unknown && text[digits] != 0;
    return unknown || (digits == 12 && (!text[12] || strcmp(text + 12, "-dirty") == 0));
}

int main(int argc, char **argv)
{
    struct mr_image image;
    if (argc != 3)
        return fail("not two words", "usage: stamp ELF COMMIT");
    if (!read_file(argv[1]))
        return fail("cannot read the image", argv[1]);
    uint8_t *head = find_segment_bytes(MR_FLASH, MR_IMAGE_HEAD_BYTES);
    enum mr_status status = head ? mr_image_decode(&image, head) : MR_UNKNOWN;
    if (status != MR_OK && status != MR_CRC)
        return fail("no header to complete", argv[1]);
    if (!mr_board_by_number(image.board))
        return fail("no such board", argv[1]);
    image.program_crc = compute_program_crc(image.program_start, image.program_end);
    if (!parse_commit(&image, argv[2]))
        return fail("not a commit", argv[2]);
    mr_image_encode(&image, head);
    return write_file(argv[1]) ? 0 : fail("cannot write the image", argv[1]);
}
