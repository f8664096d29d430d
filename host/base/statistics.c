#include "host/base/statistics.h"

#include <math.h>
#include <stdlib.h>

enum mr_status line_fit(const double *x, const double *y, size_t count, struct line_fit *line,
                        struct error *error)
{
    if (count < 3)
        return error_set(error, MR_TOO_FEW,
                         "too few points for a slope with its error: %zu; give three or more",
                         count);
    double n = (double)count, mx = 0.0, my = 0.0, sxx = 0.0, sxy = 0.0, residual2 = 0.0;
    for (size_t i = 0; i < count; i++) {
        mx += x[i] / n;
        my += y[i] / n;
    }
    for (size_t i = 0; i < count; i++) {
        sxx += (x[i] - mx) * (x[i] - mx);
        sxy += (x[i] - mx) * (y[i] - my);
    }
    if (!(sxx > 0.0))
        return error_set(
            error, MR_TOO_FEW,
            "cannot fit a slope: all %zu points are at %g; give points at different values", count,
            mx);
    double slope = sxy / sxx;
    for (size_t i = 0; i < count; i++) {
        double off = y[i] - my - slope * (x[i] - mx);
        residual2 += off * off;
    }
    double variance = residual2 / (n - 2.0);
    *line = (struct line_fit){
        .slope = {slope, sqrt(variance / sxx)},
        .intercept = {my - slope * mx, sqrt(variance * (1.0 / n + mx * mx / sxx))},
        .covariance = -variance * mx / sxx,
        .scatter = sqrt(variance),
    };
    return MR_OK;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void sort_numbers(double *values, size_t count)
{
    if (count > 1)
        qsort(values, count, sizeof *values, ascending);
}

struct wilson wilson_of(size_t count, size_t of)
{
    const double z = 1.959963984540054; /* normal distribution: 2.5 % above */
    if (of == 0)
        return (struct wilson){0.0, 1.0};
    double n = (double)of, p = (double)count / n, z2 = z * z / n;
    double middle = (p + z2 / 2.0) / (1.0 + z2),
           half = z / (1.0 + z2) * sqrt(p * (1.0 - p) / n + z2 / (4.0 * n));
    return (struct wilson){fmax(0.0, middle - half), fmin(1.0, middle + half)};
}
