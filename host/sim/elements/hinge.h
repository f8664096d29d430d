/* Hinge: the moment between two mats that are turned against each other by d. README.md, "Joint
 * moment". Free up to TAD; beyond, `deadband` KT (d - TAD sgn d) + CT d', `switched` KT d + CT
 * d'. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_HINGE_H
#define MATRIG_HOST_SIM_ELEMENTS_HINGE_H

#include <math.h>
#include <stdbool.h>

#include "host/sim/elements/law.h"

/* Mode at turn d: the side of TAD that it is beyond, 0 within. */
LAW_INLINE signed char hinge_side(double turn_rad, double tad_rad)
{
    return turn_rad > tad_rad ? 1 : turn_rad < -tad_rad ? -1 : 0;
}

/* How far d is beyond what is free. */
LAW_INLINE double hinge_wound_rad(bool jumps, int side, double turn_rad, double tad_rad)
{
    if (!jumps)
        turn_rad -= tad_rad * side;
    return turn_rad;
}

/* Its slopes are KT and CT while it is engaged. */
LAW_INLINE double hinge_moment_lb_ft(double kt, double ct, double wound_rad, double rate_rad_s)
{
    return kt * wound_rad + ct * rate_rad_s;
}

LAW_INLINE double hinge_margin_rad(int side, double turn_rad, double tad_rad)
{
    return side ? side * turn_rad - tad_rad : tad_rad - fabs(turn_rad);
}

#endif
