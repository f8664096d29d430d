/* Polynomial: a switch condition within a step that is a power series (chain_motion.h), s[0] + s[1]
 * t + ... + s[degree] t^degree, and the time at which it falls below 0. */
#ifndef MATRIG_HOST_SIM_SOLVERS_POLYNOMIAL_H
#define MATRIG_HOST_SIM_SOLVERS_POLYNOMIAL_H

#define POLYNOMIAL_DEGREE 20 /* maximum */

double polynomial_value(const double *s, int degree, double t);

/* Time, within 0..wide, at which a condition that must not be negative falls below 0; INFINITY:
 * never. For a condition that begins within `edge` of 0 the limit is -edge, which is larger than
 * all rounding errors, so that a switch is not reversed at once. Changes s. */
double polynomial_first_fall_s(double *s, int degree, double wide, double edge);

#endif
