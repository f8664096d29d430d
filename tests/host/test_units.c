/* Numbers and units as people write them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "host/base/units.h"
#include "tests/cmocka_all.h"

TEST(numbers_are_decimal)
{
    static const struct {
        const char *text;
        double value;
        size_t length;
    } cases[] = {
        {"12", 12.0, 2},        {"-0.5mm", -0.5, 4}, {" +.25 in", 0.25, 5}, {"5.", 5.0, 2},
        {"1e3lb", 1000.0, 3},   {"2E-1", 0.2, 4},    {"3e", 3.0, 1},        {"4ex", 4.0, 1},
        {"5e+N", 5.0, 1},       {"0x10N", 0.0, 1},   {"-0X1p3", 0.0, 2},    {"6.7.8", 6.7, 3},
        {"1e400", HUGE_VAL, 5},
    };
    static const char *const none[] = {"", " ", "mm", "inf", "nan", "-inf", ".", "-", "+.e5", "e5"};
    const char *end;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_true(mr_decimal_parse(cases[i].text, &end) == cases[i].value);
        assert_int_equal(end - cases[i].text, cases[i].length);
    }
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++) {
        assert_true(mr_decimal_parse(none[i], &end) == 0.0);
        assert_ptr_equal(end, none[i]);
    }
}

/* What strtod says of the same text, wherever that is decimal. */
TEST(as_the_library_reads_them)
{
    static const char letters[] = "0123456789+-.eE ";
    char text[12];
    uint32_t random = 1;
    for (unsigned n = 0; n < 100000; n++) {
        const char *end;
        char *library;
        for (size_t i = 0; i < sizeof text - 1; i++) {
            random = random * 1664525u + 1013904223u;
            text[i] = letters[(random >> 16) % (sizeof letters - 1)];
        }
        text[sizeof text - 1] = '\0';
        double wanted = strtod(text, &library), value = mr_decimal_parse(text, &end);
        assert_ptr_equal(end, library);
        assert_memory_equal(&value, &wanted, sizeof value);
    }
}

static const char *word_of(const char *word)
{
    const struct unit_word *unit = unit_word_find(word, strlen(word));
    return unit ? unit->word : "none";
}

TEST(a_capital_m_is_mega)
{
    static const char *const cases[][2] = {
        {"mm", "mm"},  {"MM", "mm"},   {"m", "m"},    {"cm", "cm"}, {"Metres", "m"},
        {"IN", "in"},  {"Lb", "lb"},   {"KN", "kN"},  {"n", "N"},   {"Kg", "kg"},
        {"M", "none"}, {"Mm", "none"}, {"x", "none"}, {"", "none"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        assert_string_equal(word_of(cases[i][0]), cases[i][1]);
}
