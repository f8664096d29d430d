/* Scene parameters from simple tests on one mat, each with its error (1973 report, sections 3.4 and
 * 2.6).
 *
 * Errors are standard errors of independent readings, propagated to first order. The error of a
 * list of readings includes their scatter. An error stated with the list covers errors that scatter
 * does not show, such as a wrong scale, and is added in quadrature. Units are ft, lb and s unless
 * the name states another unit. Pure functions. */
#ifndef MATRIG_HOST_ANALYSE_PARAMS_H
#define MATRIG_HOST_ANALYSE_PARAMS_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"
#include "host/base/statistics.h"

/* Computes the moment of inertia of a mat that hangs on two parallel cords and swings about the
 * vertical: I = W d^2 T^2 / (16 pi^2 l), slug ft2. d: distance between the cords, which are equally
 * far from the centre; l: length of a cord; T: period of small swings. */
struct estimate params_compute_inertia(struct estimate weight_lb, struct estimate spacing_ft,
                                       struct estimate cord_ft, struct estimate period_s);

/* Computes the stiffness of a joint as wide as the mat, lb/ft, from the stiffness per width of the
 * tested strip (lb/in per in). */
struct estimate params_compute_joint_stiffness(struct estimate slope_lb_in_in,
                                               struct estimate joint_in);

/* A straight line through readings of a part with free travel. The part moves freely up to x = free
 * and acts as a spring beyond: y = k (x - free). Only readings beyond `free` are used. */
struct params_spring_fit {
    bool is_known; /* the slope differs from zero (Student's t, at a level of 0.005) */
    /* number of readings with x below `free`; the line is valid only if this is 0 */
    size_t free_travel_readings;
    double scatter; /* standard deviation of y about the line */
    struct estimate stiffness, free_travel;
};

/* Returns MR_TOO_FEW for fewer than three readings or if all x are equal, otherwise MR_OK. */
enum mr_status params_fit_spring(const double *x, const double *y, size_t count,
                                 struct params_spring_fit *spring, struct error *error);

/* Computes the rotational stiffness of a joint from that of a strip. `width_ratio`: width of the
 * joint divided by the width of the strip. */
struct estimate params_compute_hinge_stiffness(struct estimate strip_ft_lb_rad,
                                               struct estimate width_ratio);

struct estimate params_compute_mat_area(struct estimate length_ft, struct estimate width_ft);

/* Computes the friction coefficient: the pull at which the mat just slides, divided by the weight
 * on the soil. */
struct estimate params_compute_friction(struct estimate pull_lb, struct estimate weight_lb);

/* Computes the soil stiffness under one mat end. A wheel in the middle of `mats` mats side by side
 * along the runway (1 if it stands on one mat) sinks by d: KV = P/(2 mats d). If neighbouring mats
 * carry load too, the true value is smaller. */
struct estimate params_compute_soil_stiffness(struct estimate load_lb,
                                              struct estimate deflection_ft, double mats);

/* Computes the soil stiffness under one mat end from a plate bearing test: pressure under the plate
 * divided by its settlement is the modulus of soil reaction, which is equal for model and prototype
 * (2.2), and each end carries half of the mat: KV = slope A_mat/(2 A_plate). Settlement before the
 * plate is seated has no effect. 1.96 errors are a 95 % interval, because Student's t is included.
 * MR_TOO_FEW: fewer than three readings, or all settlements are equal. */
enum mr_status params_compute_plate_soil_stiffness(const double *load_lb,
                                                   const double *settlement_ft, size_t count,
                                                   struct estimate plate_ft,
                                                   struct estimate mat_ft2,
                                                   struct estimate *kv_lb_ft, struct error *error);

/* Computes the mean of at least one reading, with its standard error. `each`: standard error of
 * every reading; it is the only error if there is one reading. */
struct estimate params_compute_mean(const double *readings, size_t count, double each);

#endif
