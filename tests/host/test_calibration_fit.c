/* Calibration: the line and its errors against closed forms and repeated trials, the table against
 * a curve, what is refused. */
#include <math.h>
#include <stdlib.h>

#include "host/calibrate/fit.h"
#include "tests/host/scratch.h"

static double gauss(void)
{
    double sum = -6.0; /* twelve even ones: variance 1 */
    for (int i = 0; i < 12; i++)
        sum += rand() / (RAND_MAX + 1.0);
    return sum;
}

/* Transducer: 0.0016 in per code, zero at 62.5 codes; known values 0 to 2 in. */
static size_t make(struct calibrate_point *point, size_t count, double noise_codes, double bend)
{
    for (size_t i = 0; i < count; i++) {
        double value = 2.0 * (double)i / (double)(count - 1);
        point[i] = (struct calibrate_point){
            value, 62.5 + (value - bend * value * (2.0 - value)) / 0.0016 + noise_codes * gauss(),
            0.5};
    }
    return count;
}

TEST(a_line_is_found_again)
{
    struct calibrate_point point[11];
    struct mr_channel_config channel = {
        .kind = MR_KIND_DISPLACEMENT, .points = 3, .station_ft = 40.0f};
    struct calibrate_fit fit;
    struct error error = {0};
    assert_int_equal(
        calibrate_fit(point, make(point, 11, 0.0, 0.0), 0.001, false, &channel, &fit, &error),
        MR_OK);
    assert_true(fabs(fit.unit_per_code / 0.0016 - 1.0) < 1e-9 && fabs(fit.zero_code - 62.5) < 1e-6);
    assert_true(fit.worst_residual < 2e-6 && fit.linearity_error < 2e-6); /* single precision */
    /* the known values' own error */
    assert_true(fabs(fit.gain_error - 0.001 / 2.0) < 1e-6 && fabs(fit.zero_error - 0.001) < 1e-6);
    assert_true(channel.points == 0 && channel.station_ft == 40.0f &&
                fabsf(channel.unit_per_code - 0.0016f) < 1e-9f);
}

/* One bad point: its residual is told. Line through (0,0) (1,1) (2,2) (3,3.4): slope 1.12,
 * intercept -0.08 by hand. */
TEST(residuals_by_hand)
{
    const struct calibrate_point point[4] = {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3.4, 3, 0}};
    struct mr_channel_config channel = {.kind = MR_KIND_TENSION};
    struct calibrate_fit fit;
    struct error error = {0};
    static const double residual[4] = {-0.08, 0.04, 0.16, -0.12};
    assert_int_equal(calibrate_fit(point, 4, 0.0, false, &channel, &fit, &error), MR_OK);
    assert_true(fabs(fit.unit_per_code - 1.12) < 1e-9 && fabs(fit.zero_code - 0.08 / 1.12) < 1e-9);
    for (int i = 0; i < 4; i++)
        assert_true(fabs(fit.residual[i] - residual[i]) < 1e-6);
    assert_int_equal(fit.worst_point, 2);
    /* sum of squares 0.048, two degrees of freedom; standard error of the slope: sqrt(0.024 / 5) */
    assert_true(fabs(fit.linearity_error - sqrt(0.024)) < 1e-6);
    assert_true(fabs(fit.gain_error - sqrt(0.024 / 5.0) / 1.12) < 1e-6);
    /* of the intercept: sqrt(0.024 (1/4 + 1.5^2 / 5)), at the zero code 0.0714: mean 1.5 less
     * that */
    assert_true(fabs(fit.zero_error - sqrt(0.024 * (0.25 + pow(1.5 - 0.08 / 1.12, 2) / 5.0))) <
                1e-6);
    /* without the last the others lie on one line; without another three miss it by as much as two
     * decide it: 0.4 / 6 at least */
    double rest;
    assert_int_equal(calibrate_find_outlier(point, 4, false, 0.03, &channel, &rest), 3);
    assert_true(rest < 1e-6 && fabs(fit.max_deviation - 0.16) < 1e-6);
    /* of three any one explains it */
    assert_int_equal(calibrate_find_outlier(point + 1, 3, false, 0.03, &channel, &rest), 3);
    /* a table goes through all points: the third is off its neighbours' chord by 0.2 */
    assert_int_equal(calibrate_fit(point, 4, 0.0, true, &channel, &fit, &error), MR_OK);
    assert_true(fit.worst_residual < 1e-6 && fabs(fit.max_deviation - 0.2) < 1e-6);
}

TEST(stated_errors_hold)
{
    enum { TRIALS = 500 };
    struct calibrate_point point[9];
    struct mr_channel_config channel = {.kind = MR_KIND_DISPLACEMENT};
    struct calibrate_fit fit;
    struct error error = {0};
    double gain = 0.0, zero = 0.0;
    srand(3);
    for (int i = 0; i < TRIALS; i++) {
        assert_int_equal(
            calibrate_fit(point, make(point, 9, 3.0, 0.0), 0.0, false, &channel, &fit, &error),
            MR_OK);
        gain += pow((fit.unit_per_code / 0.0016 - 1.0) / fit.gain_error, 2) / TRIALS;
        zero += pow((fit.zero_code - 62.5) * 0.0016 / fit.zero_error, 2) / TRIALS;
    }
    /* squares of Student's t with seven degrees of freedom: 7/5 in the mean */
    assert_true(gain > 1.1 && gain < 1.75 && zero > 1.1 && zero < 1.75);
}

TEST(a_table_follows_a_curve)
{
    struct calibrate_point point[8];
    struct mr_channel_config channel = {.kind = MR_KIND_DISPLACEMENT};
    struct calibrate_fit line, table;
    struct error error = {0};
    double worst = 0.0;
    make(point, 8, 0.0, 0.02);
    assert_int_equal(calibrate_fit(point, 8, 0.0, false, &channel, &line, &error), MR_OK);
    assert_true(line.worst_residual > 0.005);
    assert_int_equal(calibrate_fit(point, 8, 0.0, true, &channel, &table, &error), MR_OK);
    assert_int_equal(channel.points, 8);
    assert_true(table.worst_residual < 1e-5);
    for (double value = 0.0; value <= 2.0; value += 0.01) { /* between the points too */
        double code = 62.5 + (value - 0.02 * value * (2.0 - value)) / 0.0016;
        float straight = ((float)code - channel.zero_code) * channel.unit_per_code;
        worst = fmax(worst, fabs((double)mr_channel_linearise(&channel, straight) - value));
    }
    assert_true(worst < 2.0 * table.linearity_error && worst > 0.3 * table.linearity_error &&
                worst < line.worst_residual / 5.0);
    for (int i = 0; i < 8; i++) /* a bridge wired the other way round: codes fall */
        point[i].code = -point[i].code;
    assert_int_equal(calibrate_fit(point, 8, 0.0, true, &channel, &table, &error), MR_OK);
    assert_true(channel.unit_per_code < 0.0f && table.worst_residual < 1e-5);
}

TEST(what_is_no_calibration_is_refused)
{
    struct calibrate_point point[12];
    struct mr_channel_config channel = {.kind = MR_KIND_DISPLACEMENT};
    struct calibrate_fit fit;
    struct error error = {0};
    make(point, 12, 0.0, 0.0);
    assert_int_equal(calibrate_fit(point, 2, 0.0, false, &channel, &fit, &error), MR_TOO_FEW);
    error = (struct error){0};
    assert_int_equal(calibrate_fit(point, 12, 0.0, true, &channel, &fit, &error), MR_LIMIT);
    error = (struct error){0};
    for (int i = 0; i < 12; i++)
        point[i].value = 1.0;
    assert_int_equal(calibrate_fit(point, 12, 0.0, false, &channel, &fit, &error), MR_TOO_FEW);
    error = (struct error){0};
    srand(9);
    for (int i = 0; i < 12; i++)
        point[i] = (struct calibrate_point){i, 2000.0 + gauss(), 1.0}; /* not connected */
    assert_int_equal(calibrate_fit(point, 12, 0.0, false, &channel, &fit, &error), MR_NUMERICS);
    assert_error(&error, MR_NUMERICS, "do not change");
}
