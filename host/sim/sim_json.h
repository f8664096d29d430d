/* A simulation's result as `matrig sim --json` prints it. */
#ifndef MATRIG_HOST_SIM_JSON_H
#define MATRIG_HOST_SIM_JSON_H

#include <jansson.h>

#include "host/sim/sim.h"

/* The mats that a scene asks for (u_mats, else all): how many, and the i-th of them, from 1. */
size_t sim_shown_count(const struct sim_scene *scene);
int sim_shown_mat(const struct sim_scene *scene, size_t i);

/* A new object, whatever the status; the caller releases it. Lengths in ft, times in s. */
json_t *sim_result_json(const struct sim_scene *scene, const struct sim_result *result);

#endif
