/* Chain: the horizontal equations of a whole runway. A scene without modifications, for which no
 * step, no single pass and no solver `staggered` is asked, is chain_event.h's. Here: a fixed step
 * that checks itself (solver `staggered`).
 *
 * Scheme: staggered (leapfrog) - speeds half a step off the positions, kicked by the forces at the
 * present openings and the thrust averaged exactly over the kick; friction exact within the kick;
 * the joints' damper acts on the last half step's speeds, half a step late. First order with CL
 * above 0; without it second order while nothing slips, opens or hits, and between first and second
 * with friction and contacts.
 *
 * How a run is checked: PLANAR.md, "Error estimate". With options->single one pass
 * answers; only its energy is checked.
 * Only the mats between the outermost awake ones and one more on either side are integrated: a mat
 * at rest is moved by its neighbours only, so the motion spreads at most one mat per step and the
 * results are those of integrating all. A pass ends early when its mats are at rest and the path is
 * over. */
#ifndef MATRIG_HOST_SIM_SOLVERS_CHAIN_H
#define MATRIG_HOST_SIM_SOLVERS_CHAIN_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* Run a checked scene of model chain. MR_OK: look at result->status. MR_USAGE: an
 * impossible number of steps. The caller frees the result in every case. */
enum mr_status chain_run(const struct sim_scene *scene, const struct sim_options *options,
                         struct sim_result *result, struct error *error);

#endif
