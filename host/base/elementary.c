#include "host/base/elementary.h"

#include <math.h>
#include <stddef.h>

/* 32 significant bits, so that the product with an exponent is exact */
#define LN2_HIGH    0.6931471803691238
#define LN2_LOW     1.9082149292705877e-10
#define LOG2_E      1.4426950408889634
#define PI_2        1.5707963267948966
#define PI_2_LOW    6.123233995736766e-17
/* pi / 2 in two parts, the first of 32 bits: n * PI_2_PART_1 is exact */
#define PI_2_PART_1 1.5707963267341256
#define PI_2_PART_2 6.077100506506192e-11

/* Evaluates c[0] + c[1] x + ... */
static double evaluate_polynomial(double x, const double *c, size_t count)
{
    double sum = c[count - 1];
    for (size_t i = count - 1; i-- > 0;)
        sum = sum * x + c[i];
    return sum;
}
#define EVALUATE_POLYNOMIAL(x, c) evaluate_polynomial(x, c, sizeof(c) / sizeof(c)[0])

/* Reduces x to k log 2 + r with |r| at most half of log 2; returns e^r - 1 from its series up to
 * r^13. */
static double compute_reduced_expm1(double x, int *k)
{
    static const double c[] = {1.0 / 2,       1.0 / 6,        1.0 / 24,        1.0 / 120,
                               1.0 / 720,     1.0 / 5040,     1.0 / 40320,     1.0 / 362880,
                               1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};
    double n = fabs(x) < 0.34 ? 0.0 : floor(x * LOG2_E + 0.5);
    double high = x - n * LN2_HIGH, low = n * LN2_LOW, r = high - low;
    *k = (int)n;
    return r + (r * r * EVALUATE_POLYNOMIAL(r, c) + ((high - r) - low));
}

double elementary_exp(double x)
{
    int k;
    if (!(x < 710.0))
        return x + (x > 0.0 ? (double)INFINITY : 0.0);
    if (x < -746.0)
        return 0.0;
    double e = compute_reduced_expm1(x, &k);
    return ldexp(1.0 + e, k);
}

double elementary_expm1(double x)
{
    int k;
    if (!(x < 710.0))
        return x + (x > 0.0 ? (double)INFINITY : 0.0);
    if (x < -40.0)
        return -1.0;
    double e = compute_reduced_expm1(x, &k);
    if (k == 0)
        return x == 0.0 ? x : e;
    return k > 60 ? ldexp(1.0 + e, k) : ldexp(e, k) + (ldexp(1.0, k) - 1.0);
}

/* With x = 2^k (1 + f) and s = f / (2 + f): log(1 + f) = 2 s (1 + s^2/3 + s^4/5 + ...), |s| <
 * 0.172. */
double elementary_log(double x)
{
    static const double c[] = {1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9,  1.0 / 11, 1.0 / 13,
                               1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21, 1.0 / 23};
    int k;
    if (!(x > 0.0))
        return x == 0.0 ? -(double)INFINITY : (double)NAN;
    if (isinf(x))
        return x;
    double m = frexp(x, &k);
    if (m < 0.70710678118654752) {
        m *= 2.0;
        k--;
    }
    double f = m - 1.0, s = f / (2.0 + f), z = s * s, half = 0.5 * f * f;
    /* computed as 2 s = f - s f, in which the rounding error of s cancels */
    double rest = s * (half + 2.0 * z * EVALUATE_POLYNOMIAL(z, c));
    return k * LN2_HIGH - ((half - (rest + k * LN2_LOW)) - f);
}

double elementary_pow(double x, double y)
{
    if (y == 0.0 || x == 1.0)
        return 1.0;
    return y == 1.0 ? x : elementary_exp(y * elementary_log(x));
}

/* Reduces x to n pi/2 + r with |r| at most pi/4. Sets sine and cosine of r; returns n modulo 4. */
static int reduce_to_quadrant(double x, double *sine, double *cosine)
{
    static const double s[] = {
        -1.0 / 6,        1.0 / 120,        -1.0 / 5040,          1.0 / 362880,
        -1.0 / 39916800, 1.0 / 6227020800, -1.0 / 1307674368000, 1.0 / 355687428096000};
    static const double c[] = {
        1.0 / 24,        -1.0 / 720,         1.0 / 40320,         -1.0 / 3628800,
        1.0 / 479001600, -1.0 / 87178291200, 1.0 / 20922789888000};
    if (!(fabs(x) < 1e9)) {
        *sine = *cosine = (double)NAN;
        return 0;
    }
    double n = fabs(x) < 0.78 ? 0.0 : floor(x / PI_2 + 0.5);
    double high = x - n * PI_2_PART_1, low = n * PI_2_PART_2, r = high - low,
           lost = (high - r) - low;
    double z = r * r, half = 0.5 * z, one = 1.0 - half;
    *sine = r == 0.0 ? r : r + (r * z * EVALUATE_POLYNOMIAL(z, s) + lost * one);
    *cosine = one + (((1.0 - one) - half) + (z * z * EVALUATE_POLYNOMIAL(z, c) - r * lost));
    return (int)fmod(fmod(n, 4.0) + 4.0, 4.0);
}

double elementary_sin(double x)
{
    double s, c;
    int n = reduce_to_quadrant(x, &s, &c);
    return n == 0 ? s : n == 1 ? c : n == 2 ? -s : -c;
}

double elementary_cos(double x)
{
    double s, c;
    int n = reduce_to_quadrant(x, &s, &c);
    return n == 0 ? c : n == 1 ? -s : n == 2 ? -c : s;
}

double elementary_tan(double x)
{
    double s, c;
    return reduce_to_quadrant(x, &s, &c) % 2 == 0 ? s / c : -c / s;
}

/* Returns (asin(x)/x - 1)/x^2 as a evaluate_polynomial in z = x^2, fitted at the Chebyshev points
 * of 0 to 1/4, accurate to 1.5e-17. For larger x the caller uses asin(x) = pi/2 - 2 asin(sqrt((1 -
 * x)/2)). */
static double compute_asin_correction(double z)
{
    static const double c[] = {0.16666666666666669,  0.07499999999998433,  0.04464285714635543,
                               0.030381944138531247, 0.02237217294214989,  0.017352392720869973,
                               0.013971212973552933, 0.011479177415184906, 0.01032281435018578,
                               0.005457506718640358, 0.01740087944269402,  -0.014851887071247204,
                               0.028757851367421566};
    return z * EVALUATE_POLYNOMIAL(z, c);
}

double elementary_asin(double x)
{
    double size = fabs(x);
    if (size <= 0.5)
        return x + x * compute_asin_correction(x * x);
    if (!(size <= 1.0))
        return (double)NAN;
    double z = 0.5 * (1.0 - size), root = sqrt(z);
    double head = (double)(float)root, tail = size < 1.0 ? (z - head * head) / (root + head) : 0.0;
    double rest = 2.0 * root * compute_asin_correction(z) - (PI_2_LOW - 2.0 * tail);
    return copysign(PI_2 / 2.0 - (rest - (PI_2 / 2.0 - 2.0 * head)), x);
}

double elementary_acos(double x)
{
    if (fabs(x) <= 0.5)
        return PI_2 - (elementary_asin(x) - PI_2_LOW);
    if (!(fabs(x) <= 1.0))
        return (double)NAN;
    double z = 0.5 * (1.0 - fabs(x)), root = sqrt(z),
           angle = 2.0 * (root + root * compute_asin_correction(z));
    return x > 0.0 ? angle : 2.0 * PI_2 - (angle - 2.0 * PI_2_LOW);
}

double elementary_tanh(double x)
{
    double size = fabs(x), t;
    if (size > 22.0)
        return copysign(1.0, x);
    t = elementary_expm1(2.0 * size);
    return isnan(x) ? x : copysign(t / (t + 2.0), x);
}
