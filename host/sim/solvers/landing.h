/* Landing: the consistent model over a whole landing, with a fixed step. README.md, "Chain and
 * landings".
 *
 * A landing has tens of thousands of switches (joints that close, mats that stop), so they are
 * sampled. Scheme: as the chain's (chain.h), heights alike: speeds half a step off the
 * positions, kicked by the forces at the present positions; friction exact within the kick; the
 * joints' dampers act on the last half step's speeds, the soil's on the next one's. The soil pushes
 * and never pulls at the end of a step, and what it pushes with in a step is what a mat on it rubs
 * with (friction_normal soil). Second order while nothing damps or switches, first order else.
 *
 * Two parts are integrated, each following the motion. Mats that slide, and one at rest on either
 * side: exact, as the motion spreads one mat per step; mats that tilt under profile full or heave
 * on soil friction count as sliding. Mats that heave, and four at rest at either end: what those
 * hold back is below 1e-13 of L, which sampled switches amplify to some 2 % of the error estimate.
 * Flat mats do not heave, so a flat landing without a wheel load costs what the chain costs.
 *
 * On uneven ground (scene key `ground`) heights are counted from the ground under each node; mats
 * begin tilted, and what slides heaves. There a node is at rest when it is slower than 1e-6 of
 * sqrt(g L), as under compression it rests off its settled height; between 1e-7 and 1e-5 the lifts
 * of landings without a wave differ by less than 1e-7 in.
 *
 * A step in which a node lands is divided in 16 for the heights: two nodes that land within one
 * step lift their neighbours otherwise together than one after the other, and no step longer than
 * what lies between them shows it. A joint with slack that closed in the last step is damped for
 * the share of it in which it was closed. With options->single neither is done.
 * How a run is checked: PLANAR.md, "Error estimate". With options->single one march
 * answers, unchecked (sim.h). */
#ifndef MATRIG_HOST_SIM_SOLVERS_LANDING_H
#define MATRIG_HOST_SIM_SOLVERS_LANDING_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* Run a checked scene of model consistent. MR_OK: look at result->status. MR_USAGE: friction tanh
 * or sign. The caller frees the result in every case. */
enum mr_status landing_run(const struct sim_scene *scene, const struct sim_options *options,
                           struct sim_result *result, struct error *error);

#endif
