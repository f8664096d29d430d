/* Slip: dry friction over one step of constant force, exactly. README.md, "Friction" (stick). */
#ifndef MATRIG_HOST_SIM_ELEMENTS_SLIP_H
#define MATRIG_HOST_SIM_ELEMENTS_SLIP_H

#include <math.h>

/* Speed after h of a mat that a force beyond its Coulomb limit throws back: it stops on the way and starts again. */
static inline double slip_thrown_back_ft_s(double v_ft_s, double x_lb, double c_lb, double h_s, double mass_slug)
{
    double brake_lb = x_lb - copysign(c_lb, v_ft_s);
    double left_s = h_s + v_ft_s * mass_slug / brake_lb; /* brake and speed have opposite signs */
    return (x_lb - copysign(c_lb, x_lb)) * (left_s / mass_slug);
}

/* Speed after h of a mat at v under force x and Coulomb limit c: at rest it stays while |x| <= c; one whose speed
 * reaches 0 within h is tested again there. `stops` counts those. */
static inline __attribute__((always_inline)) double slip_speed_ft_s(double v_ft_s, double x_lb, double c_lb, double h_s,
                                                                    double mass_slug, unsigned *stops)
{
    if (v_ft_s == 0.0)
        return fabs(x_lb) <= c_lb ? 0.0 : (x_lb - copysign(c_lb, x_lb)) * (h_s / mass_slug);
    double brake_lb = x_lb - copysign(c_lb, v_ft_s);
    double after_ft_s = v_ft_s + brake_lb * (h_s / mass_slug);
    if (after_ft_s * v_ft_s > 0.0)
        return after_ft_s;
    ++*stops;
    return fabs(x_lb) <= c_lb ? 0.0 : slip_thrown_back_ft_s(v_ft_s, x_lb, c_lb, h_s, mass_slug);
}

#endif
