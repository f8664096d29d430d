#include "host/sim/models/vector.h"

#include <stdint.h>
#include <string.h>

#define LOG2_E   1.44269504088896340736
#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW  1.90821492927058770002e-10
/* 1.5 * 2^52: adding it leaves the nearest integer in the last bits */
#define ROUND    6755399441055744.0
#define COUNT    4

typedef double four __attribute__((vector_size(8 * COUNT)));
typedef int64_t four_bits __attribute__((vector_size(8 * COUNT)));

/* tanh x = 1 - 2/(e^2x + 1) for x > 0. e^y = 2^k e^r with |r| <= ln 2 / 2; Taylor's series ends
 * below 1e-17. */
static inline __attribute__((always_inline)) four tanh_of(four x)
{
    const four_bits sign = (four_bits)(four){-0.0, -0.0, -0.0, -0.0};
    four size = (four)((four_bits)x & ~sign);
    const four_bits small = size < 20.0, most = (four_bits)(four){20.0, 20.0, 20.0, 20.0};
    four y = 2.0 * (four)((small & (four_bits)size) | (~small & most));
    four k = y * LOG2_E + ROUND;
    four whole = k - ROUND;
    four r = (y - whole * LN2_HIGH) - whole * LN2_LOW;
    four r2 = r * r, r4 = r2 * r2;
    four low = (1.0 + r) + r2 * (1.0 / 2 + r * (1.0 / 6)) + r4 * (1.0 / 24 + r * (1.0 / 120));
    four high = (1.0 / 720 + r * (1.0 / 5040)) + r2 * (1.0 / 40320 + r * (1.0 / 362880)) +
                r4 * ((1.0 / 3628800 + r * (1.0 / 39916800)) +
                      r2 * (1.0 / 479001600 + r * (1.0 / 6227020800)));
    four power = (four)(((four_bits)k + 1023) << 52);
    four t = 1.0 - 2.0 / (power * (low + r4 * r2 * high) + 1.0);
    return (four)((four_bits)t | ((four_bits)x & sign));
}

VECTOR void vector_tanh(const double *restrict from, double scale, double *restrict to, int count)
{
    int i = 0;
    for (; i + COUNT <= count; i += COUNT) {
        four x = {from[2 * i], from[2 * i + 2], from[2 * i + 4], from[2 * i + 6]};
        x = tanh_of(scale * x);
        memcpy(to + i, &x, sizeof x);
    }
    for (; i < count; i++)
        to[i] = tanh_of((four){scale * from[2 * i]})[0];
}
