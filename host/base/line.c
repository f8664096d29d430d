#include "host/base/line.h"

#include <math.h>

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
        return error_set(error, MR_TOO_FEW,
                         "no slope: all %zu points lie at %g; give different ones", count, mx);
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
