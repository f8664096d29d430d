/* A straight line through readings by least squares, with its errors. Pure. */
#ifndef MATRIG_HOST_BASE_LINE_H
#define MATRIG_HOST_BASE_LINE_H

#include <stddef.h>

#include "host/base/error.h"

/* A value with its standard error, both in the unit that the user of it says. */
struct estimate {
    double value;
    double error;
};

/* y = intercept + slope x; the errors from the scatter about it. */
struct line_fit {
    struct estimate slope, intercept;
    double covariance; /* of slope and intercept */
    double scatter;    /* of a reading */
};

/* Both arrays have `count` readings. MR_TOO_FEW below three or when all x are the same. */
enum mr_status line_fit(const double *x, const double *y, size_t count, struct line_fit *line,
                        struct error *error);

#endif
