#include "host/analyse/rig.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/xmalloc.h"

enum mr_status rig_predict_next_landing(const double *x, const double *y, size_t count, double at,
                                        bool squared, struct estimate *predicted,
                                        struct error *error)
{
    double *z = xcalloc(2 * count + 1, sizeof *z), *weight = z + count;
    struct line_fit line;
    /* constant errors of y give errors of y^2 that are proportional to y */
    for (size_t i = 0; i < count; i++) {
        z[i] = squared ? y[i] * y[i] : y[i];
        weight[i] = squared ? 1.0 / z[i] : 1.0;
    }
    enum mr_status status = line_fit_with_weights(x, z, weight, count, &line, error);
    free(z);
    if (status != MR_OK)
        return status;
    double value = line.intercept.value + line.slope.value * at;
    if (squared && !(value > 0.0))
        return error_set(
            error, MR_NUMERICS,
            "the gear would not reach touchdown from a release height of %g ft, according to %zu "
            "landings; give a height near the heights of these landings",
            at, count);
    *predicted = line_predict(&line, count, at, squared ? 1.0 / value : 1.0);
    if (squared) {
        predicted->value = sqrt(value);
        predicted->error /= 2.0 * predicted->value;
    }
    return MR_OK;
}

enum mr_status rig_measure_height(const struct rig_marks *marks, struct estimate distance_ft,
                                  struct estimate *height_ft, struct error *error)
{
    const double dx = marks->x[1] - marks->x[0], dy = marks->y[1] - marks->y[0],
                 px = marks->x[2] - marks->x[0], py = marks->y[2] - marks->y[0],
                 between = hypot(dx, dy), scale = distance_ft.value / between;
    if (!(between > 20.0 * marks->error && between > 0.0 && marks->error >= 0.0 &&
          isfinite(px + py)))
        return error_set(error, MR_USAGE,
                         "the scale of the picture is too uncertain: the points of known distance "
                         "are only %.3g pixels apart; mark three points, the first two at a "
                         "distance of more than 20 times the error of a mark",
                         between);
    /* y increases downwards in a picture */
    const double off = (dy * px - dx * py) / between * (dx < 0.0 ? -1.0 : 1.0),
                 along = (dx * px + dy * py) / (between * between);
    /* An error of one end of the line shifts it, at the point, in proportion to the distance of the
     * point from the other end. Only errors along the line change the scale, so shift and scale
     * errors are independent. */
    const double of_off = marks->error * sqrt(1.0 + along * along + (1.0 - along) * (1.0 - along)),
                 of_scale = hypot(distance_ft.error / distance_ft.value,
                                  M_SQRT2 * marks->error / between);
    *height_ft = (struct estimate){scale * off, scale * hypot(of_off, off * of_scale)};
    return MR_OK;
}
