#include "host/sim/models/lanes.h"

#include "host/sim/models/lanes_math.h"

#define LOG2_E   1.44269504088896340736
#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW  1.90821492927058770002e-10
/* 1.5 * 2^52: adding it leaves the nearest integer in the last bits */
#define ROUND    6755399441055744.0

/* tanh x = 1 - 2/(e^2x + 1) for x > 0. e^y = 2^k e^r with |r| <= ln 2 / 2; Taylor's series ends
 * below 1e-17. */
LANES_INLINE lanes tanh_of(lanes x)
{
    const lanes_mask sign = (lanes_mask)lanes_all(-0.0);
    lanes size = (lanes)((lanes_mask)x & ~sign);
    lanes y = 2.0 * lanes_pick(size < 20.0, size, lanes_all(20.0));
    lanes k = y * LOG2_E + ROUND;
    lanes whole = k - ROUND;
    lanes r = (y - whole * LN2_HIGH) - whole * LN2_LOW;
    lanes r2 = r * r, r4 = r2 * r2;
    lanes low = (1.0 + r) + r2 * (1.0 / 2 + r * (1.0 / 6)) + r4 * (1.0 / 24 + r * (1.0 / 120));
    lanes high = (1.0 / 720 + r * (1.0 / 5040)) + r2 * (1.0 / 40320 + r * (1.0 / 362880)) +
                 r4 * ((1.0 / 3628800 + r * (1.0 / 39916800)) +
                       r2 * (1.0 / 479001600 + r * (1.0 / 6227020800)));
    lanes power = (lanes)(((lanes_mask)k + 1023) << 52);
    lanes t = 1.0 - 2.0 / (power * (low + r4 * r2 * high) + 1.0);
    return (lanes)((lanes_mask)t | ((lanes_mask)x & sign));
}

LANES void lanes_tanh(const double *restrict from, double scale, double *restrict to, int count)
{
    if (count < LANES_COUNT) {
        lanes x = {0.0};
        for (int i = 0; i < count; i++)
            x[i] = from[2 * i];
        x = tanh_of(scale * x);
        for (int i = 0; i < count; i++)
            to[i] = x[i];
        return;
    }
    LANES_EACH(k, 0, count)
    {
        /* the last of these is from[2 k + 6]: nothing beyond is there */
        lanes x = __builtin_shufflevector(lanes_load(from + 2 * k), lanes_load(from + 2 * k + 3), 0,
                                          2, 5, 7);
        lanes_store(to + k, tanh_of(scale * x));
    }
}
