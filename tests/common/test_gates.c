#include "common/gates.h"

#include <math.h>
#include <stdio.h>

#include "common/staircase.h"
#include "tests/cmocka_all.h"

#define SWITCH_ERROR_FT (0.02 / 12.0 / 1.7320508)

#define DELAY_S 0.025
/* A brake that rises evenly within 2 d leaves the gear a (d^2 / 3) / 2 further back than one that
 * comes at d at once. */
#define SHAPE   (1.0 / 3.0)

/* Gates of a gear whose brake has risen evenly 50 ms after touchdown: with D the distance that
 * remains to be braked at once, t = d + (v - sqrt(v^2 - 2 a D)) / a. */
static size_t uniform_gates(double touchdown_ft, double speed_ft_s, double deceleration_ft_s2,
                            struct mr_gate *gates)
{
    size_t count = 0;
    for (unsigned i = 0; i < 24; i++) {
        double station_ft = -2.5 + 5.0 * i;
        double d = station_ft - touchdown_ft;
        double braked = d - speed_ft_s * DELAY_S +
                        0.5 * deceleration_ft_s2 * SHAPE * DELAY_S * DELAY_S;
        double left = speed_ft_s * speed_ft_s - 2.0 * deceleration_ft_s2 * braked;
        if (left < 0.0)
            break;
        double t_s = d < 0.0 ? d / speed_ft_s
                             : DELAY_S + (speed_ft_s - sqrt(left)) / deceleration_ft_s2;
        gates[count++] = (struct mr_gate){.t_s = 10.0 + t_s, .station_ft = station_ft};
    }
    return count;
}

TEST(uniform_deceleration_is_recovered)
{
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_gates_summary summary;
    size_t count = uniform_gates(3.0, 28.0, 4.0, gates);
    /* 25 ms later than with a brake that comes at once */
    const double stop_s = 17.0 + DELAY_S,
                 stop_ft = 3.0 + 98.0 + 28.0 * DELAY_S - 2.0 * SHAPE * DELAY_S * DELAY_S;
    assert_int_equal(mr_gates_summarise(gates, count, 3.0, SWITCH_ERROR_FT, &summary), MR_OK);
    assert_true(summary.is_uniform);
    assert_int_equal(summary.outlier_mask, 0);
    /* The shape of the rise is not told by the gates: it costs less than a fifth of the error. */
    assert_near(summary.touchdown_speed_ft_s.value, 28.0, 1e-3);
    assert_near(summary.touchdown_t_s.value, 10.0, 1e-5);
    assert_near(summary.mean_deceleration_ft_s2.value, 28.0 / (stop_s - 10.0), 2e-4);
    assert_near(summary.stop_t_s.value, stop_s, 2e-4);
    assert_near(summary.stop_station_ft.value, stop_ft, 5e-4);
    assert_int_equal(summary.gates_before_touchdown, 2); /* the switches at -2.5 and 2.5 ft */
    assert_int_equal(summary.gates_used_for_stop, count);
    /* better than the track alone, 28 * 1.41 s / 5 ft, but not by magic: the delay is not known
     * well */
    double track = 28.0 * 1.4142136 * SWITCH_ERROR_FT / 5.0;
    assert_true(summary.touchdown_speed_ft_s.error < track &&
                summary.touchdown_speed_ft_s.error > 0.3 * track);

    /* Without those the braked part is carried back: then the delay as known beforehand counts, 12
     * ms of 4 ft/s2. */
    assert_int_equal(mr_gates_summarise(gates + 2, count - 2, 3.0, SWITCH_ERROR_FT, &summary),
                     MR_OK);
    assert_int_equal(summary.gates_before_touchdown, 0);
    assert_near(summary.touchdown_speed_ft_s.value, 28.0, 2e-3);
    assert_near(summary.touchdown_speed_ft_s.error, 0.012 * 4.0, 0.2 * 0.012 * 4.0);
}

/* One switch opens 3 ms late: named, its lateness told, the rest as good as before. */
TEST(a_late_switch_is_left_out)
{
    for (size_t late = 0; late < 18; late++) {
        struct mr_gate gates[MR_GATES_MAX];
        struct mr_gates_summary summary;
        size_t count = uniform_gates(3.0, 28.0, 4.0, gates);
        gates[late].t_s += 3e-3;
        assert_int_equal(mr_gates_summarise(gates, count, 3.0, SWITCH_ERROR_FT, &summary), MR_OK);
        assert_int_equal(summary.outlier_mask, 1u << late);
        assert_near(summary.lateness_s[late], 3e-3, 3e-4);
        assert_near(summary.touchdown_speed_ft_s.value, 28.0, 0.028);
    }
}

/* Standard errors against the textbook: for n equally spaced times, unit apart, a straight line's
 * slope has the variance 12 s^2 / (n (n^2 - 1)), a parabola's second coefficient 180 s^2 / (n (n^2
 * - 1) (n^2 - 4)). */
TEST(errors_are_the_textbook_ones)
{
    const double s = 0.003;
    for (unsigned n = 4; n <= 20; n += 4) {
        struct mr_gate gates[MR_GATES_MAX];
        struct mr_gates_fit fit;
        struct mr_motion_estimate motion;
        for (unsigned i = 0; i < n; i++)
            gates[i] = (struct mr_gate){.t_s = i, .station_ft = 30.0 * i - 2.0 * i * i};
        double m = n;
        assert_int_equal(mr_gates_fit(gates, n, 2, s, &fit), MR_OK);
        mr_gates_motion_at_time(&fit, 0.5 * (m - 1.0), &motion);
        assert_near(motion.speed_ft_s.error, s * sqrt(12.0 / (m * (m * m - 1.0))), 1e-12);
        assert_near(motion.deceleration_ft_s2.error,
                    2.0 * s * sqrt(180.0 / (m * (m * m - 1.0) * (m * m - 4.0))), 1e-12);
        assert_near(motion.deceleration_ft_s2.value, 4.0, 1e-9);
    }
}

static uint32_t lcg_state;
static double uniform(void)
{
    lcg_state = lcg_state * 1664525u + 1013904223u;
    return (double)(lcg_state >> 8) / 16777216.0;
}

/* The online estimate at the last switch, 2000 times with switches misplaced by up to 0.02 in: the
 * stated 95 % interval must hold in 95 % of them; the binomial spread of 2000 is 0.5 %, so 93.5 to
 * 96.5 % is three of it. test_landings has the rest. */
TEST(the_online_intervals_hold)
{
    unsigned inside = 0;
    const unsigned landings = 2000;
    lcg_state = 1970;
    for (unsigned n = 0; n < landings; n++) {
        struct mr_gate gates[MR_GATES_MAX];
        struct mr_motion_estimate now;
        double v = 20.0 + 26.0 * uniform(), a = 4.0 + 8.0 * uniform();
        size_t count = uniform_gates(3.0, v, a, gates);
        double true_s = gates[count - 1].t_s - 10.0;
        for (size_t i = 0; i < count; i++)
            gates[i].station_ft += (2.0 * uniform() - 1.0) * 0.02 / 12.0;
        assert_int_equal(mr_gates_latest_motion(gates + 2, count - 2, SWITCH_ERROR_FT, &now),
                         MR_OK);
        inside += (unsigned)(fabs(now.speed_ft_s.value - (v - a * (true_s - DELAY_S))) <
                             1.96 * now.speed_ft_s.error);
    }
    printf("# of %u: online speed %.1f %%\n", landings, 100.0 * inside / landings);
    assert_in_range(inside, 1870, 1930);
}

/* Station of a gear that touches down at 10 s at 3 ft, and whose brake rises evenly within `rise_s`
 * from `onset_s` later: integrated by hand. */
static double late_station(double v, double a, double onset_s, double rise_s, double t_s)
{
    double x = 3.0 + v * (t_s - 10.0), s = t_s - 10.0 - onset_s;
    if (s > rise_s)
        x -= a * (rise_s * rise_s / 6.0 + 0.5 * rise_s * (s - rise_s) +
                  0.5 * (s - rise_s) * (s - rise_s));
    else if (s > 0.0)
        x -= a * s * s * s / (6.0 * rise_s);
    return x;
}

static size_t late_gates(double v, double a, double onset_s, double rise_s, struct mr_gate *gates)
{
    double stop_s = 10.0 + onset_s + 0.5 * rise_s + v / a;
    size_t count = 0;
    for (unsigned i = 0; i < 24; i++) {
        double station_ft = -2.5 + 5.0 * i, low_s = 9.0, high_s = stop_s;
        if (late_station(v, a, onset_s, rise_s, stop_s) <= station_ft)
            break;
        for (int k = 0; k < 60; k++) {
            double mid_s = 0.5 * (low_s + high_s);
            if (late_station(v, a, onset_s, rise_s, mid_s) < station_ft)
                low_s = mid_s;
            else
                high_s = mid_s;
        }
        gates[count++] = (struct mr_gate){.t_s = low_s, .station_ft = station_ft};
    }
    return count;
}

/* A brake that acts up to 0.6 s late, 2000 times: touchdown, stop and mean deceleration hold in
 * 95 % of them (bounds of 92.5 and 98 % chosen afterwards: the length of the rise is assumed), none
 * is far off, and no switch is named. */
TEST(a_late_brake_is_no_early_switch)
{
    const unsigned landings = 2000;
    unsigned inside[5] = {0}, beyond = 0, named = 0, of = 0;
    lcg_state = 1976;
    for (unsigned n = 0; n < landings; n++) {
        struct mr_gate gates[MR_GATES_MAX];
        struct mr_gates_summary summary;
        double v = 26.0 + 14.0 * uniform(), a = v * v / 170.0 + 6.0 * uniform(),
               onset_s = 0.6 * uniform(), rise_s = 0.01 + 0.06 * uniform();
        size_t count = late_gates(v, a, onset_s, rise_s, gates);
        for (size_t i = 0; i < count; i++)
            gates[i].station_ft += (2.0 * uniform() - 1.0) * 0.02 / 12.0;
        double took_s = onset_s + 0.5 * rise_s + v / a;
        assert_int_equal(mr_gates_summarise(gates, count, 3.0, SWITCH_ERROR_FT, &summary), MR_OK);
        const double off[5] = {
            (summary.touchdown_speed_ft_s.value - v) / summary.touchdown_speed_ft_s.error,
            (summary.touchdown_t_s.value - 10.0) / summary.touchdown_t_s.error,
            (summary.mean_deceleration_ft_s2.value - v / took_s) /
                summary.mean_deceleration_ft_s2.error,
            (summary.stop_t_s.value - 10.0 - took_s) / summary.stop_t_s.error,
            (summary.stop_station_ft.value - late_station(v, a, onset_s, rise_s, 10.0 + took_s)) /
                summary.stop_station_ft.error,
        };
        of++;
        named += summary.outlier_mask != 0;
        for (unsigned k = 0; k < 5; k++) {
            inside[k] += fabs(off[k]) < 1.96;
            beyond += fabs(off[k]) > 5.0;
            if (fabs(off[k]) > 5.0)
                printf("# v %.2f a %.2f onset %.3f rise %.3f gates %zu even %d: %u off by %.1f "
                       "errors\n",
                       v, a, onset_s, rise_s, count, summary.is_uniform, k, off[k]);
        }
    }
    printf("# of %u: speed %u, touchdown %u, deceleration %u, stop %u, its station %u within; "
           "%u beyond 5 errors, %u named a switch\n",
           of, inside[0], inside[1], inside[2], inside[3], inside[4], beyond, named);
    for (unsigned k = 0; k < 5; k++)
        assert_in_range(inside[k], 1850, 1960);
    assert_int_equal(beyond, 0);
    assert_true(named < 10);
}

/* The error of the speed at a given station against the definition: move each switch a little, fit
 * again, see how much that speed moves. Where the gear is slow, being there earlier or later
 * matters most. */
TEST(the_error_at_a_station_is_that_of_moved_switches)
{
    const double station_ft = 90.0, h_ft = 1e-5;
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_gates_fit fit;
    struct mr_motion_estimate there, moved;
    double square = 0.0;
    size_t count = uniform_gates(3.0, 28.0, 4.0, gates) - 2;
    assert_int_equal(mr_gates_fit(gates + 2, count, 2, SWITCH_ERROR_FT, &fit), MR_OK);
    assert_int_equal(mr_gates_motion_at_station(&fit, station_ft, false, &there), MR_OK);
    double braked_ft = 87.0 - 28.0 * DELAY_S + 2.0 * SHAPE * DELAY_S * DELAY_S;
    assert_near(there.speed_ft_s.value, sqrt(28.0 * 28.0 - 8.0 * braked_ft), 1e-7);
    for (size_t i = 0; i < count; i++) {
        gates[2 + i].station_ft += h_ft;
        assert_int_equal(mr_gates_fit(gates + 2, count, 2, SWITCH_ERROR_FT, &fit), MR_OK);
        assert_int_equal(mr_gates_motion_at_station(&fit, station_ft, false, &moved), MR_OK);
        gates[2 + i].station_ft -= h_ft;
        double slope = (moved.speed_ft_s.value - there.speed_ft_s.value) / h_ft;
        square += slope * slope;
    }
    assert_near(there.speed_ft_s.error, SWITCH_ERROR_FT * sqrt(square),
                1e-3 * there.speed_ft_s.error);
}

/* Braking that changes along the way needs a higher order; the fit must take it and still be
 * right. */
TEST(a_changing_deceleration_is_followed)
{
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_gates_summary summary;
    size_t count = 0;
    /* From 25 ms on, b later: a = 6.6 + 0.5 b, v = 35.5 - 6.6 b - 0.25 b^2, x = 3 + 35.5 t - 3.3
     * b^2 - b^3 / 12; Newton for each station */
    for (unsigned i = 0; i < 24; i++) {
        double station_ft = 7.5 + 5.0 * i, t = 0.1;
        for (int k = 0; k < 50; k++) {
            double b = t - DELAY_S, v = 35.5 - 6.6 * b - 0.25 * b * b;
            if (v < 0.5)
                break;
            t -= (3.0 + 35.5 * t - 3.3 * b * b - b * b * b / 12.0 - station_ft) / v;
        }
        double b = t - DELAY_S;
        if (fabs(3.0 + 35.5 * t - 3.3 * b * b - b * b * b / 12.0 - station_ft) > 1e-9)
            break;
        gates[count++] = (struct mr_gate){.t_s = t, .station_ft = station_ft};
    }
    assert_true(count > 14);
    assert_int_equal(mr_gates_summarise(gates, count, 3.0, SWITCH_ERROR_FT, &summary), MR_OK);
    double stop_s = DELAY_S + (-6.6 + sqrt(6.6 * 6.6 + 4.0 * 0.25 * 35.5)) / 0.5;
    assert_in_range(summary.gates_used_for_stop, 4, 7); /* eight are not described by a parabola */
    assert_near(summary.touchdown_speed_ft_s.value, 35.5, 0.002 * 35.5);
    assert_near(summary.mean_deceleration_ft_s2.value, 35.5 / stop_s, 0.02 * 35.5 / stop_s);
    assert_near(summary.stop_t_s.value, stop_s, 3.0 * summary.stop_t_s.error);
}

/* Quantile 0.975 of Student's t from a table. */
TEST(students_factor_is_that_of_the_tables)
{
    const struct {
        unsigned freedom;
        double t;
    } rows[] = {{1, 12.706}, {2, 4.303},  {5, 2.571},  {10, 2.228},
                {15, 2.131}, {20, 2.086}, {30, 2.042}, {60, 2.000}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_near(mr_gates_student_factor(rows[i].freedom), rows[i].t / 1.96,
                    0.005 * rows[i].t / 1.96);
    assert_near(mr_gates_student_factor(0), mr_gates_student_factor(1),
                0.0); /* as bad as can be stated */
}

/* Gates of a polynomial of order 1 to 4 with exact stations: the lowest order that is enough, and
 * its derivatives. */
TEST(the_lowest_order_that_is_enough_is_taken)
{
    const double c[] = {3.0, 40.0, -3.0, -0.35, 0.04};
    for (unsigned order = 2; order <= MR_GATES_ORDER_MAX; order++) {
        struct mr_gate gates[MR_GATES_MAX];
        struct mr_gates_fit fit;
        struct mr_motion_estimate motion;
        for (unsigned i = 0; i < 20; i++) {
            double t = 0.2 * i, x = 0.0;
            for (unsigned k = order + 1; k-- > 0;)
                x = x * t + c[k];
            gates[i] = (struct mr_gate){.t_s = t, .station_ft = x};
        }
        assert_int_equal(mr_gates_fit_best(gates, 20, SWITCH_ERROR_FT, &fit), MR_OK);
        assert_int_equal(fit.degree, order);
        mr_gates_motion_at_time(&fit, 2.0, &motion);
        double speed = c[1] + 4.0 * c[2] + (order > 2 ? 12.0 * c[3] : 0.0) +
                       (order > 3 ? 32.0 * c[4] : 0.0);
        double rise = 2.0 * c[2] + (order > 2 ? 12.0 * c[3] : 0.0) +
                      (order > 3 ? 48.0 * c[4] : 0.0);
        assert_near(motion.speed_ft_s.value, speed, 1e-9);
        assert_near(motion.deceleration_ft_s2.value, -rise, 1e-8);
        /* with few gates no higher order is tried: three degrees of freedom must remain */
        assert_int_equal(mr_gates_fit_best(gates, 6, SWITCH_ERROR_FT, &fit), MR_OK);
        assert_int_equal(fit.degree, 2);
        assert_int_equal(mr_gates_fit_best(gates, 2, SWITCH_ERROR_FT, &fit), MR_OK);
        assert_int_equal(fit.degree, 1);
        assert_int_equal(mr_gates_fit_best(gates, 1, SWITCH_ERROR_FT, &fit), MR_TOO_FEW);
        assert_int_equal(mr_gates_motion_at_station(&fit, 1e4, false, &motion),
                         MR_NUMERICS); /* never there */
        assert_int_equal(mr_gates_motion_at_station(&fit, -1e4, false, &motion), MR_NUMERICS);
        assert_int_equal(mr_gates_fit(gates, 20, 0, SWITCH_ERROR_FT, &fit), MR_TOO_FEW);
        assert_int_equal(mr_gates_fit(gates, 20, MR_GATES_ORDER_MAX + 1, SWITCH_ERROR_FT, &fit),
                         MR_TOO_FEW);
    }
}

/* Of the last six, one opens 5 ms late: at 15 to 28 ft/s that is an inch off, and the speed does
 * not feel it. */
TEST(the_online_estimate_leaves_one_out)
{
    for (size_t late = 7; late < 11; late++) {
        struct mr_gate gates[MR_GATES_MAX];
        struct mr_motion_estimate now;
        (void)uniform_gates(3.0, 28.0, 4.0, gates);
        double since_s = gates[11].t_s - 10.0;
        gates[late].t_s += 5e-3;
        assert_int_equal(mr_gates_latest_motion(gates, 12, SWITCH_ERROR_FT, &now), MR_OK);
        assert_near(now.speed_ft_s.value, 28.0 - 4.0 * (since_s - DELAY_S), 1e-3);
        gates[late].t_s = gates[late - 1].t_s;
        assert_int_equal(mr_gates_latest_motion(gates, 12, SWITCH_ERROR_FT, &now), MR_MALFORMED);
    }
}

/* Comes in at 32 ft/s, brakes with a1 up to 50 ft from touchdown and with a2 from there on. Times
 * by v = sqrt(v0^2 - 2 a x). */
static size_t two_brakes(double a1_ft_s2, double a2_ft_s2, unsigned first, struct mr_gate *gates)
{
    const double v0 = 32.0, change_ft = 50.0;
    double v1 = sqrt(v0 * v0 - 2.0 * a1_ft_s2 * change_ft), t1 = DELAY_S + (v0 - v1) / a1_ft_s2;
    size_t count = 0;
    for (unsigned i = first; i < 24; i++) {
        double x = -5.5 + 5.0 * i, t = x / v0, braked = x - v0 * DELAY_S;
        if (braked > change_ft) {
            double left = v1 * v1 - 2.0 * a2_ft_s2 * (braked - change_ft);
            if (left < 0.0)
                break;
            t = t1 + (v1 - sqrt(left)) / a2_ft_s2;
        } else if (x > 0.0) {
            t = DELAY_S + (v0 - sqrt(v0 * v0 - 2.0 * a1_ft_s2 * braked)) / a1_ft_s2;
        }
        gates[count++] = (struct mr_gate){.t_s = 10.0 + t, .station_ft = 3.0 + x};
    }
    return count;
}

/* A brake that is let off or pulled on half way is not even: its ends are taken apart, and each is
 * still right. */
TEST(an_uneven_brake_is_taken_apart)
{
    const struct {
        double a1, a2;
    } brakes[] = {{4.0, 9.0}, {6.0, 4.0}, {3.0, 12.0}, {7.0, 2.9}};
    for (size_t b = 0; b < sizeof brakes / sizeof brakes[0]; b++) {
        for (unsigned first = 0; first < 3; first++) {
            /* with both switches on the track, one, none */
            struct mr_gate gates[MR_GATES_MAX];
            struct mr_gates_summary summary;
            double a1 = brakes[b].a1, a2 = brakes[b].a2, v1 = sqrt(32.0 * 32.0 - 100.0 * a1);
            double stop_s = 10.0 + DELAY_S + (32.0 - v1) / a1 + v1 / a2;
            double stop_ft = 3.0 + 32.0 * DELAY_S + 50.0 + 0.5 * v1 * v1 / a2;
            size_t count = two_brakes(a1, a2, first, gates);
            assert_int_equal(mr_gates_summarise(gates, count, 3.0, SWITCH_ERROR_FT, &summary),
                             MR_OK);
            assert_false(summary.is_uniform);
            assert_int_equal(summary.gates_before_touchdown, 2 - first);
            assert_near(summary.touchdown_speed_ft_s.value, 32.0, 0.01 * 32.0);
            assert_near(summary.stop_t_s.value, stop_s, 0.01 + 3.0 * summary.stop_t_s.error);
            assert_near(summary.stop_station_ft.value, stop_ft,
                        0.01 + 3.0 * summary.stop_station_ft.error);
            assert_near(summary.mean_deceleration_ft_s2.value, 32.0 / (stop_s - 10.0),
                        0.02 * 32.0 / (stop_s - 10.0));
        }
    }
}

/* The same, and the third switch from the end opens 10 ms late: it alone keeps the others off a
 * parabola. */
TEST(a_late_switch_near_the_stop_is_left_out)
{
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_gates_summary summary;
    size_t count = two_brakes(6.0, 4.0, 0, gates);
    double v1 = sqrt(32.0 * 32.0 - 600.0), stop_ft = 3.0 + 32.0 * DELAY_S + 50.0 + v1 * v1 / 8.0;
    assert_true(count > 18);
    gates[count - 3].t_s += 10e-3;
    assert_int_equal(mr_gates_summarise(gates, count, 3.0, SWITCH_ERROR_FT, &summary), MR_OK);
    assert_false(summary.is_uniform);
    assert_int_equal(summary.outlier_mask, 1u << (count - 3));
    assert_near(summary.lateness_s[count - 3], 10e-3, 1e-3);
    assert_int_equal(summary.gates_used_for_stop, 7);
    assert_near(summary.stop_station_ft.value, stop_ft, 0.05);
}

/* Four gates, one of them 0.1 ft off: nobody can tell which, so the errors say that something is
 * wrong. */
TEST(few_gates_that_disagree_have_wide_errors)
{
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_gates_summary good, bad;
    uniform_gates(3.0, 28.0, 4.0, gates);
    gates[2] = gates[6];
    gates[3] = gates[14];
    assert_int_equal(mr_gates_summarise(gates, 4, 3.0, SWITCH_ERROR_FT, &good), MR_OK);
    assert_true(good.is_uniform);
    gates[2].station_ft += 0.1;
    assert_int_equal(mr_gates_summarise(gates, 4, 3.0, SWITCH_ERROR_FT, &bad), MR_OK);
    assert_false(bad.is_uniform);
    assert_int_equal(bad.gates_used_for_stop, 4);
    assert_true(bad.touchdown_speed_ft_s.error > 5.0 * good.touchdown_speed_ft_s.error);
    assert_true(bad.stop_station_ft.error > 5.0 * good.stop_station_ft.error);
    assert_near(bad.touchdown_speed_ft_s.value, 28.0, 1.96 * bad.touchdown_speed_ft_s.error);
}

/* Whatever the gates, there is an answer within bounds or a refusal: times strictly rising,
 * stations not, gears that get faster, that roll back, that jump. An answer has finite values,
 * errors, and comes to rest after touchdown. */
TEST(nonsense_is_refused_or_bounded)
{
    unsigned answered = 0, refused = 0;
    lcg_state = 5;
    for (unsigned n = 0; n < 4000; n++) {
        struct mr_gate gates[MR_GATES_MAX];
        struct mr_gates_summary summary;
        size_t count = 3 + (size_t)(uniform() * 22.0);
        double v = 5.0 + 41.0 * uniform(), a = 30.0 * uniform() - 4.0,
               noise_ft = pow(10.0, -4.0 + 5.0 * uniform());
        double t = 0.0, step_s = 0.05 + 0.3 * uniform(),
               uneven = uniform() < 0.3 ? 3.0 * uniform() - 1.5 : 0.0;
        double touchdown_ft = 10.0 * uniform();
        for (size_t i = 0; i < count; i++) {
            gates[i].t_s = t;
            gates[i].station_ft = v * t - 0.5 * a * t * t - uneven * t * t * t / 6.0 +
                                  noise_ft * (uniform() - 0.5);
            t += step_s * (0.2 + uniform());
        }
        enum mr_status status = mr_gates_summarise(gates, count, touchdown_ft, SWITCH_ERROR_FT,
                                                   &summary);
        answered += (unsigned)(status == MR_OK);
        refused += (unsigned)(status != MR_OK);
        if (status == MR_OK) {
            assert_true(isfinite(summary.stop_station_ft.value) &&
                        summary.touchdown_speed_ft_s.value > 0.0);
            assert_true(summary.stop_t_s.value > summary.touchdown_t_s.value);
            assert_true(summary.touchdown_speed_ft_s.error > 0.0 && summary.stop_t_s.error > 0.0);
            assert_true(summary.mean_deceleration_ft_s2.value > 0.0 &&
                        isfinite(summary.mean_deceleration_ft_s2.error));
        } else {
            assert_true(status == MR_NUMERICS || status == MR_TOO_FEW);
        }
        size_t twice = 1 + (size_t)(uniform() * (double)(count - 1));
        gates[twice].t_s = gates[twice - 1].t_s;
        status = mr_gates_summarise(gates, count, touchdown_ft, SWITCH_ERROR_FT, &summary);
        assert_int_equal(status, MR_MALFORMED);
    }
    printf("# of 4000: %u answered, %u refused\n", answered, refused);
    assert_true(answered > 400 && refused > 400);
}

TEST(too_little_is_refused)
{
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_gates_summary summary;
    struct mr_gates_fit fit;
    struct mr_motion_estimate motion;
    uniform_gates(3.0, 28.0, 4.0, gates);
    assert_int_equal(mr_gates_latest_motion(gates, 1, SWITCH_ERROR_FT, &motion), MR_TOO_FEW);
    assert_int_equal(mr_gates_latest_motion(gates, 2, SWITCH_ERROR_FT, &motion), MR_OK);
    assert_true(isnan(motion.deceleration_ft_s2.value));
    assert_int_equal(mr_gates_summarise(gates, 2, 3.0, SWITCH_ERROR_FT, &summary), MR_TOO_FEW);
    assert_int_equal(mr_gates_summarise(gates + 2, 2, 3.0, SWITCH_ERROR_FT, &summary), MR_TOO_FEW);
    gates[2].t_s = gates[1].t_s;
    assert_int_equal(mr_gates_fit(gates, 4, 2, SWITCH_ERROR_FT, &fit), MR_MALFORMED);
}

TEST(the_staircase_names_the_switch)
{
    struct mr_staircase staircase;
    const uint16_t steps[] = {64, 120, 176, 72};
    float step;
    const uint32_t edge_tick = 0xfffff000u; /* TIM2 wraps in the middle */
    mr_staircase_init(&staircase);
    for (int32_t n = -8; n < 4; n++) {
        assert_int_equal(mr_staircase_find_step(&staircase, edge_tick, &step), MR_TOO_FEW);
        /* The block that begins 0.1 ms before the edge straddles it and must not count. */
        float code = n < -1 ? 62.0f : n == -1 ? 140.0f : 62.0f + 176.0f + (n % 2 ? 0.7f : -0.7f);
        mr_staircase_add(&staircase, edge_tick + (uint32_t)(84000 * n + 75600), code);
    }
    assert_int_equal(mr_staircase_find_step(&staircase, edge_tick, &step), MR_OK);
    assert_near(step, 176.0, 1e-3);
    assert_int_equal(mr_staircase_identify(step, steps, 4, 0), 3);
    assert_int_equal(mr_staircase_identify(step, steps, 4, 4), 0);  /* that one is open already */
    assert_int_equal(mr_staircase_identify(69.0f, steps, 4, 0), 4); /* 72 is nearer than 64 */
    assert_int_equal(mr_staircase_identify(100.0f, steps, 4, 0), 0);
}

/* Blocks a millisecond apart, the first 4 ms before the edge at tick 0; `codes` are their
 * levels. */
static enum mr_status step_of(const float *codes, unsigned count, float *step)
{
    struct mr_staircase staircase;
    mr_staircase_init(&staircase);
    for (unsigned i = 0; i < count; i++)
        mr_staircase_add(&staircase, (uint32_t)(84000 * ((int32_t)i - 4)) + 42000u, codes[i]);
    return mr_staircase_find_step(&staircase, 42000u + 84000u / 2u, step);
}

TEST(a_step_is_read_next_to_its_edge)
{
    /* Blocks 0 to 3 before, 4 straddles, 5 to 8 after; then the next switch opens. */
    const float later[] = {62, 62, 62, 62, 100, 238, 238, 238, 238, 238, 358, 358, 358, 358};
    /* The next switch opens 2.5 ms after the edge: no level can be told from the other. */
    const float soon[] = {62, 62, 62, 62, 100, 238, 238, 358, 358, 358};
    /* The switch before opened 2 ms before the edge. */
    const float just[] = {62, 62, 120, 182, 200, 358, 358, 358, 358, 358};
    float step;
    assert_int_equal(step_of(later, 14, &step), MR_OK);
    assert_near(step, 176.0, 1e-3);
    assert_int_equal(step_of(soon, 10, &step), MR_NUMERICS);
    assert_int_equal(step_of(just, 10, &step), MR_NUMERICS);
}
