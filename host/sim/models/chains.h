/* Chains side by side: eight members of an ensemble of runways in the lanes of vector instructions.
 * Each is the chain of common/matchain.h at group 1, with parameters, joints and wheel of its own,
 * and comes to the same bits as that: the same operations in the same order, lane by lane, and a
 * lane whose bay sleeps is not touched. Only mats, mats' length and step are common to the eight.
 *
 * Feet, pounds, seconds. One owner: chains_new allocates, chains_free releases. */
#ifndef MATRIG_HOST_SIM_MODELS_CHAINS_H
#define MATRIG_HOST_SIM_MODELS_CHAINS_H

#include "common/matchain.h"

#define CHAINS_LANES 8

struct chains;

/* At rest. `params` of each lane; the step and the number of mats are those of the first.
 * gap_ft[lane] and grit_lb[lane] have mats + 1 values, as mr_chain_start has them. NULL: out of
 * memory, or parameters that mr_chain_start refuses (MR_USAGE, MR_NUMERICS in *status). */
struct chains *chains_new(const struct mr_chain_params params[CHAINS_LANES],
                          const float *const gap_ft[CHAINS_LANES],
                          const float *const grit_lb[CHAINS_LANES], enum mr_status *status);
void chains_free(struct chains *chains);

/* One step with thrust_lb[lane] on the mat (1..mats) under each lane's wheel; 0: none. */
void chains_step(struct chains *chains, const unsigned mat[CHAINS_LANES],
                 const float thrust_lb[CHAINS_LANES]);
/* After the steps of a block, as mr_chain_settle. A bit for each lane that has run away. */
unsigned chains_settle(struct chains *chains);

/* Of joint 1..mats+1, and of mat 1..mats. */
float chains_opening_ft(const struct chains *chains, unsigned lane, unsigned joint);
float chains_displacement_ft(const struct chains *chains, unsigned lane, unsigned mat);
/* Bays awake in any lane, for what a step costs: mats times eight. */
unsigned chains_mats_awake(const struct chains *chains);

#endif
