/* Gates: from the times at which switches of known position opened to position, speed and
 * deceleration of the gear, each with its standard error (report 2.7.1: "determined using the known
 * position of switches and the voltage-time record").
 *
 * Model: station x(t) is a polynomial in time; switch i opened at t_i exactly (the capture is good
 * to 12 ns), its position is known with independent errors of standard deviation
 * `position_error_ft`. Least squares in a time scaled to [-1, 1] with Chebyshev polynomials gives
 * the coefficients and their covariance C = s^2 (A'A)^-1, where s is position_error_ft. When the
 * residuals contradict that (chi-square, 1 in 100), the polynomial is not the shape: s is then the
 * residual standard deviation, widened by Student's t of its degrees of freedom over 1.96. So 1.96
 * stated errors are a 95 % interval always, whether the scale was known or estimated. Errors of
 * derived quantities are first-order: grad' C grad.
 *
 * Double precision throughout: an edge comes a few times a second, so software doubles cost the
 * board nothing, and host and board agree to the last bit. Pure functions, no heap. */
#ifndef MATRIG_COMMON_GATES_H
#define MATRIG_COMMON_GATES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

#define MR_GATES_MAX       32u /* edges of one landing */
#define MR_GATES_ORDER_MAX 4u  /* of the polynomial */
#define MR_GATES_LOCAL     6u  /* edges that the online estimate uses */
#define MR_GATES_END       8u  /* edges that the final fit uses at each end */

struct mr_gate {
    double t_s;        /* when it opened, s from any origin */
    double station_ft; /* where it is */
};

struct mr_gates_fit {
    double mid_s; /* scaled time (t - mid_s) / half_s */
    double half_s;
    unsigned order;                             /* of the polynomial, 1 to MR_GATES_ORDER_MAX */
    unsigned count;                             /* edges used */
    double coefficient[MR_GATES_ORDER_MAX + 1]; /* of Chebyshev polynomials, ft */
    double covariance[MR_GATES_ORDER_MAX + 1][MR_GATES_ORDER_MAX + 1]; /* ft^2 */
    /* root of (sum of squared residuals / degrees of freedom); 0 with none left */
    double residual_ft;
};

/* A value and its standard error, in the unit of the name that holds it. */
struct mr_estimate {
    double value;
    double error;
};

struct mr_motion_estimate {
    double t_s;
    struct mr_estimate position_ft;
    struct mr_estimate speed_ft_s;
    struct mr_estimate deceleration_ft_s2; /* NaN when the order is 1 */
};

/* Fit `count` gates (2 to MR_GATES_MAX, times strictly rising) with the given order. MR_OK;
 * MR_TOO_FEW: fewer than order + 1 gates; MR_MALFORMED: times not rising; MR_NUMERICS: singular. */
enum mr_status mr_gates_fit(const struct mr_gate *gates, size_t count, unsigned order,
                            double position_error_ft, struct mr_gates_fit *fit);

/* Fit with the lowest order from 2 (1 with two gates) that the gates do not contradict: a higher
 * order is taken when the coefficients it adds lower the sum of squares by more than chance would
 * in 1 of 100 landings (chi-square with position_error_ft known), as long as three degrees of
 * freedom remain. Errors as mr_gates_fit. */
enum mr_status mr_gates_fit_best(const struct mr_gate *gates, size_t count,
                                 double position_error_ft, struct mr_gates_fit *fit);

/* The online estimate: the last MR_GATES_LOCAL gates or fewer, quadratic (line with two), evaluated
 * at the last gate. With all of them, one that alone keeps the others off a parabola is left
 * out. */
enum mr_status mr_gates_now(const struct mr_gate *gates, size_t count, double position_error_ft,
                            struct mr_motion_estimate *motion);

/* Motion at a time. Outside the gates it extrapolates, and the errors say so by growing. */
void mr_gates_at(const struct mr_gates_fit *fit, double t_s, struct mr_motion_estimate *motion);

/* Motion when the fit is at `station_ft`, searched among the gates and one mean interval and a half
 * before the first or beyond the last. MR_OK; MR_NUMERICS: the fit does not pass there. */
enum mr_status mr_gates_at_station(const struct mr_gates_fit *fit, double station_ft,
                                   bool beyond_last, struct mr_motion_estimate *motion);

struct mr_gates_summary {
    struct mr_estimate touchdown_speed_ft_s;
    struct mr_estimate touchdown_t_s;
    struct mr_estimate stop_t_s; /* when the speed reaches 0 */
    struct mr_estimate stop_station_ft;
    struct mr_estimate mean_deceleration_ft_s2; /* touchdown speed / (stop time - touchdown time) */
    /* of the last gates; of all of them where braking is even */
    unsigned used_for_stop;
    unsigned count;            /* gates, all of them */
    unsigned before_touchdown; /* of them on the track */
    /* the brake held one deceleration (common/braking.h) */
    bool even;
    /* bit g: gate g opened at another time than the rest allows, left out */
    uint32_t alien;
    /* how late it did, s; negative: early; of aliens only */
    double late_s[MR_GATES_MAX];
};

/* Factor from a standard error whose scale was estimated with so many degrees of freedom to one for
 * 1.96 of which the 95 % interval holds: Student's t, 0.975, over 1.96. 1 to 30 and beyond. */
double mr_gates_student(unsigned freedom);

/* Final fit of a landing; the touchdown station is taken as given.
 *
 * Even braking (common/braking.h) first, by all gates; those that alone contradict the others are
 * alien and left out. Where it does not hold, the ends are taken apart: Touchdown: even braking
 * through as many of the first MR_GATES_END gates beyond touchdown as it describes, with those on
 * the track. Where it describes none, two gates on the track give the speed, which is constant
 * there (report 2.4), or else a polynomial is carried back (mr_gates_fit_best) and corrected for
 * the delay of the brake. Stop: constant deceleration from the last gates on: a parabola through as
 * many of the last MR_GATES_END as it describes (chi-square, 1 in 100), at least 4, carried on to
 * rest. Where all 8 do not lie on one, braking changes and may go on to: the error then includes
 * how far a cubic disagrees, because what lies beyond the last gate is extrapolated. A gate without
 * which all the others lie on one is alien. Errors of position enter every part; MR_OK; MR_TOO_FEW:
 * fewer than 3 gates, or none beyond touchdown; MR_NUMERICS: no touchdown or no stop in the fit;
 * MR_MALFORMED: times not rising. */
enum mr_status mr_gates_summarise(const struct mr_gate *gates, size_t count, double touchdown_ft,
                                  double position_error_ft, struct mr_gates_summary *summary);

#endif
