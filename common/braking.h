/* Braking: the motion of a landing that brakes evenly, fitted to all its gates at once, and the
 * gates that do not belong.
 *
 * Model: constant speed v on the track (report 2.4), touchdown at a known station at time T, from
 * there a deceleration that rises to a within 2 d as 3 u^2 - 2 u^3 and then stays: s seconds after
 * touchdown, the rise being over, the gear is a ((s - d)^2 + k d^2) / 2 behind one that rolls on.
 * Unknown are T, v, a, the delay d and the shape k (1/3 for a straight rise, 1/7 for a quintic
 * one). A landing with few gates cannot tell d and k from the rest, so both are also taken as
 * measured beforehand, with the standard errors below: our choice for disk brakes on the rig; the
 * report does not say. Gauss-Newton least squares with independent errors of position of standard
 * deviation `position_error_ft`, which is known: it is never estimated here, so intervals are
 * normal, 1.96 standard errors for 95 %.
 *
 * Whether the model holds is asked by chi-square (1 in 1000 of the landings that are as it says
 * fail). A gate that alone makes it fail by more than MR_GATE_ALIEN standard errors can be left
 * out, the worst first.
 *
 * Pure, no heap, double precision with + - * / and square roots only: host and board agree to the
 * last bit. */
#ifndef MATRIG_COMMON_BRAKING_H
#define MATRIG_COMMON_BRAKING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/gates.h"
#include "common/status.h"

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
    uint32_t left_out; /* bit g: gate g is not part of it */
};

/* Fit the gates (at most MR_GATES_MAX, times rising) but those of `left_out`. MR_OK; MR_TOO_FEW:
 * fewer than 3, or none beyond touchdown; MR_NUMERICS: no braking in them, or not to be fitted. */
enum mr_status mr_braking_fit(const struct mr_gate *gates, size_t count, double touchdown_ft,
                              double position_error_ft, uint32_t left_out, struct mr_braking *fit);

/* Leave out the worst gate, the one that chi-square would lose most without, and fit again: at most
 * a fifth of the gates, and two degrees of freedom must be left to tell which it was. MR_OK;
 * MR_LIMIT: none contradicts the others that much, or no more can be left out; else as
 * mr_braking_fit. `fit` is kept when MR_LIMIT. */
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

#endif
