/* Polynomial: the value of a switch condition within a step (chain_motion.h), s[0] + s[1] t + ... +
 * s[degree] t^degree, and the time at which it falls below 0. */
#ifndef MATRIG_HOST_SIM_SOLVERS_POLYNOMIAL_H
#define MATRIG_HOST_SIM_SOLVERS_POLYNOMIAL_H

#define POLYNOMIAL_DEGREE_MAX 20 /* largest degree */

double polynomial_value(const double *s, int degree, double t);

/* Returns the time from 0 to `wide` at which a condition s falls below 0; INFINITY: never. If it
 * begins within `edge` of 0, the limit is -edge instead of 0, so that a switch is not reversed at
 * once; `edge` is larger than all rounding errors. Changes s. */
double polynomial_first_negative_s(double *s, int degree, double wide, double edge);

#endif
