/* The committed synthetic landings (tests/runs/README.md), checked without the program that made
 * them: form and checksum, and whether the physics in them holds by closed forms and by other
 * routes than the generator's. Reads only the files. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/common/run_text.h"
#include "tests/cmocka_all.h"

#define RUNS 3

/* Physics, written down again (tests/runs/README.md). */
#define MAT_FT    (2.0 / 7.0)
#define MAT_LB    0.466
#define STICK_LB  (0.5 * MAT_LB)
#define KL_LB_IN  (2.9e5 / 12.0)
#define SLACK_IN  0.030
#define GRIT_LB   20.0
#define GEAR_SLUG (1300.0 / 12.0 / 32.174) /* one of twelve shares */

static const int numbers[RUNS] = {1, 4, 5};
static struct run *runs[RUNS];

static double truth(const struct run *run, const char *name)
{
    for (int i = 0; i < run->truths; i++)
        if (strcmp(run->truth[i].name, name) == 0)
            return run->truth[i].value;
    fail_msg("landing %d has no truth %s", run->landing, name);
    return 0.0;
}

static double truth_of(const struct run *run, const char *name, int number)
{
    char full[64];

    snprintf(full, sizeof full, "%s_%d", name, number);
    return truth(run, full);
}

static int load_all(void **state)
{
    (void)state;
    assert_int_equal(crc_of("123456789", 9), 0xCBF43926u); /* the check value of this CRC */
    for (int r = 0; r < RUNS; r++) {
        runs[r] = calloc(1, sizeof *runs[r]);
        assert_non_null(runs[r]);
        load(runs[r], numbers[r]);
    }
    return 0;
}

static int free_all(void **state)
{
    (void)state;
    for (int r = 0; r < RUNS; r++) {
        free(runs[r]->text);
        free(runs[r]);
    }
    return 0;
}

static double d_in(const struct run *run, int sample, int channel)
{
    return (double)run->row[sample][channel] * 1e-5;
}

TEST(everything_is_there)
{
    for (int r = 0; r < RUNS; r++) {
        const struct run *run = runs[r];
        double stop_s = truth(run, "stop_t_s");

        assert_int_equal(run->landing, numbers[r]);
        assert_int_equal(run->switches, SWITCHES);
        assert_int_equal(run->transducers, TRANSDUCERS);
        assert_int_equal(run->gages, GAGES);
        assert_int_equal(run->gaps, JOINTS);
        assert_int_equal(run->gap_ends, JOINTS);
        assert_int_equal(run->surveys, SEGMENTS);
        assert_int_equal(run->samples, lround(run->duration_s * 1000.0) + 1);
        assert_true(run->duration_s > stop_s + 2.5);
        assert_int_equal(run->others, 3);
        assert_string_equal(run->other[0].name, "arm");
        assert_string_equal(run->other[0].link, "can");
        assert_int_equal(run->other[0].argument, run->landing);
        assert_true(run->other[0].t_s > 0.5 && run->other[0].t_s < run->open_s[0]);
        assert_string_equal(run->other[1].name, "mark");
        assert_true(fabs(run->other[1].t_s - stop_s - 1.0) <= 0.0005);
        assert_string_equal(run->other[2].name, "disarm");
        assert_true(fabs(run->other[2].t_s - run->duration_s + 0.3) < 1e-9);
        assert_true(run->bytes < 1000000);
    }
}

TEST(one_rig_one_runway)
{
    for (int r = 0; r < RUNS; r++) {
        assert_memory_equal(runs[r]->true_ft, runs[0]->true_ft, sizeof runs[0]->true_ft);
        /* pretensions too */
        assert_memory_equal(runs[r]->row[0], runs[0]->row[0], sizeof runs[0]->row[0]);
        for (int i = 0; i < SWITCHES; i++) {
            assert_true(fabs(runs[r]->nominal_ft[i] - (-2.5 + 5.0 * i)) < 1e-9);
            assert_true(fabs(runs[r]->true_ft[i] - runs[r]->nominal_ft[i]) <= 0.02 / 12.0 + 1e-6);
        }
        for (int i = 0; i < TRANSDUCERS; i++)
            assert_true(fabs(runs[r]->transducer_ft[i] - (40.0 + 10.0 * i)) < 1e-9);
        for (int i = 0; i < GAGES; i++)
            assert_int_equal(runs[r]->band[i], i < 7 ? 1 : 2);
    }
    /* 4, then 5 */
    assert_memory_equal(runs[1]->gap_end_in, runs[2]->gap_in, sizeof runs[1]->gap_end_in);
}

/* Edges against what the report states, by divided differences: over three edges their second
 * difference is the mean deceleration there (weighted by a hat), whatever the rest of the
 * motion. */
TEST(edges_tell_the_stated_motion)
{
    static const double speed[RUNS] = {28.0, 28.0, 35.5};
    static const double least[RUNS] = {4.0, 4.6, 6.6};
    static const double most[RUNS] = {4.0, 4.6, 9.2};

    for (int r = 0; r < RUNS; r++) {
        const struct run *run = runs[r];
        double stop_ft = truth(run, "stop_station_ft"), stop_s = truth(run, "stop_t_s");
        double previous_s = 0.0, first = 0.0, last = 0.0;

        assert_true(fabs(truth(run, "touchdown_speed_ft_s") - speed[r]) < 1e-9);
        for (int i = 0; i < 2; i++) { /* on the track, before the touchdown: at constant speed */
            double ride_s = (run->touchdown_ft - run->true_ft[i]) / speed[r];

            assert_true(fabs(run->open_s[i] + ride_s - run->touchdown_s) < 4e-8);
        }
        assert_true(fabs(run->open_s[1] - 1.6) < 0.02);
        assert_true(fabs(truth(run, "mean_deceleration_ft_s2") * (stop_s - run->touchdown_s) -
                         speed[r]) < 1e-6);
        for (int i = 0; i < SWITCHES; i++) {
            assert_true(isnan(run->open_s[i]) == (run->true_ft[i] > stop_ft));
            if (isnan(run->open_s[i]))
                continue;
            assert_true(run->open_s[i] > previous_s && run->open_s[i] <= stop_s);
            previous_s = run->open_s[i];
            if (i >= 4) { /* three edges after the brakes have come on */
                const double *t = &run->open_s[i - 2], *x = &run->true_ft[i - 2];
                double a = -2.0 * ((x[2] - x[1]) / (t[2] - t[1]) - (x[1] - x[0]) / (t[1] - t[0])) /
                           (t[2] - t[0]);

                assert_true(a > least[r] * 0.983 && a < most[r] * 1.017);
                first = i == 4 ? a : first;
                last = a;
            }
        }
        if (numbers[r] == 5)
            assert_true(first < 6.8 && last > 9.0);
        else /* braking distance V^2/2a, half the 50 ms of rising brake, ripple of 1 % */
            assert_true(fabs(stop_ft - run->touchdown_ft - speed[r] * speed[r] / (2.0 * least[r]) -
                             speed[r] * 0.025) < 0.5);
        /* the gear's momentum went through the strip */
        assert_true(fabs(truth(run, "thrust_impulse_lb_s") / (GEAR_SLUG * speed[r]) - 1.0) < 1e-3);
    }
}

/* Displacement is what the joints upfield opened: from the ground to mat 141 at station 40, and so
 * on every 35 joints. */
TEST(gaps_add_up_to_movement)
{
    for (int r = 0; r < RUNS; r++) {
        const struct run *run = runs[r];
        double sum = 0.0;

        for (int j = 1; j <= JOINTS; j++) {
            sum += run->gap_end_in[j - 1] - run->gap_in[j - 1];
            if (j >= 141 && (j - 141) % 35 == 0 && (j - 141) / 35 < TRANSDUCERS)
                assert_true(fabs(sum - d_in(run, run->samples - 1, (j - 141) / 35)) < 2e-5);
        }
        assert_true(fabs(sum) < 1e-6 * JOINTS); /* the ground at both ends stayed */
        for (int i = 0; i < TRANSDUCERS; i++) {
            double peak = 0.0;

            for (int k = 0; k < run->samples; k++) {
                double speed = k == 0 ? 0.0
                                      : (d_in(run, k, i) - d_in(run, k - 1, i)) / 12.0 / 0.001;

                peak = fmax(peak, fabs(d_in(run, k, i)));
                if (k < run->touchdown_s * 1000.0)
                    assert_int_equal(run->row[k][i], 0);
                /* a mat alone pushed through all its slack: v^2 = 2 F slack / m; a rebound at most
                 * doubles it */
                assert_true(fabs(speed) <
                            2.0 * sqrt(2.0 * 32.0 * SLACK_IN / 12.0 / (MAT_LB / 32.174)));
            }
            assert_true(fabs(peak - truth_of(run, "peak_displacement_in", i + 1)) < 1e-9 + 0.6e-5);
            /* at rest */
            assert_int_equal(run->row[run->samples - 1][i], run->row[run->samples - 1000][i]);
        }
    }
}

/* At rest every joint's force lies in an interval that its gap gives (grit and stick take what they
 * must), and neighbours differ by at most a mat's friction: carry the interval of possible forces
 * along the runway. */
TEST(rest_is_in_equilibrium)
{
    for (int r = 0; r < RUNS; r++) {
        const double rounding_lb = 1e-7 * KL_LB_IN;
        double low = -1e9, high = 1e9;

        for (int j = 0; j < JOINTS; j++) {
            double gap = runs[r]->gap_end_in[j];
            double hook = KL_LB_IN * (gap - SLACK_IN);
            double contact = fmax(0.0, -KL_LB_IN * gap);
            double least = fmax(hook, -fmax(contact, GRIT_LB)) - rounding_lb;
            double most = fmax(hook, -contact) + rounding_lb;

            low = fmax(low - STICK_LB, least);
            high = fmin(high + STICK_LB, most);
            if (low > high)
                fail_msg("landing %d: mat %d cannot be at rest: %g lb too much", numbers[r], j,
                         low - high);
        }
    }
}

/* A push of F cannot slide more than F/(f w) mats; and as the wheel passes, movement practically
 * ceases. */
TEST(movement_keeps_to_the_wheel)
{
    for (int r = 0; r < RUNS; r++) {
        const struct run *run = runs[r];
        double push_lb = GEAR_SLUG * 1.016 * (numbers[r] == 1 ? 4.0 : numbers[r] == 4 ? 4.6 : 9.2);
        double farthest_ft = push_lb / STICK_LB * MAT_FT;

        for (int i = 0; i < TRANSDUCERS; i++) {
            int moved = 0, edge = 0, passed = SWITCHES;
            double wheel_ft, after;

            while (moved < run->samples && d_in(run, moved, i) < 0.005)
                moved++;
            if (moved == run->samples)
                continue;
            while (edge < SWITCHES && run->open_s[edge] * 1000.0 <= moved)
                edge++;
            wheel_ft = run->true_ft[edge - 1]; /* at least here */
            /* switches are 5 ft apart */
            assert_true(run->transducer_ft[i] - wheel_ft < farthest_ft + 5.0);
            assert_true(run->transducer_ft[i] - wheel_ft > 3.0);
            for (int s = SWITCHES - 1; s >= 0; s--)
                if (run->true_ft[s] > run->transducer_ft[i] + 2.0)
                    passed = s;
            if (passed == SWITCHES || isnan(run->open_s[passed]))
                continue;
            after = fabs(d_in(run, run->samples - 1, i) -
                         d_in(run, (int)(run->open_s[passed] * 1000.0) + 1, i));
            assert_true(after < 0.1 * truth_of(run, "peak_displacement_in", i + 1));
        }
    }
}

/* Gages between two transducers can be worked out from these: a first-order lag of 10 ms on 60
 * lb/in of their difference. */
TEST(witness_bands_follow_the_mat)
{
    static const int behind[] = {0, 1, 2, 3,
                                 /* transducers 5 ft behind gages 3..7; the next one is 5 ft
                                  * ahead */
                                 4};

    for (int r = 0; r < RUNS; r++)
        for (int g = 0; g < GAGES; g++) {
            int at = g % 7;
            double start = (double)runs[r]->row[0][TRANSDUCERS + g] * 0.01, lag = 0.0, old = 0.0,
                   change = 0.0;

            assert_true(fabs(start - (g < 7 ? 100.0 : 60.0)) < 12.0);
            for (int k = 0; k < runs[r]->samples; k++) {
                double tension = (double)runs[r]->row[k][TRANSDUCERS + g] * 0.01;

                assert_true(tension >= 0.0);
                change = fmax(change, fabs(tension - start));
                if (at >= 2) {
                    int left = behind[at - 2];
                    double now = 60.0 * (d_in(runs[r], k, left + 1) - d_in(runs[r], k, left));

                    if (k > 0) /* exact for a ramp between samples */
                        lag = lag * exp(-0.1) + now - old * exp(-0.1) -
                              (now - old) * 10.0 * (1.0 - exp(-0.1));
                    old = now;
                    assert_true(fabs(tension - start - lag) < 0.05);
                }
            }
            assert_true(fabs(change - truth_of(runs[r], "peak_tension_change_lb", g + 1)) < 0.0101);
        }
}

TEST(survey_reads_the_gaps)
{
    for (int r = 0; r < RUNS; r++) {
        double square = 0.0;
        int count = 0;

        for (int s = 0; s < SEGMENTS; s++) {
            double sum = 0.0, error;

            for (int j = 0; j < 10; j++)
                sum += runs[r]->gap_in[10 * s + j];
            error = runs[r]->survey_in[s] - sum;
            assert_true(runs[r]->survey_in[s] >= 0.0 && fabs(error) < 0.025);
            if (sum > 0.015) {
                square += error * error;
                count++;
            }
        }
        /* 0.005 in rms, give or take three times 0.005/sqrt(2 count) */
        assert_true(count > 25 && fabs(sqrt(square / count) - 0.005) < 0.015 / sqrt(2.0 * count));
    }
}

/* The longest run from closed joint to closed joint with at most one open in every ten: by trying
 * all pairs. */
static void check_zone(const struct run *run, const double *gap_in, const char *when)
{
    int best = 0, start = 0, closed = 0;
    char name[64];

    for (int a = 0; a < JOINTS; a++) {
        closed += gap_in[a] <= 0.001;
        for (int b = a + 1; b < JOINTS && gap_in[a] <= 0.001; b++) {
            int most_open = 0;

            for (int window = a; window <= b; window++) {
                int open = 0;

                for (int j = window; j <= b && j < window + 10; j++)
                    open += gap_in[j] > 0.001;
                most_open = open > most_open ? open : most_open;
            }
            if (most_open > 1)
                break;
            if (gap_in[b] <= 0.001 && b - a > best) {
                best = b - a;
                start = a;
            }
        }
    }
    snprintf(name, sizeof name, "zone_at_%s_mats", when);
    assert_int_equal(best, lround(truth(run, name)));
    snprintf(name, sizeof name, "zone_at_%s_start_station_ft", when);
    assert_true(fabs(start * MAT_FT - truth(run, name)) < 1e-5);
    snprintf(name, sizeof name, "zone_at_%s_end_station_ft", when);
    assert_true(fabs((start + best) * MAT_FT - truth(run, name)) < 1e-5);
    snprintf(name, sizeof name, "closed_joints_at_%s", when);
    assert_int_equal(closed, lround(truth(run, name)));
}

TEST(zones_are_where_the_gaps_say)
{
    for (int r = 0; r < RUNS; r++) {
        check_zone(runs[r], runs[r]->gap_in, "start");
        check_zone(runs[r], runs[r]->gap_end_in, "end");
    }
    /* what the two demo landings are for: no zone to warn of in the first, a long one in the fifth,
     * ahead of the stop */
    assert_true(truth(runs[0], "zone_ahead_longest_mats") < 30.0 &&
                truth(runs[0], "zone_ahead_first_t_s") < 0.0);
    assert_true(truth(runs[2], "zone_at_end_mats") >= 50.0);
    assert_true(truth(runs[2], "zone_ahead_first_t_s") > runs[2]->touchdown_s);
    assert_true(truth(runs[2], "zone_ahead_first_t_s") < truth(runs[2], "stop_t_s"));
}

TESTS_BETWEEN(load_all, free_all);
