/* Similitude: the report's two tables line by line, and numbers its text works out. */
#include <math.h>
#include <string.h>

#include "common/similitude.h"
#include "tests/cmocka_all.h"

static double ratio(enum mr_similitude_rule rule, double n, const char *name)
{
    const struct mr_quantity *quantity = mr_quantity_find(name);
    assert_non_null(quantity);
    return mr_similitude_ratio(rule, n, quantity->dimension);
}

TEST(table_2_2)
{
    static const struct {
        const char *name;
        int half_powers;
    } rows[] = {
        {"gravity", 0},      {"length", 2},
        {"density", 0},      {"weight", 6},
        {"acceleration", 0}, {"friction", 0},
        {"landings", 0},     {"velocity", 1},
        {"modulus", 2},      {"pressure", 2},
        {"time", 1},         {"soil_modulus", 0},
        {"inertia", 10},     {"torsional_stiffness", 8},
        {"stiffness", 4},
    };
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        const struct mr_quantity *quantity = mr_quantity_find(rows[i].name);
        assert_non_null(quantity);
        if (mr_similitude_half_powers(MR_KEEP_DENSITY, quantity->dimension) != rows[i].half_powers)
            fail_msg("%s", rows[i].name);
        assert_near(ratio(MR_KEEP_DENSITY, 7, rows[i].name) / pow(7, rows[i].half_powers / 2.0), 1,
                    1e-14);
    }
}

TEST(table_b_2)
{
    static const struct {
        const char *name;
        int half_powers;
    } rows[] = {
        {"gravity", 0},  {"length", 2},   {"modulus", 0},  {"weight", 4},
        {"density", -2}, {"friction", 0}, {"velocity", 1}, {"pressure", 0},
    };
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        const struct mr_quantity *quantity = mr_quantity_find(rows[i].name);
        assert_non_null(quantity);
        if (mr_similitude_half_powers(MR_KEEP_MODULUS, quantity->dimension) != rows[i].half_powers)
            fail_msg("%s", rows[i].name);
    }
}

TEST(what_the_text_works_out)
{
    assert_near(1000 * ratio(MR_KEEP_DENSITY, 7, "W"), 343000, 1e-6); /* 2.3 */
    /* 2.6, rounded there */
    assert_near(1440 * ratio(MR_KEEP_DENSITY, 7, "W"), 495000, 1500);
    assert_near(1220 * ratio(MR_KEEP_DENSITY, 7, "W"), 419000, 1000);        /* 2.3 */
    assert_near(82 / ratio(MR_KEEP_DENSITY, 7, "p"), 12, 0.5);               /* 2.3, psi */
    assert_near(28 * ratio(MR_KEEP_DENSITY, 7, "v") * 3600 / 5280, 50, 1);   /* 2.4, mph */
    assert_near(46 * ratio(MR_KEEP_DENSITY, 7, "v") * 3600 / 5280, 85, 2.5); /* "about" */
    assert_near(1450 / ratio(MR_KEEP_DENSITY, 7, "line_force"), 30, 0.5);    /* 2.5, lb/in */
    assert_near(120 * ratio(MR_KEEP_DENSITY, 7, "length"), 840, 1e-9);       /* 2.6 */
    assert_near(0.25 / ratio(MR_KEEP_DENSITY, 7, "length"), 0.036, 0.0005);  /* 2.7.2, in */
    assert_near(2 / ratio(MR_KEEP_DENSITY, 7, "I"), 1.19e-4, 0.005e-4);      /* 3.4 */
    assert_near(1.8e7 / ratio(MR_KEEP_DENSITY, 7, "KL"), 3.67e5, 0.005e5);   /* 3.4 */
    assert_near(1e5 / ratio(MR_KEEP_DENSITY, 7, "KT"), 41.5, 0.2);           /* 3.4 */
    assert_near(40000 / ratio(MR_KEEP_MODULUS, 6.6, "W"), 920, 2);           /* B.2 */
}

TEST(names_are_found)
{
    assert_ptr_equal(mr_quantity_find("inertia"), mr_quantity_find("I"));
    assert_null(mr_quantity_find("speed"));
    assert_null(mr_quantity_find(""));
}
