/* Elementary functions with identical results on every processor. The functions of the C library
 * have variants for processors with and without fused multiply-add, which sometimes differ in the
 * last bit; in a simulation with bounces and slip, such a difference changes the landing. The
 * functions here are sums and products in a fixed order, and sqrt, which IEEE 754 defines exactly.
 * Errors are at most 2 units in the last place (elementary_pow: 2 + |y log x|). Arguments of sine,
 * cosine and tangent are angles with |x| at most 10. Special values are those of C. */
#ifndef MATRIG_HOST_BASE_ELEMENTARY_H
#define MATRIG_HOST_BASE_ELEMENTARY_H

double elementary_exp(double x);
double elementary_expm1(double x);
double elementary_log(double x);
double elementary_pow(double x, double y); /* x must not be negative */
double elementary_sin(double x);
double elementary_cos(double x);
double elementary_tan(double x);
double elementary_asin(double x);
double elementary_acos(double x);
double elementary_tanh(double x);

#endif
