/* The flash interface on a test image (images/flash.c): keys, errors, times, the stall, what a
 * power cut leaves.
 *
 * HCLK is 16 MHz, so a cycle is 62.5 ns: a word takes 16 us = 256 cycles, a 16 KiB sector at x32
 * 250 ms = 4,000,000 (DS8626, typical). A loop around the operation adds some tens of cycles. */
#include "hil/board/board.h"
#include "tests/hil/bench.h"

#define SECTOR_1    0x08004000u
#define WORD_CYCLES 256u
#define LOOP_CYCLES 100u

static struct hil_board *flash_board(enum hil_cell_times times, uint32_t which, uint32_t a,
                                     uint32_t b)
{
    struct hil_options options;
    hil_options_default(&options);
    options.cell_times = times;
    struct hil_board *board = bench_board("flash", &options);
    bench_control(board, 0, which);
    bench_control(board, 1, a);
    bench_control(board, 2, b);
    return board;
}

static void finish(struct hil_board *board, uint64_t t_ps)
{
    bench_run(board, t_ps);
    assert_int_equal(bench_result(board, 43), 0x600d);
}

TEST(test_keys)
{
    static const uint32_t control_register[] = {0x80000000u, 0x80000000u, 0x80000000u, 1,
                                                0x80000000u, 0,           0x80000000u};
    struct hil_board *board = flash_board(HIL_TIMES_TYPICAL, 1, 0, 0);
    finish(board, HIL_PS_PER_MS);
    for (unsigned i = 0; i < 7; i++)
        assert_int_equal(bench_result(board, 1 + i) & 0xffffff01u, control_register[i]);
    assert_int_equal(bench_result(board, 8), 0x0fffaaed); /* OPTLOCK still set */
    assert_int_equal(hil_board_counters(board)->flash_errors, 2);
    hil_board_destroy(board);
}

TEST(test_program)
{
    struct hil_board *board = flash_board(HIL_TIMES_TYPICAL, 2, 0, 0);
    finish(board, 10 * HIL_PS_PER_MS);
    assert_in_range(bench_result(board, 2) - bench_result(board, 1), WORD_CYCLES,
                    WORD_CYCLES + LOOP_CYCLES);
    assert_int_equal(bench_result(board, 3), 0x12345678);
    assert_int_equal(bench_result(board, 4), 0x12340000); /* 0x12345678 and 0xffff0000 */
    assert_int_equal(bench_result(board, 5), 0);
    /* five words up to here, two of them waited for, three back to back */
    assert_in_range(bench_result(board, 6) - bench_result(board, 1), 5 * WORD_CYCLES,
                    5 * WORD_CYCLES + LOOP_CYCLES);
    assert_int_equal(bench_result(board, 7), 0x11111111);
    assert_int_equal(bench_result(board, 8), 0x22222222);
    assert_int_equal(bench_result(board, 9), 0x33333333);
    assert_int_equal(bench_result(board, 10), 0x5aa5a5ff);
    assert_int_equal(bench_result(board, 11), 0);
    assert_int_equal(hil_board_counters(board)->flash_errors, 0);
    hil_board_destroy(board);
}

/* SR: PGSERR 0x80, PGPERR 0x40, PGAERR 0x20, OPERR 2 only with ERRIE. */
TEST(test_mistakes)
{
    struct hil_board *board = flash_board(HIL_TIMES_TYPICAL, 3, 0, 0);
    finish(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 1), 0x80);
    assert_int_equal(bench_result(board, 2), 0);
    assert_int_equal(bench_result(board, 3), 0x40);
    assert_int_equal(bench_result(board, 4), 0x20);
    assert_int_equal(bench_result(board, 41), 1); /* the error interrupt */
    assert_int_equal(bench_result(board, 42), 0x42);
    assert_int_equal(bench_result(board, 5), 0xffffffff);
    assert_int_equal(bench_result(board, 6), 6); /* STRT with SER and MER does nothing */
    assert_int_equal(bench_result(board, 7), 0);
    hil_board_destroy(board);
}

/* Typical and maximum erase times by PSIZE (x8, x16, x32) and sector size, in milliseconds
 * (DS8626). */
TEST(test_erase_times)
{
    static const struct {
        uint32_t psize, sector, typical_ms, maximum_ms;
    } cases[] = {
        {0, 1, 400, 800},   {1, 2, 300, 600},  {2, 3, 250, 500},
        {0, 4, 1200, 2400}, {2, 4, 550, 1100}, {2, 11, 1000, 2000},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (unsigned maximum = 0; maximum < 2; maximum++) {
            uint32_t ms = maximum ? cases[i].maximum_ms : cases[i].typical_ms;
            struct hil_board *board = flash_board(maximum ? HIL_TIMES_MAXIMUM : HIL_TIMES_TYPICAL,
                                                  4, cases[i].psize, cases[i].sector);
            finish(board, 3 * HIL_PS_PER_S);
            assert_in_range(bench_result(board, 2) - bench_result(board, 1), ms * 16000u,
                            ms * 16000u + 200u);
            hil_board_destroy(board);
        }
    }
}

/* Code in flash stands still: one look at BSY, and of 250 SysTick interrupts one, pending, is
 * taken. */
TEST(test_stall)
{
    struct hil_board *board = flash_board(HIL_TIMES_TYPICAL, 4, 2, 1);
    uint32_t old = 0x12345678;
    assert_int_equal(hil_board_poke(board, SECTOR_1 + 0x3ffc, &old, 4), MR_OK);
    finish(board, HIL_PS_PER_S);
    assert_int_equal(bench_word(board, SECTOR_1 + 0x3ffc), 0xffffffff);
    assert_in_range(bench_result(board, 3), 0, 2);
    assert_in_range(bench_result(board, 5), 1, 2);
    assert_in_range(hil_board_counters(board)->flash_stall_cycles, 3999000, 4000000);
    assert_int_equal(bench_result(board, 4) & (1u << 16), 0); /* STRT fell back */
    /* end of operation, EOP only because of EOPIE */
    assert_int_equal(bench_result(board, 41), 1);
    assert_int_equal(bench_result(board, 42), 1);
    hil_board_destroy(board);
}

/* Code in RAM runs on and polls some hundred thousand times, until it reads flash itself. */
TEST(test_no_stall_in_ram)
{
    struct hil_board *board = flash_board(HIL_TIMES_TYPICAL, 5, 0, 0);
    finish(board, HIL_PS_PER_S);
    assert_in_range(bench_result(board, 2) - bench_result(board, 1), 4000000,
                    4000000 + LOOP_CYCLES);
    assert_true(bench_result(board, 3) > 400000);
    assert_int_equal(hil_board_counters(board)->flash_stall_cycles, 0);
    hil_board_destroy(board);

    board = flash_board(HIL_TIMES_TYPICAL, 5, 0, 1);
    finish(board, HIL_PS_PER_S);
    assert_in_range(bench_result(board, 2) - bench_result(board, 1), 4000000,
                    4000000 + LOOP_CYCLES);
    assert_int_equal(bench_result(board, 3), 0); /* the load of flash took all the time */
    assert_int_equal(bench_result(board, 6), 0xffffffff);
    assert_int_equal(bench_result(board, 7), 0);
    assert_true(hil_board_counters(board)->flash_stall_cycles > 3999000);
    hil_board_destroy(board);
}

/* Option bytes: factory values; a brown-out level, kept through a power cut; write protection is
 * refused. */
TEST(test_options)
{
    struct hil_board *board = flash_board(HIL_TIMES_TYPICAL, 6, 0x0fffaae8, 0);
    finish(board, HIL_PS_PER_S);
    assert_int_equal(bench_result(board, 1), 0x0fffaaed);
    assert_int_equal(bench_result(board, 2), 0x5513aaec); /* value below, complement above */
    assert_int_equal(bench_result(board, 3), 0xf0000fff);
    hil_supply_cut(&board->supply);
    bench_run(board, hil_board_now_ps(board) + 70 * HIL_PS_PER_NS);
    assert_int_equal(hil_board_counters(board)->power_cuts, 1);
    /* RAM is noise now, and main has not looked yet */
    assert_int_not_equal(bench_result(board, 43), 0x600d);
    bench_control(board, 0, 6);
    bench_control(board, 1, 0x0ffdaaec);
    assert_int_equal(hil_board_run_until(board, hil_board_now_ps(board) + HIL_PS_PER_S),
                     MR_UNMODELLED);
    assert_int_equal(bench_result(board, 1), 0x0fffaae9);
    assert_non_null(strstr(hil_board_failure_reason(board), "write protection"));
    hil_board_destroy(board);
}

static unsigned zero_bits(uint32_t word)
{
    return (unsigned)__builtin_popcount(~word);
}

/* Power cut in the middle of the 10th word: nine are there, the 10th has some of its bits, the rest
 * is erased. */
TEST(test_torn_word)
{
    unsigned zeroes[3] = {0}, n = 0;
    for (unsigned permille = 0; permille < 1000; permille += 450, n++) {
        for (unsigned seed = 1; seed <= 8; seed++) {
            struct hil_options options;
            hil_options_default(&options);
            options.noise_seed = seed;
            struct hil_board *board = bench_board("flash", &options);
            bench_control(board, 0, 7);
            bench_cut_at(board, false, 10, permille);
            bench_run(board, 2 * HIL_PS_PER_MS);
            assert_int_equal(hil_board_counters(board)->power_cuts, 1);
            for (unsigned i = 0; i < 9; i++)
                assert_int_equal(bench_word(board, SECTOR_1 + 4 * i), 0x5a000000u + i);
            uint32_t torn = bench_word(board, SECTOR_1 + 36);
            /* no bit that was not to change */
            assert_int_equal(torn & (0x5a000000u + 9), 0x5a000000u + 9);
            zeroes[n] += zero_bits(torn);
            for (unsigned i = 10; i < 64; i++)
                assert_int_equal(bench_word(board, SECTOR_1 + 4 * i), 0xffffffff);
            hil_board_destroy(board);
        }
    }
    /* 26 bits of 0x5a000009 are zero; 8 words: none, 45 %, 90 % of 208, within four sigma (7.2 and
     * 4.3) */
    /* the cut is a few cycles late, in 16 us: below 2 % */
    assert_in_range(zeroes[0], 0, 208 * 2 / 100);
    assert_in_range(zeroes[1], 208 * 45 / 100 - 29, 208 * 45 / 100 + 29);
    assert_in_range(zeroes[2], 208 * 90 / 100 - 18, 208);
}

/* The same in the erase before them: sector 1 has part of its old bits, its neighbours all. */
TEST(test_torn_sector)
{
    uint8_t old[0x4000] = {0}, cells[0x4000];
    unsigned ones = 0;
    struct hil_board *board = flash_board(HIL_TIMES_TYPICAL, 7, 1, 0);
    for (uint32_t at = SECTOR_1; at < SECTOR_1 + 0x8000; at += sizeof old)
        assert_int_equal(hil_board_poke(board, at, old, sizeof old), MR_OK);
    bench_cut_at(board, false, 1, 250);
    /* 62.5 ms of 250, then it has started anew; RAM is noise, control too */
    bench_run(board, 63 * HIL_PS_PER_MS);
    assert_int_equal(hil_board_peek(board, SECTOR_1, cells, sizeof cells), MR_OK);
    for (unsigned i = 0; i < sizeof cells; i++)
        ones += (unsigned)__builtin_popcount(cells[i]);
    assert_in_range(ones, 131072 / 4 - 700, 131072 / 4 + 700); /* sigma 157 */
    assert_int_equal(hil_board_peek(board, SECTOR_1 + 0x4000, cells, sizeof cells), MR_OK);
    assert_memory_equal(cells, old, sizeof old);
    hil_board_destroy(board);
}

/* Spread times: words between 16 and 100 us, most near 16, and the same again for the same seed. */
TEST(test_spread)
{
    uint64_t cycles[3];
    for (unsigned i = 0; i < 3; i++) {
        struct hil_options options;
        hil_options_default(&options);
        options.noise_seed = i == 2 ? 7 : 5;
        struct hil_board *board = bench_board("flash", &options);
        bench_control(board, 0, 7);
        finish(board, 20 * HIL_PS_PER_MS);
        cycles[i] = hil_board_counters(board)->flash_stall_cycles;
        hil_board_destroy(board);
    }
    assert_int_equal(cycles[0], cycles[1]);
    assert_int_not_equal(cycles[0], cycles[2]);
    /* mean of the spread: 16 + 84 / 9 us = 405 cycles */
    assert_in_range(cycles[0], 64 * 250, 64 * 800);
}
