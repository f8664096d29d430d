/* Braking by itself: closed forms of a gear whose brake rises as a straight line (shape 1/3),
 * textbook chi-square. */
#include "common/gates.h"

#include <math.h>
#include <string.h>

#include "tests/cmocka_all.h"

#define ERROR_FT           (0.02 / 12.0)
#define TOUCHDOWN_FT       3.0
#define TOUCHDOWN_S        7.0
#define SPEED_FT_S         30.0
#define DECELERATION_FT_S2 6.0
#define DELAY_S            0.025

/* A brake that rises straight within 2 d has cost a ((s - d)^2 + d^2 / 3) / 2 when it has risen,
 * and during the rise a s^3 / (12 d). */
static double station_at(double since_s)
{
    double lost = 0.0;
    if (since_s > 2.0 * DELAY_S)
        lost = 0.5 * ((since_s - DELAY_S) * (since_s - DELAY_S) + DELAY_S * DELAY_S / 3.0);
    else if (since_s > 0.0)
        lost = since_s * since_s * since_s / (12.0 * DELAY_S);
    return TOUCHDOWN_FT + SPEED_FT_S * since_s - DECELERATION_FT_S2 * lost;
}

/* Gates at times rather than at stations: those of the closed form. */
static size_t gates_at(const double *since_s, size_t count, struct mr_gate *gates)
{
    for (size_t g = 0; g < count; g++)
        gates[g] = (struct mr_gate){.t_s = TOUCHDOWN_S + since_s[g],
                                    .station_ft = station_at(since_s[g])};
    return count;
}

static size_t usual_gates(struct mr_gate *gates)
{
    const double since_s[] = {-0.2, -0.04, 0.15, 0.4, 0.8, 1.2, 1.7, 2.3, 2.9, 3.6, 4.3};
    return gates_at(since_s, sizeof since_s / sizeof since_s[0], gates);
}

/* Table of chi-square, upper tail: 1 in 100 and 1 in 1000. */
TEST(chi_square_is_that_of_the_tables)
{
    const struct {
        unsigned freedom;
        double one_in_100, one_in_1000;
    } rows[] = {{1, 6.635, 10.828},
                {2, 9.210, 13.816},
                {5, 15.086, 20.515},
                {10, 23.209, 29.588},
                {20, 37.566, 45.315}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_near(mr_chi_square_limit(rows[i].freedom, MR_SIGMA_1_IN_100), rows[i].one_in_100,
                    0.01 * rows[i].one_in_100);
        assert_near(mr_chi_square_limit(rows[i].freedom, MR_SIGMA_1_IN_1000), rows[i].one_in_1000,
                    0.031 * rows[i].one_in_1000);
    }
    /* nothing left over: nothing can contradict */
    assert_near(mr_chi_square_limit(0, MR_SIGMA_1_IN_100), 0.0, 0.0);
}

TEST(the_closed_form_is_found)
{
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_braking fit;
    size_t count = usual_gates(gates);
    assert_int_equal(mr_braking_fit(gates, count, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_OK);
    assert_true(mr_braking_is_accepted(&fit));
    assert_int_equal(fit.degrees_of_freedom, count - 3);
    assert_near(fit.speed_ft_s, SPEED_FT_S, 1e-3);
    assert_near(fit.deceleration_ft_s2, DECELERATION_FT_S2, 1e-3);
    assert_near(fit.touchdown_s, TOUCHDOWN_S, 1e-5);
    for (size_t g = 0; g < count; g++) {
        struct mr_gate later = {.t_s = gates[g].t_s + 1e-3, .station_ft = gates[g].station_ft};
        assert_near(mr_gate_lateness_s(&fit, &gates[g]), 0.0, 1e-5);
        assert_near(mr_gate_lateness_s(&fit, &later), 1e-3, 1e-5);
    }
    /* a switch that opens when the gear stands or would roll back has no lateness */
    assert_near(
        mr_gate_lateness_s(&fit, &(struct mr_gate){.t_s = TOUCHDOWN_S + 6.0, .station_ft = 50.0}),
        0.0, 0.0);
    /* none contradicts the others */
    assert_int_equal(mr_braking_drop_worst_gate(gates, count, ERROR_FT, &fit), MR_LIMIT);
    assert_int_equal(fit.excluded_mask, 0);
}

/* A switch within the 50 ms in which the brake rises, and gates of which some are left out
 * beforehand. The shape of the rise is known beforehand only, which costs some 0.01 % of the
 * speed. */
TEST(a_gate_within_the_rise_and_gates_left_out)
{
    const double since_s[] = {-0.2, -0.04, 0.03, 0.4, 0.8, 1.2, 1.7, 2.3, 2.9, 3.6, 4.3};
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_braking fit;
    size_t count = gates_at(since_s, sizeof since_s / sizeof since_s[0], gates);
    assert_int_equal(mr_braking_fit(gates, count, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_OK);
    assert_near(fit.speed_ft_s, SPEED_FT_S, 5e-3);
    gates[4].station_ft += 1.0; /* nonsense in what is left out changes nothing */
    gates[0].station_ft -= 1.0;
    assert_int_equal(mr_braking_fit(gates, count, TOUCHDOWN_FT, ERROR_FT, 1u << 4 | 1u << 0, &fit),
                     MR_OK);
    assert_true(mr_braking_is_accepted(&fit));
    assert_int_equal(fit.degrees_of_freedom, count - 2 - 3);
    assert_near(fit.speed_ft_s, SPEED_FT_S, 5e-3);
}

TEST(the_worst_are_left_out_one_by_one)
{
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_braking fit;
    size_t count = usual_gates(gates);
    gates[5].station_ft += 0.10; /* 60 errors */
    gates[8].station_ft -= 0.06;
    assert_int_equal(mr_braking_fit(gates, count, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_OK);
    assert_false(mr_braking_is_accepted(&fit));
    assert_int_equal(mr_braking_drop_worst_gate(gates, count, ERROR_FT, &fit), MR_OK);
    assert_int_equal(fit.excluded_mask, 1u << 5);
    assert_int_equal(mr_braking_drop_worst_gate(gates, count, ERROR_FT, &fit), MR_OK);
    assert_int_equal(fit.excluded_mask, 1u << 5 | 1u << 8);
    assert_true(mr_braking_is_accepted(&fit));
    assert_near(fit.speed_ft_s, SPEED_FT_S, 2e-3);
    /* a fifth of 11 gates is 2: with three out there is no more to be had, however bad the rest */
    gates[3].station_ft += 0.10;
    gates[6].station_ft += 0.10;
    assert_int_equal(
        mr_braking_fit(gates, count, TOUCHDOWN_FT, ERROR_FT, 1u << 5 | 1u << 8 | 1u << 9, &fit),
        MR_OK);
    assert_false(mr_braking_is_accepted(&fit));
    assert_int_equal(mr_braking_drop_worst_gate(gates, count, ERROR_FT, &fit), MR_LIMIT);
    /* nor with five gates, of which two alone are beyond what is needed: with one less none could
     * tell which it was */
    const double few_s[] = {-0.2, 0.4, 1.2, 2.9};
    count = gates_at(few_s, 4, gates);
    gates[2].station_ft += 0.10;
    assert_int_equal(mr_braking_fit(gates, count, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_OK);
    assert_int_equal(mr_braking_drop_worst_gate(gates, count, ERROR_FT, &fit), MR_LIMIT);
}

TEST(three_gates_are_taken_as_they_are)
{
    const double since_s[] = {0.2, 1.5, 3.5};
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_braking fit;
    gates_at(since_s, 3, gates);
    assert_int_equal(mr_braking_fit(gates, 3, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_OK);
    assert_int_equal(fit.degrees_of_freedom, 0);
    assert_true(mr_braking_is_accepted(&fit));
    assert_near(fit.speed_ft_s, SPEED_FT_S, 0.01); /* the shape is not told by three */
}

TEST(what_is_no_braking_is_refused)
{
    struct mr_gate gates[MR_GATES_MAX];
    struct mr_braking fit;
    size_t count = usual_gates(gates);
    assert_int_equal(mr_braking_fit(gates, 2, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_TOO_FEW);
    assert_int_equal(mr_braking_fit(gates, 4, TOUCHDOWN_FT, ERROR_FT, 1u << 1 | 1u << 2, &fit),
                     MR_TOO_FEW);
    /* none beyond touchdown */
    assert_int_equal(mr_braking_fit(gates, count, 200.0, ERROR_FT, 0, &fit), MR_TOO_FEW);
    for (size_t g = 0; g < count; g++) /* it gets faster */
        gates[g].station_ft =
            TOUCHDOWN_FT + 20.0 * (gates[g].t_s - TOUCHDOWN_S) +
            (gates[g].t_s > TOUCHDOWN_S ? 3.0 * pow(gates[g].t_s - TOUCHDOWN_S, 2.0) : 0.0);
    assert_int_equal(mr_braking_fit(gates, count, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_NUMERICS);
    usual_gates(gates);
    gates[4].t_s = gates[3].t_s;
    assert_int_equal(mr_braking_fit(gates, count, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_MALFORMED);
    for (size_t g = 0; g < 5; g++) /* backward */
        gates[g] = (struct mr_gate){.t_s = (double)g, .station_ft = 80.0 - 10.0 * (double)g};
    assert_int_equal(mr_braking_fit(gates, 5, TOUCHDOWN_FT, ERROR_FT, 0, &fit), MR_NUMERICS);
}

/* v = 0.2 ft/s against 30 ft/s2 would stand after 32 ms, the brake having risen after 50. */
TEST(at_rest_before_the_brake_has_risen_is_refused)
{
    struct mr_gates_summary summary;
    struct mr_braking fit = {.touchdown_ft = 3.0,
                             .speed_ft_s = 0.2,
                             .deceleration_ft_s2 = 30.0,
                             .delay_s = DELAY_S,
                             .shape = 1.0 / 3.0};
    assert_int_equal(mr_braking_summarise(&fit, &summary), MR_NUMERICS);
    fit.speed_ft_s = 30.0;
    assert_int_equal(mr_braking_summarise(&fit, &summary), MR_OK);
    assert_near(summary.stop_t_s.value, 1.0 + DELAY_S, 1e-12);
    assert_near(summary.stop_station_ft.value, 3.0 + 0.75 + 15.0 - 5.0 * DELAY_S * DELAY_S, 1e-12);
    assert_near(summary.mean_deceleration_ft_s2.value, 30.0 / 1.025, 1e-12);
    assert_near(summary.stop_t_s.error, 0.0, 0.0); /* a covariance of zero */
}
