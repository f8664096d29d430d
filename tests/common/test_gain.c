/* Gains that no sensor of the rig has: mistakes of units and columns are refused, every gain that a
 * sensor can have is taken. Limits by hand from the facts: 28 and 7/16 in over 2047.5 codes, 2600
 * and 40 lb over 4095. */
#include <math.h>
#include <string.h>

#include "common/gain.h"
#include "tests/cmocka_all.h"
#include "tests/common/sound_config.h"

static const struct mr_channel_config transducer = {.kind = MR_KIND_DISPLACEMENT,
                                                    .unit_per_code = 3.3f / 4096.0f / 0.5f,
                                                    .zero_code = 62.06f,
                                                    .low = -0.5f,
                                                    .high = 3.0f};
static const struct mr_channel_config gage = {.kind = MR_KIND_TENSION,
                                              .unit_per_code = 3.3f / 4096.0f / 0.005f,
                                              .zero_code = 496.48f,
                                              .low = -75.0f,
                                              .high = 575.0f};

static enum mr_config_rule with_gain(struct mr_channel_config channel, double factor)
{
    channel.unit_per_code = (float)((double)channel.unit_per_code * factor);
    return mr_gain_check(&channel);
}

TEST(built_in_channels_pass)
{
    const struct mr_config sound = sound_config();
    assert_int_equal(mr_gain_check(&transducer), MR_RULE_NONE);
    assert_int_equal(mr_gain_check(&gage), MR_RULE_NONE);
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++)
        assert_int_equal(mr_gain_check(&sound.channel[i]), MR_RULE_NONE);
}

TEST(mistakes_of_units_are_refused)
{
    assert_int_equal(with_gain(transducer, 25.4), MR_RULE_CODE_TOO_COARSE); /* mm for in */
    assert_int_equal(with_gain(transducer, -25.4), MR_RULE_CODE_TOO_COARSE);
    assert_int_equal(with_gain(transducer, 1.0 / 12.0), MR_RULE_CODE_TOO_FINE); /* ft for in */
    assert_int_equal(with_gain(transducer, 0.0254), MR_RULE_CODE_TOO_FINE);     /* m for in */
    assert_int_equal(with_gain(gage, 4.4482216), MR_RULE_CODE_TOO_COARSE);      /* N for lb */
    assert_int_equal(with_gain(gage, 4.4482216e-3), MR_RULE_CODE_TOO_FINE);     /* kN for lb */
    struct mr_channel_config swapped = transducer;
    swapped.unit_per_code = 620.5571f;
    swapped.zero_code = -0.1f;
    assert_int_equal(mr_gain_check(&swapped), MR_RULE_CODE_TOO_COARSE);
    swapped = gage;
    swapped.unit_per_code = 1.0f / gage.unit_per_code;
    assert_int_equal(mr_gain_check(&swapped), MR_RULE_CODE_TOO_COARSE);
}

TEST(the_limits_are_where_the_facts_put_them)
{
    struct mr_channel_config c = {.kind = MR_KIND_DISPLACEMENT}; /* no range is set */
    static const struct {
        double unit, codes;
        enum mr_config_rule beyond;
        uint8_t kind;
    } limit[] = {{28.0, 2047.5, MR_RULE_CODE_TOO_COARSE, MR_KIND_DISPLACEMENT},
                 {0.4375, 2047.5, MR_RULE_CODE_TOO_FINE, MR_KIND_DISPLACEMENT},
                 {2600.0, 4095.0, MR_RULE_CODE_TOO_COARSE, MR_KIND_TENSION},
                 {40.0, 4095.0, MR_RULE_CODE_TOO_FINE, MR_KIND_TENSION}};
    for (unsigned i = 0; i < 4; i++) {
        double out = limit[i].beyond == MR_RULE_CODE_TOO_COARSE ? 1.001 : 0.999;
        c.kind = limit[i].kind;
        for (int sign = -1; sign <= 1; sign += 2) {
            c.unit_per_code = (float)(sign * limit[i].unit / limit[i].codes * out);
            assert_int_equal(mr_gain_check(&c), limit[i].beyond);
            c.unit_per_code = (float)(sign * limit[i].unit / limit[i].codes / out);
            assert_int_equal(mr_gain_check(&c), MR_RULE_NONE);
        }
    }
}

/* 1 in of travel: at 0.0099 in per code it is 101 codes, at 0.0101 99. */
TEST(a_range_of_few_codes_is_refused)
{
    struct mr_channel_config c = {
        .kind = MR_KIND_DISPLACEMENT, .low = -0.5f, .high = 0.5f, .unit_per_code = 0.0099f};
    assert_int_equal(mr_gain_check(&c), MR_RULE_NONE);
    c.unit_per_code = -0.0101f;
    assert_int_equal(mr_gain_check(&c), MR_RULE_RANGE_TOO_NARROW);
}

/* A gage of 0.04 lb per code whose zero is at 0: the converter ends at 4095 * 1.02 codes, 167.1
 * lb. */
TEST(a_range_beyond_the_converter_is_refused)
{
    struct mr_channel_config c = {.kind = MR_KIND_TENSION, .high = 668.0f, .unit_per_code = 0.04f};
    assert_true(fabsf(mr_channel_range_share(&c) - 167.076f / 668.0f) < 1e-5f);
    assert_int_equal(mr_gain_check(&c), MR_RULE_NONE);
    c.high = 669.0f;
    assert_int_equal(mr_gain_check(&c), MR_RULE_RANGE_UNREACHABLE);
    c.high = 600.0f;
    c.zero_code = 4000.0f; /* and a zero near the end leaves 7 lb */
    assert_int_equal(mr_gain_check(&c), MR_RULE_RANGE_UNREACHABLE);
    /* and one beyond the end leaves nothing: the converter ends at -0.9 lb */
    c.zero_code = 4200.0f;
    assert_true(mr_channel_range_share(&c) == 0.0f);
    c.zero_code = 4000.0f;
    c.unit_per_code = -0.16f; /* a falling one reads 640 lb from there */
    assert_int_equal(mr_gain_check(&c), MR_RULE_NONE);
}

/* A table hides a mistake as well as the straight line does: values in mm against readings in
 * in. */
TEST(a_table_is_part_of_the_gain)
{
    struct mr_channel_config c = transducer;
    c.points = 3;
    for (unsigned i = 0; i < 3; i++) {
        c.point_reading[i] = (float)i;
        c.point_value[i] = 1.01f * (float)i;
    }
    assert_int_equal(mr_gain_check(&c), MR_RULE_NONE);
    assert_true(fabsf(mr_channel_gain(&c) / transducer.unit_per_code - 1.01f) < 1e-6f);
    for (unsigned i = 0; i < 3; i++)
        c.point_value[i] *= 25.4f;
    assert_int_equal(mr_gain_check(&c), MR_RULE_CODE_TOO_COARSE);
}

TEST(a_configuration_is_refused_by_channel)
{
    struct mr_config c = sound_config();
    struct mr_config_violation reason;
    c.channel[2].unit_per_code = 25.4f * 0.0016113281f;
    assert_int_equal(mr_config_check(&c, &reason), MR_LIMIT);
    assert_int_equal(reason.group, MR_GROUP_channel);
    assert_int_equal(reason.index, 2);
    assert_int_equal(reason.field, MR_FIELD_channel_unit_per_code);
    assert_int_equal(reason.rule, MR_RULE_CODE_TOO_COARSE);
    c.channel[2].kind = MR_KIND_NONE; /* nothing measures by it */
    assert_int_equal(mr_config_check(&c, &reason), MR_OK);
}
