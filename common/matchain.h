/* The runway's mats as a chain, small and fast enough for the board: horizontal movement u of each
 * mat, joints with slack that close against a resistance, dry friction, and the thrust of the
 * braking axle. It is the chain model of host/sim (host/sim/README.md) in single precision: model
 * A-2 of the report with slack added. The order of operations is fixed, without library calls and
 * fused multiply-add, so that board and host agree bit for bit.
 *
 * Mats are numbered 1..mats from the upfield end. Joint j is between mats j-1 and j; joints 1 and
 * mats+1 connect to the ground. Units are feet, pounds and seconds; downfield is positive. The
 * opening of a joint is g = gap + u_j - u_(j-1); for its tension see host/sim/README.md, "Joint
 * force" and "Chain and landings". A mat at rest stays at rest while |X| <= friction, where X is
 * the force without friction. A mat whose speed would change sign within a step stops.
 *
 * Levels: `group` mats (1, 2 or 4) move as one body with their total mass and friction; the
 * stiffness of the joint between groups is kl / group. Gaps and slack of the inner joints are added
 * to those of the left joint. The resistance of a joint between groups is the mean over its joints
 * unless the caller sets a different one. The time step is proportional to `group`, as is the
 * stability limit.
 *
 * Bays: the chain is divided into bays of MR_CHAIN_BAY_GROUPS mats, and only active (awake) bays
 * are computed. A bay becomes active in the step in which the wheel pushes one of its mats or an
 * adjacent mat moves, and inactive after a block in which neither its mats nor the adjacent mats
 * have moved. */
#ifndef MATRIG_COMMON_MATCHAIN_H
#define MATRIG_COMMON_MATCHAIN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

#define MR_CHAIN_MATS         512u
#define MR_CHAIN_INDICES      (MR_CHAIN_MATS + 2u)
#define MR_CHAIN_BAY_GROUPS   8u
#define MR_CHAIN_BAYS         (MR_CHAIN_MATS / MR_CHAIN_BAY_GROUPS)
/* largest plausible movement; in the report no mat moved by a foot */
#define MR_CHAIN_RUNAWAY_FT   1.0f
#define MR_CHAIN_RUNAWAY_FT_S 100.0f
#define MR_CHAIN_STEP_MARGIN  0.9f /* recommended time step / stability limit */

struct mr_chain_params {
    uint16_t mats; /* 1..MR_CHAIN_MATS */
    float mat_length_ft;
    float mass_slug;   /* mass of one mat (strip) */
    float friction_lb; /* friction coefficient f times the weight of a mat */
    float kl_lb_ft;    /* joint stiffness */
    float cl_lb_s_ft;  /* joint damping */
    float slack_ft;    /* free play of a joint */
    /* time step of a chain of single mats, below mr_chain_step_limit_s; for groups,
     * `mats_per_group` times this */
    float step_s;
};

struct mr_chain {
    struct mr_chain_params params;
    unsigned mats_per_group; /* number of mats per group */
    unsigned group_count;    /* number of groups */
    /* bays low..high contain all awake bays; low > high: none is awake */
    unsigned bay_count, low_bay, high_bay;
    /* is_awake[b]: bay b, from 1, is computed; it holds mats (b - 1) MR_CHAIN_BAY_GROUPS + 1 to b
     * MR_CHAIN_BAY_GROUPS */
    bool is_awake[MR_CHAIN_BAYS + 2u];
    float mass_slug, friction_lb, kl_lb_ft, slack_ft, step_s; /* values of one group of mats */
    float step_per_mass;                                      /* step divided by mass */
    float u_ft[MR_CHAIN_INDICES]; /* index: group from 1; 0 and group_count + 1 are the ground */
    float v_ft_s[MR_CHAIN_INDICES];
    float gap_ft[MR_CHAIN_INDICES]; /* opening of joint j at u = 0 */
    float grit_extent_ft[MR_CHAIN_INDICES];
    float grit_lb[MR_CHAIN_INDICES];
    float push_lb[MR_CHAIN_INDICES]; /* permanent force on each group, in addition to the thrust */
    uint32_t updates;  /* number of mat updates computed since the last mr_chain_reset_updates */
    bool has_diverged; /* a check failed (mr_chain_end_block), so the state is invalid */
};

/* Largest stable step of a chain of single mats: 4 / (d + sqrt(d^2 + 4 w^2)), w^2 = 4 kl / m, d = 4
 * cl / m (symplectic Euler). */
float mr_chain_step_limit_s(const struct mr_chain_params *params);

/* Starts the chain at rest with the given openings and closing resistances of joints 1..mats+1
 * (index 0 is joint 1). A NaN opening means slack / 2; a NaN resistance, or NULL for the list,
 * means no resistance. MR_USAGE: an impossible parameter; MR_NUMERICS: the step is beyond the
 * stability limit. */
enum mr_status mr_chain_start(struct mr_chain *chain, const struct mr_chain_params *params,
                              unsigned group, const float *gap_ft, const float *grit_lb);

/* Computes one step with `thrust_lb` on the mat (1..mats) under the wheel; mat 0: no thrust. */
void mr_chain_step(struct mr_chain *chain, unsigned mat, float thrust_lb);
/* Sets a permanent force on a mat in addition to the thrust (0: none), by which the predictor
 * corrects the chain towards a transducer's reading. */
void mr_chain_set_force(struct mr_chain *chain, unsigned mat, float push_lb);
/* Call after the steps of a block: deactivates bays at rest and checks the state. Returns false if
 * the state is invalid: a movement is not finite or exceeds MR_CHAIN_RUNAWAY_FT. */
bool mr_chain_end_block(struct mr_chain *chain);

/* Opening of a joint between groups, feet. */
static inline float mr_chain_opening_ft(const struct mr_chain *chain, unsigned joint)
{
    return chain->gap_ft[joint] + (chain->u_ft[joint] - chain->u_ft[joint - 1u]);
}
/* Static compression of a joint between groups at its present opening, lb; 0: none. */
static inline float mr_chain_compression_lb(const struct mr_chain *chain, unsigned joint)
{
    float grit_extent_ft = chain->grit_extent_ft[joint],
          press_ft = (grit_extent_ft > 0.0f ? grit_extent_ft : 0.0f) -
                     mr_chain_opening_ft(chain, joint);
    if (!(press_ft > 0.0f))
        return 0.0f;
    float press_lb = chain->kl_lb_ft * press_ft;
    return grit_extent_ft > 0.0f && press_lb > chain->grit_lb[joint] ? chain->grit_lb[joint]
                                                                     : press_lb;
}
/* Displacement of a mat (1..mats), feet. */
float mr_chain_displacement_ft(const struct mr_chain *chain, unsigned mat);
uint32_t mr_chain_reset_updates(struct mr_chain *chain);

#endif
