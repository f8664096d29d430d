/* A channel's calibration from known values and what the converter read at them: straight line by
 * least squares, residuals, standard errors; where the line is not good enough, a table of points
 * (common/channels.h). Pure. */
#ifndef MATRIG_HOST_CALIBRATE_FIT_H
#define MATRIG_HOST_CALIBRATE_FIT_H

#include "common/channels.h"
#include "host/base/error.h"

#define CALIBRATE_POINTS_MAX 64u

struct calibrate_point {
    double value;  /* what is known to be true, in or lb */
    double code;   /* mean reading, codes times the reference's ratio */
    double spread; /* standard deviation of a block's reading, codes; NaN: not known */
};

struct calibrate_fit {
    double unit_per_code, zero_code;
    double gain_error;      /* relative */
    double zero_error;      /* in or lb, like those below */
    double linearity_error; /* what the calibration leaves: root mean square */
    double worst;           /* largest residual, in size, and the point that has it */
    size_t worst_point;
    double residual[CALIBRATE_POINTS_MAX]; /* calibrated reading less the known value */
    double low, high;                      /* known values */
    /* what a reading is off its fit, at most: of a table also a point off its neighbours' chord */
    double miss;
};

/* `known_error`: standard error of the known values, common to all (a gage block's set, a
 * weight's). Sets kind-independent fields of `channel`: unit_per_code, zero_code, points, errors;
 * the others stay. With `table` the distinct values become its points, 2 to 8, and residuals are
 * against the table. MR_TOO_FEW: fewer than three points or two values; MR_NUMERICS: the reading
 * does not follow the value, or the table does not rise; MR_LIMIT: more values than a table has
 * room for. */
enum mr_status calibrate_fit(const struct calibrate_point *point, size_t count, double known_error,
                             bool table, struct mr_channel_config *channel,
                             struct calibrate_fit *fit, struct error *error);

/* The point without which the others fit to `most`, and twice as well as without any other; its
 * index, and what the others miss then. `count`: no single point explains it. */
size_t calibrate_outlier(const struct calibrate_point *point, size_t count, bool table, double most,
                         const struct mr_channel_config *channel, double *miss);

#endif
