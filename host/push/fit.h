/* Fit of one push test by two laws of the ground (host/sim/README.md, "Gear on elastic ground").
 *
 *     elastic    u = u0 + sum of dq/K while |q| grows, rho dq/K while it falls
 *     rigid      u = u0
 *
 * Here q = F, because the mat at rest is in equilibrium. In both laws the mat slides when F reaches
 * a limit. K is the stiffness of all mats under the load together.
 *
 * Force and displacement both have errors, and force errors accumulate along the loading path: the
 * true force of each reading is an unknown. For given a = 1/K and b = rho/K the displacements are
 * linear in the forces, u = u0 + G(a, b) F. The least-squares sum over all true forces is
 *
 *     chi2(a, b) = r' V^-1 r,   r = u - u0 - G F,   V = displacement^2 I + force^2 G G'
 *
 * Log det V is not added: it would treat the true forces as drawn from a distribution, and would
 * bias a toward 0. A sliding part has a free offset, and its force is the limit. Sliding is assumed
 * only for readings at the end of the first loading, and only if it reduces chi2 by more than
 * PUSH_SLIDE_GAIN_MIN stretch^2, which happens by chance once in 600 tests.
 *
 * An interval contains the values at which chi2, minimised over the other parameter, has risen by
 * at most (1.96 stretch)^2. Such intervals are also valid for a poorly determined k; if k is not
 * determined, the interval has no upper end. Pure functions, except that they allocate memory.
 * Units are lb and in. */
#ifndef MATRIG_HOST_PUSH_FIT_H
#define MATRIG_HOST_PUSH_FIT_H

#include <stddef.h>

#include "host/base/error.h"

/* A file of push tests. A mat under the load of an axle is pushed along the runway, and its
 * displacement is read at each force, while the force increases and while it decreases
 * (docs/howto/push-test.md).
 *
 *     test,load (lb),force (lb),displacement (in)
 *     A,108,0,0
 *     A,108,10,0.016
 *     B,216,0,0.0005
 *
 * The first line names the columns, in any order: load, force and displacement (or dial) with their
 * units, as calibrate reads them (host/calibrate/points.h: lb, N, kN, kg; in, mm, cm, m, ft), and
 * optionally test. A unit may follow each value. Rows are in the order of reading. A new test or a
 * different load begins a new series, with undisturbed ground and a new dial zero. An empty load or
 * test repeats that of the previous row. Empty lines and lines that begin with # are skipped. */

#define PUSH_SERIES_MAX   40u
/* maximum number of readings of a series; fitting so many takes 0.3 s */
#define PUSH_READINGS_MAX 60u
#define PUSH_NAME_SIZE    24u
#define PUSH_FORCE_MAX_LB \
    1e7 /* largest load or force; PUSH_DISPLACEMENT_MAX_IN: largest displacement */
#define PUSH_DISPLACEMENT_MAX_IN 1e4

struct push_series {
    const char *path;          /* path of the file, for errors; the caller owns it */
    char name[PUSH_NAME_SIZE]; /* name of the test, or its number in the file if it has none */
    double load_lb;
    size_t count;
    double force_lb[PUSH_READINGS_MAX], displacement_in[PUSH_READINGS_MAX];
};

struct push_readings {
    struct push_series *series; /* allocated */
    size_t count;
};

/* Loads a file; after a failure nothing remains to be freed. MR_IO: it cannot be read.
 * MR_MALFORMED: `error` has file, line and column. MR_TOO_LONG: too many series or readings. */
enum mr_status push_readings_load(const char *path, struct push_readings *readings,
                                  struct error *error);
void push_readings_free(struct push_readings *readings);

/* ---- a test ---- */

#define PUSH_SLIDE_GAIN_MIN 10.0
#define PUSH_READINGS_MIN   5u /* minimum number of readings of a test */
#define PUSH_PRIOR_DECADES  1.0

/* Standard errors of a reading. */
struct push_errors {
    double force_lb, displacement_in;
};

/* A 95 % interval. `value` NaN: not determined; low and high are still valid bounds. -INFINITY and
 * INFINITY: no bound. */
struct push_interval {
    double value, low, high;
};

struct push_fit {
    struct push_interval k_lb_in, unloading_ratio;
    double slide_force_lb; /* force at which the mat slid; NaN: it did not slide */
    /* first sliding reading, from 0, and number of sliding readings */
    size_t first_sliding_reading, slid_count;
    double max_force_lb; /* largest magnitude of the force */
    double dial_zero_in; /* dial reading at force 0, according to the elastic law */
    double chi_square, rigid_chi_square;
    size_t degrees_of_freedom; /* degrees of freedom of the elastic fit */
    double log_odds; /* natural logarithm of the odds of elastic to rigid, with equal prior odds */
    size_t unloading_count; /* number of readings with decreasing force */
};

/* Fits a test. `expected_lb_in`: K is assumed to lie within PUSH_PRIOR_DECADES decades of this
 * value, with a uniform prior in its logarithm; only the odds use it. `stretch`: ratio of the
 * readings' scatter to the stated errors, at least 1. MR_TOO_FEW: fewer than PUSH_READINGS_MIN
 * readings, or no force above the force error. */
enum mr_status push_fit(const struct push_series *series, struct push_errors gages,
                        double expected_lb_in, double stretch, struct push_fit *fit,
                        struct error *error);

/* Computes the displacements of the elastic law at the forces as read, in. If K is not determined,
 * its lower bound is used; if rho is not determined, 1. `displacement_in` has room for
 * series->count values. */
void push_fit_curve(const struct push_series *series, struct push_errors gages,
                    const struct push_fit *fit, double *displacement_in);

#endif
