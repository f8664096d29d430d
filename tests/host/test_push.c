/* Push tests of grounds that are known (push_case.h): how often the 95 % intervals hold the truth,
 * which law is said, and what must not be told. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/push/ground.h"
#include "tests/cmocka_all.h"
#include "tests/host/push_case.h"
#include "tests/long.h"

#define TRIALS 500

static const struct push_setting two_mats = {.gage_errors = {0.5, 0.001}, .mat_count = 2};

/* What is tested, and what came of it. */
struct trial {
    double k_lb_ft, unloading, law, friction, spread, force_error_lb, displacement_error_in;
    size_t loads, each; /* loads (108 lb, 216 lb), tests under each */
    double most_lb;     /* under one axle */
    bool rounds, down;
};

struct tally {
    unsigned trials, k, unloading, law, friction, elastic, rigid, slid, poor;
    double k_width;
};

static bool holds(const struct push_interval *of, double truth)
{
    return of->low <= truth && truth <= of->high;
}

static void run(const struct trial *t, uint64_t *seed, struct tally *tally)
{
    struct push_series series[8];
    struct push_readings readings = {series, 0};
    struct push_ground ground;
    struct error error = {0};
    for (size_t i = 0; i < t->each; i++) {
        for (size_t axles = 1; axles <= t->loads; axles++) {
            double place = exp(t->spread * push_normal(seed)), a = (double)axles;
            struct push_truth truth = {.k_lb_in = place * t->k_lb_ft / 12.0 * two_mats.mat_count *
                                                  pow(a, t->law),
                                       .unloading = t->unloading,
                                       .limit_lb = t->friction * 108.0 * a,
                                       .force_error_lb = t->force_error_lb,
                                       .displacement_error_in = t->displacement_error_in,
                                       .rounds = t->rounds};
            series[readings.count++] = push_test(&truth, 108.0 * a, t->most_lb / 8.0 * a,
                                                 t->most_lb * a, t->down, seed);
        }
    }
    if (push_ground_estimate(&readings, &two_mats, &ground, &error) != MR_OK)
        fail_msg("%s", error.text);
    tally->k += holds(&ground.k_lb_ft.interval, t->k_lb_ft);
    tally->unloading += holds(&ground.unloading_ratio.interval, t->unloading);
    tally->law += holds(&ground.axle_law.interval, t->law);
    tally->friction += holds(&ground.friction.interval, t->friction);
    tally->elastic += ground.law == PUSH_ELASTIC;
    tally->rigid += ground.law == PUSH_RIGID;
    tally->poor += ground.has_excess_scatter;
    tally->k_width += (ground.k_lb_ft.interval.high - ground.k_lb_ft.interval.low) / t->k_lb_ft /
                      tally->trials;
    for (size_t i = 0; i < readings.count; i++)
        tally->slid += ground.fit[i].slid_count > 0;
    push_ground_free(&ground);
}

/* Two loads, any ground and axle law, the gages that a push test is planned with. */
static const struct trial usual = {.law = -1.0,
                                   .friction = 0.5,
                                   .force_error_lb = 0.5,
                                   .displacement_error_in = 0.001,
                                   .loads = 2,
                                   .each = 1,
                                   .most_lb = 40.0,
                                   .down = true};

static struct tally run_all(const struct trial *trial, unsigned trials, uint64_t seed,
                            const char *what)
{
    struct tally tally = {.trials = trials};
    for (unsigned i = 0; i < trials; i++) {
        struct trial t = *trial;
        if (t.k_lb_ft == 0.0) /* any ground: 4,000 to 16,000 lb/ft, and so on */
            t.k_lb_ft = 4000.0 * pow(4.0, push_random(&seed));
        if (t.unloading == 0.0)
            t.unloading = 0.4 + 0.6 * push_random(&seed);
        if (t.law < 0.0)
            t.law = 1.2 * push_random(&seed);
        run(&t, &seed, &tally);
    }
    print_message("%s, of %d: k held %u (95 %% as wide as %.2f of it), unloading %u, axle law %u, "
                  "f %u; elastic %u, rigid %u, poor %u, slid %u\n",
                  what, trials, tally.k, tally.k_width, tally.unloading, tally.law, tally.friction,
                  tally.elastic, tally.rigid, tally.poor, tally.slid);
    return tally;
}

/* Fewer than 95 % come out once in 200 (binomial); more than 99.4 % is wider than need be. */
static void held(const struct tally *tally, unsigned count, double most)
{
    double n = tally->trials;
    assert_true(count >= n * (0.95 - 2.58 * sqrt(0.95 * 0.05 / n)));
    assert_true(count <= most * n);
}

TEST(intervals_hold)
{
    struct trial trial = usual;
    struct tally tally = run_all(&trial, TRIALS, 20260314u, "0.5 lb and 0.001 in of noise");
    held(&tally, tally.k, 0.994);
    held(&tally, tally.unloading, 0.994);
    held(&tally, tally.law, 0.994);
    assert_int_equal(tally.elastic, tally.trials);
    assert_true(tally.poor <= 3 && tally.slid <= 5);
    assert_true(tally.k_width < 0.25);
}

/* Gages that read to 0.5 lb and 0.001 in, and nothing else is wrong: errors as stated are three
 * times too large, so the intervals hold more often. */
TEST(intervals_hold_of_divisions)
{
    struct trial trial = usual;
    trial.rounds = true;
    struct tally tally = run_all(&trial, tests_take(120, TRIALS), 7u,
                                 "divisions of 0.5 lb and 0.001 in");
    held(&tally, tally.k, 1.0);
    held(&tally, tally.unloading, 1.0);
    held(&tally, tally.law, 1.0);
}

/* Gages twice as bad as they are said to be: the scatter says so. */
TEST(worse_gages_widen)
{
    struct trial trial = usual;
    trial.force_error_lb = 1.0;
    trial.displacement_error_in = 0.002;
    struct tally tally = run_all(&trial, tests_take(120, TRIALS), 99u, "twice the noise");
    held(&tally, tally.k, 0.994);
    held(&tally, tally.unloading, 0.994);
    held(&tally, tally.law, 0.994);
    assert_true(tally.poor > tally.trials * 17 / 20);
}

/* Places that differ by 15 %: readings of one place alone would state 5 %. */
TEST(places_widen)
{
    struct trial trial = usual;
    trial.spread = 0.15;
    trial.each = 3;
    struct tally tally = run_all(&trial, tests_take(120, TRIALS), 3u,
                                 "places 15 % apart, three each");
    /* t with the scatter of six tests is not exact */
    assert_true(tally.k > 0.9 * tally.trials && tally.law > 0.9 * tally.trials);
    held(&tally, tally.unloading, 0.994);
}

TEST(what_slides_is_told_and_left_out)
{
    struct trial trial = usual;
    trial.friction = 0.3;
    struct tally tally = run_all(&trial, tests_take(120, TRIALS), 11u, "slides at 0.3");
    held(&tally, tally.k, 0.994);
    held(&tally, tally.unloading, 0.994);
    held(&tally, tally.law, 0.994);
    held(&tally, tally.friction, 1.0);
    assert_int_equal(tally.slid, 2 * tally.trials);
    assert_int_equal(tally.elastic, tally.trials);
}

/* Of a rigid ground elastic is said once in 500 at most, rigid in most; the odds ask for 20. */
TEST(rigid_ground_is_not_called_elastic)
{
    struct trial trial = {.k_lb_ft = HUGE_VAL,
                          .unloading = 1.0,
                          .friction = 0.5,
                          .force_error_lb = 0.5,
                          .displacement_error_in = 0.001,
                          .loads = 1,
                          .each = 2,
                          .most_lb = 40.0,
                          .down = true};
    struct tally tally = run_all(&trial, tests_take(120, TRIALS), 5u, "rigid");
    assert_true(tally.elastic <= 1);
    assert_true(tally.rigid > tally.trials / 2);
    trial.friction = 0.3;
    tally = run_all(&trial, tests_take(120, TRIALS), 6u, "rigid, slides at 0.3");
    assert_true(tally.elastic <= 2);
    assert_int_equal(tally.slid, 2 * tally.trials);
}

/* A push of 3 lb moves 0.0026 in: mostly neither law can be told. */
TEST(a_weak_push_cannot_tell)
{
    struct tally tally = run_all(&(struct trial){.k_lb_ft = 7000.0,
                                                 .unloading = 1.0,
                                                 .friction = 0.5,
                                                 .force_error_lb = 0.5,
                                                 .displacement_error_in = 0.001,
                                                 .loads = 1,
                                                 .each = 1,
                                                 .most_lb = 3.0,
                                                 .down = true},
                                 tests_take(120, TRIALS), 8u, "3 lb");
    assert_true(tally.rigid <= 10); /* the odds ask for 20 to 1 */
    assert_true(tally.elastic + tally.rigid < tally.trials / 2);
}

static struct push_series exact_test(double load_lb, double k_lb_in, double most_lb, bool down)
{
    uint64_t seed = 1;
    struct push_truth truth = {k_lb_in, 0.8, 54.0, 0.0, 0.0, false};
    return push_test(&truth, load_lb, most_lb / 8.0, most_lb, down, &seed);
}

static struct push_ground find(struct push_series *series, size_t count,
                               const struct push_setting *setting)
{
    struct push_readings readings = {series, count};
    struct push_ground ground;
    struct error error = {0};
    if (push_ground_estimate(&readings, setting, &ground, &error) != MR_OK)
        fail_msg("%s", error.text);
    return ground;
}

/* 1,200 lb/in of two mats are 7,200 lb/ft of one; exact readings give it back. */
TEST(stiffness_is_of_one_mat)
{
    struct push_series series = exact_test(108.0, 1200.0, 40.0, true);
    struct push_setting setting = two_mats;
    struct push_ground ground = find(&series, 1, &setting);
    assert_near(ground.k_lb_ft.interval.value, 7200.0, 0.01);
    assert_near(ground.unloading_ratio.interval.value, 0.8, 2e-5);
    assert_near(ground.axle_load_lb, 108.0, 0.0);
    assert_true(isnan(ground.spread));
    push_ground_free(&ground);
    setting.mat_count = 1;
    ground = find(&series, 1, &setting);
    assert_near(ground.k_lb_ft.interval.value, 14400.0, 0.02);
    push_ground_free(&ground);
}

TEST(what_was_not_read_is_not_told)
{
    struct push_setting setting = two_mats;
    struct push_series series[2] = {exact_test(108.0, 1200.0, 40.0, false),
                                    exact_test(216.0, 2400.0, 80.0, false)};
    struct push_ground ground = find(series, 1, &setting);
    assert_true(isnan(ground.unloading_ratio.interval.value));
    assert_non_null(strstr(ground.unloading_ratio.reason, "no readings while unloading"));
    assert_true(isnan(ground.axle_law.interval.value));
    assert_non_null(strstr(ground.axle_law.reason, "one load"));
    assert_true(isnan(ground.friction.interval.value));
    assert_near(ground.friction.interval.low, 40.0 / 108.0, 1e-9);
    push_ground_free(&ground);
    /* the axle's load was not tested, and nobody knows the law */
    setting.axle_load_lb = 60.0;
    ground = find(series, 1, &setting);
    assert_true(isnan(ground.k_lb_ft.interval.value));
    assert_int_equal(ground.law, PUSH_ELASTIC);
    push_ground_free(&ground);
    /* with both loads it is: 1200 (60/108)^1 */
    ground = find(series, 2, &setting);
    assert_near(ground.k_lb_ft.interval.value, 7200.0 * 60.0 / 108.0, 0.01);
    assert_near(ground.axle_law.interval.value, 1.0, 2e-5);
    push_ground_free(&ground);
}

/* All below what the dial shows: a bound, no value. */
TEST(below_resolution_is_a_bound)
{
    struct push_series series = exact_test(108.0, HUGE_VAL, 40.0, true);
    struct push_ground ground = find(&series, 1, &two_mats);
    assert_true(isnan(ground.k_lb_ft.interval.value));
    assert_true(ground.k_lb_ft.interval.low > 50000.0 && isinf(ground.k_lb_ft.interval.high));
    assert_int_equal(ground.law, PUSH_RIGID);
    push_ground_free(&ground);
}

TEST(refusals)
{
    struct push_series series = exact_test(108.0, 1200.0, 40.0, true);
    struct push_fit fit;
    struct error error = {0};
    series.path = "push.csv";
    series.count = 4;
    assert_int_equal(push_fit(&series, two_mats.gage_errors, 1000.0, 1.0, &fit, &error),
                     MR_TOO_FEW);
    assert_non_null(strstr(error.text, "too few readings: push.csv"));
    error = (struct error){0};
    series = exact_test(108.0, 1200.0, 2.0, true);
    series.path = "push.csv";
    assert_int_equal(push_fit(&series, two_mats.gage_errors, 1000.0, 1.0, &fit, &error),
                     MR_TOO_FEW);
    assert_non_null(strstr(error.text, "all forces are below their error"));
}

/* Pushed the other way, with another zero of the dial: the same ground. */
TEST(signs_and_zero_do_not_matter)
{
    struct push_series series = exact_test(108.0, 1200.0, 40.0, true);
    for (size_t i = 0; i < series.count; i++) {
        series.force_lb[i] = -series.force_lb[i];
        series.displacement_in[i] = 0.7 - series.displacement_in[i];
    }
    struct push_ground ground = find(&series, 1, &two_mats);
    assert_near(ground.k_lb_ft.interval.value, 7200.0, 0.05);
    assert_near(ground.unloading_ratio.interval.value, 0.8, 1e-5);
    push_ground_free(&ground);
}

/* Pushed through 0: what falls to 0 springs back by rho, what grows beyond loads. */
TEST(through_zero_and_again)
{
    const double forces[] = {0, 10, 20, 30, 20, 10, 0, -10, -20, -10, 0, 10, 20, 30, 40};
    struct push_truth truth = {1200.0, 0.8, 1e9, 0.0, 0.0, false};
    struct push_series series = {.load_lb = 108.0};
    double displacement_in = 0.0, hold_lb = 0.0;
    for (size_t i = 0; i < sizeof forces / sizeof forces[0]; i++) {
        double change = fabs(forces[i]) - fabs(hold_lb);
        displacement_in += (forces[i] - hold_lb) * (change < 0.0 ? truth.unloading : 1.0) /
                           truth.k_lb_in;
        hold_lb = forces[i];
        series.force_lb[series.count] = forces[i];
        series.displacement_in[series.count++] = displacement_in;
    }
    struct push_ground ground = find(&series, 1, &two_mats);
    assert_near(ground.k_lb_ft.interval.value, 7200.0, 0.05);
    assert_near(ground.unloading_ratio.interval.value, 0.8, 1e-5);
    push_ground_free(&ground);
}
