/* Calibration of a channel from known values and the converter's readings at these values: a
 * least-squares straight line, residuals and standard errors. If the line is not good enough, a
 * table of points is used (common/channels.h). Pure functions. */
#ifndef MATRIG_HOST_CALIBRATE_FIT_H
#define MATRIG_HOST_CALIBRATE_FIT_H

#include "common/channels.h"
#include "host/base/error.h"

#define CALIBRATE_POINTS_MAX 64u

struct calibrate_point {
    double value;  /* known value, in inches or pounds */
    double code;   /* mean reading, codes times the ratio of the reference */
    double spread; /* standard deviation of a block's reading, codes; NaN: not known */
};

struct calibrate_fit {
    double unit_per_code, zero_code;
    double gain_error; /* relative error of the gain */
    /* standard error of the zero, in inches or pounds, like the fields below */
    double zero_error;
    double linearity_error; /* root mean square of the residuals of the calibration */
    double worst_residual;  /* largest residual by magnitude, and the index of its point */
    size_t worst_point;
    double residual[CALIBRATE_POINTS_MAX]; /* calibrated reading minus known value */
    double low, high;                      /* smallest and largest known value */
    /* Largest deviation of a reading from the fit; for a table, also of a point from the chord of
     * its neighbours. */
    double max_deviation;
};

/* Fits a channel. `known_error`: standard error that all known values share, for example that of a
 * set of gage blocks or of a weight. Sets unit_per_code, zero_code, points and errors of `channel`;
 * other fields are unchanged. With `table`, the 2 to 8 distinct values become the points of the
 * table, and residuals are relative to the table. MR_TOO_FEW: fewer than three points or two
 * values. MR_NUMERICS: the reading does not follow the value, or the table does not rise. MR_LIMIT:
 * more values than a table has room for. */
enum mr_status calibrate_fit(const struct calibrate_point *point, size_t count, double known_error,
                             bool table, struct mr_channel_config *channel,
                             struct calibrate_fit *fit, struct error *error);

/* Finds an outlier: a point whose removal lets the others fit to within `most`, and at least twice
 * as well as the removal of any other point. Returns its index, and in `miss` the largest deviation
 * of the others. Returns `count` if no single point explains the deviation. */
size_t calibrate_find_outlier(const struct calibrate_point *point, size_t count, bool table,
                              double most, const struct mr_channel_config *channel, double *miss);

#endif
