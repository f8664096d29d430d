/* The clocks' map against truth: seeded sessions with an offset and a rate that are known, and
 * delays of known distributions. The stated 95 % interval must hold in 93.5 to 96.5 % of them, for
 * the rate and for times of day inside the session and after it. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "common/splitmix.h"
#include "host/link/timemap.h"
#include "tests/cmocka_all.h"

#define ROUNDS   4000u
#define EPOCH_US 1790000000000000

static uint64_t state = 6;

/* SplitMix64, 0 to 1 */
static double even(void)
{
    return ((double)(mr_splitmix64(&state) >> 11) + 0.5) / 9007199254740992.0;
}

/* Delays in us, all from 0 on. */
static double exponential(void)
{
    return -800.0 * log(even());
}
static double flat(void)
{
    return 1000.0 * even();
}
static double half_normal(void)
{
    return 500.0 * fabs(sqrt(-2.0 * log(even())) * cos(6.283185307179586 * even()));
}
/* A USB adapter that is asked every millisecond; one of ten after other traffic; now and then a
 * busy computer. */
static double mixed(void)
{
    double u = even();
    return u < 0.02 ? 30000.0 * even() : u < 0.1 ? 4000.0 * even() : 1000.0 * even();
}
/* Most when the bus is free, the others behind frames of 130 us, one or more. */
static double bus(void)
{
    return even() < 0.7 ? 100.0 * even() : 130.0 * even() - 100.0 * log(even());
}

struct held_frame {
    unsigned rate, middle, end, after;
    double half_us, half_ppm; /* means */
};

static double draw_session(struct timemap *map, double (*delay_us)(void), unsigned pairs,
                           double step_s, double *fast_ppm, double *begin_us)
{
    memset(map, 0, sizeof *map);
    double gain_ppm = 100.0 * (2.0 * even() - 1.0); /* host time against board time */
    *begin_us = floor(1e9 * even());
    *fast_ppm = (1.0 / (1.0 + gain_ppm * 1e-6) - 1.0) * 1e6;
    for (unsigned i = 0; i < pairs; i++) {
        double board_us = *begin_us + 1e6 * step_s * i;
        double host_us = (board_us - *begin_us) * (1.0 + gain_ppm * 1e-6) + delay_us();
        timemap_add(map, board_us, EPOCH_US + (int64_t)floor(host_us));
    }
    return gain_ppm;
}

static bool holds(const struct timemap_fit *fit, double begin_us, double since_us, double gain_ppm)
{
    struct timemap_value host = timemap_to_host_us(fit, begin_us + since_us);
    double truth_us = since_us * (1.0 + gain_ppm * 1e-6);
    return fabs(host.value - (double)EPOCH_US - truth_us) <= host.half_width;
}

static void check(const char *name, double (*delay_us)(void), unsigned pairs, double step_s,
                  double most)
{
    static struct timemap map;
    static struct timemap_fit fit;
    struct held_frame held = {0};
    for (unsigned round = 0; round < ROUNDS; round++) {
        double fast_ppm, begin_us, span_us = 1e6 * step_s * (pairs - 1);
        double gain_ppm = draw_session(&map, delay_us, pairs, step_s, &fast_ppm, &begin_us);
        timemap_fit(&map, 500.0, &fit);
        assert_int_equal(fit.refusal, TIMEMAP_OK);
        held.rate += fabs(fit.rate_ppm.value - fast_ppm) <= fit.rate_ppm.half_width;
        held.middle += holds(&fit, begin_us, 0.4 * span_us, gain_ppm);
        held.end += holds(&fit, begin_us, span_us, gain_ppm);
        held.after += holds(&fit, begin_us, 1.3 * span_us, gain_ppm);
        held.half_us += timemap_to_host_us(&fit, begin_us + span_us).half_width / ROUNDS;
        held.half_ppm += fit.rate_ppm.half_width / ROUNDS;
    }
    const unsigned counts[] = {held.rate, held.middle, held.end, held.after};
    printf("# %-12s %3u pairs: rate %.2f %% (+- %.2f ppm), middle %.2f %%, end %.2f %% (+- %.0f "
           "us), after %.2f %%\n",
           name, pairs, 100.0 * held.rate / ROUNDS, held.half_ppm, 100.0 * held.middle / ROUNDS,
           100.0 * held.end / ROUNDS, held.half_us, 100.0 * held.after / ROUNDS);
    for (unsigned i = 0; i < 4; i++) {
        assert_true(counts[i] >= 0.935 * ROUNDS);
        assert_true(counts[i] <= most * ROUNDS);
    }
}

TEST(intervals_hold_for_delays_of_every_kind)
{
    check("exponential", exponential, 60, 1.0, 0.965);
    check("flat", flat, 60, 1.0, 0.965);
    check("half normal", half_normal, 60, 1.0, 0.965);
    check("mixed", mixed, 60, 1.0, 0.965);
    check("bus", bus, 60, 1.0, 0.965);
}

TEST(intervals_hold_for_short_and_long_sessions)
{
    /* With a dozen pairs the strip takes in half of them, and exponential delays thin out there:
     * wider than need be. */
    check("exponential", exponential, 12, 1.0, 0.98);
    check("exponential", exponential, 30, 1.0, 0.965);
    check("flat", flat, 12, 1.0, 0.965);
    check("mixed", mixed, 12, 1.0, 0.965);
    check("exponential", exponential, 100, 0.1, 0.965);
    check("mixed", mixed, 600, 1.0, 0.965);
}

static struct timemap_fit refused_of(double rate, double (*delay_us)(void), unsigned pairs,
                                     int64_t begin_us, int64_t step_us)
{
    struct timemap map = {0};
    struct timemap_fit fit;
    for (unsigned i = 0; i < pairs; i++)
        timemap_add(&map, 1e6 * i,
                    begin_us + (int64_t)(1e6 * i * rate + delay_us()) +
                        (i > pairs / 2 ? step_us : 0));
    timemap_fit(&map, 500.0, &fit);
    return fit;
}

TEST(what_is_no_map_is_refused)
{
    assert_int_equal(refused_of(1.0, exponential, 11, EPOCH_US, 0).refusal, TIMEMAP_TOO_FEW_PAIRS);
    assert_int_equal(refused_of(1.0, exponential, 12, EPOCH_US, 0).refusal, TIMEMAP_OK);
    assert_int_equal(refused_of(1.0, exponential, 60, 0, 0).refusal, TIMEMAP_UNDATED);
    /* emulated: four board seconds in one */
    struct timemap_fit fast = refused_of(0.25, exponential, 60, EPOCH_US, 0);
    assert_int_equal(fast.refusal, TIMEMAP_WRONG_RATE);
    assert_near(fast.rate_ppm.value, 3e6, 1e3);
    /* no crystal is that bad */
    assert_int_equal(refused_of(1.002, exponential, 60, EPOCH_US, 0).refusal, TIMEMAP_WRONG_RATE);
    /* the clock was set in the middle, as it was in a recording that came out 556 ppm slow */
    static const int64_t steps_us[] = {20000, -20000, 8000, -8000};
    for (unsigned i = 0; i < 40; i++)
        for (unsigned pairs = 49; pairs <= 600; pairs += 137)
            assert_int_equal(refused_of(1.0, exponential, pairs, EPOCH_US, steps_us[i % 4]).refusal,
                             TIMEMAP_UNCERTAIN);
    assert_int_equal(refused_of(1.0, exponential, 60, EPOCH_US, 400000000).refusal,
                     TIMEMAP_UNCERTAIN);
}

/* A recording in which every stamp is exact has a map that is exact. */
static double none(void)
{
    return 0.0;
}
TEST(without_delays_it_is_exact)
{
    struct timemap_fit fit = refused_of(1.0, none, 60, EPOCH_US, 0);
    assert_int_equal(fit.refusal, TIMEMAP_OK);
    assert_near(fit.rate_ppm.value, 0.0, 0.001);
    struct timemap_value host = timemap_to_host_us(&fit, 59e6);
    assert_near(host.value - (double)EPOCH_US, 59e6, 1.0);
    assert_true(host.half_width < 1.0);
}

/* 700 pairs: the oldest hundred, which had another rate, are forgotten. */
TEST(the_newest_count)
{
    struct timemap map = {0};
    struct timemap_fit fit;
    for (unsigned i = 0; i < 700; i++)
        timemap_add(&map, 1e6 * i, EPOCH_US + (int64_t)(1e6 * i * (i < 100 ? 1.0001 : 1.0)));
    timemap_add(&map, 500e6, 0); /* not later than the last */
    timemap_fit(&map, 500.0, &fit);
    assert_int_equal(fit.pair_count, TIMEMAP_PAIRS_MAX);
    assert_near(fit.from_us, 100e6, 0.5);
    assert_near(fit.to_us, 699e6, 0.5);
    assert_near(fit.rate_ppm.value, 0.0, 0.01);
}
