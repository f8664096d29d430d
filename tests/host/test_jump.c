/* A calibration against the one before: which gain is a jump, of the same sensor and of another. */
#include <string.h>

#include "common/channels.h"
#include "host/calibrate/jump.h"
#include "tests/cmocka_all.h"

static const struct mr_channel_config transducer = {.kind = MR_KIND_DISPLACEMENT,
                                                    .number = 3,
                                                    .unit_per_code = 0.0016f,
                                                    .zero_code = 62.0f,
                                                    .serial = "ET-17",
                                                    .calibrated_day = 20000};
static const struct mr_channel_config gage = {.kind = MR_KIND_TENSION,
                                              .number = 3,
                                              .unit_per_code = 0.16f,
                                              .zero_code = 500.0f,
                                              .serial = "SG-1",
                                              .calibrated_day = 20000};

static char text[JUMP_TEXT_SIZE];

static bool jumps(struct mr_channel_config old, double factor, const char *serial)
{
    struct mr_channel_config new = old;
    new.unit_per_code = (float)((double)new.unit_per_code *factor);
    new.calibrated_day = 20365;
    memset(new.serial, 0, sizeof new.serial);
    memcpy(new.serial, serial, strlen(serial));
    return jump_find(&old, &new, text);
}

TEST(of_the_same_sensor)
{
    static const double units[] = {25.4,   2.54,   12.0, 0.0254, 4.448,
                                   2.2046, 0.4536, 1.12, 0.89,   -1.0};
    for (unsigned i = 0; i < sizeof units / sizeof units[0]; i++) {
        assert_true(jumps(transducer, units[i], "ET-17"));
        assert_true(jumps(gage, units[i], "SG-1"));
        assert_true(jumps(gage, units[i], "")); /* nobody said that it is another */
    }
    assert_false(jumps(transducer, 1.09, "ET-17") || jumps(transducer, 0.92, "ET-17"));
    assert_false(jumps(transducer, 1.0, "ET-17"));
}

TEST(of_another_and_of_the_first_calibration)
{
    struct mr_channel_config never = transducer, never_gage = gage;
    never.calibrated_day = never_gage.calibrated_day = 0;
    assert_false(jumps(transducer, 1.4, "ET-18") || jumps(never, 1.4, "ET-17") ||
                 jumps(transducer, -1.4, "ET-18"));
    assert_true(jumps(transducer, 2.54, "ET-18") && jumps(never, 2.54, "ET-17") &&
                jumps(never, 0.5, "ET-17"));
    assert_false(jumps(gage, 0.25, "SG-2") || jumps(never_gage, 0.25, "SG-1"));
    assert_true(jumps(gage, 9.8, "SG-2") && jumps(never_gage, 0.19, "SG-1"));
}

TEST(a_table_counts)
{
    struct mr_channel_config table = transducer;
    table.points = 2;
    table.point_reading[1] = 1.0f;
    table.point_value[1] = 25.4f;
    assert_true(jump_find(&transducer, &table, text) && strstr(text, "a factor of 25.4"));
}

TEST(what_is_said)
{
    char name[8];
    jumps(transducer, 2.54, "ET-17");
    assert_string_equal(text, "gain 0.0016 -> 0.004064 in per code, a factor of 2.54");
    jump_channel_name(2, name);
    assert_string_equal(name, "d3");
    jump_channel_name(21, name);
    assert_string_equal(name, "t14");
}

TEST(what_cannot_be_compared)
{
    struct mr_channel_config none = {0}, other = transducer;
    assert_false(jump_find(&none, &transducer, text) || jump_find(&transducer, &none, text));
    other.number = 4;
    other.unit_per_code = 1.0f;
    assert_false(jump_find(&transducer, &other, text));
}
