/* Units of a scene's numbers: each key has its own in ft, lb, s, slug; a value may be written as
 * text with that unit or its SI counterpart: "ground_damping": "175 N s/m". */
#ifndef MATRIG_HOST_SIM_SCENE_SCENE_UNITS_H
#define MATRIG_HOST_SIM_SCENE_SCENE_UNITS_H

#include <stdbool.h>

#include "host/sim/scene/scene_keys.h"

/* The SI counterpart of a key's unit, and what a value in the key's unit is multiplied by to have
 * it; NULL: none. */
const char *sim_unit_si(const char *unit, double *factor);

/* Read "NUMBER UNIT" into the key's unit. False: no such number or unit. */
bool sim_unit_read(const struct sim_key *key, const char *text, double *value);

#endif
