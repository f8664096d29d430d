/* One push test against two laws of the ground (host/sim/README.md, "Gear on elastic ground").
 *
 *     elastic    u = u0 + sum of dq/K while |q| grows, rho dq/K while it falls
 *     rigid      u = u0
 *
 * with q = F, as what rests is in balance; both slide where F reaches a limit. K is of all mats
 * that the load presses, together.
 *
 * Force and displacement both have errors, and those of the force add up along the way: the true
 * force of each reading is an unknown of its own. Given a = 1/K and b = rho/K the displacements
 * are linear in them, u = u0 + G(a, b) F, so the least squares over all true forces are
 *
 *     chi2(a, b) = r' V^-1 r,   r = u - u0 - G F,   V = moved^2 I + force^2 G G'
 *
 * (no log det V: that would take the true forces as drawn from a distribution, and draws a to 0).
 * What slid has a free offset, and its force is the limit. Readings slide only at the end of the
 * first way up, and only where chi2 falls by more than PUSH_SLIDE_GAIN stretch^2 (by chance once in
 * 600).
 *
 * Intervals are where chi2, the other parameter free, has risen by (1.96 stretch)^2. So they hold
 * for a k that is barely told too, and one that is not told has no upper end. Pure functions but
 * for their own memory. Units lb, in. */
#ifndef MATRIG_HOST_PUSH_FIT_H
#define MATRIG_HOST_PUSH_FIT_H

#include <stddef.h>

#include "host/base/error.h"

/* A file of push tests: a mat under the load of an axle is pushed along the runway, and what it
 * moved is read at each force, on the way up and on the way down (docs/howto/push-test.md).
 *
 *     test,load (lb),force (lb),displacement (in)
 *     A,108,0,0
 *     A,108,10,0.016
 *     B,216,0,0.0005
 *
 * The first line names the columns: load, force and displacement (or dial) with their units, as
 * calibrate reads them (host/calibrate/points.h: lb, N, kN, kg; in, mm, cm, m, ft), and test, which
 * may be missing. They may stand in any order. A value may have a unit of its own behind it. Rows
 * stand in the order in which they were read. A new test, or another load, is a series of its own:
 * its ground is fresh and its dial has a zero of its own. An empty load or test is that of the row
 * before. Empty lines and lines that begin with # are passed over. */

#define PUSH_SERIES_MAX   40u
#define PUSH_READINGS_MAX 60u /* of a series: 0.3 s each */
#define PUSH_NAME         24u
#define PUSH_MOST_LB      1e7 /* a load or a force; a displacement */
#define PUSH_MOST_IN      1e4

struct push_series {
    const char *path;     /* of the file, for errors; the caller's */
    char name[PUSH_NAME]; /* of its test, or its number in the file */
    double load_lb;
    size_t count;
    double force_lb[PUSH_READINGS_MAX], moved_in[PUSH_READINGS_MAX];
};

struct push_readings {
    struct push_series *series; /* allocated */
    size_t count;
};

/* Frees what was read when it fails, too. MR_IO; MR_MALFORMED, naming file, line and column;
 * MR_TOO_LONG. */
enum mr_status push_readings_load(const char *path, struct push_readings *readings,
                                  struct error *error);
void push_readings_free(struct push_readings *readings);

/* ---- a test ---- */

#define PUSH_SLIDE_GAIN 10.0
#define PUSH_LEAST      5u /* readings of a test */
#define PUSH_DECADES    1.0

/* Standard errors of a reading. */
struct push_gages {
    double force_lb, moved_in;
};

/* 95 %. value NaN: not told; low and high are bounds all the same, -INFINITY and INFINITY: none. */
struct push_interval {
    double value, low, high;
};

struct push_fit {
    struct push_interval k_lb_in, unloading;
    double limit_lb;        /* at which it slid; NaN: it did not */
    size_t slid_from, slid; /* reading, from 0, and how many */
    double most_lb;         /* largest force read, without sign */
    double zero_in;         /* dial at force 0, by the elastic law */
    double chi_square, rigid_chi_square;
    size_t freedom;  /* of the elastic law */
    double log_odds; /* natural: elastic against rigid, both as likely before */
    size_t falling;  /* readings while the force falls */
};

/* `expected_lb_in`: K is taken to lie within PUSH_DECADES of it either side, evenly in its
 * logarithm, before the test is seen; the odds alone use it. `stretch`: by how much readings
 * scatter more than the gages are said to, at least 1. MR_TOO_FEW: fewer than PUSH_LEAST readings,
 * or no force beyond the gage's error. */
enum mr_status push_fit(const struct push_series *series, struct push_gages gages,
                        double expected_lb_in, double stretch, struct push_fit *fit,
                        struct error *error);

/* The elastic law's way through the forces as they were read, in; where K is not told, with the
 * least that it may be; where rho is not, with 1. `moved_in` has room for
 * series->count. */
void push_fit_curve(const struct push_series *series, struct push_gages gages,
                    const struct push_fit *fit, double *moved_in);

#endif
