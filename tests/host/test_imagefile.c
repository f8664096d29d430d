/* Image files: the three formats say the same, and what is wrong with one is one clear error. The
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
    mr_image_put(&image, content);
}

/* ---- writers ---- */

static size_t record(char *out, unsigned address, unsigned type, const uint8_t *data,
                     unsigned count)
{
    unsigned sum = count + (address >> 8) + (address & 0xff) + type;
    int n = sprintf(out, ":%02X%04X%02X", count, address, type);
    for (unsigned i = 0; i < count; i++) {
        n += sprintf(out + n, "%02X", data[i]);
        sum += data[i];
    }
    return (size_t)(n + sprintf(out + n, "%02X\r\n", (unsigned)(uint8_t)(0x100u - (sum & 0xff))));
}

static size_t hex_run(char *out, uint32_t from, uint32_t to)
{
    size_t n = 0;
    for (uint32_t at = from; at < to; at += 16)
        n += record(out + n, at & 0xffff, 0, content + at, to - at < 16 ? to - at : 16);
    return n;
}

static size_t make_hex(char *out)
{
    const uint8_t low[2] = {0x08, 0x00}, high[2] = {0x08, 0x01},
                  start[4] = {0x08, 0x01, 0x00, 0x05};
    size_t n = record(out, 0, 4, low, 2);
    n += hex_run(out + n, 0, MR_IMAGE_HEAD);
    n += record(out + n, 0, 4, high, 2);
    n += hex_run(out + n, PROGRAM, PROGRAM + PROGRAM_BYTES);
    n += record(out + n, 0, 5, start, 4);
    return n + record(out + n, 0, 1, NULL, 0);
}

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
         .p_filesz = MR_IMAGE_HEAD,
         .p_memsz = MR_IMAGE_HEAD},
        {.p_type = PT_LOAD,
         .p_offset = (Elf32_Off)data + MR_IMAGE_HEAD,
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
    memcpy(out + data, content, MR_IMAGE_HEAD);
    memcpy(out + data + MR_IMAGE_HEAD, content + PROGRAM, PROGRAM_BYTES);
    return data + MR_IMAGE_HEAD + PROGRAM_BYTES;
}

/* ---- reading ---- */

static void reads(const char *path)
{
    struct imagefile image;
    struct error error = {0};
    if (imagefile_read(path, &image, &error) != MR_OK)
        fail_msg("%s", error.text);
    assert_true(image.stamped);
    assert_int_equal(image.header.commit, 0xc7a3136a);
    assert_int_equal(image.count, MR_IMAGE_HEAD + PROGRAM_BYTES);
    assert_memory_equal(image.bytes, content, sizeof content);
    for (uint32_t i = 0; i < IMAGEFILE_BYTES; i++)
        assert_int_equal(image.given[i],
                         i < MR_IMAGE_HEAD || (i >= PROGRAM && i < PROGRAM + PROGRAM_BYTES));
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
    static char hex[20000];
    static uint8_t elf[20000];
    make_content();
    scratch_write("a.bin", content, sizeof content);
    scratch_write("a.hex", hex, make_hex(hex));
    scratch_write("a.elf", elf, make_elf(elf));
    reads("a.bin");
    reads("a.hex");
    reads("a.elf");
}

static void hex_of_segments(void **state) /* type 2: 16 times the value is added */
{
    (void)state;
    static char hex[20000];
    const uint8_t segment[2] = {0x10, 0x00};
    make_content();
    size_t n = record(hex, 0, 2, segment, 2);
    n += record(hex + n, 0, 0, content, 16);
    (void)record(hex + n, 0, 1, NULL, 0);
    scratch_write("seg.hex", hex, strlen(hex));
    refused("seg.hex", MR_MALFORMED, "outside the flash (0x00010000)");
}

static void bad_hex(void **state)
{
    (void)state;
    static char hex[20000], bad[20000];
    make_content();
    size_t n = make_hex(hex);
    hex[n] = '\0';
    scratch_write("b.hex", hex, n - 13); /* the end record is 11 characters and a line end */
    refused("b.hex", MR_TRUNCATED, "no end record");
    scratch_write("b.hex", hex, 300);
    refused("b.hex", MR_MALFORMED, "no record of Intel HEX: line 8");
    /* every digit of one record turned into another: its checksum, or its length, tells */
    size_t begin = (size_t)(strchr(hex, '\n') - hex) + 1,
           end = (size_t)(strchr(hex + begin, '\r') - hex);
    for (size_t i = begin + 1; i < end; i++) {
        struct imagefile image;
        struct error error = {0};
        memcpy(bad, hex, n);
        bad[i] = hex[i] == '0' ? '1' : '0';
        scratch_write("b.hex", bad, n);
        enum mr_status status = imagefile_read("b.hex", &image, &error);
        assert_true(status == MR_CRC || status == MR_MALFORMED);
        assert_non_null(strstr(error.text, "line 2"));
        imagefile_free(&image);
    }
    memcpy(bad, hex, n);
    memcpy(bad + n, hex, n);
    scratch_write("b.hex", bad, 2 * n);
    refused("b.hex", MR_MALFORMED, "after its end record");
    scratch_write("b.hex", ":0000000600\n:00000001FF\n", 24);
    refused("b.hex", MR_CRC, "line 1");
    scratch_write("b.hex", ":00000006FA\n:00000001FF\n", 24);
    refused("b.hex", MR_MALFORMED, "unknown record (type 6");
    scratch_write("b.hex", ":020000040800F2\n:0100000001FE\n:0100000002FD\n:00000001FF\n", 56);
    refused("b.hex", MR_MALFORMED, "two values for 0x08000000: line 3");
    scratch_write("b.hex", ":020000040800F2\n:01800000007F\n:00000001FF\n", 42);
    refused("b.hex", MR_MALFORMED, "where the configuration is kept");
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
    refused("c.elf", MR_MALFORMED, "another machine (ELF class 1, machine 3;");
    bad[EI_CLASS] = ELFCLASS64;
    ((Elf32_Ehdr *)(void *)bad)->e_machine = EM_ARM;
    scratch_write("c.elf", bad, n);
    refused("c.elf", MR_MALFORMED, "another machine");
    memcpy(bad, elf, n);
    ((Elf32_Ehdr *)(void *)bad)->e_type = ET_REL;
    scratch_write("c.elf", bad, n);
    refused("c.elf", MR_MALFORMED, "not linked yet");
    static const size_t cuts[] = {4, 51, 60, 147, 200};
    for (unsigned i = 0; i < 5; i++) {
        scratch_write("c.elf", elf, cuts[i]);
        refused("c.elf", MR_TRUNCATED, "it ends inside");
    }
    scratch_write("c.elf", elf, n - 1);
    refused("c.elf", MR_TRUNCATED, "it ends inside segment 1");
}

static void bad_bin(void **state)
{
    (void)state;
    make_content();
    content[0x9000] = 'c';
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_MALFORMED,
            "it holds something at 0x08009000, where the configuration is kept");
    make_content();
    /* cut off: the header knows how long it was */
    scratch_write("d.bin", content, sizeof content - 1);
    refused("d.bin", MR_CRC, "its header says");
    content[PROGRAM + 50] ^= 1;
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_CRC, "its header says");
    make_content();
    content[0x20]++;
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_CRC, "vectors or header are damaged");
    make_content();
    put_word(content, 0x40001000);
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_MALFORMED, "no vectors of an STM32F407 (stack 0x40001000");
    make_content();
    put_word(content + 4, 0x08010004); /* without its Thumb bit */
    scratch_write("d.bin", content, sizeof content);
    refused("d.bin", MR_MALFORMED, "entry 0x08010004");
    uint8_t *large = calloc(1, IMAGEFILE_BYTES + 1);
    scratch_write("d.bin", large, IMAGEFILE_BYTES + 1);
    free(large);
    refused("d.bin", MR_TOO_LONG, "more than the flash has");
}

static void no_image_at_all(void **state)
{
    (void)state;
    scratch_write("e.elf", "", 0);
    refused("e.elf", MR_TRUNCATED, "an empty file");
    scratch_write("e.bin", "", 0);
    refused("e.bin", MR_TRUNCATED, "an empty file");
    scratch_write("e.txt", "hello", 5);
    refused("e.txt", MR_MALFORMED, "neither ELF nor Intel HEX, nor named .bin");
    refused("nowhere.elf", MR_IO, "no firmware image");
    scratch_write("short.bin", "\0\20\0\40\5\0\1\10", 8);
    refused("short.bin", MR_MALFORMED, "no vectors");
}

static void an_image_without_header_is_known_for_it(void **state)
{
    (void)state;
    struct imagefile image;
    struct error error = {0};
    make_content();
    memset(content + MR_IMAGE_PLACE, 0xff, MR_IMAGE_BYTES);
    scratch_write("f.bin", content, sizeof content);
    assert_int_equal(imagefile_read("f.bin", &image, &error), MR_OK);
    assert_false(image.stamped);
    imagefile_free(&image);
    make_content();
    content[MR_IMAGE_PLACE + 4] = 2;
    scratch_write("f.bin", content, sizeof content);
    refused("f.bin", MR_VERSION, "of another format");
}

int main(void)
{
    scratch_begin();
    mkdir("build/test-tmp/imagefile", 0777);
    if (chdir("build/test-tmp/imagefile") != 0)
        return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_formats_say_the_same),
        cmocka_unit_test(hex_of_segments),
        cmocka_unit_test(bad_hex),
        cmocka_unit_test(bad_elf),
        cmocka_unit_test(bad_bin),
        cmocka_unit_test(no_image_at_all),
        cmocka_unit_test(an_image_without_header_is_known_for_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
