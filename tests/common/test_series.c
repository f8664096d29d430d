#include "common/catalogue.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/cmocka_all.h"

/* -0.3312 in * 10000 = -3312 = 0xf310, 14.02 lb * 50 = 701 = 0x02bd; missing = 0x8000: worked out
 * by hand. */
TEST(packs_put_the_bytes_worked_out_by_hand)
{
    const float d[8] = {-0.3312f, NAN, 4.0f, 0, 0, 0, 1.0f, NAN};
    float t[14] = {0};
    uint8_t out[MR_MESSAGE_BYTES_MAX];
    t[12] = 14.02f;
    t[13] = NAN;
    assert_int_equal(
        mr_series_pack_put(mr_series_pack_at(MR_PACK_DISPLACEMENT_1_3), d, 0x51234, out), 8);
    assert_memory_equal(out, ((const uint8_t[]){0x10, 0xf3, 0x00, 0x80, 0xff, 0x7f, 0x34, 0x12}),
                        8);
    assert_int_equal(
        mr_series_pack_put(mr_series_pack_at(MR_PACK_DISPLACEMENT_7_8), d, 0x51234, out), 8);
    /* 2 and 8 are missing */
    assert_memory_equal(out, ((const uint8_t[]){0x10, 0x27, 0x00, 0x80, 0x82, 0x00, 0x34, 0x12}),
                        8);
    assert_int_equal(mr_series_pack_put(mr_series_pack_at(MR_PACK_TENSION_13_14), t, 9, out), 8);
    assert_memory_equal(out, ((const uint8_t[]){0xbd, 0x02, 0x00, 0x80, 0x00, 0x20, 0x09, 0x00}),
                        8);
}

/* The message that the catalogue describes, field by field: another way to the same numbers. */
TEST(a_pack_is_the_message_of_the_catalogue)
{
    unsigned seen[MR_SERIES_COUNT] = {0};
    for (unsigned number = 0; number < MR_SERIES_PACK_COUNT; number++) {
        const struct mr_series_pack *pack = mr_series_pack_at(number);
        const struct mr_series *series = mr_series_at(pack->series);
        const struct mr_message_info *info = mr_message_find(pack->id);
        float values[16], got[MR_PACK_READINGS];
        uint8_t out[MR_MESSAGE_BYTES_MAX];
        char name[16];
        assert_int_equal(mr_series_pack_find(pack->id), number);
        assert_int_equal(info->period_ms, series->averaged_blocks);
        assert_int_equal(pack->first_reading, seen[pack->series] + 1);
        seen[pack->series] += pack->reading_count;
        for (unsigned i = 0; i < series->reading_count; i++)
            values[i] = 0.5f * (float)i - 1.0f;
        assert_int_equal(mr_series_pack_put(pack, values, 70000, out), info->length);
        assert_int_equal(mr_series_pack_get(pack, out, got), pack->reading_count);
        for (unsigned i = 0; i < pack->reading_count; i++) {
            snprintf(name, sizeof name, "%c%u_%s", series->letter, pack->first_reading + i,
                     info->fields[i].unit);
            assert_string_equal(info->fields[i].name, name);
            assert_true(mr_field_value(&info->fields[i], out) ==
                        (double)values[pack->first_reading - 1 + i]);
            assert_true(got[i] == values[pack->first_reading - 1 + i]);
            assert_true(info->fields[i].counts_per_unit == series->counts_per_unit);
        }
        assert_true(mr_field_value(&info->fields[info->field_count - 1], out) == 70000 - 65536);
    }
    for (unsigned i = 0; i < MR_SERIES_COUNT; i++)
        assert_int_equal(seen[i], mr_series_at(i)->reading_count);
    assert_int_equal(mr_series_pack_find(MR_ID_HELLO), MR_SERIES_PACK_COUNT);
}
