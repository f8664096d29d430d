/* Waves pressed flat between landings. Expected values by hand. Units ft, lb. */
#include "host/landing_series/play.h"

#include <math.h>
#include <string.h>

#include "tests/cmocka_all.h"

#define JOINTS 8 /* seven mats */
#define RUB    1.0
#define KL     1e6

static double gap_ft[JOINTS], u_ft[JOINTS], closing_lb[JOINTS];

static void press(const double *gaps)
{
    struct flat_runway runway = {JOINTS, gap_ft, u_ft, closing_lb, RUB, KL};
    memcpy(gap_ft, gaps, sizeof gap_ft);
    memset(u_ft, 0, sizeof u_ft);
    flatten(&runway);
}

static void near(double value, double expected)
{
    if (!(fabs(value - expected) <= 1e-11))
        fail_msg("%.12g is not %.12g", value, expected);
}

/* One mat on the right, two on the left, as a joint is closed there. Then two on either side, which
 * hold 2 lb: 2e-6 ft. Of equal sides the right one goes. */
static void it_goes_to_the_side_that_resists_less(void **state)
{
    (void)state;
    const double gaps[JOINTS] = {0.1, 0.1, 0.01, 0, -0.0150, 0.01, 0.1, 0.1};
    press(gaps);
    near(gap_ft[5], 0.0);
    near(gap_ft[4], -2.0 * RUB / KL);
    near(gap_ft[6], 0.1 - (0.005 - 2e-6));
    near(u_ft[6], 0.005 - 2e-6);
    near(u_ft[5], 0.015 - 2e-6);
    near(u_ft[4], 0.0);
}

static void dirt_turns_it_round(void **state)
{
    (void)state;
    const double gaps[JOINTS] = {0.1, 0.1, 0.01, 0, -0.0150, 0.01, 0.1, 0.1};
    closing_lb[5] = 20.0;
    press(gaps);
    closing_lb[5] = 0.0;
    near(gap_ft[5], 0.01);
    near(gap_ft[2], 0.0); /* mats 4 and 3 */
    near(gap_ft[1], 0.1 - (0.005 - 3e-6));
    near(u_ft[2], -(0.005 - 3e-6));
    near(u_ft[3], -(0.015 - 3e-6));
    near(u_ft[5], 0.0);
}

/* Against an end nothing moves, and all openings together stay what they are. */
static void ends_hold_and_the_sum_stays(void **state)
{
    (void)state;
    const double gaps[JOINTS] = {-0.02, 0, -0.01, 0.003, -0.004, 0.02, 0.001, 0.03};
    double before = 0.0, after = 0.0;
    press(gaps);
    for (int j = 0; j < JOINTS; j++) {
        before += gaps[j];
        after += gap_ft[j];
        assert_true(gap_ft[j] > -8.0 * RUB / KL);
        double opened = (j < JOINTS - 1 ? u_ft[j + 1] : 0.0) - (j > 0 ? u_ft[j] : 0.0);
        near(gap_ft[j] - gaps[j], opened);
    }
    near(after, before);
}

/* What friction holds stays as it is, to the bit. */
static void a_pressed_runway_that_holds_stays(void **state)
{
    (void)state;
    const double gaps[JOINTS] = {0.1, 0, -0.9e-6, -1.9e-6, -2.9e-6, -1.9e-6, -0.9e-6, 0.1};
    press(gaps);
    assert_memory_equal(gap_ft, gaps, sizeof gap_ft);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_goes_to_the_side_that_resists_less),
        cmocka_unit_test(dirt_turns_it_round),
        cmocka_unit_test(ends_hold_and_the_sum_stays),
        cmocka_unit_test(a_pressed_runway_that_holds_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
