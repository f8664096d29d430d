/* Image files: both formats say the same, and what is wrong with one is one clear error. The
 * files are written here byte by byte, from the formats' own descriptions. */
#include <elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/crc32.h"
#include "host/board/imagefile.h"
#include "tests/cmocka_all.h"
#include "tests/host/scratch.h"

#define PROGRAM       0x10000u
#define PROGRAM_BYTES 100u

static uint8_t content[PROGRAM + PROGRAM_BYTES]; /* as a .bin: flash from its start */

static void put_word(uint8_t *p, uint32_t value)
{
    for (unsigned i = 0; i < 4; i++)
        p[i] = (uint8_t)(value >> 8 * i);
}

static void make_content(void)
{
    struct mr_image image = {.major = 1,
                             .minor = 2,
                             .patch = 3,
                             .commit = 0xc7a3136a,
                             .commit_more = 0xb3a3,
                             .program_start = 0x08010000,
                             .program_end = 0x08010000 + PROGRAM_BYTES};
    memset(content, 0xff, sizeof content);
    put_word(content, 0x20001000);
    put_word(content + 4, 0x08010005);
    for (unsigned i = 0; i < PROGRAM_BYTES; i++)
        content[PROGRAM + i] = (uint8_t)(i * 3u);
    memset(content + PROGRAM + 40, 0xff, 20); /* blank bytes in a program belong to it */
    image.program_crc = mr_crc32(0, content + PROGRAM, PROGRAM_BYTES);
    mr_image_encode(&image, content);
}

/* ---- writers ---- */

static size_t make_elf(uint8_t *out)
{
    Elf32_Ehdr head = {.e_type = ET_EXEC,
                       .e_machine = EM_ARM,
                       .e_version = 1,
                       .e_phoff = sizeof head,
                       .e_ehsize = sizeof head,
                       .e_phentsize = sizeof(Elf32_Phdr),
                       .e_phnum = 3};
    memcpy(head.e_ident, "\177ELF\1\1\1", 7);
    size_t data = sizeof head + 3 * sizeof(Elf32_Phdr);
    const Elf32_Phdr parts[3] = {
        {.p_type = PT_LOAD,
         .p_offset = (Elf32_Off)data,
         .p_vaddr = 0x08000000,
         .p_paddr = 0x08000000,
         .p_filesz = MR_IMAGE_HEAD_BYTES,
         .p_memsz = MR_IMAGE_HEAD_BYTES},
        {.p_type = PT_LOAD,
         .p_offset = (Elf32_Off)data + MR_IMAGE_HEAD_BYTES,
         .p_vaddr = 0x20001000,
         .p_paddr = 0x08010000,
         /* initial data: loaded where p_paddr says */
         .p_filesz = PROGRAM_BYTES,
         .p_memsz = 4 * PROGRAM_BYTES},
        /* a stack, nothing in the file */
        {.p_type = PT_LOAD,
         .p_offset = 0,
         .p_vaddr = 0x20000000,
         .p_paddr = 0x20000000,
         .p_memsz = 4096},
    };
    memcpy(out, &head, sizeof head);
    memcpy(out + sizeof head, parts, sizeof parts);
    memcpy(out + data, content, MR_IMAGE_HEAD_BYTES);
    memcpy(out + data + MR_IMAGE_HEAD_BYTES, content + PROGRAM, PROGRAM_BYTES);
    return data + MR_IMAGE_HEAD_BYTES + PROGRAM_BYTES;
}

/* ---- reading ---- */

static void reads(const char *path)
{
    struct imagefile image;
    struct error error = {0};
    if (imagefile_read(path, &image, &error) != MR_OK)
        fail_msg("%s", error.text);
    assert_true(image.has_header);
    assert_int_equal(image.header.commit, 0xc7a3136a);
    assert_int_equal(image.present_count, MR_IMAGE_HEAD_BYTES + PROGRAM_BYTES);
    assert_memory_equal(image.bytes, content, sizeof content);
    for (uint32_t i = 0; i < IMAGEFILE_BYTES; i++)
        assert_int_equal(image.is_present[i],
                         i < MR_IMAGE_HEAD_BYTES || (i >= PROGRAM && i < PROGRAM + PROGRAM_BYTES));
    imagefile_free(&image);
}

static void refused(const char *path, enum mr_status status, const char *what)
{
    struct imagefile image;
    struct error error = {0};
    assert_int_equal(imagefile_read(path, &image, &error), status);
    print_message("# %s\n", error.text);
    assert_non_null(strstr(error.text, what));
    assert_non_null(strstr(error.text, path));
    imagefile_free(&image);
}

static void the_formats_say_the_same(void **state)
{
    (void)state;
    static uint8_t elf[20000];
    make_content();
    scratch_write("a.bin", content, sizeof content);
    scratch_write("a.elf", elf, make_elf(elf));
    reads("a.bin");
    reads("a.elf");
}

static void bad_elf(void **state)
{
    (void)state;
    static uint8_t elf[20000], bad[20000];
    make_content();
    size_t n = make_elf(elf);
    memcpy(bad, elf, n);
    ((Elf32_Ehdr *)(void *)bad)->e_machine = EM_386;
    scratch_write("c.elf", bad, n);
    refused("c.elf", MR_MALFORMED, "different machine (ELF class 1 and machine 3,");
    bad[EI_CLASS] = ELFCLASS64;
    ((Elf32_Ehdr *)(void *)bad)->e_machine = EM_ARM;
    scratch_write("c.elf", bad, n);
    refused("c.elf", MR_MALFORMED, "different machine");
    memcpy(bad, elf, n);
    ((Elf32_Ehdr *)(void *)bad)->e_type = ET_REL;
    scratch_write("c.elf", bad, n);
    refused("c.elf", MR_MALFORMED, "not a linked program");
    static const size_t cuts[] = {4, 51, 60, 147, 200};
    for (unsigned i = 0; i < 5; i++) {
        scratch_write("c.elf", elf, cuts[i]);
        refused("c.elf", MR_TRUNCATED, "the file ends inside");
    }
    scratch_write("c.elf", elf, n - 1);
    refused("c.elf", MR_TRUNCATED, "the file ends inside segment 1");
}

static void bad_bin(void **state)
{
    (void)state;
    make_content();
    content[0x9000] = 'c';
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_MALFORMED,
            "the image has data at 0x08009000, inside the configuration area");
    make_content();
    /* cut off: the header knows how long it was */
    scratch_write("d.bin", content, sizeof content - 1);
    refused("d.bin", MR_CRC, "the header states");
    content[PROGRAM + 50] ^= 1;
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_CRC, "the header states");
    make_content();
    content[0x20]++;
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_CRC, "vectors or the header are damaged");
    make_content();
    put_word(content, 0x40001000);
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_MALFORMED, "no valid vectors of an STM32F407 (stack 0x40001000");
    make_content();
    put_word(content + 4, 0x08010004); /* without its Thumb bit */
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_MALFORMED, "entry 0x08010004");
    uint8_t *large = calloc(1, IMAGEFILE_BYTES + 1);
    scratch_write("d.bin", large, IMAGEFILE_BYTES + 1);
    free(large);
    refused("d.bin", MR_TOO_LONG, "but the flash holds only");
}

static void no_image_at_all(void **state)
{
    (void)state;
    scratch_write("e.elf", "", 0);
    refused("e.elf", MR_TRUNCATED, "the image file is empty");
    scratch_write("e.bin", "", 0);
    refused("e.bin", MR_TRUNCATED, "the image file is empty");
    scratch_write("e.txt", "hello", 5);
    refused("e.txt", MR_MALFORMED, "neither an ELF file nor named .bin");
    refused("nowhere.elf", MR_IO, "no firmware image");
    scratch_write("short.bin", "\0\20\0\40\5\0\1\10", 8);
    refused("short.bin", MR_MALFORMED, "no valid vectors");
}

static void an_image_without_header_is_known_for_it(void **state)
{
    (void)state;
    struct imagefile image;
    struct error error = {0};
    make_content();
    memset(content + MR_IMAGE_OFFSET, 0xff, MR_IMAGE_BYTES);
    scratch_write("f.bin", content, sizeof content);
    assert_int_equal(imagefile_read("f.bin", &image, &error), MR_OK);
    assert_false(image.has_header);
    imagefile_free(&image);
    make_content();
    content[MR_IMAGE_OFFSET + 4] = 2;
    scratch_write("f.bin", content, sizeof content);
    refused("f.bin", MR_VERSION, "of a different format");
}

int main(void)
{
    scratch_begin();
    mkdir("build/test-tmp/imagefile", 0777);
    if (chdir("build/test-tmp/imagefile") != 0)
        return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_formats_say_the_same),
        cmocka_unit_test(bad_elf),
        cmocka_unit_test(bad_bin),
        cmocka_unit_test(no_image_at_all),
        cmocka_unit_test(an_image_without_header_is_known_for_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
