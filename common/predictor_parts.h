/* What the parts of the predictor share: predictor.c (a block: chain, correction, search, budget),
 * predictor_joints.c (joints at rest and what they resist), predictor_zone.c (what is said). Nobody
 * else includes it. */
#ifndef MATRIG_COMMON_PREDICTOR_PARTS_H
#define MATRIG_COMMON_PREDICTOR_PARTS_H

#include "common/predictor.h"
#include "common/wire.h"

#define IN_PER_FT 12.0f
#define G_FT_S2   32.174f

static inline bool between(float x, float least, float most)
{
    return x >= least && x <= most;
}

static inline unsigned joints_of(const struct mr_predictor *p)
{
    return p->config.chain.mats + 1u;
}

static inline float thrust_lb(const struct mr_predictor *p)
{
    return p->config.thrust_lb_per_g * p->deceleration_ft_s2 / G_FT_S2;
}

/* Gaps of a runway that nobody has measured. */
void mr_predictor_lay(struct mr_predictor *p);
/* The joints become as the transducers alone would have them; as the chain has them. */
void mr_predictor_fold_kinematic(struct mr_predictor *p);
void mr_predictor_fold_chain(struct mr_predictor *p);
/* Closing resistances into the chain, after a start of it or a change of scale; those of groups
 * that move, every few blocks. */
void mr_predictor_set_grits(struct mr_predictor *p);
void mr_predictor_follow_grits(struct mr_predictor *p);

#endif
