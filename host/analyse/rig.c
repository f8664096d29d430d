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
    /* equal errors of v are errors of v^2 in proportion to v */
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
                         "the gear would not arrive: release at %g ft, by %zu landings; give a "
                         "height near those of the landings",
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
