/* Chain: the horizontal equations of a whole runway. By default, chain_event.h solves scenes
 * without modifications. The solver `staggered` in this file, with fixed steps and an error check,
 * solves scenes with modifications, and any scene for which a step, a single pass or this solver is
 * requested.
 *
 * Scheme: staggered (leapfrog). Speeds are computed at times half a step after the positions. Kicks
 * change the speeds, with the forces at the present openings and with the thrust, which is averaged
 * exactly over the kick. Friction is exact within the kick. The dampers of the joints use the
 * previous speeds, which are half a step old. The scheme is first order with CL above 0. Without CL
 * it is second order while nothing slips, opens or collides, and between first and second order
 * with friction and contacts.
 *
 * PLANAR.md, "Error estimate", describes how a run is checked. With options->is_single_pass there
 * is one pass, and only its energy is checked. Only the mats from the first to the last moving mat,
 * and one more on either side, are integrated. Because a mat at rest is moved only by its
 * neighbours, motion spreads at most one mat per step, and the results are the same as if all mats
 * were integrated. A pass ends early when all mats are at rest and the path has ended. */
#ifndef MATRIG_HOST_SIM_SOLVERS_CHAIN_H
#define MATRIG_HOST_SIM_SOLVERS_CHAIN_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* Runs a checked scene of model chain. MR_OK: the run ended, see result->status. MR_USAGE: the
 * number of steps is impossible. The caller frees the result in every case. */
enum mr_status chain_run(const struct sim_scene *scene, const struct sim_options *options,
                         struct sim_result *result, struct error *error);

#endif
