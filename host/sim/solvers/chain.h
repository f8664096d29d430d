/* Chain: the horizontal equations of a whole runway. chain_event.h solves a scene without
 * modifications, unless a step, a single pass or the solver `staggered` is requested. This file has
 * the fixed step that checks itself (solver `staggered`).
 *
 * Scheme: staggered (leapfrog). Speeds are computed at times half a step after the positions. Kicks
 * change the speeds, with the forces at the present openings and with the thrust, which is averaged
 * exactly over the kick. Friction is exact within the kick. The dampers of the joints act with the
 * speeds of the last half step, half a step late. The scheme is first order with CL above 0.
 * Without CL it is second order while nothing slips, opens or collides, and between first and
 * second order with friction and contacts.
 *
 * PLANAR.md, "Error estimate", describes how a run is checked. With options->is_single_pass there
 * is one pass, and only its energy is checked. Only the mats between the outermost mats that are
 * awake, and one more on either side, are integrated. A mat at rest is moved only by its
 * neighbours, so the motion spreads at most one mat per step, and the results are those of
 * integrating all mats. A pass ends early when its mats are at rest and the path is over. */
#ifndef MATRIG_HOST_SIM_SOLVERS_CHAIN_H
#define MATRIG_HOST_SIM_SOLVERS_CHAIN_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* Runs a checked scene of model chain. MR_OK: the run ended, see result->status. MR_USAGE: the
 * number of steps is impossible. The caller frees the result in every case. */
enum mr_status chain_run(const struct sim_scene *scene, const struct sim_options *options,
                         struct sim_result *result, struct error *error);

#endif
