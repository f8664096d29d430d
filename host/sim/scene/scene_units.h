/* Units of a scene's numbers: each key has its own in ft, lb, s, slug; a value may be written as
 * text with any unit of its kind (host/base/quantity.h): "ground_damping": "175 N s/m". */
#ifndef MATRIG_HOST_SIM_SCENE_SCENE_UNITS_H
#define MATRIG_HOST_SIM_SCENE_SCENE_UNITS_H

#include <stdbool.h>

#include "host/base/quantity.h"
#include "host/sim/scene/scene_keys.h"

/* A number, or text "NUMBER UNIT", in the key's unit. False: neither; text without a unit is none,
 * nor is text for a key that has none. */
bool sim_unit_read(const struct sim_key *key, const json_t *value, double *number,
                   struct quantity_wrong *wrong);

#endif
