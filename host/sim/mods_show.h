/* What matrig sim says about a scene's modifications. */
#ifndef MATRIG_HOST_SIM_MODS_SHOW_H
#define MATRIG_HOST_SIM_MODS_SHOW_H

#include <jansson.h>

#include "host/sim/elements/mods.h"

/* The state as scene keys would have it (band_T0, band_slipped, band_pulled, cleat_left, torn) and the extremes of the
 * run; NULL without modifications. */
json_t *sim_mods_json(const struct sim_scene *scene, const struct mods_state *state);

/* A few lines of text; nothing without modifications. */
void sim_mods_print(const struct sim_scene *scene, const struct mods_state *state, bool si);

#endif
