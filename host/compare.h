/* Measured against simulated: one landing and the whole-runway chain driven by its own motion and survey. */
#ifndef MATRIG_HOST_COMPARE_H
#define MATRIG_HOST_COMPARE_H

#include "host/analyse/zones.h"
#include "host/sim/sim.h"

#define COMPARE_AIRCRAFT_LB 1300.0 /* model aircraft as landed (report 2.3: 1220 to 1500) */
#define COMPARE_STRIPS 12.0        /* the chain is a strip 12/7 ft wide; it carries a twelfth of the thrust */
#define COMPARE_PATH_STEP_S 0.02
#define COMPARE_SAMPLE_S 0.002

struct comparison {
    struct store_simulation row[MR_TRANSDUCERS]; /* per transducer that is fitted */
    size_t count;
    double run_ms;    /* of the simulation */
    double error_in;  /* its own estimate */
    size_t surveyed;  /* segments whose slack was known */
    char *scene_json; /* what was simulated, for the record */
};

/* Puts the run's motion (path) and survey (gap0) into a scene that holds everything else. MR_TOO_FEW: the
 * motion is not known. Path: station of the fitted motion, thrust = (aircraft / strips) a / g. */
enum mr_status compare_scene(const struct measured *measured, const struct zones_closure *survey,
                             struct sim_scene *scene, struct error *error);

/* Runs the scene and compares. The caller frees with compare_free, also after an error. */
enum mr_status compare_run(const struct measured *measured, const struct sim_scene *scene,
                           struct comparison *comparison, struct error *error);
void compare_free(struct comparison *comparison);

#endif
