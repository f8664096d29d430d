/* Scans, excitation and edges on the board (images/scan.c): times, order, codes and captures worked
 * out from RM0090 and the rig's formulas. TIM2 and TIM4 start together; TIM4 triggers at count 2000
 * of 10500, 84 MHz, 2 HCLK cycles a count. */
#include <math.h>

#include "hil/board/board.h"
#include "tests/hil/bench.h"

#define TRIGGER   4000u /* cycles after the start */
#define PERIOD    21000u
/* latency, 16 conversions; ADC clock = HCLK / 8 */
#define ADC1_SCAN ((2u + 16u * (112u + 12u)) * 8u)
#define ADC3_SCAN ((2u + 8u * (112u + 12u)) * 8u)

static struct hil_run run;

static void prepare(void)
{
    still_run(&run, 1.0);
    for (unsigned i = 0; i < HIL_RUN_TRANSDUCERS; i++)
        run.samples[0][i] = 10000 * ((int32_t)i + 1); /* 0.1 in, 0.2 in, ... */
    for (unsigned i = 0; i < HIL_RUN_GAGES; i++)
        run.samples[0][HIL_RUN_TRANSDUCERS + i] = 1000 * ((int32_t)i + 1); /* 10 lb, 20 lb, ... */
}

static struct hil_board *scanning(uint32_t control, uint64_t *start)
{
    prepare();
    struct hil_board *board = bench_board("scan", NULL);
    hil_board_attach_rig(board, &run);
    bench_control(board, 0, control);
    *start = 0;
    for (uint64_t t_us = 2000; !*start; t_us += 5) { /* until TIM2 runs; the clock takes 2.2 ms */
        assert_true(t_us < 4000);
        bench_run(board, t_us * HIL_PS_PER_US);
        if (board->state.mcu.tim[HIL_TIM2].cr1 & 1u)
            *start = board->state.mcu.tim[HIL_TIM2].base_cycle;
    }
    assert_int_equal(bench_result(board, 0), 0x100);
    assert_int_equal(board->core.state.clock.hclk_hz, 168000000);
    return board;
}

static void run_to_cycle(struct hil_board *board, uint64_t cycle)
{
    bench_run(board, hil_clock_ps_at_cycle(&board->core.state.clock, cycle));
}

static uint16_t code_at(const struct hil_board *board, uint32_t table, unsigned i)
{
    uint16_t code;
    assert_int_equal(hil_board_peek(board, table + 2u * i, &code, 2), MR_OK);
    return code;
}

static unsigned code_of(double volts)
{
    return (unsigned)floor(volts / 3.3 * 4096.0 + 0.5);
}

TEST(test_scan_times)
{
    uint64_t start;
    struct hil_board *board = scanning(0, &start);
    const struct hil_counters *c = hil_board_counters(board);
    run_to_cycle(board, start + TRIGGER + ADC3_SCAN - 1);
    assert_int_equal(c->adc_scans[HIL_ADC3], 0);
    run_to_cycle(board, start + TRIGGER + ADC3_SCAN);
    assert_int_equal(c->adc_scans[HIL_ADC3], 1);
    run_to_cycle(board, start + TRIGGER + ADC1_SCAN - 1);
    assert_int_equal(c->adc_scans[HIL_ADC1], 0);
    run_to_cycle(board, start + TRIGGER + ADC1_SCAN);
    assert_int_equal(c->adc_scans[HIL_ADC1], 1);
    /* 800 scans in 100 ms, none lost, none started in another */
    run_to_cycle(board, start + TRIGGER + ADC1_SCAN + 799u * PERIOD);
    assert_int_equal(c->adc_scans[HIL_ADC1], 800);
    assert_int_equal(c->adc_scans[HIL_ADC3], 800);
    assert_int_equal(c->adc_triggers_ignored, 0);
    assert_int_equal(c->adc_overruns, 0);
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* Half transfer after two scans, complete after four; the handler reads TIM2 within 20 ticks of the
 * last conversion. */
TEST(test_dma_flags)
{
    uint64_t start;
    struct hil_board *board = scanning(0, &start);
    run_to_cycle(board, start + TRIGGER + ADC1_SCAN + 3u * PERIOD + 400u);
    uint32_t half = (TRIGGER + PERIOD + ADC1_SCAN) / 2u,
             complete = (TRIGGER + 3u * PERIOD + ADC1_SCAN) / 2u;
    assert_int_equal(bench_result(board, 1), 2);
    assert_in_range(bench_result(board, 2), half, half + 20u);
    assert_in_range(bench_result(board, 3), complete, complete + 20u);
    hil_board_destroy(board);
    hil_run_free(&run);
}

TEST(test_order_and_codes)
{
    uint64_t start;
    struct hil_board *board = scanning(0, &start);
    run_to_cycle(board, start + TRIGGER + ADC1_SCAN + PERIOD);
    uint32_t adc1 = bench_result(board, 4), adc3 = bench_result(board, 5);
    for (unsigned scan = 0; scan < 2; scan++) {
        for (unsigned g = 1; g <= 14; g++)
            assert_int_equal(code_at(board, adc1, 16u * scan + g - 1),
                             code_of(0.400 + 0.005 * 10.0 * g));
        assert_int_equal(code_at(board, adc1, 16u * scan + 14), code_of(0.050));
        assert_int_equal(code_at(board, adc1, 16u * scan + 15), 3103);
        /* Output 1 starts high and 2 low; both toggle at count 100, before the scan: the first
         * polarity is minus. */
        double polarity = scan ? 1.0 : -1.0;
        for (unsigned ch = 1; ch <= 8; ch++) {
            double since_s = (TRIGGER + (2.0 + 112.0 * ch + 12.0 * (ch - 1)) * 8.0 - 200.0) / 168e6;
            double volts = 1.65 +
                           polarity * (0.050 + 0.5 * 0.1 * ch) * (1.0 - 2.0 * exp(-since_s / 4e-6));
            assert_int_equal(code_at(board, adc3, 8u * scan + ch - 1), code_of(volts));
        }
    }
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* Reversed every scan, each polarity lasts as long as the other: over 40 periods of 250 us, 5 ms
 * and 5 ms, to the ps. */
TEST(test_excitation_has_no_mean)
{
    uint64_t start;
    struct hil_board *board = scanning(0, &start);
    const struct hil_counters *c = hil_board_counters(board);
    run_to_cycle(board, start + 50u * PERIOD);
    uint64_t plus = c->excitation_plus_ps, minus = c->excitation_minus_ps;
    run_to_cycle(board, start + 50u * PERIOD + 80u * PERIOD);
    assert_true(llabs((long long)(c->excitation_plus_ps - plus) - 5000000000ll) <= 100);
    assert_true(llabs((long long)(c->excitation_minus_ps - minus) - 5000000000ll) <= 100);
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* Without the alternate function the excitation never reaches the transducers, and they sit at
 * mid-scale. */
TEST(test_no_excitation)
{
    uint64_t start;
    struct hil_board *board = scanning(1, &start);
    run_to_cycle(board, start + TRIGGER + ADC1_SCAN);
    for (unsigned ch = 0; ch < 8; ch++)
        assert_int_equal(code_at(board, bench_result(board, 5), ch), 2048);
    assert_int_equal(hil_board_counters(board)->excitation_plus_ps, 0);
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* Edges at 10 ms + k * 2.5 ms are 210000 ticks of 84 MHz apart, exactly; the first is where its
 * time says. */
TEST(test_captures)
{
    uint64_t start;
    prepare();
    struct hil_board *board = scanning(0, &start);
    for (unsigned k = 0; k < 6; k++)
        /* position 6 first, 1 last */
        run.switch_open_ps[5 - k] = (10000000u + 2500000u * k) * HIL_PS_PER_NS;
    hil_board_attach_rig(board, &run);
    bench_run(board, 30 * HIL_PS_PER_MS);
    uint32_t edges = bench_result(board, 6);
    uint64_t start_ps = hil_clock_ps_at_cycle(&board->core.state.clock, start);
    double expected = floor((double)(10 * HIL_PS_PER_MS - start_ps) * 84e6 / 1e12);
    uint32_t first = bench_word(board, edges);
    assert_true(fabs(first - expected) <= 1.0);
    for (unsigned k = 1; k < 6; k++)
        assert_int_equal(
            bench_word(board, edges + 4u * k) - bench_word(board, edges + 4u * (k - 1)), 210000);
    assert_int_equal(hil_board_counters(board)->edges_captured, 6);
    /* codes after all six: 64 + 8 * perm, perm = 0 7 14 21 4 11: 840 codes on top of 0.050 V */
    assert_int_equal(code_at(board, bench_result(board, 4), 14),
                     code_of(0.050 + 840.0 * 3.3 / 4096.0));
    hil_board_destroy(board);
    hil_run_free(&run);
}

TEST(test_edges_need_their_pin)
{
    uint64_t start;
    struct hil_board *board = scanning(2, &start);
    run.switch_open_ps[0] = 10 * HIL_PS_PER_MS;
    hil_board_attach_rig(board, &run);
    bench_run(board, 20 * HIL_PS_PER_MS);
    assert_int_equal(hil_board_counters(board)->switches_opened, 1);
    assert_int_equal(hil_board_counters(board)->edges_captured, 0);
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* The filter delays by its length, 8 clocks for IC1F = 3, and swallows what is shorter. Driven by
 * hand, no image. */
TEST(test_capture_filter)
{
    uint64_t start;
    struct hil_board *board = scanning(0, &start);
    struct hil_tim *t = &board->state.mcu.tim[HIL_TIM2];
    run_to_cycle(board, start + 100000);
    t->ccmr[0] = 0x31;
    /* 12 cycles: 6 clocks, too short */
    hil_gpio_drive(&board->mcu.gpio, 0, 15, true, hil_now_cycle(&board->core));
    run_to_cycle(board, start + 100012);
    hil_gpio_drive(&board->mcu.gpio, 0, 15, false, hil_now_cycle(&board->core));
    run_to_cycle(board, start + 101000);
    assert_int_equal(hil_board_counters(board)->edges_captured, 0);
    hil_gpio_drive(&board->mcu.gpio, 0, 15, true,
                   hil_now_cycle(&board->core)); /* 18 cycles: 9 clocks */
    run_to_cycle(board, start + 101018);
    hil_gpio_drive(&board->mcu.gpio, 0, 15, false, hil_now_cycle(&board->core));
    run_to_cycle(board, start + 102000);
    assert_int_equal(hil_board_counters(board)->edges_captured, 1);
    assert_int_equal(bench_word(board, bench_result(board, 6)), 101000 / 2 + 8);
    hil_board_destroy(board);
    hil_run_free(&run);
}

/* Noise: 2 LSB rms and no mean over 32000 codes of the reference (standard errors 0.011 and 0.008
 * LSB). */
TEST(test_noise)
{
    struct hil_options options;
    double sum = 0.0, squares = 0.0;
    unsigned n = 0;
    hil_options_default(&options);
    options.noise_seed = 7;
    prepare();
    struct hil_board *board = bench_board("scan", &options);
    hil_board_attach_rig(board, &run);
    bench_run(board, 5 * HIL_PS_PER_MS);
    for (uint64_t t_us = 5000; n < 32000; t_us += 500) { /* four scans in the circle */
        bench_run(board, t_us * HIL_PS_PER_US);
        for (unsigned scan = 0; scan < 4; scan++, n++) {
            double error = code_at(board, bench_result(board, 4), 16u * scan + 15) -
                           2.5 / 3.3 * 4096.0;
            sum += error;
            squares += error * error;
        }
    }
    assert_true(fabs(sum / n) < 0.05);
    /* 4 + 1/48 of the generator and 1/12 of rounding */
    assert_true(fabs(sqrt(squares / n) - sqrt(4.0 + 1.0 / 48.0 + 1.0 / 12.0)) < 0.04);
    hil_board_destroy(board);
    hil_run_free(&run);
}
