/* Elementary functions against long double ones of the C library, which have 11 bits more and no
 * variants, and their bits against those that were computed once: they are the same everywhere. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/elementary.h"
#include "tests/cmocka_all.h"

typedef double function(double);
typedef long double truth(long double);

static uint64_t state;

static double even(double from, double to)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return from + (to - from) * ((double)(state >> 11) / 9007199254740992.0);
}

/* Worst error in units in the last place; and the bits of all results, folded. */
static double worst_of(function *f, truth *right, double from, double to, uint64_t *bits)
{
    double worst = 0.0;
    state = 1;
    for (int i = 0; i < 20000; i++) {
        double x = even(from, to), y = f(x);
        long double t = right((long double)x);
        double unit = nextafter(fabs((double)t), (double)INFINITY) - fabs((double)t);
        double error = (double)(fabsl((long double)y - t)) / unit;
        uint64_t word;
        worst = error > worst ? error : worst;
        memcpy(&word, &y, sizeof word);
        *bits = (*bits ^ word) * 1099511628211u;
    }
    return worst;
}

TEST(within_two_units_of_the_truth)
{
    uint64_t bits = 14695981039346656037u;
    const struct {
        const char *name;
        function *f;
        truth *right;
        double from, to;
    } rows[] = {
        {"exp", elementary_exp, expl, -700.0, 700.0},
        {"exp", elementary_exp, expl, -1.0, 1.0},
        {"expm1", elementary_expm1, expm1l, -1.0, 1.0},
        {"expm1", elementary_expm1, expm1l, -1e-5, 1e-5},
        {"expm1", elementary_expm1, expm1l, -50.0, 50.0},
        {"log", elementary_log, logl, 1e-9, 3.0},
        {"log", elementary_log, logl, 0.9, 1.1},
        {"log", elementary_log, logl, 1.0, 1e9},
        {"sin", elementary_sin, sinl, -10.0, 10.0},
        {"cos", elementary_cos, cosl, -10.0, 10.0},
        {"tan", elementary_tan, tanl, -1.5, 1.5},
        {"asin", elementary_asin, asinl, -1.0, 1.0},
        {"asin", elementary_asin, asinl, -0.13, 0.13},
        {"acos", elementary_acos, acosl, -1.0, 1.0},
        {"acos", elementary_acos, acosl, 0.99, 1.0},
        {"tanh", elementary_tanh, tanhl, -3.0, 3.0},
        {"tanh", elementary_tanh, tanhl, -1e-3, 1e-3},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        double worst = worst_of(rows[i].f, rows[i].right, rows[i].from, rows[i].to, &bits);
        print_message("%s from %g to %g: %.2f\n", rows[i].name, rows[i].from, rows[i].to, worst);
        assert_true(worst <= 2.0);
    }
    print_message("bits %016llx\n", (unsigned long long)bits);
    assert_int_equal(bits, 0xf452c48bb11d0fa5);
}

TEST(power)
{
    state = 2;
    for (int i = 0; i < 20000; i++) {
        double x = even(0.0, 10.0), y = even(-3.0, 3.0);
        long double right = powl((long double)x, (long double)y);
        double wide = (2.0 + fabs(y * log(x))) * 2.22e-16;
        assert_true(fabsl((long double)elementary_pow(x, y) - right) <= (long double)wide * right);
    }
    assert_true(elementary_pow(0.0, 2.0) == 0.0 && elementary_pow(0.0, 0.0) == 1.0);
    assert_true(isinf(elementary_pow(0.0, -1.0)) && elementary_pow(3.0, 1.0) > 2.999);
}

TEST(special_values)
{
    assert_true(elementary_exp(0.0) == 1.0 && elementary_exp(-1000.0) == 0.0);
    assert_true(isinf(elementary_exp(1000.0)) && isnan(elementary_exp((double)NAN)));
    assert_true(elementary_exp(-(double)INFINITY) == 0.0);
    assert_true(elementary_expm1(-1000.0) == -1.0 && elementary_expm1(0.0) == 0.0);
    assert_true(elementary_log(1.0) == 0.0 && isinf(elementary_log(0.0)));
    assert_true(isnan(elementary_log(-1.0)) && isnan(elementary_log((double)NAN)));
    assert_true(elementary_sin(0.0) == 0.0 && elementary_cos(0.0) == 1.0);
    assert_true(elementary_asin(1.0) == asin(1.0) && elementary_asin(-1.0) == -asin(1.0));
    assert_true(isnan(elementary_asin(1.01)) && isnan(elementary_acos(-1.01)));
    assert_true(elementary_acos(1.0) == 0.0 && elementary_acos(-1.0) == acos(-1.0));
    assert_true(elementary_tanh(100.0) == 1.0 && elementary_tanh(-100.0) == -1.0);
    assert_true(isnan(elementary_tanh((double)NAN)) && isnan(elementary_sin((double)NAN)));
}
