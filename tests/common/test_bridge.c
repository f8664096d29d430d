/* A strain bridge against one worked out resistor by resistor. */
#include <math.h>

#include "common/bridge.h"
#include "tests/cmocka_all.h"

/* Kirchhoff for four resistors: r[0] over r[1] in one branch, r[2] over r[3] in the other. */
static double output_v(const double r[4], double excitation_v)
{
    return excitation_v * (r[1] / (r[0] + r[1]) - r[3] / (r[2] + r[3]));
}

/* 3/8 x 0.020 in of steel, 350 ohm, gage factor 2.09, 5 V; two gages along the band and two across
 * it. */
static const struct mr_bridge bridge = {.excitation_v = 5.0,
                                        .amplifier_gain = 160.0,
                                        .gage_factor = 2.09,
                                        .arms = 2.6,
                                        .area_in2 = 0.0075,
                                        .modulus_psi = 29e6,
                                        .gage_ohm = 350.0,
                                        .shunt_ohm = 120e3};

static void a_pound_is_what_the_resistors_make_of_it(void **state)
{
    (void)state;
    double tension_lb = 100.0, strain = tension_lb / (0.0075 * 29e6);
    double along = 350.0 * (1.0 + 2.09 * strain), across = 350.0 * (1.0 - 0.3 * 2.09 * strain);
    double codes = output_v((const double[]){across, along, along, across}, 5.0) * 160.0 / 3.3 *
                   4096.0;
    /* what is not straight: 0.03 % */
    assert_near(mr_bridge_lb_per_code(&bridge) * codes, tension_lb, 0.05);
}

static void one_gage_alone_gives_a_quarter(void **state)
{
    (void)state;
    struct mr_bridge quarter = bridge;
    quarter.arms = 1.0;
    double strain = 100.0 / (0.0075 * 29e6);
    double codes = output_v((const double[]){350.0, 350.0 * (1.0 + 2.09 * strain), 350.0, 350.0},
                            5.0) *
                   160.0 / 3.3 * 4096.0;
    assert_near(mr_bridge_lb_per_code(&quarter) * codes, 100.0, 0.06);
}

static void a_shunt_stands_for_the_tension_with_its_output(void **state)
{
    (void)state;
    double shunted = 350.0 * 120e3 / (350.0 + 120e3);
    double codes = output_v((const double[]){shunted, 350.0, 350.0, 350.0}, 5.0) * 160.0 / 3.3 *
                   4096.0;
    struct mr_bridge none = bridge;
    assert_near(mr_bridge_shunt_lb(&bridge), mr_bridge_lb_per_code(&bridge) * codes, 1e-6);
    none.shunt_ohm = 0.0;
    assert_true(isnan(mr_bridge_shunt_lb(&none)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pound_is_what_the_resistors_make_of_it),
        cmocka_unit_test(one_gage_alone_gives_a_quarter),
        cmocka_unit_test(a_shunt_stands_for_the_tension_with_its_output),
    };
    return cmocka_run_group_tests_name("common/bridge", tests, NULL, NULL);
}
