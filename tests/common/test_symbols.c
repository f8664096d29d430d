/* Symbols of an ELF file that is laid out here by hand, from the standard's tables: header, three
 * sections (none, symbols, names). */
#include <string.h>

#include "common/symbols.h"
#include "tests/cmocka_all.h"

#define SYMBOLS_AT  52u
#define NAMES_AT    (SYMBOLS_AT + 16u * 7u)
#define SECTIONS_AT (NAMES_AT + 48u)
#define FILE_BYTES  (SECTIONS_AT + 3u * 40u)

static uint8_t file[FILE_BYTES];
static struct mr_symbol room[8];
static struct mr_symbols symbols;

static void put(unsigned at, unsigned bytes, uint32_t value)
{
    for (unsigned i = 0; i < bytes; i++)
        file[at + i] = (uint8_t)(value >> 8 * i);
}

static void put_symbol(unsigned n, uint32_t name, uint32_t address, uint32_t size, uint8_t info,
                       uint16_t section)
{
    unsigned at = SYMBOLS_AT + 16u * n;
    put(at, 4, name);
    put(at + 4, 4, address);
    put(at + 8, 4, size);
    put(at + 12, 1, info);
    put(at + 14, 2, section);
}

static void put_section(unsigned n, uint32_t type, uint32_t offset, uint32_t bytes, uint32_t link)
{
    unsigned at = SECTIONS_AT + 40u * n;
    put(at + 4, 4, type);
    put(at + 16, 4, offset);
    put(at + 20, 4, bytes);
    put(at + 24, 4, link);
}

static int lay_out(void **state)
{
    (void)state;
    /* 1 take, 6 alias, 12 table, 18 stop, 23 late, 28 undefined */
    static const char names[48] = "\0take\0alias\0table\0stop\0late\0undefined";
    memset(file, 0, sizeof file);
    memcpy(file, "\177ELF\1\1\1", 7);
    put(32, 4, SECTIONS_AT);
    put(46, 2, 40);
    put(48, 2, 3);
    put_section(1, 2, SYMBOLS_AT, 16u * 7u, 2);
    put_section(2, 3, NAMES_AT, sizeof names, 0);
    memcpy(file + NAMES_AT, names, sizeof names);
    put_symbol(1, 23, 0x08010101, 0, 0x12, 1); /* Thumb, no size */
    put_symbol(2, 1, 0x08010001, 0x40, 0x12, 1);
    put_symbol(3, 6, 0x08010001, 0, 0x12, 1);   /* another name for it, without a size */
    put_symbol(4, 12, 0x08010080, 16, 0x11, 1); /* an object */
    /* begins inside take; longer than there is room */
    put_symbol(5, 18, 0x08010031, 0x1000, 0x02, 1);
    put_symbol(6, 28, 0, 0, 0x12, 0); /* of another file */
    symbols = (struct mr_symbols){0};
    return 0;
}

TEST_IN(functions_are_found_by_address_and_name, lay_out, NULL)
{
    size_t most;
    assert_int_equal(mr_symbols_count(file, sizeof file, &most), MR_OK);
    assert_int_equal(most, 7);
    assert_int_equal(mr_symbols_read(file, sizeof file, room, &symbols), MR_OK);
    assert_int_equal(symbols.entry_count, 3);
    assert_string_equal(mr_symbols_by_address(&symbols, 0x08010000)->name, "take");
    /* up to the one that begins inside */
    assert_int_equal(mr_symbols_by_name(&symbols, "take")->size, 0x30);
    assert_string_equal(mr_symbols_by_address(&symbols, 0x0801002e)->name, "take");
    assert_string_equal(mr_symbols_by_address(&symbols, 0x08010030)->name, "stop");
    assert_int_equal(mr_symbols_by_name(&symbols, "stop")->size, 0xd0);
    assert_int_equal(mr_symbols_by_name(&symbols, "late")->address, 0x08010100);
    /* the last, without a size: one instruction */
    assert_int_equal(mr_symbols_by_name(&symbols, "late")->size, 2);
    assert_null(mr_symbols_by_address(&symbols, 0x08010102));
    assert_null(mr_symbols_by_address(&symbols, 0x0800ffff));
    assert_null(mr_symbols_by_name(&symbols, "table"));
    assert_null(mr_symbols_by_name(&symbols, "alias"));
}

TEST_IN(a_stripped_image_has_none, lay_out, NULL)
{
    size_t most = 99;
    put_section(1, 1, 0, 0, 0);
    assert_int_equal(mr_symbols_count(file, sizeof file, &most), MR_OK);
    assert_int_equal(most, 0);
    assert_int_equal(mr_symbols_read(file, sizeof file, room, &symbols), MR_OK);
    assert_int_equal(symbols.entry_count, 0);
    assert_null(mr_symbols_by_address(&symbols, 0x08010000));
}

TEST_IN(what_is_no_whole_image_is_refused, lay_out, NULL)
{
    size_t most;
    for (size_t cut = 0; cut < sizeof file; cut++)
        assert_int_equal(mr_symbols_read(file, cut, room, &symbols),
                         cut < 52 ? MR_MALFORMED : MR_TRUNCATED);
    /* a table that ends beyond the file, and beyond 32 bits */
    put_section(1, 2, SYMBOLS_AT, 0xfffffff0u, 2);
    assert_int_equal(mr_symbols_count(file, sizeof file, &most), MR_TRUNCATED);
    assert_int_equal(most, 0);
    put_section(1, 2, SYMBOLS_AT, 16u * 7u, 2);
    put_section(2, 3, NAMES_AT, FILE_BYTES, 0); /* names that do */
    assert_int_equal(mr_symbols_read(file, sizeof file, room, &symbols), MR_TRUNCATED);
    put(4, 1, 2); /* 64 bits */
    assert_int_equal(mr_symbols_count(file, sizeof file, &most), MR_MALFORMED);
}

/* Names at the very end of the file, the last one without its zero. */
TEST_IN(a_name_that_does_not_end_is_refused, lay_out, NULL)
{
    put_section(2, 3, FILE_BYTES - 4u, 4, 0);
    for (unsigned n = 1; n < 7; n++)
        put(SYMBOLS_AT + 16u * n, 4, 100); /* outside the names: passed over */
    assert_int_equal(mr_symbols_read(file, sizeof file, room, &symbols), MR_OK);
    assert_int_equal(symbols.entry_count, 0);
    put(SYMBOLS_AT + 32u, 4, 1);
    memcpy(file + FILE_BYTES - 4u, "\0abc", 4);
    assert_int_equal(mr_symbols_read(file, sizeof file, room, &symbols), MR_TRUNCATED);
    assert_int_equal(symbols.entry_count, 0);
}

TEST_IN(sections_that_are_not_there_are_refused, lay_out, NULL)
{
    /* names in a section that there is not: no table of ours */
    put_section(1, 2, SYMBOLS_AT, 16u * 7u, 9);
    assert_int_equal(mr_symbols_read(file, sizeof file, room, &symbols), MR_OK);
    assert_int_equal(symbols.entry_count, 0);
    put(46, 2, 39); /* sections too short for what is read of them */
    assert_int_equal(mr_symbols_read(file, sizeof file, room, &symbols), MR_TRUNCATED);
    put(48, 2, 0); /* none at all */
    assert_int_equal(mr_symbols_read(file, sizeof file, room, &symbols), MR_OK);
    assert_int_equal(symbols.entry_count, 0);
}

/* 400 functions in an order that was shuffled, each address twice, one of the two names without a
 * size: found by every address in them. */
TEST_IN(many_are_sorted, lay_out, NULL)
{
    enum { FUNCTIONS = 400, TABLE = 16 * 2 * FUNCTIONS };
    static uint8_t big[52 + TABLE + 8 + 3 * 40];
    static struct mr_symbol all[2 * FUNCTIONS];
    memcpy(big, file, 52);
    memcpy(big + 52 + TABLE, "\0one\0b\0", 8);
    memcpy(big + 52 + TABLE + 8, file + SECTIONS_AT, 3 * 40);
    uint8_t *kept[] = {big + 52 + TABLE + 8 + 40, big + 52 + TABLE + 8 + 80};
    const uint32_t values[][2] = {{52, TABLE}, {52 + TABLE, 8}};
    for (unsigned i = 0; i < 2; i++) {
        for (unsigned k = 0; k < 8; k++)
            kept[i][16 + k] = (uint8_t)(values[i][k / 4] >> 8 * (k % 4));
    }
    for (unsigned k = 0; k < 4; k++)
        big[32 + k] = (uint8_t)((52u + TABLE + 8u) >> 8 * k);
    for (unsigned n = 0; n < 2 * FUNCTIONS; n++) {
        /* 37 and 400 have no common divisor: each place twice */
        uint8_t *symbol = big + 52 + 16 * n;
        uint32_t address = 0x08010001u + 64u * (37u * n % FUNCTIONS);
        for (unsigned k = 0; k < 4; k++)
            symbol[4 + k] = (uint8_t)(address >> 8 * k);
        symbol[0] = n < FUNCTIONS ? 5 : 1;
        symbol[8] = n < FUNCTIONS ? 0 : 48;
        symbol[12] = 0x12;
        symbol[14] = 1;
    }
    assert_int_equal(mr_symbols_read(big, sizeof big, all, &symbols), MR_OK);
    assert_int_equal(symbols.entry_count, FUNCTIONS);
    for (uint32_t n = 0; n < FUNCTIONS; n++) {
        assert_int_equal(symbols.entries[n].address, 0x08010000u + 64u * n);
        assert_string_equal(symbols.entries[n].name, "one");
        assert_ptr_equal(mr_symbols_by_address(&symbols, 0x08010000u + 64u * n + 47u),
                         &symbols.entries[n]);
        assert_null(mr_symbols_by_address(&symbols, 0x08010000u + 64u * n + 48u));
    }
}
