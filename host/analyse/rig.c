#include "host/analyse/rig.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/xmalloc.h"

enum mr_status rig_touchdown_speed(const double *release_ft, const double *speed_ft_s, size_t count,
                                   double height_ft, struct estimate *predicted_ft_s,
                                   struct error *error)
{
    double *squared = xcalloc(2 * count + 1, sizeof *squared), *weight = squared + count;
    struct line_fit line;
    /* equal errors of v are errors of v^2 that are proportional to v */
    for (size_t i = 0; i < count; i++) {
        squared[i] = speed_ft_s[i] * speed_ft_s[i];
        weight[i] = 1.0 / squared[i];
    }
    enum mr_status status = line_fit_weighted(release_ft, squared, weight, count, &line, error);
    free(squared);
    if (status != MR_OK)
        return status;
    double v2 = line.intercept.value + line.slope.value * height_ft;
    if (!(v2 > 0.0))
        return error_set(error, MR_NUMERICS,
                         "the gear would not reach touchdown: release at %g ft, according to %zu "
                         "landings; give a height near those of the landings",
                         height_ft, count);
    *predicted_ft_s = line_predict(&line, count, height_ft, 1.0 / v2);
    predicted_ft_s->value = sqrt(v2);
    predicted_ft_s->error /= 2.0 * predicted_ft_s->value;
    return MR_OK;
}

enum mr_status rig_bearing_drag(const double *temperatures_f, const double *deceleration_ft_s2,
                                size_t count, double temperature_f,
                                struct estimate *predicted_ft_s2, struct error *error)
{
    struct line_fit line;
    if (line_fit(temperatures_f, deceleration_ft_s2, count, &line, error) == MR_OK)
        *predicted_ft_s2 = line_predict(&line, count, temperature_f, 1.0);
    return error->status;
}

enum mr_status rig_height(const struct rig_marks *marks, struct estimate distance_ft,
                          struct estimate *height_ft, struct error *error)
{
    const double dx = marks->x[1] - marks->x[0], dy = marks->y[1] - marks->y[0],
                 px = marks->x[2] - marks->x[0], py = marks->y[2] - marks->y[0],
                 between = hypot(dx, dy), scale = distance_ft.value / between;
    if (!(between > 20.0 * marks->error && between > 0.0 && marks->error >= 0.0 &&
          isfinite(px + py)))
        return error_set(error, MR_USAGE,
                         "no scale: the points of known distance are %.3g pixels apart; mark three "
                         "points, and these two more than 20 errors of a mark apart",
                         between);
    /* y increases downwards in a picture */
    const double off = (dy * px - dx * py) / between * (dx < 0.0 ? -1.0 : 1.0),
                 along = (dx * px + dy * py) / (between * between);
    /* An error of one end shifts the line at the point in proportion to the distance of the other
     * end. Only errors along the line change the scale, so shift and scale errors are
     * independent. */
    const double of_off = marks->error * sqrt(1.0 + along * along + (1.0 - along) * (1.0 - along)),
                 of_scale = hypot(distance_ft.error / distance_ft.value,
                                  M_SQRT2 * marks->error / between);
    *height_ft = (struct estimate){scale * off, scale * hypot(of_off, off * of_scale)};
    return MR_OK;
}
