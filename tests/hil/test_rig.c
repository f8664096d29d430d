/* The rig's voltages against numbers worked out by hand. */
#include <math.h>

#include "hil/board/board.h"
#include "tests/hil/bench.h"

static double rig_volts(struct hil_rig_device *rig, unsigned port, unsigned pin, uint64_t at)
{
    return hil_rig_channel_volts(rig, hil_rig_find_channel(rig, port, pin), at);
}

static void assert_volts(struct hil_board *board, unsigned port, unsigned pin, uint64_t t_ps,
                         double volts)
{
    double got = rig_volts(&board->rig, port, pin,
                           hil_clock_cycle_at_ps(&board->core.state.clock, t_ps));
    /* a step settles by 15 uV in the cycle that times are rounded to */
    if (fabs(got - volts) > 2e-5)
        fail_msg("pin %c%u: %.9f V, expected %.9f", 'A' + (int)port, pin, got, volts);
}

/* 64 + 8 * ((7 (p - 1)) mod 24): a permutation of 64 to 248 in steps of 8, neighbours at least 56
 * apart. */
TEST(test_steps)
{
    static const unsigned by_hand[6] = {64, 120, 176, 232, 96, 152};
    unsigned seen[24] = {0};
    for (unsigned p = 1; p <= 6; p++)
        assert_int_equal(hil_switch_step_codes(p), by_hand[p - 1]);
    for (unsigned p = 1; p <= 24; p++) {
        seen[(hil_switch_step_codes(p) - 64) / 8]++;
        if (p < 24)
            assert_true(abs((int)hil_switch_step_codes(p) - (int)hil_switch_step_codes(p + 1)) >=
                        56);
    }
    for (unsigned i = 0; i < 24; i++)
        assert_int_equal(seen[i], 1);
}

/* Switch 1 adds 64 codes = 0.0515625 V, switch 2 120 codes = 0.09667969 V; 20 us to 1 - 1/e. */
TEST(test_staircase)
{
    struct hil_run run;
    still_run(&run, 1.0);
    run.switch_open_ps[0] = 10 * HIL_PS_PER_MS;
    run.switch_open_ps[1] = 15 * HIL_PS_PER_MS;
    struct hil_board *board = bench_board("clock", NULL);
    hil_board_attach_rig(board, &run);
    bench_run(board, 9 * HIL_PS_PER_MS);
    assert_volts(board, 2, 4, 9 * HIL_PS_PER_MS, 0.050);
    bench_run(board, 10 * HIL_PS_PER_MS + 100 * HIL_PS_PER_US);
    assert_volts(board, 2, 4, 10 * HIL_PS_PER_MS, 0.050);
    assert_volts(board, 2, 4, 10 * HIL_PS_PER_MS + 20 * HIL_PS_PER_US,
                 0.050 + 0.0515625 * 0.6321205588);
    assert_volts(board, 2, 4, 14 * HIL_PS_PER_MS, 0.1015625);
    bench_run(board, 20 * HIL_PS_PER_MS);
    assert_volts(board, 2, 4, 20 * HIL_PS_PER_MS, 0.1982421875);
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* The one-shot: 20 us high on PA15, and only then. */
TEST(test_pulse)
{
    struct hil_run run;
    still_run(&run, 1.0);
    run.switch_open_ps[4] = 10 * HIL_PS_PER_MS;
    struct hil_board *board = bench_board("clock", NULL);
    hil_board_attach_rig(board, &run);
    static const struct {
        uint64_t t_us;
        bool level;
    } expected[] = {
        {9999, false},
        {10001, true},
        {10019, true},
        {10021, false},
    };
    for (unsigned i = 0; i < 4; i++) {
        bench_run(board, expected[i].t_us * HIL_PS_PER_US);
        assert_int_equal(hil_board_pin_level(board, 0, 15), expected[i].level);
    }
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* 0.5 in at 1 kHz samples 0 and 1 lb to 200 lb: half way between samples, and held at the ends. */
TEST(test_truth_and_gages)
{
    static int32_t table[2][HIL_RUN_COLUMNS];
    struct hil_run run = {.sample_rate_hz = 1000.0, .sample_count = 2, .samples = table};
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        run.switch_open_ps[i] = HIL_RUN_NEVER;
    table[1][0] = 50000;                        /* transducer 1: 0.5 in */
    table[0][8] = 10000, table[1][8] = 20000;   /* gage 1: 100 to 200 lb */
    table[0][21] = -5000, table[1][21] = -5000; /* gage 14: -50 lb */
    assert_true(hil_run_get_true_value(&run, 0, 0.0005) == 0.25);
    assert_true(hil_run_get_true_value(&run, 0, 5.0) == 0.5);
    assert_true(fabs(hil_run_get_true_value(&run, 8, 0.00025) - 125.0) < 1e-9);
    struct hil_board *board = bench_board("clock", NULL);
    hil_board_attach_rig(board, &run);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_volts(board, 0, 0, 10 * HIL_PS_PER_MS, 0.400 + 0.005 * 200.0);
    assert_volts(board, 2, 3, 10 * HIL_PS_PER_MS, 0.400 - 0.250);
    assert_volts(board, 0, 1, 10 * HIL_PS_PER_MS, 0.400);
    assert_volts(board, 2, 5, 10 * HIL_PS_PER_MS, 2.5);
    assert_volts(board, 5, 3, 10 * HIL_PS_PER_MS, 1.65); /* not excited */
    hil_board_destroy(board);
}

/* Excitation driven by hand: +1 settles from 0 as 1 - exp(-t/4 us), a reversal as 1 - 2 exp(-t/4
 * us) with the other sign. With d = 0.5 in the full voltage is 0.3 V. */
TEST(test_excitation)
{
    static int32_t table[1][HIL_RUN_COLUMNS];
    struct hil_run run = {.sample_rate_hz = 1.0, .sample_count = 1, .samples = table};
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        run.switch_open_ps[i] = HIL_RUN_NEVER;
    table[0][0] = 50000;
    struct hil_board *board = bench_board("clock", NULL);
    hil_board_attach_rig(board, &run);
    bench_run(board, 10 * HIL_PS_PER_MS);
    uint64_t at = hil_now_cycle(&board->core);
    double tau_cycles = 4e-6 * 168e6; /* 672 */
    hil_rig_set_excitation(&board->rig, true, false, at);
    assert_true(fabs(rig_volts(&board->rig, 5, 3, at) - 1.65) < 1e-9);
    double one_tau = 1.65 + 0.3 * 0.6321205588;
    assert_true(fabs(rig_volts(&board->rig, 5, 3, at + (uint64_t)tau_cycles) - one_tau) < 1e-9);
    at += 168000;
    hil_rig_set_excitation(&board->rig, false, true, at);
    assert_true(fabs(rig_volts(&board->rig, 5, 3, at) - 1.95) < 1e-9);
    one_tau = 1.65 - 0.3 * (1.0 - 2.0 * 0.3678794412);
    assert_true(fabs(rig_volts(&board->rig, 5, 3, at + (uint64_t)tau_cycles) - one_tau) < 1e-9);
    assert_true(fabs(rig_volts(&board->rig, 5, 3, at + 168000) - 1.35) < 1e-9);
    hil_rig_set_excitation(&board->rig, true, true, at + 168000);
    assert_true(fabs(rig_volts(&board->rig, 5, 3, at + 336000) - 1.65) < 1e-9);
    hil_board_destroy(board);
}
