/* A calibration against the one before: what is a jump, of gain and of zero, of the same sensor and
 * of another. */
#include <math.h>
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

static struct jump by_gain(struct mr_channel_config old, double factor, const char *serial)
{
    struct jump jump;
    struct mr_channel_config new = old;
    new.unit_per_code = (float)((double)new.unit_per_code *factor);
    new.calibrated_day = 20365;
    memset(new.serial, 0, sizeof new.serial);
    memcpy(new.serial, serial, strlen(serial));
    jump_find(&old, &new, &jump);
    return jump;
}

TEST(of_the_same_sensor)
{
    static const double units[] = {25.4,   2.54,   12.0, 0.0254, 4.448,
                                   2.2046, 0.4536, 1.12, 0.89,   -1.0};
    for (unsigned i = 0; i < sizeof units / sizeof units[0]; i++) {
        assert_true(by_gain(transducer, units[i], "ET-17").gain);
        assert_true(by_gain(gage, units[i], "SG-1").gain);
        assert_true(by_gain(gage, units[i], "").gain); /* nobody said that it is another */
    }
    assert_false(by_gain(transducer, 1.09, "ET-17").gain ||
                 by_gain(transducer, 0.92, "ET-17").gain);
    assert_false(by_gain(transducer, 1.0, "ET-17").gain);
}

TEST(of_another_and_of_the_first_calibration)
{
    struct mr_channel_config never = transducer, never_gage = gage;
    never.calibrated_day = never_gage.calibrated_day = 0;
    assert_false(by_gain(transducer, 1.4, "ET-18").gain || by_gain(never, 1.4, "ET-17").gain ||
                 by_gain(transducer, -1.4, "ET-18").gain);
    assert_true(by_gain(transducer, 2.54, "ET-18").gain && by_gain(never, 2.54, "ET-17").gain &&
                by_gain(never, 0.5, "ET-17").gain);
    assert_false(by_gain(gage, 0.25, "SG-2").gain || by_gain(never_gage, 0.25, "SG-1").gain);
    assert_true(by_gain(gage, 9.8, "SG-2").gain && by_gain(never_gage, 0.19, "SG-1").gain);
}

TEST(of_the_zero)
{
    struct jump jump;
    struct mr_channel_config moved = transducer;
    moved.zero_code += 160.0f; /* 0.256 in */
    assert_true(jump_find(&transducer, &moved, &jump) && jump.zero && !jump.gain &&
                fabs(jump.shift - 0.256) < 1e-6);
    moved.zero_code -= 10.0f;
    assert_false(jump_find(&transducer, &moved, &jump));
    moved = gage;
    moved.zero_code -= 63.0f; /* 10.08 lb */
    assert_true(jump_find(&gage, &moved, &jump) && jump.zero && jump.shift < 0.0);
    memcpy(moved.serial, "SG-2", 5);
    assert_false(jump_find(&gage, &moved, &jump));
    struct mr_channel_config unknown = gage;
    unknown.zero_code = NAN; /* of a landing whose configuration was not kept */
    moved = gage;
    assert_false(jump_find(&unknown, &moved, &jump));
}

TEST(a_table_counts)
{
    struct jump jump;
    struct mr_channel_config table = transducer;
    table.points = 2;
    table.point_reading[1] = 1.0f;
    table.point_value[1] = 25.4f;
    assert_true(jump_find(&transducer, &table, &jump) && jump.gain &&
                fabs(jump.ratio - 25.4) < 1e-4);
}

TEST(what_is_said)
{
    char text[160], name[8];
    struct jump jump = by_gain(transducer, 2.54, "ET-17");
    jump_text(&jump, &transducer, text, sizeof text);
    assert_string_equal(text, "gain 0.0016 -> 0.004064 in per code, 2.54 times");
    jump_channel(2, name);
    assert_string_equal(name, "d3");
    jump_channel(21, name);
    assert_string_equal(name, "t14");
}

TEST(what_cannot_be_compared)
{
    struct jump jump;
    struct mr_channel_config none = {0}, other = transducer;
    assert_false(jump_find(&none, &transducer, &jump) || jump_find(&transducer, &none, &jump));
    other.number = 4;
    other.unit_per_code = 1.0f;
    assert_false(jump_find(&transducer, &other, &jump));
}
