/* Channels: what faults of the wiring look like to the two polarities, the table of points, limits,
 * the reference. Codes are worked out from volts: 3.3 V are 4096 codes, a transducer swings about
 * 1.65 V. */
#include <math.h>
#include <string.h>

#include "common/channels.h"
#include "tests/cmocka_all.h"

/* Of a board at 3.3 V. */
static const struct mr_channel_config plain_reference;

static const struct mr_channel_config transducer = {
    .kind = MR_KIND_DISPLACEMENT, .unit_per_code = 3.3f / 4096.0f / 0.5f, .zero_code = 62.06f};
static const struct mr_channel_config gage = {.kind = MR_KIND_TENSION,
                                              .unit_per_code = 3.3f / 4096.0f / 0.005f,
                                              .zero_code = 0.4f * 4096.0f / 3.3f};

static uint16_t code_of(double volts)
{
    double code = floor(volts / 3.3 * 4096.0 + 0.5);
    return code < 0.0 ? 0 : code > 4095.0 ? 4095 : (uint16_t)code;
}

/* All transducers at these volts, all gages at `gage_v`. */
static struct mr_block block_of(double plus_v, double minus_v, double gage_v, double reference_v)
{
    static uint16_t transducers[MR_SCANS_PER_BLOCK][MR_TRANSDUCERS],
        adc1[MR_SCANS_PER_BLOCK][MR_ADC1_CHANNELS];
    struct mr_block block;
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
        for (unsigned c = 0; c < MR_TRANSDUCERS; c++)
            transducers[scan][c] = code_of(scan % 2 ? minus_v : plus_v);
        for (unsigned c = 0; c < MR_GAGES; c++)
            adc1[scan][c] = code_of(gage_v);
        adc1[scan][MR_ADC1_REFERENCE] = code_of(reference_v);
    }
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    return block;
}

static unsigned validity_of(double plus_v, double minus_v)
{
    struct mr_block block = block_of(plus_v, minus_v, 0.9, 2.5);
    struct mr_reading reading = mr_channel_read(&transducer, &block, 3,
                                                mr_reference_ratio(&plain_reference, &block));
    assert_int_equal(isnan(reading.value), reading.validity != MR_VALID);
    return reading.validity;
}

TEST(faults_of_a_transducers_leads_are_told_apart)
{
    assert_int_equal(validity_of(1.65 + 0.30, 1.65 - 0.30), MR_VALID); /* 0.5 in */
    /* 0.4 in upfield */
    assert_int_equal(validity_of(1.65 - 0.15, 1.65 + 0.15), MR_VALID);
    /* off, pulled to ground */
    assert_int_equal(validity_of(0.0, 0.0), MR_INVALID_OPEN);
    /* off, floating */
    assert_int_equal(validity_of(0.60, 0.605), MR_INVALID_OPEN);
    assert_int_equal(validity_of(2.80, 2.795), MR_INVALID_OPEN); /* likewise */
    assert_int_equal(validity_of(3.3, 3.3), MR_INVALID_SHORTED); /* to 3.3 V */
    /* leak to ground */
    assert_int_equal(validity_of(0.9 + 0.2, 0.9 - 0.2), MR_INVALID_SHORTED);
    /* leak to 3.3 V */
    assert_int_equal(validity_of(2.4 + 0.2, 2.4 - 0.2), MR_INVALID_SHORTED);
    /* both leads off, or shorted */
    assert_int_equal(validity_of(1.65, 1.65), MR_INVALID_EXCITATION);
    assert_int_equal(validity_of(1.651, 1.649), MR_INVALID_EXCITATION);
    /* 0.08 in upfield */
    assert_int_equal(validity_of(1.66, 1.64), MR_VALID);
    /* the other lead drives the cell */
    assert_int_equal(validity_of(3.3, 0.0), MR_INVALID_SATURATED);
    assert_int_equal(validity_of(0.0, 3.3), MR_INVALID_SATURATED);
}

TEST(without_a_zero_off_mid_scale_no_amplitude_is_a_reading)
{
    struct mr_channel_config centred = transducer;
    centred.zero_code = 0.0f;
    struct mr_block block = block_of(1.65, 1.65, 0.9, 2.5);
    struct mr_reading reading = mr_channel_read(&centred, &block, 0,
                                                mr_reference_ratio(&plain_reference, &block));
    assert_int_equal(reading.validity, MR_VALID);
    assert_near(reading.value, 0.0, 1e-6);
}

TEST(a_bridge_at_an_end_is_open_or_short)
{
    struct mr_block block = block_of(1.7, 1.6, 0.0, 2.5);
    assert_int_equal(mr_channel_read(&gage, &block, MR_TRANSDUCERS, 1.0f).validity,
                     MR_INVALID_OPEN);
    block = block_of(1.7, 1.6, 3.3, 2.5);
    assert_int_equal(mr_channel_read(&gage, &block, MR_TRANSDUCERS, 1.0f).validity,
                     MR_INVALID_SHORTED);
    block.high_count[MR_TRANSDUCERS] = 7; /* one code of eight came back: it only touches the end */
    assert_int_equal(mr_channel_read(&gage, &block, MR_TRANSDUCERS, 1.0f).validity,
                     MR_INVALID_SATURATED);
}

/* A converter whose reference is 1 % low reads 1 % more of everything, its zero too: 100 lb stay
 * 100 lb. */
TEST(the_reference_takes_the_scale_out_of_reading_and_zero)
{
    struct mr_block block = block_of(1.65 + 0.303, 1.65 - 0.303, 0.909, 2.525);
    float ratio = mr_reference_ratio(&plain_reference, &block);
    assert_near(ratio, 1.0 / 1.01, 2e-4);
    struct mr_reading reading = mr_channel_read(&gage, &block, MR_TRANSDUCERS + 5, ratio);
    assert_near(reading.value, 100.0, 0.15); /* a code is 0.16 lb */
    reading = mr_channel_read(&transducer, &block, 2, ratio);
    assert_near(reading.value, 0.5, 0.0012);
    assert_near(reading.code, 0.303 / 3.3 * 4096.0, 1.0);
    /* a mean that looks good of codes that were not */
    const uint8_t reference = MR_TRANSDUCERS + MR_ADC1_REFERENCE;
    block.low_count[reference] = 1;
    assert_true(isnan(mr_reference_ratio(&plain_reference, &block)));
    block.low_count[reference] = 0;
    block.high_count[reference] = 1;
    assert_true(isnan(mr_reference_ratio(&plain_reference, &block)));
}

TEST(a_table_is_straight_lines)
{
    struct mr_channel_config config = {.points = 4,
                                       .point_reading = {-1.0f, 0.0f, 1.0f, 3.0f},
                                       .point_value = {-0.8f, 0.0f, 1.2f, 3.0f}};
    const float straight[] = {-2.0f, -1.0f, -0.5f, 0.0f, 0.25f, 1.0f, 2.0f, 3.0f, 5.0f};
    const float value[] = {-1.6f, -0.8f, -0.4f, 0.0f, 0.3f, 1.2f, 2.1f, 3.0f, 4.8f}; /* by hand */
    for (unsigned i = 0; i < sizeof straight / sizeof straight[0]; i++)
        assert_near(mr_channel_linearise(&config, straight[i]), value[i], 1e-6);
    config.points = 2;
    assert_near(mr_channel_linearise(&config, 10.0f), 8.0, 1e-5);
    config.points = 1;
    assert_near(mr_channel_linearise(&config, 10.0f), 10.0, 0.0);
    config.points = 0;
    assert_near(mr_channel_linearise(&config, -3.0f), -3.0, 0.0);
    config = (struct mr_channel_config){.points = 8};
    for (unsigned i = 0; i < 8; i++) {
        config.point_reading[i] = (float)i;
        config.point_value[i] = (float)(i * i);
    }
    for (unsigned i = 0; i < 7; i++)
        assert_near(mr_channel_linearise(&config, (float)i + 0.5f),
                    ((double)(i * i) + (double)((i + 1) * (i + 1))) / 2.0, 1e-5);
}

TEST(beyond_its_limits_it_is_not_valid)
{
    struct mr_channel_config config = transducer;
    config.low = -0.25f;
    config.high = 1.5f;
    config.points = 2; /* twice what the straight line says */
    config.point_reading[1] = 1.0f;
    config.point_value[1] = 2.0f;
    struct mr_block block = block_of(1.65 + 0.05 + 0.35, 1.65 - 0.05 - 0.35, 0.9, 2.5);
    struct mr_reading reading = mr_channel_read(&config, &block, 0,
                                                mr_reference_ratio(&plain_reference, &block));
    /* beyond the last point of the table, but not beyond the limit */
    assert_int_equal(reading.validity, MR_VALID);
    assert_near(reading.value, 1.4, 0.005);
    block = block_of(1.65 + 0.05 + 0.40, 1.65 - 0.05 - 0.40, 0.9, 2.5);
    assert_int_equal(
        mr_channel_read(&config, &block, 0, mr_reference_ratio(&plain_reference, &block)).validity,
        MR_INVALID_RANGE);
    block = block_of(1.65 + 0.05 - 0.08, 1.65 - 0.05 + 0.08, 0.9, 2.5);
    assert_int_equal(
        mr_channel_read(&config, &block, 0, mr_reference_ratio(&plain_reference, &block)).validity,
        MR_INVALID_RANGE);
    config.high = config.low; /* not set */
    assert_int_equal(
        mr_channel_read(&config, &block, 0, mr_reference_ratio(&plain_reference, &block)).validity,
        MR_VALID);
}

TEST(a_calibration_travels_item_by_item)
{
    struct mr_channel_config from = {.points = 3,
                                     .gain_error = 0.1f,
                                     .zero_error = 0.2f,
                                     .linearity_error = 0.3f,
                                     .drift_error_per_h = 0.4f,
                                     .low = -5.0f,
                                     .high = 6.0f,
                                     .rate_limit_per_s = 7.0f};
    struct mr_channel_config to = {0};
    for (unsigned i = 0; i < MR_CONFIG_POINTS; i++) {
        from.point_reading[i] = 10.0f + (float)i;
        from.point_value[i] = 20.0f + (float)i;
    }
    for (unsigned item = 0; item < MR_CALIBRATION_ITEM_COUNT; item++)
        mr_channel_set_item(&to, item, mr_channel_get_item(&from, item));
    assert_memory_equal(&to, &from, sizeof to);
    assert_near(mr_channel_get_item(&from, 3), 0.4, 1e-6);
    assert_near(mr_channel_get_item(&from, 9), 20.0, 0.0);
    assert_near(mr_channel_get_item(&from, 22), 17.0, 0.0);
    assert_true(isnan(mr_channel_get_item(&from, MR_CALIBRATION_ITEM_COUNT)));
    mr_channel_set_item(&to, MR_CALIBRATION_ITEM_COUNT, 1.0f);
    mr_channel_set_item(&to, MR_CALIBRATION_POINTS, 9.0f); /* more than there is room for */
    mr_channel_set_item(&to, MR_CALIBRATION_POINTS, NAN);
    assert_memory_equal(&to, &from, sizeof to);
}

TEST(each_validity_has_a_text)
{
    for (unsigned i = 0; i < MR_VALIDITY_COUNT; i++) {
        for (unsigned k = 0; k < i; k++)
            assert_string_not_equal(mr_validity_text(i), mr_validity_text(k));
    }
    assert_string_equal(mr_validity_text(MR_VALIDITY_COUNT), "unknown");
}
