/* The step of chains.c, compiled for each kind of processor (lanes_each.h). */
#include "host/sim/elements/lanes_kernel.h"

LANES_INLINE unsigned LANES(first_mat)(unsigned bay)
{
    return (bay - 1u) * MR_CHAIN_BAY_GROUPS + 1u;
}

LANES_INLINE unsigned LANES(last_mat)(const struct chains *c, unsigned bay)
{
    return bay == c->bays ? c->mats : bay * MR_CHAIN_BAY_GROUPS;
}

LANES_INLINE masks LANES(to_mask)(words set)
{
#if defined LANES_AVX512
    return _mm256_movepi32_mask((__m256i)set);
#else
    return set;
#endif
}

LANES_INLINE lanes LANES(opening)(const struct chains *c, unsigned j)
{
    return c->gap_ft[j] + (c->u_ft[j] - c->u_ft[j - 1u]);
}

/* Tension of joint j. Updates the reach of its grit in the lanes of the mask. */
LANES_INLINE lanes LANES(pull)(struct chains *c, unsigned j, lanes g_ft, lanes rate_ft_s,
                               masks mask)
{
    struct LANES(joint) joint = {c->kl_lb_ft, c->cl_lb_s_ft, c->slack_ft};
    struct LANES(pull) pull = LANES(joint_pull)(joint, c->grit_lb[j], c->grit_yield_ft[j],
                                                c->grit_extent_ft[j], g_ft, rate_ft_s);
    c->grit_extent_ft[j] = LANES(choose)(mask, pull.grit_extent_ft, c->grit_extent_ft[j]);
    return pull.lb;
}

/* Tension of the first joint of a bay, for lanes in which the bay to its left is at rest and has
 * not computed it. */
LANES_INLINE lanes LANES(first_pull)(struct chains *c, unsigned j, masks mask)
{
    return LANES(pull)(c, j, LANES(opening)(c, j), c->v_ft_s[j] - c->v_ft_s[j - 1u], mask);
}

LANES_INLINE lanes LANES(step_bay)(struct chains *c, unsigned bay, lanes left_lb)
{
    const masks mask = LANES(to_mask)(c->awake[bay]);
    unsigned first = LANES(first_mat)(bay), last = LANES(last_mat)(c, bay);
    lanes u_ft = c->u_ft[first], v_ft_s = c->v_ft_s[first];
    for (unsigned n = first; n <= last; n++) {
        lanes next_ft = c->u_ft[n + 1u], next_ft_s = c->v_ft_s[n + 1u];
        lanes right_lb = LANES(pull)(c, n + 1u, c->gap_ft[n + 1u] + (next_ft - u_ft),
                                     next_ft_s - v_ft_s, mask);
        lanes x_lb = right_lb - left_lb + c->push_lb[n];
        lanes after_ft_s = LANES(mat_slip)(v_ft_s, x_lb, c->friction_lb, c->step_per_mass).v_ft_s;
        c->v_ft_s[n] = LANES(choose)(mask, after_ft_s, v_ft_s);
        c->u_ft[n] = LANES(choose)(mask, u_ft + c->step_s * after_ft_s, u_ft);
        left_lb = right_lb;
        u_ft = next_ft;
        v_ft_s = next_ft_s;
    }
    return left_lb;
}

LANES_INLINE void LANES(include_bay)(struct chains *c, unsigned bay)
{
    c->awake_low = bay < c->awake_low ? bay : c->awake_low;
    c->awake_high = bay > c->awake_high ? bay : c->awake_high;
}

/* Applies the thrusts; bays under the wheels become active. */
LANES_INLINE void LANES(set_thrusts)(struct chains *c, const unsigned *mat, const float *thrust_lb,
                                     bool on)
{
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        if (!(thrust_lb[k] < 0.0f || thrust_lb[k] > 0.0f) || mat[k] < 1 || mat[k] > c->mats)
            continue;
        unsigned bay = (mat[k] - 1u) / MR_CHAIN_BAY_GROUPS + 1u;
        c->push_lb[mat[k]][k] = on ? thrust_lb[k] : 0.0f;
        if (on) {
            c->awake[bay][k] = -1;
            LANES(include_bay)(c, bay);
        }
    }
}

LANES_INLINE void LANES(wake)(struct chains *c, unsigned bay, words set)
{
    if (bay < 1u || bay > c->bays || !LANES(any)(LANES(to_mask)(set)))
        return;
    c->awake[bay] |= set;
    LANES(include_bay)(c, bay);
}

/* Activates, in each lane, the neighbour of a bay whose outermost mat moves. */
LANES_INLINE void LANES(wake_neighbour_bays)(struct chains *c)
{
    const lanes none = {0};
    for (unsigned bay = c->awake_low, high = c->awake_high; bay <= high; bay++) {
        words awake = c->awake[bay];
        if (!LANES(any)(LANES(to_mask)(awake)))
            continue;
        LANES(wake)(c, bay - 1u, awake & (c->v_ft_s[LANES(first_mat)(bay)] != none));
        LANES(wake)(c, bay + 1u, awake & (c->v_ft_s[LANES(last_mat)(c, bay)] != none));
    }
}

static void LANES(step)(struct chains *c, const unsigned mat[CHAINS_LANES],
                        const float thrust_lb[CHAINS_LANES])
{
    lanes left_lb = {0};
    masks carried = LANES(to_mask)((words){0});
    LANES(set_thrusts)(c, mat, thrust_lb, true);
    for (unsigned bay = c->awake_low; bay <= c->awake_high; bay++) {
        masks awake = LANES(to_mask)(c->awake[bay]), fresh = LAW_AND(awake, LAW_NOT(carried));
        if (LANES(any)(awake)) {
            if (LANES(any)(fresh))
                left_lb = LANES(choose)(fresh, LANES(first_pull)(c, LANES(first_mat)(bay), fresh),
                                        left_lb);
            left_lb = LANES(step_bay)(c, bay, left_lb);
        }
        carried = awake;
    }
    LANES(set_thrusts)(c, mat, thrust_lb, false);
    LANES(wake_neighbour_bays)(c);
}

static unsigned LANES(end_block)(struct chains *c)
{
    const lanes none = {0}, far = none + MR_CHAIN_RUNAWAY_FT, fast = none + MR_CHAIN_RUNAWAY_FT_S;
    unsigned low = c->awake_low, high = c->awake_high, runaway = 0;
    c->awake_low = MR_CHAIN_BAYS + 1u;
    c->awake_high = 0;
    for (unsigned bay = low; bay <= high; bay++) {
        unsigned first = LANES(first_mat)(bay), last = LANES(last_mat)(c, bay);
        if (!LANES(any)(LANES(to_mask)(c->awake[bay])))
            continue;
        words moves = (c->v_ft_s[first - 1u] != none) | (c->v_ft_s[last + 1u] != none);
        for (unsigned n = first; n <= last; n++) {
            lanes u_ft = c->u_ft[n], v_ft_s = c->v_ft_s[n];
            moves |= v_ft_s != none;
            c->diverged |= c->awake[bay] &
                           ~((u_ft < far) & (u_ft > -far) & (v_ft_s < fast) & (v_ft_s > -fast));
        }
        c->awake[bay] &= moves;
        if (LANES(any)(LANES(to_mask)(c->awake[bay])))
            LANES(include_bay)(c, bay);
    }
    for (unsigned k = 0; k < CHAINS_LANES; k++)
        runaway |= c->diverged[k] ? 1u << k : 0u;
    return runaway;
}
