/* The operations of chain.c on all mats and joints in a step. They process blocks of mats, one mat
 * per lane. Compiled for each kind of processor (lanes_each.h). */
#include "host/sim/elements/lanes_kernel.h"

typedef lanes LANES(stored) __attribute__((aligned(8), may_alias));
#define LOAD_LANES(at)         ((lanes) * (const LANES(stored) *)(at))
#define STORE_LANES(at, value) (*(LANES(stored) *)(at) = (LANES(stored))(value))
#define BLOCK_MATS             ((int)LANES_COUNT)

LANES_INLINE unsigned LANES(count_set)(masks set)
{
    unsigned sum = 0;
    for (int i = 0; i < BLOCK_MATS; i++)
        sum += LANES(is_set)(set, i);
    return sum;
}

/* Number of mats or joints in a block. The arrays have padding at both ends, so that every block is
 * complete. */
static int LANES(block)(void)
{
    return BLOCK_MATS;
}

/* Tensions of the block of joints that begins at j, from the present openings and speeds. Updates
 * the reach of grit. */
LANES_INLINE lanes LANES(pull)(const struct chain *chain, int j, enum joint_law law)
{
    lanes g_ft = LOAD_LANES(chain->gap0_ft + j) +
                 (LOAD_LANES(chain->u_ft + j) - LOAD_LANES(chain->u_ft + j - 1));
    lanes rate_ft_s = LOAD_LANES(chain->v_ft_s + j) - LOAD_LANES(chain->v_ft_s + j - 1);
    struct LANES(joint)
        joint = {LOAD_LANES(chain->kl_lb_ft + j), LAW_VALUE(chain->joint_constants.cl_lb_s_ft),
                 LAW_VALUE(chain->joint_constants.slack_ft)};
    if (law == JOINT_LINEAR)
        return joint.kl_lb_ft * g_ft + joint.cl_lb_s_ft * rate_ft_s;
    const lanes none = {0};
    bool gritty = law == JOINT_GRIT;
    struct LANES(pull) pull =
        LANES(joint_pull)(joint, gritty ? LOAD_LANES(chain->grit_lb + j) : none,
                          gritty ? LOAD_LANES(chain->grit_yield_ft + j) : none,
                          gritty ? LOAD_LANES(chain->grit_extent_ft + j) : none, g_ft, rate_ft_s);
    if (gritty)
        STORE_LANES(chain->grit_extent_ft + j, pull.grit_extent_ft);
    return pull.lb;
}

/* Stores the newest tensions. The last three of each joint are kept. */
LANES_INLINE void LANES(store_tension)(const struct chain *chain, int j, lanes tension_lb)
{
    STORE_LANES(chain->earlier_tension_lb + j, LOAD_LANES(chain->last_tension_lb + j));
    STORE_LANES(chain->last_tension_lb + j, LOAD_LANES(chain->tension_lb + j));
    STORE_LANES(chain->tension_lb + j, tension_lb);
}

LANES_INLINE void LANES(pull_blocks)(const struct chain *all, int first, int last,
                                     enum joint_law law)
{
    const struct chain copy = *all, *chain = &copy;
    for (int j = first; j <= last; j += BLOCK_MATS)
        LANES(store_tension)(chain, j, LANES(pull)(chain, j, law));
}

/* Speeds of the block of mats at n after a kick, from the speeds before it. */
LANES_INLINE struct LANES(slip)
    LANES(slip)(const struct chain *chain, int n, lanes v_ft_s, lanes step_per_mass)
{
    lanes pull_lb = LOAD_LANES(chain->tension_lb + n + 1) - LOAD_LANES(chain->tension_lb + n);
    struct LANES(slip) slip = LANES(mat_slip)(v_ft_s, pull_lb + LOAD_LANES(chain->thrust_lb + n),
                                              LOAD_LANES(chain->limit_lb + n), step_per_mass);
    STORE_LANES(chain->v_ft_s + n, slip.v_ft_s);
    return slip;
}

/* Returns a correction of the positions of mats that stopped or reversed in a kick, for the block
 * of mats at n. The positions are advanced with the speed in the middle of the step, which is right
 * under constant force but not for such mats. v: speed before the kick. The result is the distance
 * to add so that the following drift (update of the positions) over h ends at the right
 * position. */
LANES_INLINE lanes LANES(stop_correction_ft)(lanes v_ft_s, struct LANES(slip) slip, double kick_s,
                                             double h_s)
{
    const lanes none = {0}, half = LAW_VALUE(0.5), half_s = LAW_VALUE(0.5 * h_s);
    lanes left_s = slip.left * LAW_VALUE(kick_s), until_s = LAW_VALUE(kick_s) - left_s;
    lanes ahead_s = until_s - (LAW_VALUE(kick_s) - half_s), back_s = left_s - half_s;
    lanes stopping_distance_ft = LAW_IF_ELSE_ZERO(LAW_IS_GREATER(until_s, none),
                                                  half * v_ft_s * ahead_s * ahead_s / until_s) +
                                 LAW_IF_ELSE_ZERO(LAW_IS_GREATER(left_s, none),
                                                  half * slip.v_ft_s * back_s * back_s / left_s);
    return LAW_IF_ELSE_ZERO(slip.stops, stopping_distance_ft);
}

/* Updates the largest tensions of the block of joints at j, from their last three tensions. For
 * tensions that are large compared with those of other joints, the peak between steps is used: the
 * vertex of the parabola through the three values, if all have the same sign. */
LANES_INLINE void LANES(update_peak_tensions)(const struct chain *chain, int j, lanes first_lb,
                                              lanes middle_lb, lanes last_lb)
{
    lanes push_lb = LANES(max)(-last_lb, LOAD_LANES(chain->max_compression_lb + j));
    lanes pull_lb = LANES(max)(last_lb, LOAD_LANES(chain->max_tension_lb + j));
    masks large = LAW_IS_GREATER(LAW_ABS(middle_lb), LAW_VALUE(chain->half_max_tension_lb));
    if (LANES(any)(large)) {
        const lanes none = {0};
        lanes across_lb = last_lb - first_lb, up_lb = middle_lb - first_lb;
        lanes down_lb = middle_lb - last_lb;
        masks top = large & LAW_IS_GREATER(up_lb * middle_lb, none) &
                    LAW_IS_GREATER(down_lb * middle_lb, none) &
                    LAW_IS_GREATER(first_lb * middle_lb, none) &
                    LAW_IS_GREATER(last_lb * middle_lb, none);
        lanes most_lb = middle_lb + LAW_IF_ELSE_ZERO(top, across_lb * across_lb /
                                                              (LAW_VALUE(8) * (up_lb + down_lb)));
        push_lb = LANES(max)(-most_lb, push_lb);
        pull_lb = LANES(max)(most_lb, pull_lb);
    }
    STORE_LANES(chain->max_compression_lb + j, push_lb);
    STORE_LANES(chain->max_tension_lb + j, pull_lb);
}

/* Kick with friction law stick, for the mats of the blocks first..last, which may be at rest,
 * moving or stopping. Returns the number of mats that stopped. */
static unsigned LANES(kick_with_sticking)(const struct chain *all, double kick_s, double h_s,
                                          int first, int last)
{
    const struct chain copy = *all, *chain = &copy;
    lanes step_per_mass = LAW_VALUE(kick_s / chain->mass_slug);
    unsigned stops = 0;
    for (int n = first; n <= last; n += BLOCK_MATS) {
        if (chain->is_varied)
            step_per_mass = LAW_VALUE(kick_s) / LOAD_LANES(chain->mat_mass_slug + n);
        lanes v_ft_s = LOAD_LANES(chain->v_ft_s + n);
        STORE_LANES(chain->previous_v_ft_s + n, v_ft_s);
        struct LANES(slip) slip = LANES(slip)(chain, n, v_ft_s, step_per_mass);
        if (!LANES(any)(slip.stops))
            continue;
        stops += LANES(count_set)(slip.stops);
        if (!chain->gear)
            STORE_LANES(chain->u_ft + n, LOAD_LANES(chain->u_ft + n) +
                                             LANES(stop_correction_ft)(v_ft_s, slip, kick_s, h_s));
    }
    return stops;
}

/* Drift (update of the positions) of the blocks first..last. Also updates the largest tensions with
 * those of the previous kick. */
static void LANES(drift)(const struct chain *all, double h_s, int first, int last)
{
    const struct chain copy = *all, *chain = &copy;
    for (int n = first; n <= last; n += BLOCK_MATS) {
        STORE_LANES(chain->u_ft + n,
                    LOAD_LANES(chain->u_ft + n) + LAW_VALUE(h_s) * LOAD_LANES(chain->v_ft_s + n));
        LANES(update_peak_tensions)
        (chain, n, LOAD_LANES(chain->earlier_tension_lb + n),
         LOAD_LANES(chain->last_tension_lb + n), LOAD_LANES(chain->tension_lb + n));
    }
}

/* A whole step (kick over kick_s, drift over h_s) of mats first..last and their joints up to last +
 * 1. Only for scenes in which joints, thrust and sticking friction are the only forces. `first` is
 * the start of a block. */
LANES_INLINE unsigned LANES(step_range)(const struct chain *all, double kick_s, double h_s,
                                        int first, int last, enum joint_law law)
{
    /* a local copy, which tells the compiler that stores do not change the pointers */
    const struct chain copy = *all, *chain = &copy;
    lanes step_per_mass = LAW_VALUE(kick_s / chain->mass_slug);
    unsigned stops = 0;
    for (int j = first; j <= last + 1; j += BLOCK_MATS) {
        lanes before_lb = LOAD_LANES(chain->last_tension_lb + j),
              last_lb = LOAD_LANES(chain->tension_lb + j);
        lanes tension_lb = LANES(pull)(chain, j, law);
        LANES(update_peak_tensions)(chain, j, before_lb, last_lb, tension_lb);
        STORE_LANES(chain->last_tension_lb + j, last_lb);
        STORE_LANES(chain->tension_lb + j, tension_lb);
    }
    for (int n = first; n <= last; n += BLOCK_MATS) {
        lanes v_ft_s = LOAD_LANES(chain->v_ft_s + n), u_ft = LOAD_LANES(chain->u_ft + n);
        struct LANES(slip) slip = LANES(slip)(chain, n, v_ft_s, step_per_mass);
        if (LANES(any)(slip.stops)) {
            stops += LANES(count_set)(slip.stops);
            u_ft += LANES(stop_correction_ft)(v_ft_s, slip, kick_s, h_s);
        }
        STORE_LANES(chain->u_ft + n, u_ft + LAW_VALUE(h_s) * slip.v_ft_s);
    }
    return stops;
}

/* Calls a separate loop for each joint law. The compiler removes unused code from each loop. */
#define CALL_FOR_JOINT_LAW(chain, do, ...)                                      \
    ((chain)->joint_law == JOINT_LINEAR  ? do(chain, __VA_ARGS__, JOINT_LINEAR) \
     : (chain)->joint_law == JOINT_SLACK ? do(chain, __VA_ARGS__, JOINT_SLACK)  \
                                         : do(chain, __VA_ARGS__, JOINT_GRIT))

static unsigned LANES(step)(const struct chain *chain, double kick_s, double h_s, int first,
                            int last)
{
    return CALL_FOR_JOINT_LAW(chain, LANES(step_range), kick_s, h_s, first, last);
}

static void LANES(pull_joints)(const struct chain *chain, int first, int last)
{
    CALL_FOR_JOINT_LAW(chain, LANES(pull_blocks), first, last);
}
#undef CALL_FOR_JOINT_LAW
#undef LOAD_LANES
#undef STORE_LANES
#undef BLOCK_MATS
