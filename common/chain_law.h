/* Law of a chain of mats over one step: the tension of a joint, and the speed of a mat under
 * Coulomb friction. The code works for any number type. Include this file once per type, after
 * defining LAW(name) (the name of function `name` for this type), LAW_REAL, LAW_ABS(x) (fabs) and
 * LAW_COPYSIGN(size, sign) (copysign).
 *
 * For a scalar type only the case that applies is computed. For a vector type, every case is
 * computed and the result is selected; LAW_VECTOR and the macros below are then defined before the
 * inclusion (host/sim/elements/lanes.h). Operations and their order are the same, so the results
 * are identical in every bit. Units: feet, pounds, seconds. See host/sim/README.md, "Chain and
 * landings". */

#ifndef LAW_VECTOR
#define LAW_MASK                           bool
#define LAW_IS_GREATER(a, b)               ((a) > (b))
#define LAW_IS_AT_LEAST(a, b)              ((a) >= (b))
#define LAW_IS_EQUAL(a, b)                 ((a) == (b))
#define LAW_IF(mask, yes, no)              ((mask) ? (yes) : (no))
#define LAW_IF_ELSE_ZERO(mask, yes)        ((mask) ? (yes) : none)
#define LAW_SELECT(mask, yes, no)          ((mask) ? (yes) : (no))
#define LAW_AND(a, b)                      ((a) && (b))
#define LAW_OR(a, b)                       ((a) || (b))
#define LAW_NOT(a)                         (!(a))
/* returns whether the time after a stop must be computed */
#define LAW_NEEDS_REMAINDER(stops, pushes) ((stops) && (pushes))
/* returns `mask` for a scalar; false for a vector, whose lanes may differ */
#define LAW_IS_SCALAR_TRUE(mask)           (mask)
#define LAW_MIN(a, b)                      ((a) < (b) ? (a) : (b))
#define LAW_MAX(a, b)                      ((a) > (b) ? (a) : (b))
#define LAW_VALUE(x)                       ((LAW_REAL)(x))
#endif
#define LAW_FUNCTION static inline __attribute__((always_inline))

/* Constants of all joints. */
struct LAW(joint) {
    LAW_REAL kl_lb_ft, cl_lb_s_ft, slack_ft;
};

/* State of a joint after the step. */
struct LAW(pull) {
    LAW_REAL lb; /* tension; compression is negative */
    LAW_REAL
    grit_extent_ft; /* opening below which grit blocks the joint; 0: there is no grit left */
    bool kept;      /* grit_extent_ft is unchanged; only used for scalar types */
};

LAW_FUNCTION struct LAW(pull) LAW(pulled)(LAW_REAL lb, LAW_REAL grit_extent_ft)
{
    return (struct LAW(pull)){lb, grit_extent_ft, false};
}
LAW_FUNCTION struct LAW(pull) LAW(held)(LAW_REAL lb, LAW_REAL grit_extent_ft)
{
    return (struct LAW(pull)){lb, grit_extent_ft, true};
}
#ifdef LAW_VECTOR
LAW_FUNCTION struct LAW(pull) LAW(pick)(LAW_MASK mask, struct LAW(pull) yes, struct LAW(pull) no)
{
    return LAW(pulled)(LAW_IF(mask, yes.lb, no.lb),
                       LAW_IF(mask, yes.grit_extent_ft, no.grit_extent_ft));
}
#endif

/* Returns the tension of a joint with opening g_ft, which changes at rate_ft_s. Above
 * grit_extent_ft the joint is open or hooked. Below it, the grit (dirt between the mats) blocks the
 * joint or yields, or there is none. grit_yield_ft: grit_lb / kl_lb_ft. */
LAW_FUNCTION struct LAW(pull)
    LAW(joint_pull)(struct LAW(joint) joint, LAW_REAL grit_lb, LAW_REAL grit_yield_ft,
                    LAW_REAL grit_extent_ft, LAW_REAL g_ft, LAW_REAL rate_ft_s)
{
    const LAW_REAL none = LAW_VALUE(0);
    const LAW_REAL kl = joint.kl_lb_ft, cl = joint.cl_lb_s_ft, slack_ft = joint.slack_ft;
    LAW_REAL held_lb = kl * (g_ft - grit_extent_ft);
    LAW_REAL yielded_ft = g_ft + grit_yield_ft;
    LAW_MASK dirty = LAW_IS_GREATER(grit_extent_ft, none);
    return LAW_SELECT(
        LAW_IS_AT_LEAST(g_ft, grit_extent_ft),
        LAW(pulled)(LAW_IF_ELSE_ZERO(LAW_IS_GREATER(g_ft, slack_ft),
                                     kl * (g_ft - slack_ft) + cl * rate_ft_s),
                    LAW_MIN(slack_ft, g_ft)),
        LAW_SELECT(
            LAW_AND(dirty, LAW_IS_AT_LEAST(held_lb, -grit_lb)),
            LAW(held)(LAW_MIN(LAW_MAX(held_lb + cl * rate_ft_s, -grit_lb), none), grit_extent_ft),
            LAW_SELECT(LAW_AND(dirty, LAW_IS_GREATER(yielded_ft, none)),
                       LAW(pulled)(-grit_lb, yielded_ft),
                       LAW(pulled)(
                           LAW_IF_ELSE_ZERO(LAW_IS_GREATER(none, g_ft), kl * g_ft + cl * rate_ft_s),
                           none))));
}

/* Motion of a mat after a step. */
struct LAW(slip) {
    LAW_REAL v_ft_s;
    LAW_MASK stops; /* the mat moved before the step and came to rest in it */
    /* fraction of the step after the stop, for vector types; 0 without a stop */
    LAW_REAL left;
};

/* Returns the motion of a mat over a step under friction and the sum x of all other forces, which
 * is constant; step_per_mass: step / mass. A mat at rest stays at rest while |x| <= friction. A mat
 * that comes to rest within the step stays at rest if |x| <= friction; otherwise x accelerates it
 * for the remainder of the step. */
LAW_FUNCTION struct LAW(slip)
    LAW(mat_slip)(LAW_REAL v_ft_s, LAW_REAL x_lb, LAW_REAL friction_lb, LAW_REAL step_per_mass)
{
    const LAW_REAL none = LAW_VALUE(0);
    LAW_MASK rests = LAW_IS_EQUAL(v_ft_s, none);
    LAW_MASK pushes = LAW_IS_GREATER(LAW_ABS(x_lb), friction_lb);
    LAW_REAL braking_lb = x_lb - LAW_COPYSIGN(friction_lb, LAW_IF(rests, x_lb, v_ft_s));
    LAW_REAL after_ft_s = v_ft_s + braking_lb * step_per_mass;
    LAW_MASK goes_on = LAW_IS_GREATER(after_ft_s * v_ft_s, none);
    if (LAW_IS_SCALAR_TRUE(goes_on))
        return (struct LAW(slip)){after_ft_s, LAW_NOT(goes_on), none};
    LAW_REAL moved_ft_s = LAW_IF_ELSE_ZERO(LAW_OR(goes_on, pushes), after_ft_s);
    LAW_MASK stops = LAW_NOT(LAW_OR(rests, goes_on));
    if (!LAW_NEEDS_REMAINDER(stops, pushes))
        return (struct LAW(slip)){moved_ft_s, stops, none};
    LAW_REAL left = LAW_IF_ELSE_ZERO(stops, LAW_VALUE(1) + v_ft_s / (braking_lb * step_per_mass));
    LAW_REAL back_lb = x_lb - LAW_COPYSIGN(friction_lb, x_lb);
    LAW_REAL thrown_ft_s = LAW_IF_ELSE_ZERO(LAW_IS_GREATER(left, none),
                                            back_lb * step_per_mass * left);
    return (struct LAW(slip)){LAW_IF(LAW_AND(stops, pushes), thrown_ft_s, moved_ft_s), stops, left};
}

#undef LAW_FUNCTION
#ifndef LAW_VECTOR
#undef LAW
#undef LAW_REAL
#undef LAW_MASK
#undef LAW_VALUE
#undef LAW_IS_GREATER
#undef LAW_IS_AT_LEAST
#undef LAW_IS_EQUAL
#undef LAW_IF
#undef LAW_IF_ELSE_ZERO
#undef LAW_SELECT
#undef LAW_AND
#undef LAW_OR
#undef LAW_NOT
#undef LAW_NEEDS_REMAINDER
#undef LAW_IS_SCALAR_TRUE
#undef LAW_MIN
#undef LAW_MAX
#undef LAW_ABS
#undef LAW_COPYSIGN
#endif
