/* The scene that a landing is simulated with: its own motion (path) and survey (gaps), the rest of
 * a scene that is given. */
#ifndef MATRIG_HOST_COMPARE_SCENE_H
#define MATRIG_HOST_COMPARE_SCENE_H

#include "host/analyse/zones.h"
#include "host/sim/scene/scene.h"

#define COMPARE_AIRCRAFT_LB 1300.0 /* model aircraft as landed (report 2.3: 1220 to 1500) */
/* the chain is a strip 12/7 ft wide; it carries a twelfth of the thrust */
#define COMPARE_STRIPS      12.0
#define COMPARE_PATH_STEP_S 0.02

/* Puts the run's motion (path) and survey (gap0) into a scene that holds everything else.
 * MR_TOO_FEW: the motion is not known; MR_TRUNCATED: the record ends before the stop. Path: station
 * of the fitted motion, thrust = (aircraft / strips) a / g. */
enum mr_status compare_scene(const struct measured *measured, const struct zones_closure *survey,
                             struct sim_scene *scene, struct error *error);
/* The scene's mats and runway are the rig's; else MR_USAGE, with what makes them so. `where` begins
 * the error. */
enum mr_status compare_scale(const struct sim_scene *scene, const char *where, struct error *error);

#endif
