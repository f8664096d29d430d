/* Scene parameters from simple tests on one mat, each with its error (1973 report, sections 3.4 and
 * 2.6).
 *
 * Errors are standard errors, of independent readings, propagated to first order. A list of
 * readings brings its own scatter; an error stated with it covers what the scatter cannot show (a
 * scale that is off) and is added in squares. Units ft, lb, s unless the name has another. Pure
 * functions. */
#ifndef MATRIG_HOST_ANALYSE_PARAMS_H
#define MATRIG_HOST_ANALYSE_PARAMS_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"
#include "host/base/statistics.h"

/* Mat hung on two parallel cords and turned about the vertical: I = W d^2 T^2 / (16 pi^2 l), slug
 * ft2. d: between the cords, both as far from the centre; l: length of a cord; T: period of small
 * turning. */
struct estimate params_inertia(struct estimate weight_lb, struct estimate spacing_ft,
                               struct estimate cord_ft, struct estimate period_s);

/* A joint's stiffness per width of the strip tested (lb/in per in), for a joint as wide as the mat:
 * lb/ft. */
struct estimate params_joint_stiffness(struct estimate slope_lb_in_in, struct estimate joint_in);

/* Readings y against x of something that yields freely up to some x and is a spring beyond: the
 * straight line of readings beyond, y = k (x - free). */
struct params_spring {
    bool known;     /* the slope differs from zero (Student's t, one in 200) */
    size_t within;  /* readings below `free`: they lie within the free travel, the line is none */
    double scatter; /* of y about the line */
    struct estimate k, free;
};

/* MR_TOO_FEW below three readings or when all x are the same, else MR_OK. */
enum mr_status params_spring(const double *x, const double *y, size_t count,
                             struct params_spring *spring, struct error *error);

/* A joint's stiffness in turning from that of a strip: wider is by how much the joint is. */
struct estimate params_hinge_stiffness(struct estimate strip_ft_lb_rad, struct estimate wider);

/* Pull that just slides the mat, over what presses it down. */
struct estimate params_friction(struct estimate pull_lb, struct estimate weight_lb);

/* Soil under one mat end: a wheel in the middle of `mats` mats side by side along the runway (1
 * when it stands on one) sinks by d: KV = P/(2 mats d). Neighbours that help make the true value
 * smaller. */
struct estimate params_soil(struct estimate load_lb, struct estimate deflection_ft, double mats);

/* Mean of readings with its standard error; `each` is what every one of them is known to. A single
 * reading has only `each`. count >= 1. */
struct estimate params_mean(const double *readings, size_t count, double each);

#endif
