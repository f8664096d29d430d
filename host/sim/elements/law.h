/* Law: how an element's force is written so that every engine can have it within its own loop.
 *
 * Each law has four things side by side, and engines take them from here: the force; its slopes
 * (Jacobian); a bound of the rate that the law brings, for the longest stable step; and a margin,
 * which says how far a mode of the law, or a mat at rest, is from a change: what has a margin may
 * be left out of a scene until the margin is used up. Functions are inlined into loops over mats;
 * what their constant arguments exclude is not compiled. Units ft, lb, s, slug, rad. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_LAW_H
#define MATRIG_HOST_SIM_ELEMENTS_LAW_H

#define LAW_INLINE static inline __attribute__((always_inline))

/* LAW_PICKED keeps the compiler from turning the choice of a value back into a branch. */
#if defined __GNUC__ && __GNUC__ >= 12 && !defined __clang__
#define LAW_PICKED(x) __builtin_assoc_barrier(x)
#else
#define LAW_PICKED(x) (x)
#endif

/* Largest rates that a law brings to a mat: `rate2` of what pulls back, 1/s2; `damping` of what
 * damps, 1/s. Bounds of several laws add up. */
struct law_bound {
    double rate2, damping;
};

/* fmin and fmax are calls, for the sake of NaN. */
LAW_INLINE double law_least(double a, double b)
{
    return a < b ? a : b;
}

LAW_INLINE double law_most(double a, double b)
{
    return a > b ? a : b;
}

#endif
