#include "common/block.h"

#include <math.h>
#include <string.h>

#include "common/channels.h"
#include "common/wire.h"
#include "tests/cmocka_all.h"

static uint16_t transducers[MR_SCANS_PER_BLOCK][MR_TRANSDUCERS];
static uint16_t adc1[MR_SCANS_PER_BLOCK][MR_ADC1_CHANNELS];

static void fill(uint16_t forward, uint16_t reversed, uint16_t code)
{
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            transducers[scan][i] = (uint16_t)((scan % 2 ? reversed : forward) + i);
        for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++)
            adc1[scan][i] = (uint16_t)(code + scan + 10 * i);
    }
}

static void sums_are_those_worked_out_by_hand(void **state)
{
    (void)state;
    struct mr_block block;
    fill(2100, 1990, 1000);
    mr_block_from_scans(&block, 5, 77, transducers, adc1);
    assert_int_equal(block.plus[3], 4 * 2103);
    assert_int_equal(block.minus[3], 4 * 1993);
    assert_int_equal(block.sum[2], 8 * 1020 + 28); /* 0 + 1 + ... + 7 = 28 */
    assert_int_equal(block.low[0] + block.high[0], 0);
}

static void saturation_is_counted_per_channel(void **state)
{
    (void)state;
    struct mr_block block;
    fill(2000, 2000, 2000);
    transducers[1][2] = 0;
    transducers[2][2] = 4095;
    transducers[3][2] = 4087;
    adc1[7][15] = 8;
    adc1[6][15] = 9; /* not saturated */
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_int_equal(block.low[2], 1);
    assert_int_equal(block.high[2], 2);
    assert_int_equal(block.low[MR_TRANSDUCERS + 15], 1);
    assert_int_equal(block.high[MR_TRANSDUCERS + 15], 0);
}

static void record_has_the_layout_of_the_header(void **state)
{
    (void)state;
    struct mr_block block, got;
    uint8_t out[MR_BLOCK_BYTES_MAX];
    fill(2100, 1990, 1000);
    transducers[0][7] = 4095;
    mr_block_from_scans(&block, 0x01020304, 0xa0b0c0d0, transducers, adc1);
    size_t length = mr_block_put(&block, out);
    assert_int_equal(length, 76);
    const uint8_t head[] = {0x04, 0x03, 0x02, 0x01, 0xd0, 0xc0, 0xb0, 0xa0, 0xd0, 0x20}; /* 4 * 2100 = 8400 = 0x20d0 */
    assert_memory_equal(out, head, sizeof head);
    const uint8_t tail[] = {0x80, 0x00, 0x00, 0x01}; /* channel 7; none low, one high */
    assert_memory_equal(out + 72, tail, sizeof tail);
    assert_int_equal(mr_block_get(&got, out, length), MR_OK);
    assert_memory_equal(&got, &block, sizeof got);
}

static void damaged_records_are_refused(void **state)
{
    (void)state;
    struct mr_block block = {.index = 1}, got;
    uint8_t out[MR_BLOCK_BYTES_MAX + 1] = {0};
    size_t length = mr_block_put(&block, out);
    assert_int_equal(length, MR_BLOCK_BYTES_MIN);
    assert_int_equal(mr_block_get(&got, out, length - 1), MR_TRUNCATED);
    assert_int_equal(mr_block_get(&got, out, length + 1), MR_TOO_LONG);
    out[72] = 1; /* channel 0 announced, its byte not there */
    assert_int_equal(mr_block_get(&got, out, length), MR_TRUNCATED);
    out[75] = 0x54; /* 5 low and 4 high of 8 */
    assert_int_equal(mr_block_get(&got, out, length + 1), MR_MALFORMED);
}

/* 0.5 V/in with 3.3 V and 4096 codes: 620.61 codes an inch; half difference (2100 - 1990) / 2 = 55 codes. */
static void readings_follow_from_volts(void **state)
{
    (void)state;
    struct mr_block block;
    const struct mr_channel_config transducer = {.kind = MR_KIND_DISPLACEMENT, .number = 1, .station_ft = 40.0f,
                                                 .unit_per_code = 3.3f / 4096.0f / 0.5f, .zero_code = 62.06f};
    const struct mr_channel_config gage = {.kind = MR_KIND_TENSION, .number = 1, .band = 1, .station_ft = 15.0f,
                                           .unit_per_code = 3.3f / 4096.0f / 0.005f, .zero_code = 496.48f};
    fill(2100, 1990, 1117);
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++)
        adc1[scan][MR_ADC1_REFERENCE] = 3103;
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    float ratio = mr_channels_ratio(&block);
    assert_near(ratio, 1.0, 1e-6);
    struct mr_reading reading = mr_channel_read(&transducer, &block, 0, ratio);
    assert_int_equal(reading.validity, MR_VALID);
    assert_near(reading.value, (55.0 - 62.06) / 620.606, 1e-5);
    /* 1117 + 3.5 = 1120.5 codes = 0.90275 V = 0.400 V + 5 mV/lb * 100.55 lb */
    reading = mr_channel_read(&gage, &block, MR_TRANSDUCERS, ratio);
    assert_near(reading.value, (1120.5 * 3.3 / 4096.0 - 0.4) / 0.005, 0.01);

    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++)
        adc1[scan][MR_ADC1_REFERENCE] = 3134; /* the converter's scale is 1 % high: everything reads 1 % high */
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_near(mr_channels_ratio(&block), 3103.0 / 3134.0, 1e-6);
}

static void what_cannot_be_true_is_not_a_value(void **state)
{
    (void)state;
    struct mr_block block;
    const struct mr_channel_config transducer = {.kind = MR_KIND_DISPLACEMENT, .number = 1, .station_ft = 40.0f,
                                                 .unit_per_code = 0.0016f};
    const struct mr_channel_config absent = {.kind = MR_KIND_NONE};
    fill(2100, 1990, 3100 - 150);
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_int_equal(mr_channel_read(&absent, &block, 0, 1.0f).validity, MR_INVALID_NOT_FITTED);
    struct mr_reading reading = mr_channel_read(&transducer, &block, 0, MR_NAN);
    assert_int_equal(reading.validity, MR_INVALID_REFERENCE);
    assert_true(isnan(reading.value));

    fill(300, 280, 2000); /* a broken lead floats low: far from mid-scale in both polarities */
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_int_equal(mr_channel_read(&transducer, &block, 0, 1.0f).validity, MR_INVALID_OPEN);
    assert_true(isnan(mr_channels_ratio(&block))); /* reference far off */

    fill(3700, 3680, 3300); /* or high */
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_int_equal(mr_channel_read(&transducer, &block, 0, 1.0f).validity, MR_INVALID_OPEN);
    assert_true(isnan(mr_channels_ratio(&block)));

    fill(2100, 1990, 2000);
    transducers[4][0] = 4095;
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_int_equal(mr_channel_read(&transducer, &block, 0, 1.0f).validity, MR_INVALID_SATURATED);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_are_those_worked_out_by_hand), cmocka_unit_test(saturation_is_counted_per_channel),
        cmocka_unit_test(record_has_the_layout_of_the_header), cmocka_unit_test(damaged_records_are_refused),
        cmocka_unit_test(readings_follow_from_volts), cmocka_unit_test(what_cannot_be_true_is_not_a_value),
    };
    return cmocka_run_group_tests_name("common/block", tests, NULL, NULL);
}
