/* Readings to parameters: hand-worked values, and errors against many readings with scatter. */
#include <math.h>
#include <string.h>

#include "host/analyse/params.h"
#include "tests/cmocka_all.h"

static struct estimate exact(double value)
{
    return (struct estimate){value, 0};
}

/* A uniform plank hung on cords at its ends: I = W l^2/(12 g) gives T = 2 pi sqrt(cord/(3 g)), whatever its
 * length. */
static void inertia_of_a_plank(void **state)
{
    (void)state;
    double g = 32.174, cord = 4, period = 2 * M_PI * sqrt(cord / (3 * g));
    struct estimate inertia = params_inertia(exact(140), exact(2), exact(cord), exact(period));
    assert_near(inertia.value, 140.0 / 32.174 * 4 / 12, 1e-12);
    assert_near(inertia.error, 0, 0);
    /* 1 % of the period, 1 % of the spacing: 2 % each */
    inertia = params_inertia(exact(140), (struct estimate){2, 0.02}, exact(cord),
                             (struct estimate){period, 0.01 * period});
    assert_near(inertia.error / inertia.value, sqrt(8) * 0.01, 1e-12);
}

/* 3.4: 9500 lb/in per in, a joint of 12 ft: 1.6e7 lb/ft. */
static void joint_of_the_report(void **state)
{
    (void)state;
    struct estimate kl = params_joint_stiffness((struct estimate){9500, 95}, exact(144));
    assert_near(kl.value, 1.6416e7, 1e-3);
    assert_near(kl.error, 1.6416e5, 1e-3);
}

static void friction_and_soil(void **state)
{
    (void)state;
    struct estimate f = params_friction((struct estimate){80, 4}, (struct estimate){160, 1.6});
    assert_near(f.value, 0.5, 1e-15);
    assert_near(f.error, 0.5 * sqrt(0.05 * 0.05 + 0.01 * 0.01), 1e-12);
    /* 2.6: 1440 lb, all on 12 wheels: 120 lb sink 0.050 in on one mat */
    struct estimate kv = params_soil(exact(120), (struct estimate){0.050 / 12, 0.005 / 12}, 1);
    assert_near(kv.value, 120 * 12 / (2 * 0.050), 1e-9);
    assert_near(kv.error / kv.value, 0.1, 1e-12);
}

static void hinge_of_the_report(void **state)
{
    (void)state;
    struct estimate kt, tad;
    struct error error = {0};
    double angle[5], moment[5];
    for (int i = 0; i < 5; i++) {
        angle[i] = (11 + i) * M_PI / 180;
        moment[i] = 1e5 * (angle[i] - 10 * M_PI / 180);
    }
    assert_int_equal(params_hinge(angle, moment, 5, exact(1), &kt, &tad, &error), MR_OK);
    assert_near(kt.value, 1e5, 1e-6);
    assert_near(tad.value * 180 / M_PI, 10, 1e-9);
    assert_near(kt.error, 0, 1e-5);
    assert_int_equal(params_hinge(angle, moment, 5, (struct estimate){72, 0.72}, &kt, &tad, &error), MR_OK);
    assert_near(kt.value, 72e5, 1e-4);
    assert_near(kt.error / kt.value, 0.01, 1e-9);
    assert_int_equal(params_hinge(angle, moment, 2, exact(1), &kt, &tad, &error), MR_TOO_FEW);
    struct error falling = {0};
    for (int i = 0; i < 5; i++)
        moment[i] = -moment[i];
    assert_int_equal(params_hinge(angle, moment, 5, exact(1), &kt, &tad, &falling), MR_MALFORMED);
}

/* The stated errors are the spread over many repeated tests. */
static void errors_are_the_spread(void **state)
{
    (void)state;
    enum { TESTS = 4000, POINTS = 8 };
    unsigned seed = 3;
    double sum_k = 0, sum_k2 = 0, sum_t = 0, sum_t2 = 0, said_k = 0, said_t = 0;
    for (int test = 0; test < TESTS; test++) {
        double angle[POINTS], moment[POINTS];
        struct estimate kt, tad;
        struct error error = {0};
        for (int i = 0; i < POINTS; i++) {
            double noise = 0;
            for (int k = 0; k < 12; k++) {
                seed = seed * 1664525u + 1013904223u;
                noise += (double)(seed >> 8) / (double)(1u << 24) - 0.5;
            }
            angle[i] = 0.18 + 0.01 * i;
            moment[i] = 1e5 * (angle[i] - 0.17) + 200 * noise;
        }
        assert_int_equal(params_hinge(angle, moment, POINTS, exact(1), &kt, &tad, &error), MR_OK);
        sum_k += kt.value, sum_k2 += kt.value * kt.value, said_k += kt.error * kt.error;
        sum_t += tad.value, sum_t2 += tad.value * tad.value, said_t += tad.error * tad.error;
    }
    double spread_k = sqrt(sum_k2 / TESTS - pow(sum_k / TESTS, 2)),
           spread_t = sqrt(sum_t2 / TESTS - pow(sum_t / TESTS, 2));
    assert_near(sqrt(said_k / TESTS) / spread_k, 1, 0.05);
    assert_near(sqrt(said_t / TESTS) / spread_t, 1, 0.05);
    assert_near(sum_k / TESTS, 1e5, 200);
}

static void means(void **state)
{
    (void)state;
    const double readings[] = {1, 2, 3, 4};
    struct estimate mean = params_mean(readings, 4, 0);
    assert_near(mean.value, 2.5, 1e-15);
    assert_near(mean.error, sqrt(5.0 / 3 / 4), 1e-15);
    mean = params_mean(readings, 4, 0.3);
    assert_near(mean.error, sqrt(5.0 / 12 + 0.09), 1e-15);
    mean = params_mean(readings, 1, 0.1);
    assert_near(mean.error, 0.1, 1e-15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inertia_of_a_plank),    cmocka_unit_test(joint_of_the_report),
        cmocka_unit_test(friction_and_soil),     cmocka_unit_test(hinge_of_the_report),
        cmocka_unit_test(errors_are_the_spread), cmocka_unit_test(means),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
