/* Statistics of a few numbers: a fitted line, sorting, and the confidence interval of a proportion.
 * Pure functions. */
#ifndef MATRIG_HOST_BASE_STATISTICS_H
#define MATRIG_HOST_BASE_STATISTICS_H

#include <stddef.h>

#include "host/base/error.h"

/* A value and its standard error, in the same unit. */
struct estimate {
    double value;
    double error;
};

/* A fitted line y = intercept + slope x. The errors are computed from the scatter about the
 * line. */
struct line_fit {
    struct estimate slope, intercept;
    double covariance; /* covariance of slope and intercept */
    double scatter;    /* standard deviation of the readings about the line */
};

/* Fits a line by least squares. Both arrays have `count` readings. MR_TOO_FEW: fewer than three
 * readings, or all x are equal. */
enum mr_status line_fit(const double *x, const double *y, size_t count, struct line_fit *line,
                        struct error *error);
/* Fits a line to readings of different accuracy. `weight` is proportional to 1/variance, and
 * `scatter` is the standard deviation of a reading of weight 1. */
enum mr_status line_fit_with_weights(const double *x, const double *y, const double *weight,
                                     size_t count, struct line_fit *line, struct error *error);
/* Predicts the next reading at `x` from a line through `count` readings. `weight` is that of the
 * new reading (1 for line_fit). The error includes the scatter and the factor of Student's t, so
 * that the reading is within 1.96 errors with a probability of 95 %. */
struct estimate line_predict(const struct line_fit *line, size_t count, double x, double weight);

/* Sorts in ascending order, in place, for medians and percentiles. NaN is not allowed. */
void sort_numbers(double *values, size_t count);

/* Wilson's 95 % interval of a proportion, from 0 to 1 (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927)
 * 209). */

struct proportion_interval {
    double low, high;
};

/* Returns the interval of the proportion of `count` events in `of` trials; if `of` is 0, the whole
 * range 0 to 1. */
struct proportion_interval compute_proportion_interval(size_t count, size_t total);

#endif
