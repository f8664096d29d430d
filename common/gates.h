/* Gates: position, speed and deceleration of the gear, each with its standard error, computed from
 * the times at which switches of known position opened (report 2.7.1: "determined using the known
 * position of switches and the voltage-time record").
 *
 * Model: the station x(t) is a polynomial in time. The time t_i at which switch i opened is taken
 * as exact (the capture is accurate to 12 ns). The positions have independent errors of standard
 * deviation `position_error_ft`. A least-squares fit of Chebyshev polynomials in time scaled to
 * [-1, 1] gives the coefficients and their covariance C = s^2 (A'A)^-1, where s is
 * position_error_ft. If the residuals are too large for this error (chi-square test, 1 in 100), the
 * motion is not this polynomial, and s is the residual standard deviation, multiplied by Student's
 * t of its degrees of freedom over 1.96. An interval of +-1.96 stated errors is therefore a 95 %
 * interval in both cases. Errors of derived quantities are first-order: grad' C grad.
 *
 * All computations are in double precision. Edges occur only a few times per second, so the cost of
 * software doubles on the board is negligible, and host and board agree to the last bit. Pure
 * functions, no heap. */
#ifndef MATRIG_COMMON_GATES_H
#define MATRIG_COMMON_GATES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

#define MR_GATES_MAX        32u /* maximum number of edges in a landing */
#define MR_GATES_ORDER_MAX  4u  /* maximum degree of the polynomial */
#define MR_GATES_ONLINE_MAX 6u  /* maximum number of edges used by the online estimate */
#define MR_GATES_END_MAX    8u  /* maximum number of edges used at each end by the final fit */

struct mr_gate {
    double t_s;        /* time at which the switch opened, s from any origin */
    double station_ft; /* station of the switch */
};

struct mr_gates_fit {
    double mid_time_s; /* scaled time is (t - mid_time_s) / half_span_s */
    double half_span_s;
    unsigned degree; /* degree of the polynomial, 1 to MR_GATES_ORDER_MAX */
    unsigned count;  /* number of edges used */
    double coefficient[MR_GATES_ORDER_MAX + 1]; /* coefficients of the Chebyshev polynomials, ft */
    /* covariance of the coefficients, ft^2 */
    double covariance[MR_GATES_ORDER_MAX + 1][MR_GATES_ORDER_MAX + 1];
    /* sqrt(sum of squared residuals / degrees of freedom); 0 without degrees of freedom */
    double residual_ft;
};

/* A value and its standard error; the name of the member that holds them gives the unit. */
struct mr_estimate {
    double value;
    double error;
};

struct mr_motion_estimate {
    double t_s;
    struct mr_estimate position_ft;
    struct mr_estimate speed_ft_s;
    struct mr_estimate deceleration_ft_s2; /* NaN if the degree of the fit is 1 */
};

/* Fits `count` gates (2 to MR_GATES_MAX, times strictly rising) with a polynomial of degree
 * `order`. MR_OK; MR_TOO_FEW: fewer than order + 1 gates; MR_MALFORMED: times not rising;
 * MR_NUMERICS: singular. */
enum mr_status mr_gates_fit(const struct mr_gate *gates, size_t count, unsigned order,
                            double position_error_ft, struct mr_gates_fit *fit);

/* Fits with the lowest suitable degree, from 2 up (1 with two gates). A higher degree is used if
 * three degrees of freedom remain and if it lowers the sum of squares by more than random errors
 * would in 99 of 100 landings (chi-square with position_error_ft known). Errors as mr_gates_fit. */
enum mr_status mr_gates_fit_best(const struct mr_gate *gates, size_t count,
                                 double position_error_ft, struct mr_gates_fit *fit);

/* Online estimate of the motion at the last gate, from a parabola (a line with two gates) through
 * the last MR_GATES_ONLINE_MAX gates or fewer. With MR_GATES_ONLINE_MAX gates, one outlier is left
 * out: a gate without which the others fit a parabola. */
enum mr_status mr_gates_latest_motion(const struct mr_gate *gates, size_t count,
                                      double position_error_ft, struct mr_motion_estimate *motion);

/* Motion at a time. Outside the gates the fit is extrapolated, with larger errors. */
void mr_gates_motion_at_time(const struct mr_gates_fit *fit, double t_s,
                             struct mr_motion_estimate *motion);

/* Motion at the time when the fit passes `station_ft`. The search covers the gates and 1.5 mean
 * intervals before the first gate or beyond the last one. MR_OK; MR_NUMERICS: the fit does not pass
 * the station there. */
enum mr_status mr_gates_motion_at_station(const struct mr_gates_fit *fit, double station_ft,
                                          bool beyond_last, struct mr_motion_estimate *motion);

struct mr_gates_summary {
    struct mr_estimate touchdown_speed_ft_s;
    struct mr_estimate touchdown_t_s;
    struct mr_estimate stop_t_s; /* time at which the speed reaches 0 */
    struct mr_estimate stop_station_ft;
    struct mr_estimate mean_deceleration_ft_s2; /* touchdown speed / (stop time - touchdown time) */
    /* number of gates used for the stop: the last ones, or all if `is_uniform` */
    unsigned gates_used_for_stop;
    unsigned gate_count;             /* number of all gates */
    unsigned gates_before_touchdown; /* number of gates on the track, before touchdown */
    /* braking was uniform, with one deceleration (see "braking") */
    bool is_uniform;
    /* bit g: gate g contradicts the other gates and was left out */
    uint32_t outlier_mask;
    /* how late an outlier gate opened, s; negative: early */
    double lateness_s[MR_GATES_MAX];
};

/* Factor for a standard error whose scale was estimated with `freedom` degrees of freedom, so that
 * +-1.96 errors are a 95 % interval: Student's t at 0.975 over 1.96. Valid for any `freedom` from
 * 1. */
double mr_gates_student_factor(unsigned freedom);

/* Final fit of a landing; the touchdown station is taken as given.
 *
 * Uniform braking (section "braking") is fitted to all gates first. A gate that alone contradicts
 * the others is an outlier and is left out. If uniform braking does not fit, touchdown and stop are
 * fitted separately:
 *
 * Touchdown: uniform braking is fitted to the gates on the track and to as many of the first
 * MR_GATES_END_MAX gates beyond touchdown as it fits. If it fits none of them, two gates on the
 * track give the speed, which is assumed constant there; without such gates, a polynomial
 * (mr_gates_fit_best) is extrapolated back and corrected for the delay of the brake.
 *
 * Stop: the deceleration at the end is taken as constant. A parabola through as many of the last
 * MR_GATES_END_MAX gates as it fits (chi-square, 1 in 100), at least 4, is extrapolated to rest. If
 * it does not fit all 8, the braking changed during these gates and may change again after the last
 * one; the error then includes the difference from a cubic. A gate without which all the others lie
 * on a parabola is an outlier.
 *
 * All parts include the errors of position. MR_OK; MR_TOO_FEW: fewer than 3 gates, or none beyond
 * touchdown; MR_NUMERICS: no touchdown or no stop in the fit; MR_MALFORMED: times not rising. */
enum mr_status mr_gates_summarise(const struct mr_gate *gates, size_t count, double touchdown_ft,
                                  double position_error_ft, struct mr_gates_summary *summary);

/* ---- braking ---- */

/* Braking: the motion of a landing with uniform braking, fitted to all its gates at once, and the
 * gates that contradict this motion.
 *
 * Model: the gear runs on the track at an assumed constant speed v and touches down at a known
 * station at time T. The deceleration then rises to its final value a over the time 2 d, following
 * 3 u^2 - 2 u^3, and stays at a. After the rise, s seconds after touchdown, the gear is behind an
 * unbraked one by a ((s - d)^2 + k d^2) / 2. Unknowns are T, v, a, the delay d and the shape k (1/3
 * for a linear rise, 1/7 for a quintic one). A landing with few gates cannot separate d and k from
 * the other unknowns, so d and k have prior values with standard errors, which are defined here.
 * They were chosen for disk brakes on the rig; the report does not give such values. The fit is
 * Gauss-Newton least squares with independent position errors of standard deviation
 * `position_error_ft`. That value is known and never estimated here, so intervals are normal:
 * +-1.96 standard errors for 95 %.
 *
 * A brake may act late. If two gates lie on the track, and the model does not fit or requires a
 * delay more than two prior errors from the prior value, the fit assumes a late brake: the
 * deceleration begins at an unknown onset after touchdown, with the prior delay and shape from
 * there.
 *
 * A chi-square test checks the model; it rejects 1 in 1000 landings for which the model is true. A
 * gate that alone causes a rejection by more than MR_GATE_OUTLIER_SIGMA standard errors can be left
 * out; the worst gate is left out first.
 *
 * Pure, no heap, double precision with + - * / and square roots only: host and board agree to the
 * last bit. */

#define MR_BRAKE_DELAY_S       0.025
#define MR_BRAKE_DELAY_ERROR_S 0.012
#define MR_BRAKE_SHAPE         0.238
#define MR_BRAKE_SHAPE_ERROR   0.095
#define MR_GATE_OUTLIER_SIGMA  5.0 /* smallest deviation of an outlier, in standard errors */

enum mr_braking_unknown {
    MR_BRAKING_TIME,
    MR_BRAKING_SPEED,
    MR_BRAKING_DECELERATION,
    MR_BRAKING_DELAY,
    MR_BRAKING_SHAPE,
    MR_BRAKING_UNKNOWN_COUNT,
};

struct mr_braking {
    double touchdown_ft;
    double touchdown_s;
    double speed_ft_s;
    double deceleration_ft_s2;
    double onset_s; /* time from touchdown to the onset of a late brake; 0 for a prompt brake */
    double delay_s;
    double shape;
    /* the unknown MR_BRAKING_DELAY is the onset of a late brake; delay_s is not fitted */
    bool is_brake_late;
    double covariance[MR_BRAKING_UNKNOWN_COUNT][MR_BRAKING_UNKNOWN_COUNT];
    double chi_square;
    unsigned degrees_of_freedom; /* degrees of freedom of chi-square */
    unsigned iterations;
    bool is_converged;      /* the last iteration changed no result significantly */
    uint32_t excluded_mask; /* bit g: gate g was left out */
};

/* Fits the gates (at most MR_GATES_MAX, times rising) except those in `left_out`. MR_TOO_FEW: fewer
 * than 3 gates, or none beyond touchdown; MR_NUMERICS: the gates show no braking, or the fit
 * failed. */
enum mr_status mr_braking_fit(const struct mr_gate *gates, size_t count, double touchdown_ft,
                              double position_error_ft, uint32_t left_out, struct mr_braking *fit);

/* Leaves out the worst gate (the gate whose removal lowers chi-square most) and fits again. At most
 * a fifth of the gates are left out, and two degrees of freedom must remain to identify the gate.
 * MR_LIMIT: no gate contradicts the others enough, or no more gates can be left out (`fit` is then
 * unchanged); else as mr_braking_fit. */
enum mr_status mr_braking_drop_worst_gate(const struct mr_gate *gates, size_t count,
                                          double position_error_ft, struct mr_braking *fit);

/* True if the chi-square test does not reject the model. */
bool mr_braking_is_accepted(const struct mr_braking *fit);

/* Time from the wheel's arrival at the gate, according to the fit, to the opening of the gate, s.
 * Negative: the gate opened early. */
double mr_gate_lateness_s(const struct mr_braking *fit, const struct mr_gate *gate);

/* Touchdown, stop and mean deceleration with their errors. MR_NUMERICS: the gear stops before the
 * deceleration has risen. */
enum mr_status mr_braking_summarise(const struct mr_braking *fit, struct mr_gates_summary *summary);

/* Limit of chi-square for a probability given as a number of normal standard deviations (Wilson and
 * Hilferty 1931). From 1 degree of freedom up, the result agrees with the tables within 1 % for
 * MR_SIGMA_1_IN_100 and within 3.1 % for MR_SIGMA_1_IN_1000. */
#define MR_SIGMA_1_IN_100  2.3263479
#define MR_SIGMA_1_IN_1000 3.0902323
double mr_chi_square_limit(unsigned freedom, double deviations);

/* ---- the final fit in steps ---- */

/* The final fit of a landing in steps: a replacement for mr_gates_summarise on the board, which
 * must process a block between two steps.
 *
 * Each step is one iteration of a fit. The result is identical to that of mr_gates_summarise, which
 * runs all these steps. The caller provides `work`, which points to the gates; they must not change
 * until the fit has finished. */

enum mr_final_stage {
    MR_FINAL_ALL_GATES,
    MR_FINAL_TOUCHDOWN,
    MR_FINAL_LAST_GATES,
    MR_FINAL_FIND_OUTLIER,
    MR_FINAL_STOP,
    MR_FINAL_DONE
};

/* Ways of describing the gates by one deceleration, tried in this order. */
enum mr_final_attempt {
    MR_FINAL_PROMPT_BRAKE,       /* the brake acts at touchdown */
    MR_FINAL_LATE_BRAKE,         /* the brake acts later than at touchdown */
    MR_FINAL_REFIT,              /* the same as MR_FINAL_PROMPT_BRAKE, to find the worst gate */
    MR_FINAL_WITHOUT_WORST_GATE, /* as MR_FINAL_PROMPT_BRAKE, without the worst gate */
};

/* Search among the last gates for a gate without which all the others lie on a parabola. */
struct mr_gates_search {
    size_t next, outlier;
    bool is_found;
    double min_residual_ft; /* smallest residual of the other gates found so far */
};

struct mr_final_fit {
    const struct mr_gate *gates;
    size_t gate_count;
    size_t gates_on_track;
    double touchdown_ft;
    double position_error_ft;
    enum mr_final_stage stage;
    enum mr_final_attempt attempt; /* present attempt */
    bool is_fit_in_progress;       /* a fit is in progress */
    size_t used;                   /* number of gates beyond touchdown in the present fit */
    union {
        struct mr_braking braking;
        struct { /* for the stages from MR_FINAL_LAST_GATES on */
            size_t used;
            struct mr_gates_fit fit;
            struct mr_gates_search search;
        } end_fit;
    };
    struct mr_gates_summary summary;
    enum mr_status status; /* result, valid at stage MR_FINAL_DONE; as from mr_gates_summarise */
};

/* Starts the fit; arguments as in mr_gates_summarise. */
void mr_final_fit_start(struct mr_final_fit *work, const struct mr_gate *gates, size_t count,
                        double touchdown_ft, double position_error_ft);
/* Computes the next step. Returns false when finished; `status` and `summary` then hold the
 * result. */
bool mr_final_fit_step(struct mr_final_fit *work);

#endif
