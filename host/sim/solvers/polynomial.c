#include "host/sim/solvers/polynomial.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

/* Leading terms smaller than this fraction of the largest value are dropped. */
#define NEGLIGIBLE_TERM_SHARE 1e-18

double polynomial_value(const double *s, int degree, double t)
{
    double sum = s[degree];
    for (int k = degree; k-- > 0;)
        sum = sum * t + s[k];
    return sum;
}

/* Finds a root of a polynomial that is positive at `low` and negative at `high`. */
static double find_root_within(const double *s, int degree, double low, double high)
{
    double narrow = DBL_EPSILON * high, t = 0.5 * (low + high);
    for (int i = 0; i < 100 && high - low > narrow; i++) {
        double f = s[degree], slope = 0.0;
        for (int k = degree; k-- > 0;) {
            slope = slope * t + f;
            f = f * t + s[k];
        }
        if (f > 0.0)
            low = t;
        else
            high = t;
        double next = t - f / slope;
        if (!(next > low && next < high))
            next = 0.5 * (low + high);
        if (f == 0.0 || fabs(next - t) <= narrow)
            break;
        t = next;
    }
    return t;
}

/* Finds the first root of s within low..high. b: the Bernstein coefficients of s in this interval
 * (Farouki 2012), changed on return. The number of roots is at most the number of sign changes in
 * b. */
static double find_first_root(const double *s, double *b, int degree, double low, double high,
                              int depth)
{
    int changes = 0;
    bool positive = true;
    for (int k = 0; k <= degree; k++) {
        bool now = k == 0 || b[k] > 0.0 || (b[k] == 0.0 && positive);
        changes += now != positive;
        positive = now;
    }
    if (changes == 0)
        return (double)INFINITY;
    if (changes == 1 || depth == 0)
        return positive ? (double)INFINITY : find_root_within(s, degree, low, high);
    double left[POLYNOMIAL_DEGREE_MAX + 1], middle = 0.5 * (low + high);
    /* de Casteljau's algorithm: b becomes the coefficients of the right half */
    for (int k = 0; k <= degree; k++) {
        left[k] = b[0];
        for (int i = 0; i < degree - k; i++)
            b[i] = 0.5 * (b[i] + b[i + 1]);
    }
    double t = find_first_root(s, left, degree, low, middle, depth - 1);
    if (t < (double)INFINITY)
        return t;
    return b[0] < 0.0 ? middle : find_first_root(s, b, degree, middle, high, depth - 1);
}

/* Finds the first root in (0, wide] of a polynomial that is positive at 0. INFINITY: none. */
static double find_root_from_positive(const double *s, int degree, double wide)
{
    double power[POLYNOMIAL_DEGREE_MAX + 1], b[POLYNOMIAL_DEGREE_MAX + 1], most = 0.0;
    power[0] = 1.0;
    for (int k = 1; k <= degree; k++) {
        power[k] = power[k - 1] * wide;
        most += fabs(s[k]) * power[k];
    }
    if (s[0] > most)
        return (double)INFINITY;
    while (degree > 1 && fabs(s[degree]) * power[degree] < NEGLIGIBLE_TERM_SHARE * most)
        degree--;
    double choices = 1.0;
    for (int k = 0; k <= degree; k++) {
        b[k] = s[k] * power[k] / choices;
        choices = choices * (degree - k) / (k + 1);
    }
    for (int k = 1; k <= degree; k++) {
        for (int i = degree; i >= k; i--)
            b[i] += b[i - 1];
    }
    return find_first_root(s, b, degree, 0.0, wide, 40);
}

double polynomial_first_negative_s(double *s, int degree, double wide, double edge)
{
    int skip = 0;
    if (s[0] <= edge)
        s[0] += edge;
    while (skip <= degree && s[skip] == 0.0)
        skip++;
    if (skip > degree)
        return (double)INFINITY;
    return s[skip] < 0.0 ? 0.0 : find_root_from_positive(s + skip, degree - skip, wide);
}
