/* Oscillators, bounded waits, watchdog, identity (images/clock.c). */
#include "tests/hil/bench.h"

static struct hil_board *started(const struct hil_options *options, uint32_t watchdog)
{
    struct hil_board *board = bench_board("clock", options);
    bench_control(board, 0, watchdog);
    return board;
}

TEST(test_start)
{
    struct hil_board *board = started(NULL, 0);
    bench_run(board, 2100 * HIL_PS_PER_US);
    assert_int_equal(bench_result(board, 1), 0); /* crystal 2 ms, PLL 200 us: not there yet */
    assert_int_equal(board->core.state.clock.hclk_hz, 16000000);
    bench_run(board, 3 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 1), 0x100);
    assert_int_equal(board->core.state.clock.hclk_hz, 168000000);
    assert_int_equal(bench_result(board, 2) >> 24, 0x0e); /* power-on, pin, brown-out */
    assert_int_equal(bench_result(board, 3), 0x00310042);
    assert_int_equal(bench_result(board, 4), 1024);
    assert_int_equal(bench_result(board, 5), 0x413);
    assert_int_equal(bench_result(board, 19), 1); /* WFE after SEV does not sleep */
    hil_board_destroy(board);
}

/* Without a crystal the wait gives up, and the board is still at 16 MHz, with the error of its
 * oscillator. */
TEST(test_no_crystal)
{
    struct hil_options options;
    hil_options_default(&options);
    options.hse_hz = 0;
    options.hsi_error_ppm = 10000;
    struct hil_board *board = started(&options, 0);
    bench_run(board, 500 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 1), 0x101);
    assert_int_equal(board->core.state.clock.hclk_hz, 16160000);
    hil_board_destroy(board);
}

/* 4 * 64 cycles of the LSI: 8 ms at 32 kHz, 15.06 ms at 17 kHz. Fed, it never fires; starved, it
 * resets within that time of the last feeding, again and again, and RCC_CSR says why. */
TEST(test_watchdog)
{
    static const struct {
        uint32_t lsi_hz;
        uint64_t timeout_us;
    } cases[] = {{32000, 8000}, {17000, 15059}};
    for (unsigned i = 0; i < 2; i++) {
        struct hil_options options;
        hil_options_default(&options);
        options.lsi_hz = cases[i].lsi_hz;
        struct hil_board *board = started(&options, 1);
        const struct hil_counters *counters = hil_board_counters(board);
        bench_run(board, 100 * HIL_PS_PER_MS);
        assert_int_equal(counters->watchdog_resets, 0);
        bench_control(board, 1, 1);
        bench_run(board, 100 * HIL_PS_PER_MS + (cases[i].timeout_us - 30) * HIL_PS_PER_US);
        assert_int_equal(counters->watchdog_resets, 0);
        bench_run(board, 100 * HIL_PS_PER_MS + (cases[i].timeout_us + 30) * HIL_PS_PER_US);
        assert_int_equal(counters->watchdog_resets, 1);
        assert_int_equal(counters->resets, 1);
        bench_control(board, 1, 0);
        bench_run(board, 110 * HIL_PS_PER_MS + cases[i].timeout_us * HIL_PS_PER_US);
        assert_int_equal(bench_result(board, 0), 2); /* started twice */
        /* IWDGRSTF, PINRSTF; the first start cleared the others */
        assert_int_equal(bench_result(board, 2) >> 24, 0x24);
        hil_board_destroy(board);
    }
}
