/* Readings to parameters: hand-worked values, and errors against many readings with scatter. */
#include <math.h>
#include <string.h>

#include "host/analyse/params.h"
#include "tests/cmocka_all.h"

static struct estimate exact(double value)
{
    return (struct estimate){value, 0};
}

/* A uniform plank hung on cords at its ends: I = W l^2/(12 g) gives T = 2 pi sqrt(cord/(3 g)),
 * whatever its length. */
TEST(inertia_of_a_plank)
{
    double g = 32.174, cord = 4, period = 2 * M_PI * sqrt(cord / (3 * g));
    struct estimate inertia = params_compute_inertia(exact(140), exact(2), exact(cord),
                                                     exact(period));
    assert_near(inertia.value, 140.0 / 32.174 * 4 / 12, 1e-12);
    assert_near(inertia.error, 0, 0);
    /* 1 % of the period, 1 % of the spacing: 2 % each */
    inertia = params_compute_inertia(exact(140), (struct estimate){2, 0.02}, exact(cord),
                                     (struct estimate){period, 0.01 * period});
    assert_near(inertia.error / inertia.value, sqrt(8) * 0.01, 1e-12);
}

/* 3.4: 9500 lb/in per in, a joint of 12 ft: 1.6e7 lb/ft. */
TEST(joint_of_the_report)
{
    struct estimate kl = params_compute_joint_stiffness((struct estimate){9500, 95}, exact(144));
    assert_near(kl.value, 1.6416e7, 1e-3);
    assert_near(kl.error, 1.6416e5, 1e-3);
}

TEST(friction_and_soil)
{
    struct estimate f = params_compute_friction((struct estimate){80, 4},
                                                (struct estimate){160, 1.6});
    assert_near(f.value, 0.5, 1e-15);
    assert_near(f.error, 0.5 * sqrt(0.05 * 0.05 + 0.01 * 0.01), 1e-12);
    /* 2.6: 1440 lb, all on 12 wheels: 120 lb sink 0.050 in on one mat */
    struct estimate kv =
        params_compute_soil_stiffness(exact(120), (struct estimate){0.050 / 12, 0.005 / 12}, 1);
    assert_near(kv.value, 120 * 12 / (2 * 0.050), 1e-9);
    assert_near(kv.error / kv.value, 0.1, 1e-12);
}

#define DEG (M_PI / 180)

/* Moments of a joint that is free up to 10 degrees and has 1e5 ft lb/rad beyond, with the scatter
 * of a scale. */
static double scatter(unsigned *seed)
{
    double sum = 0;
    for (int k = 0; k < 12; k++) {
        *seed = *seed * 1664525u + 1013904223u;
        sum += (double)(*seed >> 8) / (double)(1u << 24) - 0.5;
    }
    return sum;
}

static struct params_spring_fit hinge(double from_deg, double step_deg, size_t count,
                                      double noise_ft_lb, unsigned *seed)
{
    double angle[32], moment[32];
    struct params_spring_fit spring;
    struct error error = {0};
    for (size_t i = 0; i < count; i++) {
        angle[i] = (from_deg + step_deg * (double)i) * DEG;
        moment[i] = 1e5 * fmax(0, angle[i] - 10 * DEG) + noise_ft_lb * scatter(seed);
    }
    assert_int_equal(params_fit_spring(angle, moment, count, &spring, &error), MR_OK);
    return spring;
}

TEST(hinge_of_the_report)
{
    unsigned seed = 1;
    struct params_spring_fit spring = hinge(11, 1, 5, 0, &seed);
    assert_true(spring.is_known);
    assert_int_equal(spring.free_travel_readings, 0);
    assert_near(spring.stiffness.value, 1e5, 1e-6);
    assert_near(spring.free_travel.value / DEG, 10, 1e-9);
    assert_near(spring.stiffness.error, 0, 1e-5);
    struct estimate wide = params_compute_hinge_stiffness(spring.stiffness,
                                                          (struct estimate){72, 0.72});
    assert_near(wide.value, 72e5, 1e-4);
    assert_near(wide.error / wide.value, 0.01, 1e-9);
    const double angle[] = {1, 2, 3, 4}, falling[] = {-1, -2, -3, -4.1}, same[] = {2, 2, 2, 2};
    struct error error = {0}, alike = {0};
    assert_int_equal(params_fit_spring(angle, falling, 4, &spring, &error), MR_OK);
    assert_false(spring.is_known);
    assert_int_equal(params_fit_spring(angle, falling, 2, &spring, &error), MR_TOO_FEW);
    assert_int_equal(params_fit_spring(same, angle, 4, &spring, &alike), MR_TOO_FEW);
}

/* Readings from inside the free travel give no spring, and among others they are found. */
TEST(readings_inside_the_free_travel)
{
    unsigned seed = 5;
    int taken = 0;
    for (int test = 0; test < 2000; test++) {
        struct params_spring_fit spring = hinge(1, 1, 8, 5, &seed);
        taken += spring.is_known && !spring.free_travel_readings;
    }
    if (taken > 20)
        fail_msg("scatter taken for a spring %d times of 2000", taken);
    for (double from_deg = 2; from_deg < 8; from_deg += 1)
        assert_true(hinge(from_deg, 1, 14, 20, &seed).free_travel_readings > 0);
    assert_int_equal(hinge(10, 1, 5, 0, &seed).free_travel_readings, 0); /* the edge itself */
}

/* The stated errors are the spread over many repeated tests. */
TEST(errors_are_the_spread)
{
    enum { TESTS = 4000 };
    unsigned seed = 3;
    double sum_k = 0, sum_k2 = 0, sum_t = 0, sum_t2 = 0, said_k = 0, said_t = 0;
    for (int test = 0; test < TESTS; test++) {
        struct params_spring_fit t = hinge(10.6, 0.6, 8, 200, &seed);
        assert_true(t.is_known && t.free_travel_readings == 0);
        sum_k += t.stiffness.value, sum_k2 += t.stiffness.value * t.stiffness.value,
            said_k += t.stiffness.error * t.stiffness.error;
        sum_t += t.free_travel.value, sum_t2 += t.free_travel.value * t.free_travel.value,
            said_t += t.free_travel.error * t.free_travel.error;
    }
    double spread_k = sqrt(sum_k2 / TESTS - pow(sum_k / TESTS, 2)),
           spread_t = sqrt(sum_t2 / TESTS - pow(sum_t / TESTS, 2));
    assert_near(sqrt(said_k / TESTS) / spread_k, 1, 0.05);
    assert_near(sqrt(said_t / TESTS) / spread_t, 1, 0.05);
    assert_near(sum_k / TESTS, 1e5, 200);
    assert_near(sum_t / TESTS / DEG, 10, 0.01);
}

TEST(means)
{
    const double readings[] = {1, 2, 3, 4};
    struct estimate mean = params_compute_mean(readings, 4, 0);
    assert_near(mean.value, 2.5, 1e-15);
    assert_near(mean.error, sqrt(5.0 / 3 / 4), 1e-15);
    mean = params_compute_mean(readings, 4, 0.3);
    assert_near(mean.error, sqrt(5.0 / 12 + 0.09), 1e-15);
    mean = params_compute_mean(readings, 1, 0.1);
    assert_near(mean.error, 0.1, 1e-15);
}
