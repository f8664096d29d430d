/* Params: simple tests on one mat to scene parameters, each with its error (1973 report, section 3.4
 * and 2.6).
 *
 * Errors are standard errors, of independent readings, propagated to first order. A list of readings brings
 * its own scatter; an error stated with it covers what the scatter cannot show (a scale that is off) and is
 * added in squares. Units ft, lb, s unless the name says otherwise. Pure functions. */
#ifndef MATRIG_HOST_ANALYSE_PARAMS_H
#define MATRIG_HOST_ANALYSE_PARAMS_H

#include <stddef.h>

#include "host/error.h"

struct estimate {
    double value;
    double error;
};

/* Straight line y = intercept + slope x by least squares; the errors from the scatter about it. */
struct params_line {
    struct estimate slope, intercept;
    double covariance; /* of slope and intercept */
    double scatter;    /* of a reading */
};

/* Mat hung on two parallel cords and turned about the vertical: I = W d^2 T^2 / (16 pi^2 l), slug ft2. d:
 * between the cords, both as far from the centre; l: length of a cord; T: period of small turning. */
struct estimate params_inertia(struct estimate weight_lb, struct estimate spacing_ft, struct estimate cord_ft,
                               struct estimate period_s);

/* A joint's stiffness per width of the strip tested (lb/in per in), for a joint as wide as the mat: lb/ft. */
struct estimate params_joint_stiffness(struct estimate slope_lb_in_in, struct estimate joint_in);

/* Moment against angle beyond the free rotation: KT and TAD, where the line meets no moment. The strip tested
 * may be narrower than the joint: wider is by how much the joint is. MR_TOO_FEW below three points. */
enum mr_status params_hinge(const double *angle_rad, const double *moment_ft_lb, size_t count,
                            struct estimate wider, struct estimate *kt, struct estimate *tad_rad,
                            struct error *error);

/* Pull that just slides the mat, over what presses it down. */
struct estimate params_friction(struct estimate pull_lb, struct estimate weight_lb);

/* Soil under one mat end: a wheel that stands in the middle of `mats` mats side by side along the runway (1
 * when it stands on one) sinks by d: KV = P/(2 mats d). Neighbours that help make the true value smaller. */
struct estimate params_soil(struct estimate load_lb, struct estimate deflection_ft, double mats);

/* Mean of readings with its standard error; `each` is what every one of them is known to. A single reading
 * has only `each`. count >= 1. */
struct estimate params_mean(const double *readings, size_t count, double each);

/* MR_TOO_FEW below three points or when all x are the same. */
enum mr_status params_fit(const double *x, const double *y, size_t count, struct params_line *line,
                          struct error *error);

#endif
