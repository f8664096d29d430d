/* Elementary functions of the same bits on every processor. Those of the C library have variants
 * for processors with and without fused multiply-add, which differ in the last bit now and then; a
 * simulation with bounces and slip makes another landing of that. These are sums and products in a
 * fixed order, and sqrt, which IEEE 754 fixes. Errors: at most 2 units in the last place, of
 * elementary_pow 2 + |y log x|; sine, cosine and tangent are for angles, |x| at most 10. Special
 * values are those of C. */
#ifndef MATRIG_HOST_BASE_ELEMENTARY_H
#define MATRIG_HOST_BASE_ELEMENTARY_H

double elementary_exp(double x);
double elementary_expm1(double x);
double elementary_log(double x);
double elementary_pow(double x, double y); /* x not negative */
double elementary_sin(double x);
double elementary_cos(double x);
double elementary_tan(double x);
double elementary_asin(double x);
double elementary_acos(double x);
double elementary_tanh(double x);

#endif
