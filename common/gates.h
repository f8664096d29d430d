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

/* Motion at a time. Outside the gates it extrapolates, and the errors grow accordingly. */
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
    /* the brake held one deceleration (below) */
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
 * Even braking (below) first, by all gates; those that alone contradict the others are
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

/* ---- braking ---- */

/* Braking: the motion of a landing that brakes evenly, fitted to all its gates at once, and the
 * gates that do not belong.
 *
 * Model: constant speed v on the track (report 2.4), touchdown at a known station at time T, from
 * there a deceleration that rises to a within 2 d as 3 u^2 - 2 u^3 and then stays: s seconds after
 * touchdown, the rise being over, the gear is a ((s - d)^2 + k d^2) / 2 behind one that rolls on.
 * Unknown are T, v, a, the delay d and the shape k (1/3 for a straight rise, 1/7 for a quintic
 * one). A landing with few gates cannot separate d and k from the rest, so both also have prior
 * values, with the standard errors below: our choice for disk brakes on the rig; the report gives
 * none. Gauss-Newton least squares with independent errors of position of standard deviation
 * `position_error_ft`, which is known: it is never estimated here, so intervals are normal, 1.96
 * standard errors for 95 %.
 *
 * Chi-square tests whether the model holds (1 in 1000 of the landings for which it does fail the
 * test). A gate that alone makes it fail by more than MR_GATE_ALIEN standard errors can be left
 * out, the worst first.
 *
 * Pure, no heap, double precision with + - * / and square roots only: host and board agree to the
 * last bit. */

#define MR_BRAKE_DELAY_S       0.025
#define MR_BRAKE_DELAY_ERROR_S 0.012
#define MR_BRAKE_SHAPE         0.238
#define MR_BRAKE_SHAPE_ERROR   0.095
#define MR_GATE_ALIEN          5.0 /* standard errors */

enum mr_braking_unknown {
    MR_BRAKING_TIME,
    MR_BRAKING_SPEED,
    MR_BRAKING_DECELERATION,
    MR_BRAKING_DELAY,
    MR_BRAKING_SHAPE,
    MR_BRAKING_UNKNOWNS,
};

struct mr_braking {
    double touchdown_ft;
    double touchdown_s;
    double speed_ft_s;
    double deceleration_ft_s2;
    double delay_s;
    double shape;
    double covariance[MR_BRAKING_UNKNOWNS][MR_BRAKING_UNKNOWNS];
    double chi_square;
    unsigned freedom;  /* degrees of it */
    unsigned rounds;   /* that it took */
    bool near;         /* the last of them moved nothing that counts */
    uint32_t left_out; /* bit g: gate g is not part of it */
};

/* Fit the gates (at most MR_GATES_MAX, times rising) but those of `left_out`. MR_OK; MR_TOO_FEW:
 * fewer than 3, or none beyond touchdown; MR_NUMERICS: no braking in them, or not to be fitted. */
enum mr_status mr_braking_fit(const struct mr_gate *gates, size_t count, double touchdown_ft,
                              double position_error_ft, uint32_t left_out, struct mr_braking *fit);

/* Leave out the worst gate, the one whose removal lowers chi-square most, and fit again: at most a
 * fifth of the gates, and two degrees of freedom must remain to identify it. MR_OK; MR_LIMIT: none
 * contradicts the others that much, or no more can be left out; else as mr_braking_fit. `fit` is
 * kept when MR_LIMIT. */
enum mr_status mr_braking_leave_out(const struct mr_gate *gates, size_t count,
                                    double position_error_ft, struct mr_braking *fit);

/* Chi-square does not contradict the model. */
bool mr_braking_holds(const struct mr_braking *fit);

/* How far a gate opened after the wheel was there by the fit, s; negative: before. */
double mr_braking_late_s(const struct mr_braking *fit, const struct mr_gate *gate);

/* Touchdown, rest, mean deceleration with their errors. MR_NUMERICS: at rest before the brake has
 * risen. */
enum mr_status mr_braking_summarise(const struct mr_braking *fit, struct mr_gates_summary *summary);

/* Chi-square that chance exceeds by so many normal standard deviations (Wilson and Hilferty 1931):
 * MR_ONE_IN_100 within 1 %, MR_ONE_IN_1000 within 3.1 % of the tables from 1 degree of freedom
 * on. */
#define MR_ONE_IN_100  2.3263479
#define MR_ONE_IN_1000 3.0902323
double mr_chi_square(unsigned freedom, double deviations);

/* ---- final_fit ---- */

/* The final fit of a landing in steps: mr_gates_summarise for a board that must not leave its
 * blocks waiting.
 *
 * Each step is a round of a fit, and the same bits come out as from mr_gates_summarise, which is
 * these steps in a row. The work is the caller's; it points to the gates, which must not change
 * meanwhile. */

enum mr_final_stage {
    MR_FINAL_WHOLE,
    MR_FINAL_START,
    MR_FINAL_REST,
    MR_FINAL_ALIEN,
    MR_FINAL_STOP,
    MR_FINAL_OVER
};

/* For one of the last gates without which all the others lie on a parabola. */
struct mr_gates_search {
    size_t next, alien;
    bool found;
    double least_ft; /* residual of the others without it */
};

struct mr_final_fit {
    const struct mr_gate *gates;
    size_t count;
    size_t on_track;
    double touchdown_ft;
    double position_error_ft;
    enum mr_final_stage stage;
    bool fitted; /* the present part once; what follows leaves gates out */
    bool begun;  /* a fit, which goes on */
    size_t used; /* gates beyond touchdown of the present part */
    union {
        struct mr_braking braking;
        struct { /* from MR_FINAL_REST on */
            size_t used;
            struct mr_gates_fit fit;
            struct mr_gates_search search;
        } rest;
    };
    struct mr_gates_summary summary;
    enum mr_status status; /* when over: as mr_gates_summarise */
};

void mr_final_fit_start(struct mr_final_fit *work, const struct mr_gate *gates, size_t count,
                        double touchdown_ft, double position_error_ft);
/* False: finished; `status` and `summary` hold the result. */
bool mr_final_fit_step(struct mr_final_fit *work);

#endif
