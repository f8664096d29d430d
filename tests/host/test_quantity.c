/* Quantities as people write them. Expected values are the definitions: 1 ft = 0.3048 m, 1 in =
 * 25.4 mm, 1 lbf = 4.4482216152605 N, standard gravity 9.80665 m/s2, 1 mile = 5280 ft, 1 nautical
 * mile = 1852 m. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/quantity.h"
#include "tests/cmocka_all.h"

static struct quantity_error wrong;

static double read_in(const char *text, const char *unit, const char *bare)
{
    double value;
    if (!quantity_parse(text, unit, bare, &value, &wrong))
        fail_msg("'%s' is not read in %s: %s; %s", text, unit, wrong.what, wrong.advice);
    return value;
}

static void refused(const char *text, const char *unit, const char *bare, const char *what,
                    const char *advice)
{
    double value;
    if (quantity_parse(text, unit, bare, &value, &wrong))
        fail_msg("'%s' is read in %s: %.17g", text, unit, value);
    if (!strstr(wrong.what, what) || !strstr(wrong.advice, advice))
        fail_msg("'%s': '%s; %s' should say '%s' and '%s'", text, wrong.what, wrong.advice, what,
                 advice);
}

TEST(definitions)
{
    static const struct {
        const char *text, *unit;
        double value; /* the double nearest to it */
    } cases[] = {
        {"25.4 mm", "in", 1.0},
        {"12.7mm", "in", 0.5},
        {"1 in", "mm", 25.4},
        {"304.8 mm", "ft", 1.0},
        {"0.3048m", "ft", 1.0},
        {"1 m", "ft", 3.2808398950131235},
        {"30 cm", "in", 11.811023622047244},
        {"4.4482216152605 N", "lb", 1.0},
        {"1 kN", "lb", 224.8089430997105},
        {"480 kip", "lb", 480000.0},
        {"1 kg", "lb", 2.2046226218487757}, /* 1 / 0.45359237: its weight */
        {"1 kgf", "N", 9.80665},
        {"2 slug", "kg", 29.187805874412728},
        {"1 m/s", "ft/s", 3.2808398950131235},
        {"36 km/h", "m/s", 10.0},
        {"60 mph", "ft/s", 88.0},
        {"1 mph", "m/s", 0.44704},
        {"1 kn", "ft/s", 1.6878098571011957},
        {"1 g", "ft/s2", 32.17404855643045},
        {"3.048 m/s^2", "ft/s2", 10.0},
        {"1500 ms", "s", 1.5},
        {"2 min", "s", 120.0},
        {"180 deg", "rad", 3.141592653589793},
        {"1 N/mm", "lb/in", 5.710147154732646},
        {"1 kip/in", "lb/ft", 12000.0},
        {"175 N s/m", "lb s/ft", 11.991309024938557},
        {"1 lb s/in", "lb s/ft", 12.0},
        {"1 N m", "ft lb", 0.7375621492772654},
        {"1 ft lb/rad", "N m/rad", 1.3558179483314003},
        {"1 kg m2", "slug ft2", 0.7375621492772654},
        {"29e6 psi", "lb/ft2", 4176e6},
        {"1 MPa", "psi", 145.03773773020922},
        {"144 in2", "ft2", 1.0},
        {"645.16 mm2", "in2", 1.0},
        {"10 K", "F", 18.0},
        {"1/K", "1/F", (double)NAN}, /* no number before it */
        {"9 1/K", "1/F", 5.0},
        {"25.4 mm/s", "in/s", 1.0},
        {"2.54 mm/h", "in/h", 0.1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        if (isnan(cases[i].value)) {
            refused("/K", cases[i].unit, NULL, "not a number", "digits");
            continue;
        }
        double value = read_in(cases[i].text, cases[i].unit, NULL);
        if (value != cases[i].value)
            fail_msg("%s is %.17g %s; expected %.17g", cases[i].text, value, cases[i].unit,
                     cases[i].value);
    }
}

/* Against the exact quotient in long double: within 0.502 units in the last place. */
TEST(the_nearest_double)
{
    static const struct {
        const char *from, *to;
        long double times, over;
    } cases[] = {{"mm", "in", 10.0L, 254.0L},
                 {"m", "ft", 10000.0L, 3048.0L},
                 {"N", "lb", 1e13L, 44482216152605.0L},
                 {"kg", "lb", 1e8L, 45359237.0L},
                 {"km/h", "ft/s", 1e7L, 3600.0L * 3048.0L},
                 {"m/s2", "ft/s2", 10000.0L, 3048.0L}};
    uint64_t random = 1;
    for (unsigned n = 0; n < 20000; n++) {
        char text[60];
        random = random * 6364136223846793005u + 1442695040888963407u;
        long long whole = (long long)(random >> 20) % 10000000;
        int behind = (int)(random >> 60) % 6;
        long double tens = 1.0L;
        for (int i = 0; i < behind; i++)
            tens *= 10.0L;
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
            snprintf(text, sizeof text, "%llde-%d%s%s", whole, behind, n % 2 ? " " : "",
                     cases[i].from);
            long double exact = (long double)whole * cases[i].times / cases[i].over / tens;
            double value = read_in(text, cases[i].to, NULL);
            long double off = fabsl((long double)value - exact);
            double ulp = nextafter(fabs(value), (double)INFINITY) - fabs(value);
            if (off > (long double)ulp * 0.502L)
                fail_msg("%s is %.17g %s; the nearest is %.17g", text, value, cases[i].to,
                         (double)exact);
        }
    }
}

/* In its own unit a value is what its digits say, as without a unit. */
TEST(its_own_unit_changes_no_bit)
{
    static const char *const units[] = {"ft", "in", "lb", "ft/s", "lb s/ft", "s", "psi", "MB"};
    uint64_t random = 7;
    for (unsigned n = 0; n < 5000; n++) {
        char digits[40], text[60];
        random = random * 6364136223846793005u + 1442695040888963407u;
        snprintf(digits, sizeof digits, "%.*g", 1 + (int)(random >> 60),
                 ldexp((double)(random >> 11), -(int)(random >> 55) % 80));
        const char *unit = units[n % (sizeof units / sizeof units[0])];
        snprintf(text, sizeof text, "%s %s", digits, unit);
        double wanted = strtod(digits, NULL), with = read_in(text, unit, "mm"),
               without = read_in(digits, unit, NULL);
        assert_memory_equal(&with, &wanted, sizeof wanted);
        assert_memory_equal(&without, &wanted, sizeof wanted);
    }
}

TEST(as_people_write_them)
{
    assert_true(read_in(" 5mm ", "mm", NULL) == 5.0);
    assert_true(read_in("-5 MM", "mm", NULL) == -5.0);
    assert_true(read_in("2 Inches", "in", NULL) == 2.0);
    assert_true(read_in("2 lbf", "lb", NULL) == 2.0);
    assert_true(read_in("1.5e3 LBS", "lb", NULL) == 1500.0);
    assert_true(read_in("3 s N/m", "N s/m", NULL) == 3.0);
    assert_true(read_in("3 m / s", "m/s", NULL) == 3.0);
    assert_true(read_in("4", "in", "mm") == 20.0 / 127.0);
    assert_true(read_in("4", "", NULL) == 4.0);
    assert_true(signbit(read_in("-0 mm", "in", NULL)));
}

TEST(never_another_unit)
{
    refused("3 lb", "ft", NULL, "a force instead of a length", "write ft, in, mm, cm or m ");
    refused("3 ft", "lb", NULL, "a length instead of a force", "kg means the weight of that mass");
    refused("3 kg", "ft/s", NULL, "a mass instead of a speed", "ft/s, m/s, km/h, mph, kn");
    refused("5 kn", "lb", NULL, "a speed instead of a force", "kN");
    refused("500 g", "lb", NULL, "an acceleration instead of a force", "lb");
    refused("3 m", "s", NULL, "a length instead of a time", "no unit for s");
    refused("3 kg/m", "lb/ft", NULL, "not in lb/ft", "N/m");
    refused("3 N m", "lb/ft", NULL, "a moment instead of a stiffness", "lb/ft");
    refused("3 M", "ft", NULL, "unknown unit", "mm");
    refused("3 Mm", "ft", NULL, "unknown unit", "mm");
    refused("3 G", "ft/s2", NULL, "unknown unit", "ft/s2, m/s2 or g");
    refused("3 stone", "lb", NULL, "unknown unit", "lb");
    refused("3 ft 2 in", "ft", NULL, "unknown unit", "ft");
    refused("3 m/s/s", "m/s2", NULL, "unknown unit", "m/s2");
    refused("3 mm2x", "in2", NULL, "unknown unit", "in2");
    refused("3 lb", "", NULL, "unexpected unit", "number without a unit");
    refused("3", "in", "", "a number without a unit", "mm");
    refused("3 kB", "MB", NULL, "unknown unit", "number alone; it is in MB");
}

TEST(a_comma_is_refused_with_a_word)
{
    refused("5,2 mm", "in", NULL, "a comma in a number", "write a point: 5.2 mm");
    refused("1,000 lb", "lb", NULL, "a comma in a number", "no thousands separator");
    refused("5,", "in", NULL, "a comma in a number", "point");
    refused("", "in", NULL, "no number", "4 in");
    refused("mm", "in", NULL, "not a number", "4 in");
    refused("0x10 mm", "in", NULL, "unknown unit", "mm");
    refused("inf", "in", NULL, "not a number", "4");
    refused("1e999 mm", "in", NULL, "not a number", "4");
}

TEST(json_text_has_its_unit)
{
    json_t *number = json_real(2.5), *text = json_string("25.4 mm"), *bare = json_string("2.5");
    double value;
    assert_true(quantity_read_json(number, "in", &value, &wrong) && value == 2.5);
    assert_true(quantity_read_json(text, "in", &value, &wrong) && value == 1.0);
    assert_false(quantity_read_json(bare, "in", &value, &wrong));
    assert_false(quantity_read_json(text, "", &value, &wrong));
    assert_false(quantity_read_json(NULL, "in", &value, &wrong));
    json_decref(number);
    json_decref(text);
    json_decref(bare);
}

/* What the messages advise and the reference lists can be read, and is of the kind. */
TEST(what_is_listed_is_read)
{
    const struct quantity_kind *kind;
    unsigned count = 0;
    for (size_t i = 0; (kind = quantity_kind_get(i)); i++) {
        char units[200], first[40] = "", *rest = units, *unit;
        snprintf(units, sizeof units, "%s", kind->units);
        while ((unit = strsep(&rest, ","))) {
            unit += strspn(unit, " ");
            if (!first[0])
                snprintf(first, sizeof first, "%s", unit);
            if (isnan(quantity_convert(1.0, unit, first)))
                fail_msg("%s: %s is not of the kind of %s", kind->name, unit, first);
            count++;
        }
        assert_ptr_equal(quantity_kind_find(first), kind);
    }
    assert_true(isnan(quantity_convert(1.0, "m/s", "ft/s2")));
    assert_true(count > 60);
    assert_string_equal(quantity_unit_from_name("deceleration_ft_s2"), "ft/s2");
    assert_string_equal(quantity_unit_from_name("joint_lb_in"), "lb/in");
    assert_string_equal(quantity_unit_from_name("moment_ft_lb"), "ft lb");
    assert_string_equal(quantity_unit_from_name("chain_dt_s"), "s");
    assert_string_equal(quantity_unit_from_name("tire_psi"), "psi");
    assert_string_equal(quantity_unit_from_name("cbr_percent"), "%");
    assert_string_equal(quantity_unit_from_name("bearing_lb_in3"), "lb/in3");
    assert_string_equal(quantity_unit_from_name("friction"), "");
    assert_string_equal(quantity_unit_from_name("axles"), "");
}
