/* Landing: the consistent model over a whole landing, with a fixed step. README.md, "Chain and
 * landings".
 *
 * A landing has tens of thousands of switches (joints that close, mats that stop), so they are
 * sampled at each step instead of being located in time. The scheme is that of the chain (chain.h),
 * also for the heights. Speeds are computed half a step after the positions and are changed by
 * kicks of the forces at the present positions. Friction is exact within the kick. The dampers of
 * the joints use the previous speeds (half a step old), those of the soil the new speeds. The soil
 * may only push at the end of a step; its force is the normal force for a mat's friction
 * (friction_normal soil). The scheme is of second order while there is neither damping nor a
 * switch, otherwise of first order.
 *
 * Two ranges of mats are integrated; both follow the motion. The first part is the mats that slide,
 * and one mat at rest on either side. This is exact, because the motion spreads one mat per step;
 * mats that tilt with profile full or heave with soil friction count as sliding. The second part is
 * the mats that heave (move vertically), and four mats at rest at either end. The effect of the
 * omitted mats is below 1e-13 of L; sampled switches amplify it to about 2 % of the error estimate.
 * Flat mats do not heave, so a flat landing without a wheel load costs as much as the chain.
 *
 * On uneven ground (scene key `ground`) heights are relative to the ground under each node; mats
 * begin tilted, and sliding mats heave. There a node counts as at rest if it is slower than 1e-6 of
 * sqrt(g L); its height is not tested, because under compression a node can rest at another height
 * than its settled one. For limits from 1e-7 to 1e-5, the lifts in landings without a wave differ
 * by less than 1e-7 in.
 *
 * A step in which a node lands is divided into 16 parts for the heights. Two nodes that land in the
 * same step lift their neighbours differently from nodes that land one after the other. Only a step
 * shorter than the time between the two shows the difference. A joint with slack that closed in the
 * last step is damped only for the part of the step in which it was closed. With
 * options->is_single_pass neither correction is made.
 *
 * PLANAR.md, "Error estimate", describes how a run is checked. With options->is_single_pass there
 * is one march without a check (sim.h). */
#ifndef MATRIG_HOST_SIM_SOLVERS_LANDING_H
#define MATRIG_HOST_SIM_SOLVERS_LANDING_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* Runs a checked scene of model consistent. MR_OK: the run ended, see result->status. MR_USAGE:
 * friction is tanh or sign. The caller frees the result in every case. */
enum mr_status landing_run(const struct sim_scene *scene, const struct sim_options *options,
                           struct sim_result *result, struct error *error);

#endif
