/* Friction: Coulomb friction of a mat on the ground, limit C = f N. README.md, "Friction". Along
 * the runway, no moment.
 *
 * In continuous time (friction_rub_lb) a mat slides to one side or sticks. In a step of constant
 * force the law `stick` is exact (friction_speed_ft_s). What adds to the hold of the ground, as a
 * cleat does, adds to C. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_FRICTION_H
#define MATRIG_HOST_SIM_ELEMENTS_FRICTION_H

#include <math.h>
#include <stdbool.h>

#include "host/sim/elements/law.h"
#include "host/sim/scene/scene.h"

/* Share of C that acts against a speed. `slide`: way a mat slides, law stick; `smooth`: tanh of
 * speed over veps, law tanh. */
LAW_INLINE double friction_share(enum sim_friction law, double v_ft_s, int slide, double smooth)
{
    switch (law) {
    case SIM_STICK: return slide;
    case SIM_TANH: return smooth;
    case SIM_SIGN: return v_ft_s > 0.0 ? 1.0 : v_ft_s < 0.0 ? -1.0 : 0.0;
    case SIM_NONE: break;
    }
    return 0.0;
}

/* What C takes from the push on a mat that moves. */
LAW_INLINE double friction_rub_lb(enum sim_friction law, double c_lb, double v_ft_s, int slide,
                                  double smooth)
{
    switch (law) {
    case SIM_STICK: return slide * c_lb;
    case SIM_TANH: return c_lb * smooth;
    case SIM_SIGN: return v_ft_s == 0.0 ? 0.0 : copysign(c_lb, v_ft_s);
    case SIM_NONE: break;
    }
    return 0.0;
}

/* Slope of the force by speed. */
LAW_INLINE double friction_slope_lb_s_ft(enum sim_friction law, double c_lb, double share,
                                         double veps_ft_s)
{
    return law == SIM_TANH ? -c_lb * (1.0 - share * share) / veps_ft_s : 0.0;
}

/* How much more push a mat at rest takes before it slides. */
LAW_INLINE double friction_margin_lb(double c_lb, double push_lb)
{
    return c_lb - fabs(push_lb);
}

/* Steepest slope: of tanh, as stick and sign are not sloped. */
LAW_INLINE struct law_bound friction_bound(enum sim_friction law, double c_lb, double mass_slug,
                                           double veps_ft_s)
{
    return (struct law_bound){0.0, law == SIM_TANH ? c_lb / (mass_slug * veps_ft_s) : 0.0};
}

/* A mat over a step of constant force with law stick, for a loop over mats: nothing branches. */
struct friction_step {
    double after_ft_s; /* right unless it stops and is not held: friction_thrown_back_ft_s */
    bool stops, held;
};

LAW_INLINE struct friction_step friction_step(double v_ft_s, double x_lb, double c_lb,
                                              double per_lb)
{
    double brake_lb = x_lb - copysign(c_lb, v_ft_s == 0.0 ? x_lb : v_ft_s);
    double after_ft_s = v_ft_s + brake_lb * per_lb;
    bool rests = !(after_ft_s * v_ft_s > 0.0); /* or turns round */
    bool held = fabs(x_lb) <= c_lb;
    return (struct friction_step){(rests & held) ? 0.0 : after_ft_s, rests & (v_ft_s != 0.0), held};
}

/* Speed after h of a mat that a force beyond its Coulomb limit throws back: it stops on the way and
 * starts again. */
LAW_INLINE double friction_thrown_back_ft_s(double v_ft_s, double x_lb, double c_lb, double h_s,
                                            double mass_slug)
{
    double brake_lb = x_lb - copysign(c_lb, v_ft_s);
    double left_s = h_s + v_ft_s * mass_slug / brake_lb; /* brake and speed have opposite signs */
    return (x_lb - copysign(c_lb, x_lb)) * (left_s / mass_slug);
}

/* Speed after h of a mat at v under force x and Coulomb limit c: at rest it stays while |x| <= c;
 * one whose speed reaches 0 within h is tested again there. `stops` counts those. */
LAW_INLINE double friction_speed_ft_s(double v_ft_s, double x_lb, double c_lb, double h_s,
                                      double mass_slug, unsigned *stops)
{
    struct friction_step step = friction_step(v_ft_s, x_lb, c_lb, h_s / mass_slug);
    *stops += step.stops;
    return step.stops && !step.held ? friction_thrown_back_ft_s(v_ft_s, x_lb, c_lb, h_s, mass_slug)
                                    : step.after_ft_s;
}

#endif
