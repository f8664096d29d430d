/* Chains computed together: eight members of an ensemble of runways, one per lane of vector
 * instructions. Each is the chain of common/matchain.h with one mat per group; parameters,
 * joints and wheel are its own. Results are identical to that chain bit for bit, because each lane
 * performs the same operations in the same order, and a lane whose bay (group of mats) is at rest
 * is not changed. Only number and length of the mats and the time step are common to the eight
 * chains.
 *
 * Units are feet, pounds and seconds. chains_make allocates, chains_free releases. */
#ifndef MATRIG_HOST_SIM_MODELS_CHAINS_H
#define MATRIG_HOST_SIM_MODELS_CHAINS_H

#include "common/matchain.h"

#define CHAINS_LANES 8

struct chains;

/* Makes eight chains at rest. `params`: parameters of each lane; step and number of mats are those
 * of the first lane. gap_ft[lane] and grit_lb[lane] have mats + 1 values, as for mr_chain_start.
 * NULL: no memory, or parameters that mr_chain_start refuses (MR_USAGE, MR_NUMERICS in *status). */
struct chains *chains_make(const struct mr_chain_params params[CHAINS_LANES],
                           const float *const gap_ft[CHAINS_LANES],
                           const float *const grit_lb[CHAINS_LANES], enum mr_status *status);
void chains_free(struct chains *chains);

/* Computes one step with thrust_lb[lane] on the mat (1..mats) under each lane's wheel; 0: no
 * thrust. */
void chains_step(struct chains *chains, const unsigned mat[CHAINS_LANES],
                 const float thrust_lb[CHAINS_LANES]);
/* Call after the steps of a block, as mr_chain_end_block. Returns a bit mask of the lanes that have
 * diverged. */
unsigned chains_end_block(struct chains *chains);

/* Opening of a joint, 1 to mats + 1. */
float chains_opening_ft(const struct chains *chains, unsigned lane, unsigned joint);
float chains_displacement_ft(const struct chains *chains, unsigned lane, unsigned mat);
/* Returns the number of mats in bays that are computed in any lane, times eight lanes; the time of
 * a step is proportional to it. */
unsigned chains_active_mats(const struct chains *chains);

#endif
