/* What matrig sim answers about a scene's modifications. */
#ifndef MATRIG_HOST_SIM_MODS_ANSWER_H
#define MATRIG_HOST_SIM_MODS_ANSWER_H

#include "host/base/answer.h"
#include "host/sim/elements/mods.h"

/* "mods": for programs the state as scene keys would have it (band_T0, band_slipped, band_pulled,
 * cleat_left, torn) and each part's extremes of the run; for people the extremes of all. Nothing
 * without modifications (`state` NULL). */
void mods_answer(struct answer *answer, const struct sim_scene *scene,
                 const struct mods_state *state);

#endif
