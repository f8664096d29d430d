/* Law of a chain of mats over one step: the tension of a joint, and the speed of a mat that Coulomb
 * friction holds. Written once, for every kind of number: include it once for each, with LAW(name)
 * (what a function `name` is called there), LAW_REAL, LAW_SIZE(x) (fabs) and LAW_SIGNED(size, sign)
 * (copysign).
 *
 * One number computes the case that holds. A vector (LAW_VECTOR and the macros below are defined
 * before: host/sim/elements/lanes.h) computes every case and picks. Operations, their order and so
 * the bits are the same. Feet, pounds, seconds; host/sim/README.md, "Chain and landings". */

#ifndef LAW_VECTOR
#define LAW_MASK                bool
#define LAW_ABOVE(a, b)         ((a) > (b))
#define LAW_REACHES(a, b)       ((a) >= (b))
#define LAW_EQUALS(a, b)        ((a) == (b))
#define LAW_IF(mask, yes, no)   ((mask) ? (yes) : (no))
#define LAW_ONLY(mask, yes)     ((mask) ? (yes) : none)
#define LAW_PICK(mask, yes, no) ((mask) ? (yes) : (no))
#define LAW_BOTH(a, b)          ((a) && (b))
#define LAW_EITHER(a, b)        ((a) || (b))
#define LAW_NOT(a)              (!(a))
#define LAW_LATE(stops, pushes) ((stops) && (pushes)) /* what happens after a stop matters */
#define LAW_ONE(mask)           (mask)                /* a vector is not looked at by itself */
#define LAW_LESSER(a, b)        ((a) < (b) ? (a) : (b))
#define LAW_GREATER(a, b)       ((a) > (b) ? (a) : (b))
#define LAW_VALUE(x)            ((LAW_REAL)(x))
#endif
#define LAW_FUNCTION static inline __attribute__((always_inline))

/* What all joints share. */
struct LAW(joint) {
    LAW_REAL kl_lb_ft, cl_lb_s_ft, slack_ft;
};

/* Of a joint, from now on. */
struct LAW(pull) {
    LAW_REAL lb;       /* tension; compression is negative */
    LAW_REAL reach_ft; /* opening at which its grit holds; 0: none is left in it */
    bool kept;         /* reach_ft is as before; one number only */
};

LAW_FUNCTION struct LAW(pull) LAW(pulled)(LAW_REAL lb, LAW_REAL reach_ft)
{
    return (struct LAW(pull)){lb, reach_ft, false};
}
LAW_FUNCTION struct LAW(pull) LAW(held)(LAW_REAL lb, LAW_REAL reach_ft)
{
    return (struct LAW(pull)){lb, reach_ft, true};
}
#ifdef LAW_VECTOR
LAW_FUNCTION struct LAW(pull) LAW(pick)(LAW_MASK mask, struct LAW(pull) yes, struct LAW(pull) no)
{
    return LAW(pulled)(LAW_IF(mask, yes.lb, no.lb), LAW_IF(mask, yes.reach_ft, no.reach_ft));
}
#endif

/* A joint that is open by g and opens at a rate. Beyond its reach it is open, or hooked; short of
 * it grit holds it, yields, or is not there. give_ft: grit_lb / kl_lb_ft. */
LAW_FUNCTION struct LAW(pull)
    LAW(joint_pull)(struct LAW(joint) joint, LAW_REAL grit_lb, LAW_REAL give_ft, LAW_REAL reach_ft,
                    LAW_REAL g_ft, LAW_REAL rate_ft_s)
{
    const LAW_REAL none = LAW_VALUE(0);
    const LAW_REAL kl = joint.kl_lb_ft, cl = joint.cl_lb_s_ft, slack_ft = joint.slack_ft;
    LAW_REAL held_lb = kl * (g_ft - reach_ft);
    LAW_REAL yielded_ft = g_ft + give_ft;
    LAW_MASK dirty = LAW_ABOVE(reach_ft, none);
    return LAW_PICK(
        LAW_REACHES(g_ft, reach_ft),
        LAW(pulled)(LAW_ONLY(LAW_ABOVE(g_ft, slack_ft), kl * (g_ft - slack_ft) + cl * rate_ft_s),
                    LAW_LESSER(slack_ft, g_ft)),
        LAW_PICK(
            LAW_BOTH(dirty, LAW_REACHES(held_lb, -grit_lb)),
            LAW(held)(LAW_LESSER(LAW_GREATER(held_lb + cl * rate_ft_s, -grit_lb), none), reach_ft),
            LAW_PICK(
                LAW_BOTH(dirty, LAW_ABOVE(yielded_ft, none)), LAW(pulled)(-grit_lb, yielded_ft),
                LAW(pulled)(LAW_ONLY(LAW_ABOVE(none, g_ft), kl * g_ft + cl * rate_ft_s), none))));
}

/* Of a mat, after a step. */
struct LAW(slip) {
    LAW_REAL v_ft_s;
    LAW_MASK stops; /* it moved before, and came to rest */
    LAW_REAL left;  /* in a vector: share of the step after that; 0 of one that does not stop */
};

/* A mat over a step under a constant force x, friction apart; per_lb: step over mass. At rest it
 * stays while |x| <= friction. One that comes to rest within the step stays there, or is thrown
 * back for what is left of the step. */
LAW_FUNCTION struct LAW(slip)
    LAW(mat_slip)(LAW_REAL v_ft_s, LAW_REAL x_lb, LAW_REAL friction_lb, LAW_REAL per_lb)
{
    const LAW_REAL none = LAW_VALUE(0);
    LAW_MASK rests = LAW_EQUALS(v_ft_s, none);
    LAW_MASK pushes = LAW_ABOVE(LAW_SIZE(x_lb), friction_lb);
    LAW_REAL braking_lb = x_lb - LAW_SIGNED(friction_lb, LAW_IF(rests, x_lb, v_ft_s));
    LAW_REAL after_ft_s = v_ft_s + braking_lb * per_lb;
    LAW_MASK goes_on = LAW_ABOVE(after_ft_s * v_ft_s, none);
    if (LAW_ONE(goes_on))
        return (struct LAW(slip)){after_ft_s, LAW_NOT(goes_on), none};
    LAW_REAL moved_ft_s = LAW_ONLY(LAW_EITHER(goes_on, pushes), after_ft_s);
    LAW_MASK stops = LAW_NOT(LAW_EITHER(rests, goes_on));
    if (!LAW_LATE(stops, pushes))
        return (struct LAW(slip)){moved_ft_s, stops, none};
    LAW_REAL left = LAW_ONLY(stops, LAW_VALUE(1) + v_ft_s / (braking_lb * per_lb));
    LAW_REAL back_lb = x_lb - LAW_SIGNED(friction_lb, x_lb);
    LAW_REAL thrown_ft_s = LAW_ONLY(LAW_ABOVE(left, none), back_lb * per_lb * left);
    return (struct LAW(slip)){LAW_IF(LAW_BOTH(stops, pushes), thrown_ft_s, moved_ft_s), stops,
                              left};
}

#undef LAW_FUNCTION
#ifndef LAW_VECTOR
#undef LAW
#undef LAW_REAL
#undef LAW_MASK
#undef LAW_VALUE
#undef LAW_ABOVE
#undef LAW_REACHES
#undef LAW_EQUALS
#undef LAW_IF
#undef LAW_ONLY
#undef LAW_PICK
#undef LAW_BOTH
#undef LAW_EITHER
#undef LAW_NOT
#undef LAW_LATE
#undef LAW_ONE
#undef LAW_LESSER
#undef LAW_GREATER
#undef LAW_SIZE
#undef LAW_SIGNED
#endif
