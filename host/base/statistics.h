/* Statistics of a few numbers: a straight line, a sorted list, the interval of a share. Pure. */
#ifndef MATRIG_HOST_BASE_STATISTICS_H
#define MATRIG_HOST_BASE_STATISTICS_H

#include <stddef.h>

#include "host/base/error.h"

/* A value with its standard error, both in a unit that its owner defines. */
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

/* Numbers in order, for medians and percentiles. */

/* Sorts in place, the least first; none of them may be NaN. */
void sort_numbers(double *values, size_t count);

/* Wilson's interval of a share: within it the true one lies with 95 %. (E. B. Wilson, J. Am. Stat.
 * Assoc. 22 (1927) 209.) */

struct wilson {
    double low, high;
};

/* `count` of `of`; of none: 0 to 1. */
struct wilson wilson_of(size_t count, size_t of);

#endif
