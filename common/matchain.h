/* The runway's mats as a chain, small and quick enough for the board: horizontal movement u of each
 * mat, joints with slack that close against a resistance, dry friction, the thrust of the braking
 * axle. What host/sim's chain model computes in double precision (host/sim/README.md, MODEL of the
 * report's A-2 with slack), here in single precision with one fixed order of operations, no library
 * calls and no contraction: board and host agree bit for bit.
 *
 * Mats 1..mats from the upfield end, joint j between mats j-1 and j; joints 1 and mats+1 join the
 * ground. Feet, pounds, seconds; downfield positive. A joint is open by g = gap +
 * u_j - u_(j-1); what it pulls: host/sim/README.md, "Joint force" and "Chain and landings".
 * A mat at rest stays while |X| <= friction, X the force without friction; one that would turn
 * round within a step stops.
 *
 * Levels. `group` mats are taken as one (1, 2 or 4): mass and friction of all, kl / group, gaps and
 * slack of the joints inside added to its left joint's; its resistance is the mean of theirs unless
 * the caller sets another. The step grows with the group, for the stability limit does.
 *
 * Windows. The mats lie in bays of MR_CHAIN_BAY. A bay is computed from the step on in which the
 * wheel pushes one of its mats or the mat beside it moves, until a block in which neither its mats
 * nor those beside it have moved. */
#ifndef MATRIG_COMMON_MATCHAIN_H
#define MATRIG_COMMON_MATCHAIN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

#define MR_CHAIN_MATS         512u
#define MR_CHAIN_PLACES       (MR_CHAIN_MATS + 2u)
#define MR_CHAIN_BAY          8u
#define MR_CHAIN_BAYS         (MR_CHAIN_MATS / MR_CHAIN_BAY)
#define MR_CHAIN_RUNAWAY_FT   1.0f /* no mat of the report moved by a foot: something is wrong */
#define MR_CHAIN_RUNAWAY_FT_S 100.0f
#define MR_CHAIN_STEP_MARGIN  0.9f /* of the stability limit */

struct mr_chain_params {
    uint16_t mats; /* 1..MR_CHAIN_MATS */
    float mat_length_ft;
    float mass_slug;   /* of one mat (strip) */
    float friction_lb; /* f times its weight */
    float kl_lb_ft;    /* joint stiffness */
    float cl_lb_s_ft;  /* joint damping */
    float slack_ft;    /* free play of a joint */
    /* of level 1: below mr_chain_step_limit_s; the group's step is `group` times that */
    float step_s;
};

struct mr_chain {
    struct mr_chain_params params;
    unsigned group; /* mats in one */
    unsigned count; /* of such */
    /* bays low..high are those awake, and some between; low > high: none */
    unsigned bays, low, high;
    /* by bay, from 1; bay b has mats (b - 1) MR_CHAIN_BAY + 1 and on */
    bool awake[MR_CHAIN_BAYS + 2u];
    float mass_slug, friction_lb, kl_lb_ft, slack_ft, step_s; /* of a group */
    float per_lb;                                             /* step over mass */
    float u_ft[MR_CHAIN_PLACES]; /* by group, from 1; 0 and count + 1 are the ground */
    float v_ft_s[MR_CHAIN_PLACES];
    float gap_ft[MR_CHAIN_PLACES]; /* opening of joint j at u = 0 */
    float reach_ft[MR_CHAIN_PLACES];
    float grit_lb[MR_CHAIN_PLACES];
    float push_lb[MR_CHAIN_PLACES]; /* from outside, on each group */
    uint32_t updates;               /* mats computed since the last mr_chain_take_updates */
    bool runaway;                   /* a guard has tripped: nothing here is to be believed */
};

/* Largest stable step of a chain of single mats: 4 / (d + sqrt(d^2 + 4 w^2)), w^2 = 4 kl / m, d = 4
 * cl / m (symplectic Euler). */
float mr_chain_step_limit_s(const struct mr_chain_params *params);

/* At rest, with these openings and closing resistances of joints 1..mats+1 (index 0 is joint 1);
 * NaN in either: slack / 2, none; no list of resistances (NULL): none at all. MR_OK; MR_USAGE: a
 * parameter that makes no sense; MR_NUMERICS: the step is beyond the stability limit. */
enum mr_status mr_chain_start(struct mr_chain *chain, const struct mr_chain_params *params,
                              unsigned group, const float *gap_ft, const float *grit_lb);

/* One step with `thrust_lb` on the mat (1..mats) under the wheel; 0: none. */
void mr_chain_step(struct mr_chain *chain, unsigned mat, float thrust_lb);
/* From now on a force (0: none) on the mat, besides the thrust: what corrects the chain towards a
 * reading. */
void mr_chain_push(struct mr_chain *chain, unsigned mat, float push_lb);
/* After the steps of a block: bays at rest go to sleep, guards look. False: it has run away. */
bool mr_chain_settle(struct mr_chain *chain);

/* Opening of joint j (of groups), feet. */
static inline float mr_chain_opening_ft(const struct mr_chain *chain, unsigned joint)
{
    return chain->gap_ft[joint] + (chain->u_ft[joint] - chain->u_ft[joint - 1u]);
}
/* Compression of joint j (of groups) at rest in its present opening, lb; 0: none. */
static inline float mr_chain_compression_lb(const struct mr_chain *chain, unsigned joint)
{
    float reach_ft = chain->reach_ft[joint],
          press_ft = (reach_ft > 0.0f ? reach_ft : 0.0f) - mr_chain_opening_ft(chain, joint);
    if (!(press_ft > 0.0f))
        return 0.0f;
    float press_lb = chain->kl_lb_ft * press_ft;
    return reach_ft > 0.0f && press_lb > chain->grit_lb[joint] ? chain->grit_lb[joint] : press_lb;
}
/* Displacement of a mat (1..mats), feet. */
float mr_chain_displacement_ft(const struct mr_chain *chain, unsigned mat);
uint32_t mr_chain_take_updates(struct mr_chain *chain);

#endif
