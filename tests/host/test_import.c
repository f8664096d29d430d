/* Import: bits of signals worked out by hand, samples put into blocks against closed forms, logs
 * with damage, frames that wait. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/exchange/import.h"
#include "tests/host/scratch.h"

/* Bytes 12 34 56 78: little-endian 12 bits from bit 4 are 341 hex; big-endian 12 bits from bit 3
 * are 234 hex. NaN: beyond the frame. */
TEST(bits_lie_as_dbc_says)
{
    static const struct {
        struct import_signal signal;
        struct link_frame frame;
        double value;
    } cases[] = {
        {{.id = 1, .start_bit = 4, .bit_count = 12},
         {.length = 4, .data = {0x12, 0x34, 0x56, 0x78}},
         0x341},
        {{.id = 1, .start_bit = 3, .bit_count = 12, .is_big_endian = true},
         {.length = 4, .data = {0x12, 0x34, 0x56, 0x78}},
         0x234},
        {{.id = 1, .start_bit = 7, .bit_count = 16, .is_big_endian = true, .is_signed = true},
         {.length = 2, .data = {0xff, 0xfe}},
         -2},
        {{.id = 1, .bit_count = 32, .is_float = true},
         {.length = 4, .data = {0, 0, 0x20, 0xc0}},
         -2.5},
        {{.id = 1, .start_bit = 24, .bit_count = 16}, {.length = 4}, (double)NAN},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct link_frame frame = cases[i].frame;
        double value = 0.0;
        frame.id = 1;
        assert_int_equal(signal_extract_value(&cases[i].signal, &frame, &value),
                         !isnan(cases[i].value));
        assert_true(isnan(cases[i].value) || value == cases[i].value);
    }
    assert_false(signal_fits_frame(
        &(struct import_signal){.start_bit = 0, .bit_count = 9, .is_big_endian = true}, 1));
}

/* From 5 kHz the mean of each block, from 250 Hz straight lines, and nothing where samples are
 * missing. */
TEST(samples_become_blocks)
{
    struct series fast = {0}, slow = {0};
    float reading[100];
    /* five in a block: 0.1, 0.3 ... 0.9 ms: their mean is the middle's, at 0.5 ms */
    for (int i = 0; i < 500; i++)
        series_add_sample(&fast, (i + 0.5) * 2e-4, 10.0 * (i + 0.5) * 2e-4);
    import_resample(&fast, 0.0, 200.0, 300.0, 0, 100, reading);
    for (int i = 0; i < 100; i++)
        assert_near((double)reading[i], 10.0 * (i + 0.5) * 1e-3, 1e-7);
    for (int i = 0; i < 25; i++) {
        if (i != 10)
            series_add_sample(&slow, i * 4e-3, 3.0 - i * 4e-3);
    }
    /* the middle of a block is 437.5 us after its beginning */
    import_resample(&slow, 437.5, 4000.0, 6000.0, 0, 100, reading);
    for (int i = 0; i < 100; i++) {
        if (i > 36 && i < 44)
            assert_true(isnan(reading[i]));
        else if (i <= 96)
            assert_near((double)reading[i], 3.0 - i * 1e-3, 1e-6);
        else
            assert_true(isnan(reading[i]));
    }
    free(fast.time_s);
    free(fast.value);
    free(slow.time_s);
    free(slow.value);
}

TEST(damage_in_a_log)
{
    static const char text[] = "(1.000001) can0 123#00\r\n\n(1.000002) can1 123#01\n(1.0 can0 "
                               "123#02\n(1.000004) can0 123##0011\n"
                               "(1.000005) can0 123#05\n(1.000006) can0 123#0";
    const struct textfile file = {.text = (char *)(uintptr_t)text, .length = sizeof text - 1};
    struct candump_log log = {.interface = "can0"};
    struct candump_line line;
    const char *at = text;
    char verdict[300];
    unsigned sum = 0;
    while (candump_log_next(&log, &file, &at, &line))
        sum += line.frame.data[0] + 16;
    assert_int_equal(sum, 0x05 + 2 * 16);
    assert_int_equal(log.other_interface_frames, 1);
    parse_result_text(&log.result, verdict, sizeof verdict);
    assert_string_equal(verdict, "malformed at line 4, column 5: the line is not in the format of "
                                 "`candump -L`; 2 lines were skipped");
}

/* Frames wait for others; who reads, in the same transaction, sees all of them in order, and a
 * transaction that is given up none. */
static enum mr_status count_up(void *context, const struct store_frame *frame)
{
    int64_t *next = context;
    return frame->seq == (*next)++ && frame->data[0] == (uint8_t)frame->seq ? MR_OK : MR_LIMIT;
}
TEST(frames_that_wait_are_read)
{
    struct store *store = NULL;
    struct error error = {0};
    char path[200];
    int64_t next = 0, count = 0;
    scratch_path(path, sizeof path, "wait.db");
    for (int round = 0; round < 2; round++) {
        assert_int_equal(store_open(path, STORE_CREATE, &store, &error), MR_OK);
        assert_int_equal(store_begin(store, &error), MR_OK);
        next = 0;
        for (int64_t i = 0; i < 150; i++) {
            uint8_t data[20] = {(uint8_t)i};
            struct store_frame frame = {.run = 1,
                                        .seq = i,
                                        .board_us = STORE_NONE,
                                        .id = 5,
                                        .length = i == 77 ? 20 : 8,
                                        .data = data};
            assert_int_equal(store_frame_put(store, 1, &frame, &error), MR_OK);
        }
        assert_int_equal(store_frames_for_each(store, 1, 0, count_up, &next, &error), MR_OK);
        assert_int_equal(next, 150);
        if (round == 0) { /* given up */
            store_close(store);
            assert_int_equal(store_open(path, STORE_READ, &store, &error), MR_OK);
            assert_int_equal(store_frames_count(store, 1, 0, &count, &error), MR_OK);
            assert_int_equal(count, 0);
        } else {
            assert_int_equal(store_commit(store, &error), MR_OK);
        }
        store_close(store);
    }
    assert_int_equal(store_open(path, STORE_READ, &store, &error), MR_OK);
    assert_int_equal(store_frames_count(store, 1, 0, &count, &error), MR_OK);
    assert_int_equal(count, 150);
    store_close(store);
}
