/* Soil: what a foot of a mat at depth Y (down) stands on. README.md, "Report model" and "Consistent
 * model". In contact KV Y + CV Y', with slopes KV and CV, else nothing. The report's foot is in
 * contact from SOIL_TOUCH_FT above the ground on, and may be pulled; the consistent model's soil
 * only pushes. Fastest rate: that of a mat's end on KV and CV, from the linearised model
 * (model_fastest_rate), as the mass that a foot moves depends on the mats beside it. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_SOIL_H
#define MATRIG_HOST_SIM_ELEMENTS_SOIL_H

#include <math.h>
#include <stdbool.h>

#include "host/sim/elements/law.h"

#define SOIL_TOUCH_FT 1e-9 /* flat mats sit at 0 up to rounding: no lift below this */

LAW_INLINE double soil_lb(double kv, double cv, double y_ft, double rate_ft_s)
{
    return kv * y_ft + cv * rate_ft_s;
}

/* Positive where the soil acts. */
LAW_INLINE double soil_touch_ft(bool pushes_only, double kv, double cv, double y_ft,
                                double rate_ft_s)
{
    if (!pushes_only)
        return y_ft + SOIL_TOUCH_FT;
    return fmin(y_ft, y_ft + cv / kv * rate_ft_s);
}

LAW_INLINE double soil_margin_ft(bool contact, double touch_ft)
{
    return contact ? touch_ft : -touch_ft;
}

#endif
