/* Flashing through a boot ROM in memory (fake_rom.h): what is erased and what is kept, every
 * single-bit corruption and every lost byte of a whole session in both directions, a cable pulled
 * at every byte and then resumed, protections, another chip, silence. */
#include <stdlib.h>

#include "host/flash/flash.h"
#include "tests/cmocka_all.h"
#include "tests/host/fake_rom.h"

#define PROGRAM       0x10000u
#define PROGRAM_BYTES 420u /* two pages */
#define CONFIGURATION 0x8000u

static struct imagefile image;
static struct chip chip, before;

static uint8_t noise(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (uint8_t)(*seed >> 24);
}

static void give(uint32_t at, uint8_t byte)
{
    image.bytes[at] = byte;
    image.given[at] = 1;
    image.count++;
}

static int make_image(void **state)
{
    (void)state;
    uint32_t seed = 7;
    image = (struct imagefile){.path = "test",
                               .bytes = malloc(IMAGEFILE_BYTES),
                               .given = calloc(IMAGEFILE_BYTES, 1),
                               .stamped = true};
    memset(image.bytes, 0xff, IMAGEFILE_BYTES);
    for (uint32_t i = 0; i < MR_IMAGE_HEAD; i++)
        give(i, noise(&seed));
    for (uint32_t i = 0; i < PROGRAM_BYTES; i++)
        give(PROGRAM + i, noise(&seed));
    return 0;
}

static int free_image(void **state)
{
    (void)state;
    imagefile_free(&image);
    return 0;
}

/* A chip with an older, longer program, and a configuration. */
static void old_chip(void)
{
    uint32_t seed = 99;
    chip_init(&chip);
    for (uint32_t i = 0; i < MR_IMAGE_HEAD; i++)
        chip.flash[i] = noise(&seed);
    for (uint32_t i = 0; i < 2000; i++)
        chip.flash[PROGRAM + i] = noise(&seed);
    for (uint32_t i = CONFIGURATION; i < PROGRAM; i++)
        chip.flash[i] = noise(&seed);
    before = chip;
}

static bool holds_image(void)
{
    return memcmp(chip.flash, image.bytes, MR_IMAGE_HEAD) == 0 &&
           memcmp(chip.flash + PROGRAM, image.bytes + PROGRAM, PROGRAM_BYTES) == 0;
}

static bool configuration_kept(void)
{
    return !chip.harm && memcmp(chip.flash + CONFIGURATION, before.flash + CONFIGURATION,
                                PROGRAM - CONFIGURATION) == 0;
}

struct session {
    enum mr_status status;
    struct flash_result result;
    struct bootrom rom;
    struct error error;
};

static struct session run(const struct flash_options *options)
{
    static const struct flash_options plain;
    static const struct bootrom_line line = {&chip, "fake", chip_line_send, chip_line_receive};
    struct session s = {0};
    s.status = bootrom_begin(&s.rom, &line, &s.error);
    if (s.status == MR_OK)
        s.status = flash_run(&s.rom, &image, options ? options : &plain, &s.result, &s.error);
    assert_int_equal(s.status != MR_OK, s.error.text[0] != '\0');
    return s;
}

/* ---- what is done, and what is not ---- */

static void flashes_what_differs(void **state)
{
    (void)state;
    old_chip();
    struct session s = run(NULL);
    assert_int_equal(s.status, MR_OK);
    assert_true(holds_image());
    assert_true(configuration_kept());
    assert_int_equal(s.result.erased, 1u << 0 | 1u << 4);
    assert_int_equal(s.result.pages, 5);
    assert_int_equal(s.result.written, 5);
    assert_int_equal(s.result.verified, MR_IMAGE_HEAD + PROGRAM_BYTES);
    assert_int_equal(s.rom.repeated, 0);
    assert_int_equal(chip.erases[0], 2); /* for the detour, and for vectors and header */
    assert_int_equal(chip.erases[4], 1);
    assert_int_equal(chip.nacks, 0);
}

static void the_same_image_is_only_read(void **state)
{
    (void)state;
    old_chip();
    assert_int_equal(run(NULL).status, MR_OK);
    memset(chip.erases, 0, sizeof chip.erases);
    chip.writes = 0;
    struct session s = run(NULL);
    assert_int_equal(s.status, MR_OK);
    assert_int_equal(s.result.erased, 0);
    assert_int_equal(chip.writes, 0);
    assert_int_equal(s.result.kept, 5);
    assert_int_equal(s.result.verified, MR_IMAGE_HEAD + PROGRAM_BYTES);
    s = run(&(struct flash_options){.all = true});
    assert_int_equal(s.status, MR_OK);
    assert_int_equal(s.result.erased, 1u << 0 | 1u << 4);
    assert_int_equal(s.result.written, 5);
}

/* Another commit, the same program: the vectors' sector alone, and no detour. */
static void another_header_is_another_sector_0(void **state)
{
    (void)state;
    old_chip();
    assert_int_equal(run(NULL).status, MR_OK);
    memset(chip.erases, 0, sizeof chip.erases);
    chip.flash[0x210] ^= 0x55;
    struct session s = run(NULL);
    assert_int_equal(s.status, MR_OK);
    assert_int_equal(s.result.erased, 1u << 0);
    assert_int_equal(chip.erases[0], 1);
    assert_true(holds_image());
}

static void the_configuration_goes_only_on_order(void **state)
{
    (void)state;
    old_chip();
    struct session s = run(&(struct flash_options){.erase_configuration = true});
    assert_int_equal(s.status, MR_OK);
    assert_int_equal(s.result.erased, 1u << 0 | 1u << 2 | 1u << 3 | 1u << 4);
    for (uint32_t i = CONFIGURATION; i < PROGRAM; i++)
        assert_int_equal(chip.flash[i], 0xff);
    assert_true(holds_image());
}

/* ---- the line ---- */

/* A session on a chip with an old program, damaged once. */
static struct session damaged(enum damage damage, enum way way, size_t at, unsigned bit)
{
    chip = before;
    chip.damage = damage;
    chip.way = way;
    chip.at = at;
    chip.bit = bit;
    return run(NULL);
}

/* Whatever happens to one bit or byte anywhere: it is noticed and made good, and nothing else is
 * touched. */
static void every(enum damage damage, enum way way)
{
    old_chip();
    struct session clean = run(NULL);
    assert_int_equal(clean.status, MR_OK);
    size_t bytes = chip.passed[way];
    unsigned cases = 0, again = 0, failed = 0;
    for (size_t at = 0; at < bytes; at++) {
        for (unsigned bit = 0; bit < (damage == DAMAGE_FLIP ? 8u : 1u); bit++) {
            struct session s = damaged(damage, way, at, bit);
            assert_true(chip.damaged);
            assert_true(configuration_kept());
            if (s.status == MR_OK && !holds_image())
                fail_msg("byte %zu bit %u, way %u: taken for good", at, bit, way);
            /* all but what is read of pages that are to be erased anyway */
            again += s.status == MR_OK && (s.rom.repeated || s.result.reread);
            failed += s.status != MR_OK;
            if (s.status != MR_OK)
                print_message("# byte %zu bit %u: %s\n", at, bit, s.error.text);
            cases++;
        }
    }
    print_message("# %s %s: %u cases over %zu bytes, %u made good by repeating, %u told as an "
                  "error, 0 taken for good\n",
                  damage == DAMAGE_FLIP ? "one bit" : "one byte lost",
                  way == TO_CHIP ? "to the chip" : "to the host", cases, bytes, again, failed);
    assert_int_equal(failed, 0);
    assert_true(again > cases / 3);
}

static void every_bit_to_the_chip(void **state)
{
    (void)state;
    every(DAMAGE_FLIP, TO_CHIP);
}
static void every_bit_to_the_host(void **state)
{
    (void)state;
    every(DAMAGE_FLIP, TO_HOST);
}
static void every_lost_byte_to_the_chip(void **state)
{
    (void)state;
    every(DAMAGE_DROP, TO_CHIP);
}
static void every_lost_byte_to_the_host(void **state)
{
    (void)state;
    every(DAMAGE_DROP, TO_HOST);
}

/* One page alone, each of its frame's bits: command, complement, address and XOR, count, 256 bytes,
 * XOR. */
static void every_bit_of_a_page(void **state)
{
    (void)state;
    uint8_t page[BOOTROM_PAGE];
    uint32_t seed = 5;
    unsigned cases = 0;
    for (unsigned i = 0; i < sizeof page; i++)
        page[i] = noise(&seed);
    for (unsigned bit = 0; bit < 8 * (2 + 5 + 1 + 256 + 1); bit++) {
        static const struct bootrom_line line = {&chip, "fake", chip_line_send, chip_line_receive};
        struct bootrom rom = {0};
        struct error error = {0};
        chip_init(&chip);
        assert_int_equal(bootrom_begin(&rom, &line, &error), MR_OK);
        chip.damage = DAMAGE_FLIP;
        chip.way = TO_CHIP;
        chip.at = chip.passed[TO_CHIP] + bit / 8;
        chip.bit = bit % 8;
        assert_int_equal(bootrom_write(&rom, 0x08010000, page, sizeof page, &error), MR_OK);
        assert_true(chip.damaged);
        assert_true(rom.repeated > 0); /* noticed */
        assert_true(chip.nacks > 0);   /* by the chip */
        assert_memory_equal(chip.flash + PROGRAM, page, sizeof page);
        cases++;
    }
    print_message("# one page's write: %u bits, each noticed\n", cases);
    assert_int_equal(cases, 2120);
}

/* ---- pulled out ---- */

static void pulled_and_resumed(enum way way)
{
    old_chip();
    assert_int_equal(run(NULL).status, MR_OK);
    size_t bytes = chip.passed[way];
    unsigned resumed = 0, kept = 0;
    for (size_t at = 0; at < bytes; at++) {
        struct session s = damaged(DAMAGE_CUT, way, at, 0);
        if (s.status == MR_OK) { /* with the very last byte */
            assert_true(holds_image());
            continue;
        }
        assert_true(configuration_kept());
        chip_reconnect(&chip);
        s = run(NULL);
        if (s.status != MR_OK)
            fail_msg("pulled at byte %zu: %s", at, s.error.text);
        assert_true(holds_image());
        assert_true(configuration_kept());
        resumed += s.result.resumed;
        kept += s.result.kept;
    }
    print_message("# pulled %s at each of %zu bytes: all resumed or begun again, %u of them amid "
                  "the program, %u pages kept\n",
                  way == TO_CHIP ? "while sending" : "while receiving", bytes, resumed, kept);
    assert_true(resumed > bytes / 20);
    assert_true(kept > resumed / 2);
}

static void pulled_while_sending(void **state)
{
    (void)state;
    pulled_and_resumed(TO_CHIP);
}
static void pulled_while_receiving(void **state)
{
    (void)state;
    pulled_and_resumed(TO_HOST);
}

static uint32_t word(uint32_t at)
{
    const uint8_t *p = chip.flash + at;
    return (uint32_t)(p[0] | p[1] << 8 | p[2] << 16) | (uint32_t)p[3] << 24;
}

/* Wherever it broke off: sector 0 holds the old vectors with the whole old program, or the new with
 * the new, or goes to the boot ROM, or is erased; never vectors of one with half of the other. */
static void no_vectors_without_their_program(void **state)
{
    (void)state;
    unsigned seen[4] = {0};
    old_chip();
    assert_int_equal(run(NULL).status, MR_OK);
    size_t bytes = chip.passed[TO_CHIP];
    for (size_t at = 0; at < bytes; at++) {
        (void)damaged(DAMAGE_CUT, TO_CHIP, at, 0);
        bool old_program = memcmp(chip.flash + PROGRAM, before.flash + PROGRAM, 2000) == 0;
        bool new_program = memcmp(chip.flash + PROGRAM, image.bytes + PROGRAM, PROGRAM_BYTES) == 0;
        if (memcmp(chip.flash, before.flash, MR_IMAGE_HEAD) == 0) {
            assert_true(old_program);
            seen[0]++;
        } else if (word(4) == 0x08000009u) { /* the detour: code follows the two vectors */
            assert_int_equal(word(20), 0x1fff0000u);
            seen[1]++;
        } else if (word(4) == 0xffffffffu) {
            seen[2]++;
        } else {
            assert_true(new_program);
            assert_memory_equal(chip.flash, image.bytes, MR_IMAGE_HEAD);
            seen[3]++;
        }
    }
    print_message("# broken off: %u with the old image, %u to the boot ROM, %u without vectors, %u "
                  "with the new image\n",
                  seen[0], seen[1], seen[2], seen[3]);
    assert_true(seen[0] && seen[1] && seen[2] && seen[3]);
}

/* ---- what the chip does not allow ---- */

static void tells(enum mr_status status, const char *what)
{
    struct session s = run(NULL);
    print_message("# %s\n", s.error.text);
    assert_int_equal(s.status, status);
    assert_non_null(strstr(s.error.text, what));
    assert_true(configuration_kept());
}

static void another_chip(void **state)
{
    (void)state;
    old_chip();
    chip.id = 0x419;
    tells(MR_VERSION, "another chip: id 0x419");
    assert_memory_equal(chip.flash, before.flash, sizeof chip.flash);
}

static void read_protection(void **state)
{
    (void)state;
    old_chip();
    chip.read_protected = true;
    tells(MR_NOT_NOW, "read-protected");
    assert_memory_equal(chip.flash, before.flash, sizeof chip.flash);
}

static void write_protection(void **state)
{
    (void)state;
    old_chip();
    chip.write_protected = 1u << 4;
    tells(MR_NOT_NOW, "sector 4 (0x08010000) does not erase");
    old_chip();
    chip.write_protected = 1u << 0;
    tells(MR_LIMIT, "sector 0 (0x08000000)");
}

/* The chip says yes to each page, and one bit is not what was written: only reading back finds
 * it. */
static void what_the_chip_does_not_keep(void **state)
{
    (void)state;
    uint32_t weak = PROGRAM + 300;
    while (!(image.bytes[weak] & 1u))
        weak++;
    old_chip();
    chip.weak = weak;
    tells(MR_LIMIT, "not what was written: 0x080101");
    assert_int_equal(word(4), 0x08000009u); /* and such a program is not started */
}

static void silence(void **state)
{
    (void)state;
    old_chip();
    chip.deaf = true;
    tells(MR_TIMEOUT, "no boot ROM answers");
}

static void refusals(void **state)
{
    (void)state;
    old_chip();
    chip.refuses_all = true;
    struct session s = run(NULL);
    print_message("# %s\n", s.error.text);
    assert_int_not_equal(s.status, MR_OK);
    assert_memory_equal(chip.flash, before.flash, sizeof chip.flash);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flashes_what_differs),
        cmocka_unit_test(the_same_image_is_only_read),
        cmocka_unit_test(another_header_is_another_sector_0),
        cmocka_unit_test(the_configuration_goes_only_on_order),
        cmocka_unit_test(every_bit_of_a_page),
        cmocka_unit_test(every_bit_to_the_chip),
        cmocka_unit_test(every_bit_to_the_host),
        cmocka_unit_test(every_lost_byte_to_the_chip),
        cmocka_unit_test(every_lost_byte_to_the_host),
        cmocka_unit_test(pulled_while_sending),
        cmocka_unit_test(pulled_while_receiving),
        cmocka_unit_test(no_vectors_without_their_program),
        cmocka_unit_test(another_chip),
        cmocka_unit_test(read_protection),
        cmocka_unit_test(write_protection),
        cmocka_unit_test(what_the_chip_does_not_keep),
        cmocka_unit_test(silence),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, make_image, free_image);
}
