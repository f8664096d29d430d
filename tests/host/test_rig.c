/* What landings and plate tests teach: exact lines, the figures of the report, and how often the
 * stated interval has the truth over 500 drawn cases. Drawn with numbers of their own, by the
 * physics and not by the code. */
#include <math.h>

#include "common/splitmix.h"
#include "host/analyse/params.h"
#include "host/analyse/rig.h"
#include "tests/cmocka_all.h"

#define CASES 500u
#define G     32.174

static uint64_t state = 35;

static double uniform(double low, double high)
{
    return low + (high - low) * mr_splitmix64_uniform(&state);
}

static double normal(double error)
{
    double radius = sqrt(-2 * log(1 - uniform(0, 1)));
    return error * radius * cos(2 * M_PI * uniform(0, 1));
}

/* 95 % of the intervals have it, within what 500 draws can show. */
static void assert_holds(unsigned held)
{
    struct proportion_interval share = compute_proportion_interval(held, CASES);
    print_message("%u of %u\n", held, CASES);
    assert_true(share.low < 0.95 && share.high > 0.95);
}

static bool has(struct estimate predicted, double truth)
{
    return fabs(predicted.value - truth) <= 1.96 * predicted.error;
}

/* 2.4: 28 ft/s after a descent of 20 ft; without losses it were 35.9 ft/s. */
TEST(a_track_that_takes_a_share_of_the_energy)
{
    const double share = 28 * 28 / (2 * G * 20), height[] = {10, 14, 20, 17};
    struct estimate predicted;
    struct error error = {0};
    double speed[4];
    for (unsigned i = 0; i < 4; i++)
        speed[i] = sqrt(2 * G * height[i] * share);
    assert_int_equal(rig_predict_next_landing(height, speed, 4, 20, true, &predicted, &error),
                     MR_OK);
    assert_near(predicted.value, 28, 1e-9);
    assert_near(predicted.error, 0, 1e-5);
    assert_int_equal(rig_predict_next_landing(height, speed, 4, 5, true, &predicted, &error),
                     MR_OK);
    assert_near(predicted.value, 14, 1e-9);
}

TEST(a_height_from_which_the_gear_does_not_arrive)
{
    const double height[] = {10, 14, 20}, speed[] = {10, 20, 28};
    struct estimate predicted;
    struct error error = {0};
    assert_int_equal(rig_predict_next_landing(height, speed, 3, 1, true, &predicted, &error),
                     MR_NUMERICS);
    error = (struct error){0};
    assert_int_equal(rig_predict_next_landing(height, speed, 2, 12, true, &predicted, &error),
                     MR_TOO_FEW);
}

/* 2.7.1: 4 to 6 ft/s2 from 50 to 90 F. */
TEST(the_drag_of_the_report)
{
    const double f[] = {50, 60, 80, 90}, a[] = {4, 4.5, 5.5, 6};
    struct estimate predicted;
    struct error error = {0};
    assert_int_equal(rig_predict_next_landing(f, a, 4, 72, false, &predicted, &error), MR_OK);
    assert_near(predicted.value, 5.1, 1e-12);
    assert_near(predicted.error, 0, 1e-6);
}

TEST(touchdown_speeds_hold)
{
    unsigned held = 0;
    for (unsigned i = 0; i < CASES; i++) {
        double height[12], speed[12], share = uniform(0.5, 0.75), lost = uniform(-30, 60),
                                      error_ft_s = uniform(0.1, 0.5), next = uniform(8, 20);
        size_t count = (size_t)uniform(4, 13);
        struct estimate predicted;
        struct error error = {0};
        for (size_t k = 0; k < count; k++) {
            height[k] = uniform(8, 20);
            speed[k] = sqrt(2 * G * share * height[k] - lost) + normal(error_ft_s);
        }
        rig_predict_next_landing(height, speed, count, next, true, &predicted, &error);
        held += has(predicted, sqrt(2 * G * share * next - lost) + normal(error_ft_s));
    }
    assert_holds(held);
}

TEST(drags_hold)
{
    unsigned held = 0;
    for (unsigned i = 0; i < CASES; i++) {
        double f[12], a[12], slope = uniform(-0.06, 0.06), middle = uniform(4, 6),
                             error_ft_s2 = uniform(0.02, 0.4), next = uniform(40, 100);
        size_t count = (size_t)uniform(3, 13);
        struct estimate predicted;
        struct error error = {0};
        for (size_t k = 0; k < count; k++) {
            f[k] = uniform(50, 90);
            a[k] = middle + slope * (f[k] - 70) + normal(error_ft_s2);
        }
        rig_predict_next_landing(f, a, count, next, false, &predicted, &error);
        held += has(predicted, middle + slope * (next - 70) + normal(error_ft_s2));
    }
    assert_holds(held);
}

/* A plate of 1 in2 on soil of 200 lb/in3 takes 200 lb/in; a mat of 24 x 144 in has half of 3456 of
 * them under each end. */
TEST(a_plate_in_closed_form)
{
    const double load[] = {10, 20, 30}, settled[] = {(0.01 + 0.05) / 12, 0.11 / 12, 0.16 / 12};
    const struct estimate plate = {sqrt(4 / M_PI) / 12, 0}, mat = {24, 0};
    struct estimate kv;
    struct error error = {0};
    assert_int_equal(params_compute_plate_soil_stiffness(load, settled, 3, plate, mat, &kv, &error),
                     MR_OK);
    assert_near(kv.value, 200.0 * 12 * 3456 / 2, 1e-3);
}

TEST(plates_hold)
{
    unsigned held = 0;
    for (unsigned i = 0; i < CASES; i++) {
        double load[10], settled[10], k_lb_in3 = uniform(50, 400), plate_in = uniform(2, 12),
                                      mat_in2 = 24 * 144 / 49.0, error_lb = uniform(0.2, 5);
        double area_in2 = M_PI / 4 * plate_in * plate_in, seat_in = uniform(0, 0.02);
        size_t count = (size_t)uniform(3, 11);
        const struct estimate plate = {plate_in / 12, 0.001 / 12}, mat = {mat_in2 / 144, 0};
        struct estimate kv;
        struct error error = {0};
        for (size_t k = 0; k < count; k++) {
            double settled_in = 0.01 * (double)(k + 1);
            settled[k] = (settled_in + seat_in) / 12;
            load[k] = k_lb_in3 * area_in2 * settled_in + normal(error_lb);
        }
        params_compute_plate_soil_stiffness(load, settled, count, plate, mat, &kv, &error);
        held += has(kv, k_lb_in3 * mat_in2 / 2 * 12);
    }
    assert_holds(held);
}

/* 2 ft over 400 pixels; 60 pixels are 0.3 ft. Marks of 1 pixel, 100 pixels along the line: 60
 * within sqrt(1 + 0.25^2 + 0.75^2) pixels, the scale within sqrt(2) of 400 and 1 % of its
 * length. */
TEST(a_height_in_closed_form)
{
    const struct estimate distance = {2, 0.02};
    const double off = sqrt(1 + 1.0 / 16 + 9.0 / 16) / 60, scale = hypot(0.01, sqrt(2) / 400);
    struct rig_marks marks = {{100, 500, 200}, {300, 300, 240}, 1};
    struct estimate height;
    struct error error = {0};
    assert_int_equal(rig_measure_height(&marks, distance, &height, &error), MR_OK);
    assert_near(height.value, 0.3, 1e-12);
    assert_near(height.error, 0.3 * hypot(off, scale), 1e-12);
    marks = (struct rig_marks){{500, 100, 400}, {300, 300, 330}, 0}; /* the other way, and below */
    assert_int_equal(rig_measure_height(&marks, distance, &height, &error), MR_OK);
    assert_near(height.value, -0.15, 1e-12);
    assert_near(height.error, 0.0015, 1e-12);
    /* a line that falls by 3 in 4: (40, -30) beside it is 50 pixels above */
    marks = (struct rig_marks){{0, 400, 200 + 30}, {0, 300, 150 - 40}, 1};
    assert_int_equal(rig_measure_height(&marks, (struct estimate){5, 0}, &height, &error), MR_OK);
    assert_near(height.value, 0.5, 1e-12);
    marks.x[1] = 12;
    marks.y[1] = 16;
    assert_int_equal(rig_measure_height(&marks, distance, &height, &error), MR_USAGE);
}

TEST(heights_hold)
{
    unsigned held = 0;
    for (unsigned i = 0; i < CASES; i++) {
        double turn = uniform(-1.5, 1.5), px = uniform(80, 900), truth_ft = uniform(-0.5, 0.5),
               length_ft = uniform(0.5, 6), along = uniform(-0.5, 1.5), mark = uniform(0.3, 3),
               length_error = uniform(0.001, 0.03) * length_ft, c = cos(turn), s = sin(turn);
        double at[3][2] = {{0, 0}, {px, 0}, {along * px, truth_ft / length_ft * px}};
        struct rig_marks marks = {.error = mark};
        struct estimate height;
        struct error error = {0};
        for (int k = 0; k < 3; k++) {
            marks.x[k] = 900 + c * at[k][0] - s * at[k][1] + normal(mark);
            marks.y[k] = 700 - s * at[k][0] - c * at[k][1] + normal(mark);
        }
        assert_int_equal(
            rig_measure_height(&marks,
                               (struct estimate){length_ft + normal(length_error), length_error},
                               &height, &error),
            MR_OK);
        held += has(height, truth_ft);
    }
    assert_holds(held);
}
