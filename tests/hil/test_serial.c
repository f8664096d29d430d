/* USART1 with DMA on a test image (images/serial.c): rate, flags, circular reception. */
#include "tests/hil/bench.h"

struct heard {
    size_t count;
    uint8_t bytes[256];
    uint64_t last_ps;
};

static void hear(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct heard *heard = ctx;
    assert_true(heard->count + n <= sizeof heard->bytes);
    memcpy(heard->bytes + heard->count, bytes, n);
    heard->count += n;
    heard->last_ps = t_ps;
}

static struct hil_board *talking(uint32_t brr, uint32_t from_ccm, struct heard *heard)
{
    struct hil_board *board = bench_board("serial", NULL);
    struct hil_callbacks callbacks = {heard, NULL, hear};
    *heard = (struct heard){0};
    hil_board_set_callbacks(board, &callbacks);
    bench_control(board, 0, brr);
    bench_control(board, 1, from_ccm);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 0), 0x100);
    return board;
}

/* A byte is 10 bits of 0.5 us: 840 cycles of 168 MHz. The last of 100 bytes leaves DR two byte
 * times before the end (one byte is in the shift register when the last enters DR), so: DMA
 * complete at 98 bytes, TC at 100. Handlers are late by an entry and a few instructions. */
TEST(test_send)
{
    struct heard heard;
    struct hil_board *board = talking(0, 0, &heard);
    assert_int_equal(heard.count, 100);
    for (unsigned i = 0; i < 100; i++)
        assert_int_equal(heard.bytes[i], i + 1);
    uint32_t start = bench_result(board, 3);
    assert_int_equal(bench_result(board, 7), 48); /* HTIF, TCIF */
    assert_in_range(bench_result(board, 1) - start, 98 * 840, 98 * 840 + 60);
    assert_in_range(bench_result(board, 2) - start, 100 * 840, 100 * 840 + 60);
    hil_board_destroy(board);
}

/* Twice the divider: half the rate. */
TEST(test_wrong_rate)
{
    struct heard heard;
    struct hil_board *board = talking(84, 0, &heard);
    assert_int_equal(heard.count, 100);
    for (unsigned i = 0; i < 100; i++)
        assert_int_not_equal(heard.bytes[i], i + 1);
    assert_int_equal(hil_board_counters(board)->serial_bytes_garbled, 100);
    assert_int_equal(hil_board_counters(board)->serial_bytes_out, 0);
    hil_board_destroy(board);
}

/* DMA does not reach the CCM: transfer error, nothing sent. */
TEST(test_ccm_is_out_of_reach)
{
    struct heard heard;
    struct hil_board *board = talking(0, 1, &heard);
    assert_int_equal(heard.count, 0);
    assert_int_equal(bench_result(board, 7), 8); /* TEIF alone */
    hil_board_destroy(board);
}

/* 20 bytes into a circle of 16, then an idle line: the counter stands at 12, the first four are
 * overwritten. */
TEST(test_receive)
{
    struct heard heard;
    uint8_t bytes[20], circle[16];
    struct hil_board *board = talking(0, 0, &heard);
    for (unsigned i = 0; i < sizeof bytes; i++)
        bytes[i] = (uint8_t)(0x80 + i);
    assert_int_equal(hil_usart_inject(&board->mcu.usart, bytes, sizeof bytes), MR_OK);
    bench_run(board, 10 * HIL_PS_PER_MS + 20 * 5 * HIL_PS_PER_US + 4 * HIL_PS_PER_US);
    assert_int_equal(bench_result(board, 4), 0); /* the line has not been idle for a byte yet */
    bench_run(board, 11 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 4), 1);
    assert_int_equal(bench_result(board, 5), 12);
    assert_int_equal(hil_board_peek(board, bench_result(board, 6), circle, sizeof circle), MR_OK);
    for (unsigned i = 0; i < 16; i++)
        assert_int_equal(circle[i], i < 4 ? 0x90 + i : 0x80 + i);
    hil_board_destroy(board);
}
