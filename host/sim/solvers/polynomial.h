/* Polynomial: what a switch is within a step that is a power series (chain_motion.h), s[0] + s[1] t
 * + ... + s[degree] t^degree, and when it falls below 0. */
#ifndef MATRIG_HOST_SIM_SOLVERS_POLYNOMIAL_H
#define MATRIG_HOST_SIM_SOLVERS_POLYNOMIAL_H

#define POLYNOMIAL_DEGREE 20 /* at most */

double polynomial_value(const double *s, int degree, double t);

/* When what must not be below 0 falls below it: within 0..wide, or INFINITY. What begins within
 * `edge` of 0 may fall so far: that is above all rounding, so that a switch is not taken back in
 * the same moment. Changes s. */
double polynomial_falls_s(double *s, int degree, double wide, double edge);

#endif
