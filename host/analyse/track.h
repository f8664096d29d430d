/* Where the gear was at any time, from the gates alone, as well as the gates say.
 *
 * The fit of gates.h is a polynomial of low order: it gives speeds, but between the gates braking that changes strays from it by
 * more than its error. Here the station is a parabola whose deceleration wanders: x''' is white noise of intensity q, which the
 * gates themselves tell (restricted maximum likelihood); each gate is off by the switches' tolerance, touchdown and stop by
 * their own errors. The best linear unbiased estimate of the station under that model (universal kriging; a smoothing spline of
 * degree five) runs through the gates as far as they are exact, and its standard error grows between them as it must.
 * Before touchdown the speed is constant (report 2.4), back to the first edge; after the stop it rests. Pure. */
#ifndef MATRIG_HOST_ANALYSE_TRACK_H
#define MATRIG_HOST_ANALYSE_TRACK_H

#include "host/analyse/measured.h"

#define TRACK_POINTS (MR_GATES_MAX + 2u) /* gates, touchdown, stop */
#define TRACK_SIZE (TRACK_POINTS + 3u)   /* and the parabola */

struct track {
    bool known;
    double begin_s, stop_s; /* of what is known: first edge; at rest from there on */
    double touchdown_ft;
    struct mr_estimate touchdown_s, speed_ft_s;
    size_t points;
    double t_s[TRACK_POINTS], station_ft[TRACK_POINTS], error_ft[TRACK_POINTS];
    double q;               /* (ft/s3)^2 s */
    double inverse[TRACK_SIZE][TRACK_SIZE];
};

/* From a landing with a fit and three gates or more beyond touchdown; else it is not known. */
void track_make(const struct measured *measured, struct track *track);
/* Station of the lead wheel with its standard error; NaN where it is not known. */
struct mr_estimate track_at(const struct track *track, double t_s);

#endif
