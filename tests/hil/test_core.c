/* The core's exceptions on a test image (images/core.c), and what stops a run (images/wild.c). */
#include "tests/hil/bench.h"

/* What the handlers note, worked out from the architecture's rules: irq 6 (0xf0) runs, pends 8
 * (0x40): preempts at once; pends 7 (0xf0, equal): must wait until 6 returns, then tail-chains. */
TEST(test_order)
{
    static const uint32_t expected[] = {0x61, 0x81, 0x62, 0x71, 0x01, /* preemption, tail-chain */
                                        /* BASEPRI 0x50 passes 0x40 only */
                                        0x81, 0x02, 0x71, 0x03,
                                        /* PRIMASK: WFI wakes, handler waits for cpsie */
                                        0x04, 0x71, 0xa0, 0xb0, /* SVC, PendSV */
                                        /* inside the floating-point loop */
                                        0x81,
                                        /* SVC from the process stack */
                                        0xa0};
    struct hil_board *board = bench_board("core", NULL);
    bench_run(board, 20 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 0), 1);
    assert_int_equal(bench_result(board, 7), sizeof expected / sizeof expected[0]);
    for (unsigned i = 0; i < sizeof expected / sizeof expected[0]; i++)
        assert_int_equal(bench_result(board, 8 + i), expected[i]);
    assert_int_equal(hil_board_counters(board)->tail_chains, 1);
    assert_int_equal(bench_result(board, 1), 0); /* the stack pointer is where it was */
    /* CONTROL.SPSEL survived an exception from the process stack */
    assert_int_equal(bench_result(board, 4), 2);
    assert_int_equal(bench_result(board, 3), 10); /* SysTick */
    hil_board_destroy(board);
}

/* 1.5 + 100 * 0.25 + 7 + 100 * 0.125 = 46: exact in single precision, and any register lost in the
 * handler changes it. */
TEST(test_fp_context)
{
    float sum;
    uint32_t bits;
    struct hil_board *board = bench_board("core", NULL);
    bench_run(board, 20 * HIL_PS_PER_MS);
    bits = bench_result(board, 2);
    memcpy(&sum, &bits, sizeof sum);
    assert_true(sum == 46.0f);
    hil_board_destroy(board);
}

/* Where the run is cut into pieces changes nothing. */
TEST(test_pieces)
{
    struct hil_board *whole = bench_board("core", NULL), *cut = bench_board("core", NULL);
    bench_run(whole, 20 * HIL_PS_PER_MS);
    for (uint64_t t_ps = 0; t_ps < 20 * HIL_PS_PER_MS; t_ps += 37 * HIL_PS_PER_US)
        bench_run(cut, t_ps);
    bench_run(cut, 20 * HIL_PS_PER_MS);
    assert_int_equal(hil_board_counters(cut)->instructions,
                     hil_board_counters(whole)->instructions);
    assert_int_equal(hil_board_counters(cut)->exceptions, hil_board_counters(whole)->exceptions);
    assert_int_equal(hil_now_cycle(&cut->core), hil_now_cycle(&whole->core));
    hil_board_destroy(whole);
    hil_board_destroy(cut);
}

static struct hil_board *misdeed(uint32_t which, enum mr_status status)
{
    struct hil_board *board = bench_board("wild", NULL);
    bench_control(board, 0, which);
    assert_int_equal(hil_board_run_until(board, 100 * HIL_PS_PER_MS), status);
    return board;
}

static void assert_reason(const struct hil_board *board, const char *part)
{
    if (!strstr(hil_board_failure_reason(board), part))
        fail_msg("`%s` is not in the reason: %s", part, hil_board_failure_reason(board));
}

/* The load is the third instruction of read_at, after two of two bytes. */
static void assert_pc_of_read(const struct hil_board *board)
{
    char pc[32];
    snprintf(pc, sizeof pc, "PC 0x%08x", (unsigned)(bench_result(board, 5) & ~1u) + 4u);
    assert_reason(board, pc);
}

TEST(test_unmodelled)
{
    struct hil_board *board = misdeed(1, MR_UNMODELLED);
    assert_reason(board, "read of 4 bytes at 0x40004404");
    assert_pc_of_read(board);
    /* it stays stopped */
    assert_int_equal(hil_board_run_until(board, 200 * HIL_PS_PER_MS), MR_UNMODELLED);
    hil_board_destroy(board);
    board = misdeed(9, MR_UNMODELLED);
    assert_reason(board, "0x40023888 (RCC + 0x88)");
    assert_pc_of_read(board);
    hil_board_destroy(board);
}

TEST(test_clock_off)
{
    struct hil_board *board = misdeed(2, MR_UNMODELLED);
    assert_reason(board, "clock of the peripheral is off");
    assert_reason(board, "TIM4");
    hil_board_destroy(board);
}

/* The handler sees a precise fault with its address, and asks for a reset; the image then starts
 * again. */
TEST(test_bus_fault)
{
    struct hil_board *board = misdeed(3, MR_OK);
    assert_int_equal(bench_result(board, 1), 1);
    assert_int_equal(bench_result(board, 2), 0x8200); /* PRECISERR, BFARVALID */
    assert_int_equal(bench_result(board, 3), 0x60000000);
    assert_int_equal(bench_result(board, 0), 2);
    assert_int_equal(bench_result(board, 4), 0x600d);
    const struct hil_counters *counters = hil_board_counters(board);
    assert_int_equal(counters->resets, 1);
    assert_int_equal(counters->fault_exceptions, 1);
    assert_int_equal(counters->last_fault_pc, (bench_result(board, 5) & ~1u) + 4u);
    hil_board_destroy(board);
}

/* DUI 0553A 2.4.2: the handler runs although its frame could not be stored. CFSR: BFARVALID,
 * PRECISERR and STKERR (PM0214 4.4.11). */
TEST(test_no_memory_for_a_frame)
{
    static const struct {
        uint32_t misdeed, cfsr;
    } cases[] = {{18, 0x9200}, {19, 0x1000}};
    for (unsigned i = 0; i < 2; i++) {
        struct hil_board *board = bench_board("wild", NULL);
        bench_control(board, 0, cases[i].misdeed);
        bench_run(board, 1000000000);
        assert_int_equal(bench_result(board, 0), 2); /* it has begun again */
        assert_int_equal(bench_result(board, 1), 1);
        assert_int_equal(bench_result(board, 8), 5); /* in the bus fault */
        assert_int_equal(bench_result(board, 2), cases[i].cfsr);
        if (i == 0)
            assert_int_equal(bench_result(board, 3), 0x1ffffff8);
        hil_board_destroy(board);
    }
}

TEST(test_halts)
{
    static const struct {
        uint32_t which;
        enum mr_status status;
        const char *part;
    } cases[] = {
        {4, MR_HALTED, "exception 3 has no handler"},
        {5, MR_HALTED, "CFSR 0x00080000"}, /* NOCP */
        {15, MR_UNMODELLED, "0x40020010 (GPIOA + 0x10), PC 0x"},
        {15, MR_UNMODELLED, "read-only"},
        {16, MR_UNMODELLED, "a reserved bit"},
        {17, MR_UNMODELLED, "frames other than 8N1"},
        {7, MR_HALTED, "HCLK exceeds the limit that FLASH_ACR.LATENCY"},
        {8, MR_HALTED, "CFSR 0x00010000"},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct hil_board *board = misdeed(cases[i].which, cases[i].status);
        assert_reason(board, cases[i].part);
        assert_int_not_equal(bench_result(board, 4), 0x600d);
        hil_board_destroy(board);
    }
}

/* Usage faults that Unicorn does not know, and a return that cannot be (ARMv7-M B1.5.8): the
 * handler sees the cause, and what came before in the block was done. */
TEST(test_usage_faults)
{
    static const struct {
        uint32_t which, cfsr, done;
        bool alignment;
    } cases[] = {
        {10, 1u << 24, 77, true}, {11, 1u << 24, 0, true},  {13, 1u << 19, 77, false},
        {14, 1u << 19, 0, false}, {13, 1u << 19, 77, true}, {20, 1u << 18, 0, false},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct hil_options options;
        hil_options_default(&options);
        options.is_alignment_checked = cases[i].alignment;
        struct hil_board *board = bench_board("wild", &options);
        bench_control(board, 0, cases[i].which);
        bench_run(board, 100 * HIL_PS_PER_MS);
        assert_int_equal(bench_result(board, 1), 1);
        assert_int_equal(bench_result(board, 2), cases[i].cfsr);
        assert_int_equal(bench_result(board, 6), cases[i].done);
        assert_int_equal(bench_result(board, 4), 0x600d); /* after its reset */
        assert_int_equal(hil_board_counters(board)->fault_exceptions, 1);
        hil_board_destroy(board);
    }
}

/* Single loads and stores may be unaligned (CCR.UNALIGN_TRP is 0); what an IT block passes over may
 * be anything (ARMv7-M A7.3). */
TEST(test_no_fault)
{
    static const uint32_t cases[] = {12, 21};
    for (unsigned i = 0; i < 2; i++) {
        struct hil_options options;
        hil_options_default(&options);
        options.is_alignment_checked = true;
        struct hil_board *board = bench_board("wild", &options);
        bench_control(board, 0, cases[i]);
        bench_run(board, 100 * HIL_PS_PER_MS);
        assert_int_equal(bench_result(board, 4), 0x600d);
        assert_int_equal(hil_board_counters(board)->fault_exceptions, 0);
        hil_board_destroy(board);
    }
}

/* Code in SRAM, changed after it has run once. */
TEST(test_code_in_sram)
{
    struct hil_board *board = bench_board("ramcode", NULL);
    bench_run(board, HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 0), 1);
    assert_int_equal(bench_result(board, 1), 15);
    assert_int_equal(bench_result(board, 2), 17);
    hil_board_destroy(board);
}
