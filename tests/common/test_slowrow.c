/* Rows of the slow log: the bytes laid out by hand from common/slowrow.h, and rows put together
 * from their parts. */
#include "common/slowrow.h"

#include <math.h>
#include <string.h>
#include <zlib.h>

#include "tests/cmocka_all.h"

static struct mr_slowrow make_row(uint32_t seq)
{
    struct mr_slowrow row = {.seq = seq,
                             .block = 60000,
                             .faults = 0x80000001u,
                             .temperature_c = -0.5f,
                             .boot = 3,
                             .state = 0x41};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        row.displacement_in[i] = 0.125f * (float)i;
    for (unsigned i = 0; i < MR_GAGES; i++)
        row.tension_lb[i] = 100.0f + 0.5f * (float)i;
    row.displacement_in[7] = NAN;
    row.tension_lb[13] = NAN;
    return row;
}

static void check_row(const struct mr_slowrow *row, const struct mr_slowrow *expected)
{
    assert_int_equal(row->seq, expected->seq);
    assert_int_equal(row->block, expected->block);
    assert_int_equal(row->faults, expected->faults);
    assert_int_equal(row->boot, expected->boot);
    assert_int_equal(row->state, expected->state);
    assert_near(row->temperature_c, expected->temperature_c, 0.0);
    for (unsigned i = 0; i < MR_TRANSDUCERS - 1; i++)
        assert_near(row->displacement_in[i], expected->displacement_in[i], 1e-6);
    for (unsigned i = 0; i < MR_GAGES - 1; i++)
        assert_near(row->tension_lb[i], expected->tension_lb[i], 1e-5);
    assert_true(isnan(row->displacement_in[7]) && isnan(row->tension_lb[13]));
}

static void the_bytes_are_those_of_the_table(void **state)
{
    (void)state;
    struct mr_slowrow row = make_row(0x01020304), again;
    uint8_t bytes[MR_SLOWROW];
    /* seq, block 60000 = 0xea60, faults, -0.5 C * 16 = -8, 0 in, 0.125 in * 10000 = 1250 =
     * 0x04e2 */
    const uint8_t begin[] = {4, 3, 2,    1,    0x60, 0xea, 0, 0,    1,
                             0, 0, 0x80, 0xf8, 0xff, 0,    0, 0xe2, 0x04};
    mr_slowrow_put(&row, bytes);
    assert_memory_equal(bytes, begin, sizeof begin);
    assert_int_equal(bytes[14 + 14] | bytes[14 + 15] << 8, 0x8000); /* displacement 8 is missing */
    assert_int_equal(bytes[30] | bytes[31] << 8, 5000);             /* 100 lb * 50 */
    assert_int_equal(bytes[58], 3);
    assert_int_equal(bytes[59], 0x41);
    uint32_t crc = (uint32_t)crc32(0, bytes, 60);
    for (unsigned i = 0; i < 4; i++)
        assert_int_equal(bytes[60 + i], (uint8_t)(crc >> 8 * i));
    assert_int_equal(mr_slowrow_get(&again, bytes), MR_OK);
    check_row(&again, &row);
    for (unsigned bit = 0; bit < 8 * MR_SLOWROW; bit++) { /* every single bit is noticed */
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_int_equal(mr_slowrow_get(&again, bytes), MR_CRC);
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    memset(bytes, 0xff, sizeof bytes);
    assert_int_equal(mr_slowrow_get(&again, bytes), MR_TOO_FEW);
}

static enum mr_status give(struct mr_slowrow_reader *reader, const struct mr_slowrow *row,
                           unsigned part)
{
    uint16_t id;
    uint8_t payload[MR_MESSAGE_MAX];
    size_t length = mr_slowrow_part(row, part, &id, payload);
    return mr_slowrow_take(reader, id, payload, length);
}

static void parts_in_order_are_a_row(void **state)
{
    (void)state;
    struct mr_slowrow_reader reader = {0};
    for (uint32_t seq = 255; seq < 258; seq++) {
        struct mr_slowrow row = make_row(seq);
        for (unsigned part = 0; part + 1 < MR_SLOWROW_PARTS; part++) {
            assert_int_equal(give(&reader, &row, part), MR_TOO_FEW);
            /* what else travels meanwhile does not disturb it */
            assert_int_equal(mr_slowrow_take(&reader, MR_ID_HELLO, (const uint8_t[8]){0}, 8),
                             MR_UNKNOWN);
        }
        assert_int_equal(give(&reader, &row, MR_SLOWROW_PARTS - 1), MR_OK);
        check_row(&reader.row, &row);
    }
}

/* Any one part that is lost, doubled, cut short or of another row loses the row, and the next whole
 * one is read. */
static void a_row_with_a_hole_is_none(void **state)
{
    (void)state;
    const struct mr_slowrow row = make_row(7), other = make_row(8);
    for (unsigned hurt = 0; hurt < MR_SLOWROW_PARTS; hurt++) {
        for (unsigned how = 0; how < 4; how++) {
            struct mr_slowrow_reader reader = {0};
            unsigned whole = 0;
            if ((hurt == 0 && how == 1) || (hurt <= 1 && how == 3))
                continue; /* a beginning that comes twice is one; the state has no number */
            for (unsigned part = 0; part < MR_SLOWROW_PARTS; part++) {
                uint16_t id;
                uint8_t payload[MR_MESSAGE_MAX];
                size_t length = mr_slowrow_part(&row, part, &id, payload);
                if (part == hurt && how == 1)
                    whole += give(&reader, &row, part) == MR_OK;
                if (part == hurt && how == 2)
                    length--;
                if (part == hurt && how == 3)
                    length = mr_slowrow_part(&other, part, &id, payload);
                if (part != hurt || how)
                    whole += mr_slowrow_take(&reader, id, payload, length) == MR_OK;
            }
            if (hurt == MR_SLOWROW_PARTS - 1 && how == 1)
                assert_int_equal(whole, 1); /* it was whole before the last came again */
            else
                assert_int_equal(whole, 0);
            for (unsigned part = 0; part < MR_SLOWROW_PARTS; part++)
                whole = give(&reader, &other, part) == MR_OK;
            assert_int_equal(whole, 1);
            check_row(&reader.row, &other);
        }
    }
}

/* Parts of one kind that come out of their order, and parts that come before any beginning. */
static void parts_out_of_order_are_no_row(void **state)
{
    (void)state;
    const struct mr_slowrow row = make_row(7);
    for (unsigned at = 1; at < MR_SLOWROW_PARTS; at++) {
        for (unsigned instead = 1; instead < MR_SLOWROW_PARTS; instead++) {
            struct mr_slowrow_reader reader = {0};
            assert_int_equal(give(&reader, &row, instead), MR_UNKNOWN); /* none has begun */
            for (unsigned part = 0; part < at; part++)
                assert_int_equal(give(&reader, &row, part), MR_TOO_FEW);
            enum mr_status right = at + 1 == MR_SLOWROW_PARTS ? MR_OK : MR_TOO_FEW;
            assert_int_equal(give(&reader, &row, instead), instead == at ? right : MR_UNKNOWN);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bytes_are_those_of_the_table),
        cmocka_unit_test(parts_in_order_are_a_row),
        cmocka_unit_test(a_row_with_a_hole_is_none),
        cmocka_unit_test(parts_out_of_order_are_no_row),
    };
    return cmocka_run_group_tests_name("common/slowrow", tests, NULL, NULL);
}
