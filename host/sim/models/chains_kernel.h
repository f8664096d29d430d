/* What chains.c does in a step, compiled once for each kind of processor: VARIANT(name) is the name
 * there. A vector operation is lowered for the processor that its own function is compiled for, so
 * that function clones, and inline functions shared by both, would all be lowered for the older. */

/* Where the mask is set `yes`, else `no`. */
INLINE lanes VARIANT(choose)(masks mask, lanes yes, lanes no)
{
    return CHOOSE(mask, yes, no);
}

/* Where the mask is set `yes`, else 0. */
INLINE lanes VARIANT(only)(masks mask, lanes yes)
{
    return (lanes)(mask & (masks)yes);
}

INLINE bool VARIANT(any)(const masks *mask)
{
    return ANY(*mask);
}

INLINE unsigned VARIANT(first_of)(unsigned bay)
{
    return (bay - 1u) * MR_CHAIN_BAY + 1u;
}

INLINE unsigned VARIANT(last_of)(const struct chains *c, unsigned bay)
{
    return bay == c->bays ? c->mats : bay * MR_CHAIN_BAY;
}

/* matchain.c's pull(): every branch, and the choice between them. Beyond its reach a joint is open
 * or hooked; short of it, dirt holds it, yields, or is not there any more. */
INLINE lanes VARIANT(pull)(const struct chains *c, unsigned j, lanes g_ft, lanes opening_ft_s,
                           lanes *reach_after_ft)
{
    const lanes none = {0};
    lanes reach_ft = c->reach_ft[j], grit_lb = c->grit_lb[j];
    lanes damper_lb = c->cl_lb_s_ft * opening_ft_s;
    masks beyond = g_ft >= reach_ft, dirty = reach_ft > none;
    lanes held_lb = c->kl_lb_ft * (g_ft - reach_ft);
    masks holds = dirty & (held_lb >= -grit_lb);
    lanes kept_lb = LESSER(GREATER(-grit_lb, held_lb + damper_lb), none);
    lanes yielded_ft = g_ft + c->give_ft[j];
    masks closes = dirty & (yielded_ft > none);
    lanes pressed_lb = VARIANT(only)(g_ft < none, c->kl_lb_ft * g_ft + damper_lb);
    lanes hooked_lb = VARIANT(only)(g_ft > c->slack_ft,
                                    c->kl_lb_ft * (g_ft - c->slack_ft) + damper_lb);
    *reach_after_ft =
        VARIANT(choose)(beyond, LESSER(c->slack_ft, g_ft),
                        VARIANT(choose)(holds, reach_ft, VARIANT(only)(closes, yielded_ft)));
    return VARIANT(choose)(
        beyond, hooked_lb,
        VARIANT(choose)(holds, kept_lb, VARIANT(choose)(closes, -grit_lb, pressed_lb)));
}

/* matchain.c's slip(). A mat at rest is rubbed against its push, else against its speed. */
INLINE lanes VARIANT(slip)(lanes v_ft_s, lanes x_lb, lanes friction_lb, lanes per_lb)
{
    const lanes none = {0}, one = none + 1.0f;
    const masks sign = (masks)none - 0x7fffffff - 1;
    masks rests = v_ft_s == none;
    masks pushes = (lanes)(~sign & (masks)x_lb) > friction_lb;
    lanes along = VARIANT(choose)(rests, x_lb, v_ft_s);
    lanes braking = x_lb - (lanes)((sign & (masks)along) | (masks)friction_lb);
    lanes after_ft_s = v_ft_s + braking * per_lb;
    masks goes_on = after_ft_s * v_ft_s > none;
    lanes moved_ft_s = VARIANT(only)((rests & pushes) | goes_on, after_ft_s);
    masks turns = pushes & ~(rests | goes_on);
    if (!VARIANT(any)(&turns))
        return moved_ft_s;
    lanes left = one + v_ft_s / (braking * per_lb);
    lanes back_lb = x_lb - (lanes)((sign & (masks)x_lb) | (masks)friction_lb);
    lanes thrown = VARIANT(only)(left > none, back_lb * per_lb * left);
    return VARIANT(choose)(turns, thrown, moved_ft_s);
}

INLINE lanes VARIANT(opening)(const struct chains *c, unsigned j)
{
    return c->gap_ft[j] + (c->u_ft[j] - c->u_ft[j - 1u]);
}

/* Tension of the bay's first joint in lanes where the bay on its left did not carry it. */
INLINE lanes VARIANT(first_pull)(struct chains *c, unsigned j, masks mask)
{
    lanes reach_ft;
    lanes pull_lb = VARIANT(pull)(c, j, VARIANT(opening)(c, j), c->v_ft_s[j] - c->v_ft_s[j - 1u],
                                  &reach_ft);
    c->reach_ft[j] = VARIANT(choose)(mask, reach_ft, c->reach_ft[j]);
    return pull_lb;
}

INLINE lanes VARIANT(step_bay)(struct chains *c, unsigned bay, lanes left_lb)
{
    const masks mask = c->awake[bay];
    unsigned first = VARIANT(first_of)(bay), last = VARIANT(last_of)(c, bay);
    lanes u_ft = c->u_ft[first], v_ft_s = c->v_ft_s[first];
    for (unsigned n = first; n <= last; n++) {
        lanes next_ft = c->u_ft[n + 1u], next_ft_s = c->v_ft_s[n + 1u], reach_ft;
        lanes right_lb = VARIANT(pull)(c, n + 1u, c->gap_ft[n + 1u] + (next_ft - u_ft),
                                       next_ft_s - v_ft_s, &reach_ft);
        lanes x_lb = right_lb - left_lb + c->push_lb[n];
        lanes after_ft_s = VARIANT(slip)(v_ft_s, x_lb, c->friction_lb, c->per_lb);
        c->reach_ft[n + 1u] = VARIANT(choose)(mask, reach_ft, c->reach_ft[n + 1u]);
        c->v_ft_s[n] = VARIANT(choose)(mask, after_ft_s, v_ft_s);
        c->u_ft[n] = VARIANT(choose)(mask, u_ft + c->step_s * after_ft_s, u_ft);
        left_lb = right_lb;
        u_ft = next_ft;
        v_ft_s = next_ft_s;
    }
    return left_lb;
}

INLINE void VARIANT(stretch_to)(struct chains *c, unsigned bay)
{
    c->low = bay < c->low ? bay : c->low;
    c->high = bay > c->high ? bay : c->high;
}

/* The wheels' bays are awake from this step on. */
INLINE void VARIANT(press)(struct chains *c, const unsigned *mat, const float *thrust_lb, bool on)
{
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        if (!(thrust_lb[k] < 0.0f || thrust_lb[k] > 0.0f) || mat[k] < 1 || mat[k] > c->mats)
            continue;
        unsigned bay = (mat[k] - 1u) / MR_CHAIN_BAY + 1u;
        c->push_lb[mat[k]][k] = on ? thrust_lb[k] : 0.0f;
        if (on) {
            c->awake[bay][k] = -1;
            VARIANT(stretch_to)(c, bay);
        }
    }
}

INLINE void VARIANT(wake)(struct chains *c, unsigned bay, masks mask)
{
    if (bay < 1u || bay > c->bays || !VARIANT(any)(&mask))
        return;
    c->awake[bay] |= mask;
    VARIANT(stretch_to)(c, bay);
}

/* Bays beside one whose outermost mat moves wake in that lane. */
INLINE void VARIANT(wake_beside)(struct chains *c)
{
    const lanes none = {0};
    for (unsigned bay = c->low, high = c->high; bay <= high; bay++) {
        masks awake = c->awake[bay];
        if (!VARIANT(any)(&awake))
            continue;
        VARIANT(wake)(c, bay - 1u, awake & (c->v_ft_s[VARIANT(first_of)(bay)] != none));
        VARIANT(wake)(c, bay + 1u, awake & (c->v_ft_s[VARIANT(last_of)(c, bay)] != none));
    }
}

static void VARIANT(step)(struct chains *c, const unsigned mat[CHAINS_LANES],
                          const float thrust_lb[CHAINS_LANES])
{
    lanes left_lb = {0};
    masks carried = {0};
    VARIANT(press)(c, mat, thrust_lb, true);
    for (unsigned bay = c->low; bay <= c->high; bay++) {
        masks fresh = c->awake[bay] & ~carried;
        if (VARIANT(any)(&c->awake[bay])) {
            if (VARIANT(any)(&fresh))
                left_lb = VARIANT(choose)(
                    fresh, VARIANT(first_pull)(c, VARIANT(first_of)(bay), fresh), left_lb);
            left_lb = VARIANT(step_bay)(c, bay, left_lb);
        }
        carried = c->awake[bay];
    }
    VARIANT(press)(c, mat, thrust_lb, false);
    VARIANT(wake_beside)(c);
}

static unsigned VARIANT(settle)(struct chains *c)
{
    const lanes none = {0}, far = none + MR_CHAIN_RUNAWAY_FT, fast = none + MR_CHAIN_RUNAWAY_FT_S;
    unsigned low = c->low, high = c->high, runaway = 0;
    c->low = MR_CHAIN_BAYS + 1u;
    c->high = 0;
    for (unsigned bay = low; bay <= high; bay++) {
        unsigned first = VARIANT(first_of)(bay), last = VARIANT(last_of)(c, bay);
        if (!VARIANT(any)(&c->awake[bay]))
            continue;
        masks moves = (c->v_ft_s[first - 1u] != none) | (c->v_ft_s[last + 1u] != none);
        for (unsigned n = first; n <= last; n++) {
            lanes u_ft = c->u_ft[n], v_ft_s = c->v_ft_s[n];
            moves |= v_ft_s != none;
            c->runaway |= c->awake[bay] &
                          ~((u_ft < far) & (u_ft > -far) & (v_ft_s < fast) & (v_ft_s > -fast));
        }
        c->awake[bay] &= moves;
        if (VARIANT(any)(&c->awake[bay]))
            VARIANT(stretch_to)(c, bay);
    }
    for (unsigned k = 0; k < CHAINS_LANES; k++)
        runaway |= c->runaway[k] ? 1u << k : 0u;
    return runaway;
}
