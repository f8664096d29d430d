/* A simulation's result as `matrig sim` answers with it. */
#ifndef MATRIG_HOST_SIM_ANSWER_H
#define MATRIG_HOST_SIM_ANSWER_H

#include "host/base/answer.h"
#include "host/sim/sim.h"
#include "host/sim/elements/mods.h"

/* The mats that a scene asks for (u_mats, else all): how many, and the i-th of them, from 1. */
size_t sim_shown_count(const struct sim_scene *scene);
int sim_shown_mat(const struct sim_scene *scene, size_t i);

/* A new answer, whatever the status; the caller frees. For programs lengths in ft, times in s,
 * forces in lb, also with `si`. */
struct answer *sim_answer(const struct sim_scene *scene, const struct sim_result *result, bool si);

#endif
