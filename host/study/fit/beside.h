/* Beside: the landing of a scene on eight runways side by side (host/ensemble), which differ in
 * joints, friction, stiffness and the share of the thrust that comes to them.
 *
 * In single precision and one pass, as the board's chain: what is wrong with that is far less than
 * what unknown joints scatter. host/sim computes the same landing in double precision with a check
 * and takes ten times as long; tests/host/test_fit.c compares the two. */
#ifndef MATRIG_HOST_STUDY_FIT_BESIDE_H
#define MATRIG_HOST_STUDY_FIT_BESIDE_H

#include "host/ensemble/chains.h"
#include "host/sim/sim.h"

struct beside_lane {
    /* joints 0 .. mats; openings before the landing, then what it leaves, none below 0 */
    double *gap_ft;
    const double *grit_lb;
    double friction, kl_lb_ft;
    double thrust;       /* times the scene's */
    double *sample_u_ft; /* samples rows of stations */
    bool good;           /* out: it has not run away */
};

/* Whether that chain has all that the scene has: nothing but mats, slack, grit, dry friction under
 * their own weight, ends that are fixed, and a path whose thrust goes from mat to mat. */
bool beside_can(const struct sim_scene *scene);
/* Rows of samples, one every dt from 0 on. */
size_t beside_samples(const struct sim_scene *scene, double dt_s);
/* False: a parameter without sense. sample_dt_s is a whole number of milliseconds. */
bool beside_run(const struct sim_scene *scene, const double *station_ft, size_t stations,
                double sample_dt_s, struct beside_lane lane[CHAINS_LANES]);

#endif
