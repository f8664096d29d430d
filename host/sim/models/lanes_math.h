/* Four numbers at a time, in vector instructions where the machine has them. Every lane does what
 * one number alone would, in the same order, and no product is fused with a sum
 * (-ffp-contract=off): the same bits on every machine. Vectors stay within inlined functions, so no
 * calling convention is in it. Private to this folder. */
#ifndef MATRIG_HOST_SIM_MODELS_LANES_MATH_H
#define MATRIG_HOST_SIM_MODELS_LANES_MATH_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "host/sim/models/lanes.h"

#define LANES_COUNT 4

#define LANES_INLINE static inline __attribute__((always_inline))

typedef double lanes __attribute__((vector_size(8 * LANES_COUNT)));
typedef int64_t lanes_mask __attribute__((vector_size(8 * LANES_COUNT))); /* 0 or -1 each */
typedef int32_t lanes_int __attribute__((vector_size(4 * LANES_COUNT)));

/* Four at a time from `from` to `to`, at least four in all: where the last four would be less they
 * begin earlier, and some are computed twice. */
#define LANES_EACH(k, from, to)                                                             \
    for (int k = (from); k < (to); k = k + LANES_COUNT < (to) && k + 2 * LANES_COUNT > (to) \
                                         ? (to)-LANES_COUNT                                 \
                                         : k + LANES_COUNT)

LANES_INLINE lanes lanes_load(const double *from)
{
    lanes x;
    memcpy(&x, from, sizeof x);
    return x;
}

LANES_INLINE void lanes_store(double *to, lanes x)
{
    memcpy(to, &x, sizeof x);
}

LANES_INLINE lanes lanes_all(double x)
{
    return (lanes){x, x, x, x};
}

/* Of 2 x 4 doubles those at even and at odd places. */
LANES_INLINE lanes lanes_even(lanes a, lanes b)
{
    return __builtin_shufflevector(a, b, 0, 2, 4, 6);
}

LANES_INLINE lanes lanes_odd(lanes a, lanes b)
{
    return __builtin_shufflevector(a, b, 1, 3, 5, 7);
}

/* Modes, a byte each. The shifts are what compilers make vector instructions of. */
LANES_INLINE lanes_int lanes_modes(const signed char *from)
{
    int32_t word;
    memcpy(&word, from, sizeof word);
    lanes_int x = {word, word, word, word};
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    return (x << (lanes_int){0, 8, 16, 24}) >> 24;
#else
    return (x << (lanes_int){24, 16, 8, 0}) >> 24;
#endif
}

LANES_INLINE lanes lanes_number(lanes_int x)
{
    return __builtin_convertvector(x, lanes);
}

LANES_INLINE lanes_mask lanes_wide(lanes_int mask)
{
    return __builtin_convertvector(mask, lanes_mask);
}

LANES_INLINE lanes lanes_pick(lanes_mask mask, lanes yes, lanes no)
{
    return (lanes)((mask & (lanes_mask)yes) | (~mask & (lanes_mask)no));
}

LANES_INLINE lanes lanes_root(lanes x)
{
    return (lanes){sqrt(x[0]), sqrt(x[1]), sqrt(x[2]), sqrt(x[3])};
}

LANES_INLINE lanes lanes_copysign(lanes size, lanes sign)
{
    const lanes_mask bit = (lanes_mask)lanes_all(-0.0);
    return (lanes)(((lanes_mask)size & ~bit) | ((lanes_mask)sign & bit));
}

#endif
