/* Statistics of a few numbers: a straight line, a sorted list, the interval of a share. Pure
 * functions. */
#ifndef MATRIG_HOST_BASE_STATISTICS_H
#define MATRIG_HOST_BASE_STATISTICS_H

#include <stddef.h>

#include "host/base/error.h"

/* A value with its standard error, both in the unit that its owner defines. */
struct estimate {
    double value;
    double error;
};

/* y = intercept + slope x. Errors are computed from the scatter about the line. */
struct line_fit {
    struct estimate slope, intercept;
    double covariance; /* covariance of slope and intercept */
    double scatter;    /* standard deviation of a reading about the line */
};

/* Fits a line. Both arrays have `count` readings. MR_TOO_FEW: fewer than three readings, or all x
 * are equal. */
enum mr_status line_fit(const double *x, const double *y, size_t count, struct line_fit *line,
                        struct error *error);
/* As line_fit, for readings of different accuracy: `weight` is proportional to 1/variance, and
 * `scatter` is that of a reading of weight 1. */
enum mr_status line_fit_weighted(const double *x, const double *y, const double *weight,
                                 size_t count, struct line_fit *line, struct error *error);
/* The next reading at `x`, of this weight (1 for line_fit), from a line through `count` readings.
 * The reading is within 1.96 errors with a probability of 95 %: the error includes the scatter and
 * Student's t. */
struct estimate line_predict(const struct line_fit *line, size_t count, double x, double weight);

/* Sorting, for medians and percentiles. */

/* Sorts in place, ascending; NaN is not allowed. */
void sort_numbers(double *values, size_t count);

/* Wilson's 95 % interval of a share (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209). */

struct wilson {
    double low, high;
};

/* Interval for `count` events in `of` trials; 0 to 1 if `of` is 0. */
struct wilson wilson_interval(size_t count, size_t of);

#endif
