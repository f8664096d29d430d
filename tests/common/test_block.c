#include "common/block.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "common/channels.h"
#include "common/wire.h"
#include "tests/cmocka_all.h"

/* Of a board at 3.3 V. */
static const struct mr_channel_config plain_reference;

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

TEST(sums_are_those_worked_out_by_hand)
{
    struct mr_block block;
    fill(2100, 1990, 1000);
    mr_block_from_scans(&block, 5, 77, transducers, adc1);
    assert_int_equal(block.forward_sum[3], 4 * 2103);
    assert_int_equal(block.reversed_sum[3], 4 * 1993);
    assert_int_equal(block.sum[2], 8 * 1020 + 28); /* 0 + 1 + ... + 7 = 28 */
    assert_int_equal(block.low_count[0] + block.high_count[0], 0);
}

TEST(saturation_is_counted_per_channel)
{
    struct mr_block block;
    fill(2000, 2000, 2000);
    transducers[1][2] = 0;
    transducers[2][2] = 4095;
    transducers[3][2] = 4087;
    adc1[7][15] = 8;
    adc1[6][15] = 9; /* not saturated */
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_int_equal(block.low_count[2], 1);
    assert_int_equal(block.high_count[2], 2);
    assert_int_equal(block.low_count[MR_TRANSDUCERS + 15], 1);
    assert_int_equal(block.high_count[MR_TRANSDUCERS + 15], 0);
}

/* Each code from the ends of the converter in each place of the scans, beside codes of its
 * neighbours that are just not saturated. */
TEST(one_saturated_code_is_found_wherever_it_is)
{
    static const uint16_t ends[] = {0, 7, 8, 9, 10, 4085, 4086, 4087, 4088, 4095};
    struct mr_block block;
    for (unsigned place = 0; place < MR_SCANS_PER_BLOCK * MR_CHANNELS; place++) {
        unsigned scan = place / MR_CHANNELS, channel = place % MR_CHANNELS;
        for (unsigned i = 0; i < COUNT_OF(ends); i++) {
            for (unsigned n = 0; n < MR_SCANS_PER_BLOCK; n++) {
                for (unsigned c = 0; c < MR_TRANSDUCERS; c++)
                    transducers[n][c] = n % 2 ? 4086 : 9;
                for (unsigned c = 0; c < MR_ADC1_CHANNELS; c++)
                    adc1[n][c] = (n + c) % 3 ? 9 : 4086;
            }
            *(channel < MR_TRANSDUCERS ? &transducers[scan][channel]
                                       : &adc1[scan][channel - MR_TRANSDUCERS]) = ends[i];
            mr_block_from_scans(&block, 0, 0, transducers, adc1);
            for (unsigned c = 0; c < MR_CHANNELS; c++) {
                assert_int_equal(block.low_count[c], c == channel && ends[i] <= 8);
                assert_int_equal(block.high_count[c], c == channel && ends[i] >= 4087);
            }
        }
    }
}

TEST(record_has_the_layout_of_the_header)
{
    struct mr_block block, got;
    uint8_t out[MR_BLOCK_BYTES_MAX];
    fill(2100, 1990, 1000);
    transducers[0][7] = 4095;
    mr_block_from_scans(&block, 0x01020304, 0xa0b0c0d0, transducers, adc1);
    size_t length = mr_block_encode(&block, out);
    assert_int_equal(length, 79);
    /* 4 * 2100 = 8400 = 0x20d0 */
    const uint8_t head[] = {0x04, 0x03, 0x02, 0x01, 0xd0, 0xc0, 0xb0, 0xa0, 0, 0, 0, 0xd0, 0x20};
    assert_memory_equal(out, head, sizeof head);
    const uint8_t tail[] = {0x80, 0x00, 0x00, 0x01}; /* channel 7; none low, one high */
    assert_memory_equal(out + 75, tail, sizeof tail);
    assert_int_equal(mr_block_decode(&got, out, length), MR_OK);
    assert_memory_equal(&got, &block, sizeof got);
}

TEST(damaged_records_are_refused)
{
    struct mr_block block = {.index = 1}, got;
    uint8_t out[MR_BLOCK_BYTES_MAX + 1] = {0};
    size_t length = mr_block_encode(&block, out);
    assert_int_equal(length, 78);
    assert_int_equal(mr_block_decode(&got, out, length - 1), MR_TRUNCATED);
    assert_int_equal(mr_block_decode(&got, out, length + 1), MR_TOO_LONG);
    out[75] = 1; /* channel 0 announced, its byte not there */
    assert_int_equal(mr_block_decode(&got, out, length), MR_TRUNCATED);
    out[78] = 0x54; /* 5 low and 4 high of 8 */
    assert_int_equal(mr_block_decode(&got, out, length + 1), MR_MALFORMED);
    out[78] = 0x00; /* announced, and then none */
    assert_int_equal(mr_block_decode(&got, out, length + 1), MR_MALFORMED);
    out[78] = 0x44;
    assert_int_equal(mr_block_decode(&got, out, length + 1), MR_OK);
}

/* The channels that are there read as they would beside all others, for every count of them on both
 * converters. */
TEST(some_channels_are_summed_like_all)
{
    uint32_t draw = 1;
    for (unsigned n = 0; n < 2000; n++) {
        uint16_t some_transducers[MR_SCANS_PER_BLOCK * MR_TRANSDUCERS],
            some_others[MR_SCANS_PER_BLOCK * MR_ADC1_CHANNELS];
        unsigned at[2] = {0, 0};
        struct mr_block all, some, got;
        struct mr_scan scan;
        uint8_t out[MR_BLOCK_BYTES_MAX];
        draw = draw * 1664525u + 1013904223u;
        /* of 22 channels; staircase and reference stay */
        uint32_t absent = n == 0 ? 0x3fffffu : n < 256 ? n : draw >> 10;
        for (unsigned row = 0; row < MR_SCANS_PER_BLOCK; row++) {
            for (unsigned c = 0; c < MR_CHANNELS; c++) {
                bool transducer = c < MR_TRANSDUCERS;
                draw = draw * 1664525u + 1013904223u;
                uint16_t code = (uint16_t)(draw % 40 == 0   ? draw >> 28
                                           : draw % 40 == 1 ? 4095 - (draw >> 28)
                                                            : draw >> 20);
                *(transducer ? &transducers[row][c] : &adc1[row][c - MR_TRANSDUCERS]) = code;
                if (c >= 22 || !(absent >> c & 1u))
                    *(transducer ? &some_transducers[at[0]++] : &some_others[at[1]++]) = code;
            }
        }
        mr_scan_select_channels(&scan, absent);
        assert_int_equal(scan.transducer_count * MR_SCANS_PER_BLOCK, at[0]);
        assert_int_equal(scan.adc1_count * MR_SCANS_PER_BLOCK, at[1]);
        mr_block_from_scans(&all, 3, 4, transducers, adc1);
        mr_block_from_fitted_scans(&some, &scan, 3, 4, some_transducers, some_others);
        assert_int_equal(some.absent_channels, absent);
        for (unsigned c = 0; c < MR_CHANNELS; c++) {
            bool there = c >= 22 || !(absent >> c & 1u);
            assert_int_equal(some.low_count[c], there ? all.low_count[c] : 0);
            assert_int_equal(some.high_count[c], there ? all.high_count[c] : 0);
            if (c < MR_TRANSDUCERS) {
                assert_int_equal(some.forward_sum[c], there ? all.forward_sum[c] : 0);
                assert_int_equal(some.reversed_sum[c], there ? all.reversed_sum[c] : 0);
            } else {
                assert_int_equal(some.sum[c - 8], there ? all.sum[c - 8] : 0);
            }
        }
        size_t length = mr_block_encode(&some, out);
        /* two sums of a transducer, one of another, 2 bytes each */
        assert_true(length >= 14u + at[0] / 2 + at[1] / 4);
        assert_int_equal(mr_block_decode(&got, out, length), MR_OK);
        assert_memory_equal(&got, &some, sizeof got);
    }
}

TEST(a_record_of_switches_alone_is_18_bytes)
{
    struct mr_block block = {.index = 0x11, .tick = 0x22, .absent_channels = 0x3fffff}, got;
    uint8_t out[MR_BLOCK_BYTES_MAX];
    block.sum[MR_ADC1_STAIRCASE] = 0x4433;
    block.sum[MR_ADC1_REFERENCE] = 0x6655;
    const uint8_t by_hand[] = {0x11, 0,    0,    0,    0x22, 0,    0, 0, 0xff,
                               0xff, 0x3f, 0x33, 0x44, 0x55, 0x66, 0, 0, 0};
    assert_int_equal(mr_block_encode(&block, out), sizeof by_hand);
    assert_memory_equal(out, by_hand, sizeof by_hand);
    assert_int_equal(mr_block_decode(&got, out, sizeof by_hand), MR_OK);
    assert_int_equal(mr_block_decode(&got, out, sizeof by_hand - 1), MR_TRUNCATED);
    out[10] = 0x7f; /* no staircase */
    assert_int_equal(mr_block_decode(&got, out, sizeof by_hand), MR_MALFORMED);
    out[10] = 0x3f;
    out[15] = 1; /* counts of a channel that is absent */
    assert_int_equal(mr_block_decode(&got, out, sizeof by_hand + 1), MR_MALFORMED);
    out[8] = 0xfe; /* transducer 1 is there, its sums are not */
    assert_int_equal(mr_block_decode(&got, out, sizeof by_hand), MR_TRUNCATED);
}

/* 0.5 V/in with 3.3 V and 4096 codes: 620.61 codes an inch; half difference (2100 - 1990) / 2 = 55
 * codes. */
TEST(readings_follow_from_volts)
{
    struct mr_block block;
    const struct mr_channel_config transducer = {.kind = MR_KIND_DISPLACEMENT,
                                                 .number = 1,
                                                 .station_ft = 40.0f,
                                                 .unit_per_code = 3.3f / 4096.0f / 0.5f,
                                                 .zero_code = 62.06f};
    const struct mr_channel_config gage = {.kind = MR_KIND_TENSION,
                                           .number = 1,
                                           .band = 1,
                                           .station_ft = 15.0f,
                                           .unit_per_code = 3.3f / 4096.0f / 0.005f,
                                           .zero_code = 496.48f};
    fill(2100, 1990, 1117);
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++)
        adc1[scan][MR_ADC1_REFERENCE] = 3103;
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    float ratio = mr_reference_ratio(&plain_reference, &block);
    assert_near(ratio, 1.0, 1e-6);
    struct mr_reading reading = mr_channel_read(&transducer, &block, 0, ratio);
    assert_int_equal(reading.validity, MR_VALID);
    assert_near(reading.value, (55.0 - 62.06) / 620.606, 1e-5);
    /* 1117 + 3.5 = 1120.5 codes = 0.90275 V = 0.400 V + 5 mV/lb * 100.55 lb */
    reading = mr_channel_read(&gage, &block, MR_TRANSDUCERS, ratio);
    assert_near(reading.value, (1120.5 * 3.3 / 4096.0 - 0.4) / 0.005, 0.01);

    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++)
        /* the converter's scale is 1 % high: everything reads 1 % high */
        adc1[scan][MR_ADC1_REFERENCE] = 3134;
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_near(mr_reference_ratio(&plain_reference, &block), 3103.0 / 3134.0, 1e-6);
}

TEST(what_cannot_be_true_is_not_a_value)
{
    struct mr_block block;
    const struct mr_channel_config transducer = {
        .kind = MR_KIND_DISPLACEMENT, .number = 1, .station_ft = 40.0f, .unit_per_code = 0.0016f};
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
    assert_true(isnan(mr_reference_ratio(&plain_reference, &block))); /* reference far off */

    fill(3700, 3680, 3300); /* or high */
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_int_equal(mr_channel_read(&transducer, &block, 0, 1.0f).validity, MR_INVALID_OPEN);
    assert_true(isnan(mr_reference_ratio(&plain_reference, &block)));

    fill(2100, 1990, 2000);
    transducers[4][0] = 4095;
    mr_block_from_scans(&block, 0, 0, transducers, adc1);
    assert_int_equal(mr_channel_read(&transducer, &block, 0, 1.0f).validity, MR_INVALID_SATURATED);
}
