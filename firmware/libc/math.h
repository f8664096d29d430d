/* The part of <math.h> that the image uses; sqrt is in libc.c. */
#ifndef MATRIG_FIRMWARE_LIBC_MATH_H
#define MATRIG_FIRMWARE_LIBC_MATH_H

#define NAN         __builtin_nanf("")
#define INFINITY    __builtin_inff()
#define isnan(x)    __builtin_isnan(x)
#define isfinite(x) __builtin_isfinite(x)
#define fabs(x)     __builtin_fabs(x)
#define fabsf(x)    __builtin_fabsf(x)

/* Rounded to nearest, as IEEE 754 requires: the result has the same bits as on any host. */
double sqrt(double x);

#endif
