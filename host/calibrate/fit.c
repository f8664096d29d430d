#include "host/calibrate/fit.h"

#include <math.h>
#include <string.h>

#include "host/base/statistics.h"

#define SLOPE_MIN_STANDARD_ERRORS \
    3.0 /* number of standard errors by which the slope must differ from 0 */

static bool has_smaller_code(const struct calibrate_point *a, const struct calibrate_point *b)
{
    return a->code < b->code;
}

/* Averages values and codes of each distinct known value, sorted by the reading of the straight
 * line. Returns the number of distinct values. */
static size_t average_by_value(const struct calibrate_point *point, size_t count,
                               struct calibrate_point mean[CALIBRATE_POINTS_MAX])
{
    size_t found = 0;
    for (size_t i = 0; i < count; i++) {
        double sum = 0.0;
        size_t same = 0, earlier = 0;
        for (size_t k = 0; k < count; k++) {
            if (point[k].value != point[i].value)
                continue;
            sum += point[k].code;
            same++;
            earlier += k < i;
        }
        if (earlier)
            continue;
        struct calibrate_point p = {.value = point[i].value, .code = sum / (double)same};
        size_t at = found++;
        for (; at > 0 && has_smaller_code(&p, &mean[at - 1]); at--)
            mean[at] = mean[at - 1];
        mean[at] = p;
    }
    return found;
}

static enum mr_status set_channel_table(const struct calibrate_point *point, size_t count,
                                        struct mr_channel_config *channel, struct error *error)
{
    struct calibrate_point mean[CALIBRATE_POINTS_MAX];
    size_t values = average_by_value(point, count, mean);
    if (values > MR_CONFIG_POINTS)
        return error_set(error, MR_LIMIT,
                         "too many points: the calibration has %zu, but a table holds only %u; "
                         "leave some out, or use the straight line",
                         values, MR_CONFIG_POINTS);
    bool falls = channel->unit_per_code < 0.0f; /* the value rises while the codes fall */
    channel->points = (uint8_t)values;
    for (size_t i = 0; i < values; i++) {
        const struct calibrate_point *p = &mean[falls ? values - 1 - i : i];
        channel->point_reading[i] = ((float)p->code - channel->zero_code) * channel->unit_per_code;
        channel->point_value[i] = (float)p->value;
        if (i && (channel->point_reading[i] <= channel->point_reading[i - 1] ||
                  channel->point_value[i] <= channel->point_value[i - 1]))
            return error_set(error, MR_NUMERICS,
                             "the readings do not rise with the known values near the value %g; "
                             "measure that point again",
                             p->value);
    }
    return MR_OK;
}

static void compute_residuals(const struct calibrate_point *point, size_t count,
                              const struct mr_channel_config *channel, struct calibrate_fit *fit)
{
    double squares = 0.0;
    fit->worst_residual = 0.0;
    for (size_t i = 0; i < count; i++) {
        float straight = ((float)point[i].code - channel->zero_code) * channel->unit_per_code;
        fit->residual[i] = (double)mr_channel_linearise(channel, straight) - point[i].value;
        squares += fit->residual[i] * fit->residual[i];
        if (fabs(fit->residual[i]) > fit->worst_residual) {
            fit->worst_residual = fabs(fit->residual[i]);
            fit->worst_point = i;
        }
    }
    fit->linearity_error = sqrt(squares / (double)(count - 2));
    /* Error of interpolation between the points of a table: estimated as a quarter of the distance
     * between a point and the chord of its neighbours. */
    double curve = 0.0;
    for (unsigned i = 1; i + 1 < channel->points; i++) {
        const float *x = channel->point_reading, *y = channel->point_value;
        float along = y[i - 1] + (y[i + 1] - y[i - 1]) * (x[i] - x[i - 1]) / (x[i + 1] - x[i - 1]);
        curve = fmax(curve, fabs((double)(y[i] - along)));
    }
    fit->linearity_error = hypot(fit->linearity_error, curve / 4.0);
    fit->max_deviation = fmax(fit->worst_residual, curve);
}

enum mr_status calibrate_fit(const struct calibrate_point *point, size_t count, double known_error,
                             bool table, struct mr_channel_config *channel,
                             struct calibrate_fit *fit, struct error *error)
{
    double x[CALIBRATE_POINTS_MAX], y[CALIBRATE_POINTS_MAX];
    struct line_fit line;
    memset(fit, 0, sizeof *fit);
    fit->low = (double)INFINITY;
    fit->high = -(double)INFINITY;
    if (count < 3 || count > CALIBRATE_POINTS_MAX)
        return error_set(error, MR_TOO_FEW,
                         "too few or too many points: the calibration has %zu; give 3 to %u points "
                         "at two or more different values",
                         count, CALIBRATE_POINTS_MAX);
    for (size_t i = 0; i < count; i++) {
        x[i] = point[i].code;
        y[i] = point[i].value;
        fit->low = fmin(fit->low, y[i]);
        fit->high = fmax(fit->high, y[i]);
    }
    if (fit->low == fit->high)
        return error_set(
            error, MR_TOO_FEW,
            "all points have the same known value, %g; give two or more different values",
            fit->low);
    enum mr_status status = line_fit(x, y, count, &line, error);
    if (status != MR_OK)
        return status;
    double span = fit->high - fit->low;
    if (!(fabs(line.slope.value) > SLOPE_MIN_STANDARD_ERRORS * line.slope.error))
        return error_set(error, MR_NUMERICS,
                         "the readings do not change with the known values; check the channel "
                         "number and the connection");
    fit->unit_per_code = line.slope.value;
    fit->zero_code = -line.intercept.value / line.slope.value;
    fit->gain_error = hypot(line.slope.error / fabs(line.slope.value), known_error / span);
    /* the error applies at the zero, or at the nearest known value if the zero is outside their
     * range */
    double at = fmin(fmax(0.0, fit->low), fit->high),
           at_code = fit->zero_code + at / fit->unit_per_code;
    double variance = line.intercept.error * line.intercept.error +
                      2.0 * at_code * line.covariance +
                      at_code * at_code * line.slope.error * line.slope.error;
    fit->zero_error = hypot(sqrt(fmax(variance, 0.0)), known_error);
    channel->unit_per_code = (float)fit->unit_per_code;
    channel->zero_code = (float)fit->zero_code;
    channel->points = 0;
    memset(channel->point_reading, 0, sizeof channel->point_reading);
    memset(channel->point_value, 0, sizeof channel->point_value);
    if (table)
        status = set_channel_table(point, count, channel, error);
    compute_residuals(point, count, channel, fit);
    channel->gain_error = (float)fit->gain_error;
    channel->zero_error = (float)fit->zero_error;
    channel->linearity_error = (float)fit->linearity_error;
    return status;
}

size_t calibrate_find_outlier(const struct calibrate_point *point, size_t count, bool table,
                              double most, const struct mr_channel_config *channel, double *miss)
{
    size_t best = count;
    double least = (double)INFINITY, second = (double)INFINITY;
    for (size_t i = 0; i < count; i++) {
        struct calibrate_point rest[CALIBRATE_POINTS_MAX];
        struct mr_channel_config trial = *channel;
        struct calibrate_fit fit;
        struct error none = {0};
        memcpy(rest, point, i * sizeof *rest);
        memcpy(rest + i, point + i + 1, (count - 1 - i) * sizeof *rest);
        if (calibrate_fit(rest, count - 1, 0.0, table, &trial, &fit, &none) != MR_OK)
            continue;
        second = fmin(second, fmax(fit.max_deviation, least));
        if (fit.max_deviation < least) {
            least = fit.max_deviation;
            best = i;
        }
    }
    *miss = least;
    return least <= most && 2.0 * least < second ? best : count;
}
