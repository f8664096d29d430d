#include "host/base/statistics.h"

#include <math.h>
#include <stdlib.h>

#include "common/gates.h"

enum mr_status line_fit(const double *x, const double *y, size_t count, struct line_fit *line,
                        struct error *error)
{
    return line_fit_with_weights(x, y, NULL, count, line, error);
}

enum mr_status line_fit_with_weights(const double *x, const double *y, const double *weight,
                                     size_t count, struct line_fit *line, struct error *error)
{
    if (count < 3)
        return error_set(error, MR_TOO_FEW,
                         "too few points for a slope and its error: %zu; give three or more",
                         count);
    double sum = 0.0, mx = 0.0, my = 0.0, sxx = 0.0, sxy = 0.0, residual2 = 0.0;
    for (size_t i = 0; i < count; i++)
        sum += weight ? weight[i] : 1.0;
    for (size_t i = 0; i < count; i++) {
        double w = weight ? weight[i] : 1.0;
        mx += w * x[i] / sum;
        my += w * y[i] / sum;
    }
    for (size_t i = 0; i < count; i++) {
        double w = weight ? weight[i] : 1.0;
        sxx += w * (x[i] - mx) * (x[i] - mx);
        sxy += w * (x[i] - mx) * (y[i] - my);
    }
    if (!(sxx > 0.0))
        return error_set(
            error, MR_TOO_FEW,
            "cannot fit a slope, because all %zu points are at %g; give points at different values",
            count, mx);
    double slope = sxy / sxx;
    for (size_t i = 0; i < count; i++) {
        double off = y[i] - my - slope * (x[i] - mx);
        residual2 += (weight ? weight[i] : 1.0) * off * off;
    }
    double variance = residual2 / ((double)count - 2.0);
    *line = (struct line_fit){
        .slope = {slope, sqrt(variance / sxx)},
        .intercept = {my - slope * mx, sqrt(variance * (1.0 / sum + mx * mx / sxx))},
        .covariance = -variance * mx / sxx,
        .scatter = sqrt(variance),
    };
    return MR_OK;
}

struct estimate line_predict(const struct line_fit *line, size_t count, double x, double weight)
{
    double variance = line->scatter * line->scatter / weight +
                      line->intercept.error * line->intercept.error + 2.0 * x * line->covariance +
                      x * x * line->slope.error * line->slope.error;
    return (struct estimate){line->intercept.value + line->slope.value * x,
                             sqrt(fmax(variance, 0.0)) *
                                 mr_gates_student_factor((unsigned)count - 2u)};
}

static int compare_numbers(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void sort_numbers(double *values, size_t count)
{
    if (count > 1)
        qsort(values, count, sizeof *values, compare_numbers);
}

struct proportion_interval compute_proportion_interval(size_t count, size_t total)
{
    const double z = 1.959963984540054; /* 2.5 % of a standard normal distribution are above z */
    if (total == 0)
        return (struct proportion_interval){0.0, 1.0};
    double n = (double)total, p = (double)count / n, z2 = z * z / n;
    double middle = (p + z2 / 2.0) / (1.0 + z2),
           half = z / (1.0 + z2) * sqrt(p * (1.0 - p) / n + z2 / (4.0 * n));
    return (struct proportion_interval){fmax(0.0, middle - half), fmin(1.0, middle + half)};
}
