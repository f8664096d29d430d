#include "host/sim/models/lanes.h"

#include <stdint.h>

#if defined __x86_64__ && !defined __clang__ /* clang 14 gives clones a name that nobody links to */
#define LANES __attribute__((target_clones("avx2", "default")))
#else
#define LANES
#endif
#define LOG2_E   1.44269504088896340736
#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW  1.90821492927058770002e-10
/* 1.5 * 2^52: adding it leaves the nearest integer in the last bits */
#define ROUND    6755399441055744.0

union pattern {
    double value;
    uint64_t bits;
};

/* tanh x = 1 - 2/(e^2x + 1) for x > 0. e^y = 2^k e^r with |r| <= ln 2 / 2; Taylor's series ends
 * below 1e-17. */
LANES void lanes_tanh(const double *restrict from, double scale, double *restrict to, int count)
{
    for (int i = 0; i < count; i++) {
        union pattern x = {scale * from[2 * i]}, size = {.bits = x.bits & 0x7fffffffffffffffu};
        double y = 2.0 * (size.value < 20.0 ? size.value : 20.0);
        union pattern k = {y * LOG2_E + ROUND};
        double whole = k.value - ROUND;
        double r = (y - whole * LN2_HIGH) - whole * LN2_LOW;
        double r2 = r * r, r4 = r2 * r2;
        double low = (1.0 + r) + r2 * (1.0 / 2 + r * (1.0 / 6)) + r4 * (1.0 / 24 + r * (1.0 / 120));
        double high = (1.0 / 720 + r * (1.0 / 5040)) + r2 * (1.0 / 40320 + r * (1.0 / 362880)) +
                      r4 * ((1.0 / 3628800 + r * (1.0 / 39916800)) +
                            r2 * (1.0 / 479001600 + r * (1.0 / 6227020800)));
        union pattern power = {.bits = (k.bits + 1023) << 52};
        union pattern t = {1.0 - 2.0 / (power.value * (low + r4 * r2 * high) + 1.0)};
        t.bits |= x.bits & 0x8000000000000000u;
        to[i] = t.value;
    }
}
