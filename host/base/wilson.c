#include "host/base/wilson.h"

#include <math.h>

struct wilson wilson_of(size_t count, size_t of)
{
    const double z = 1.959963984540054; /* of the normal distribution, 2.5 % beyond */
    if (of == 0)
        return (struct wilson){0.0, 1.0};
    double n = (double)of, p = (double)count / n, z2 = z * z / n;
    double middle = (p + z2 / 2.0) / (1.0 + z2),
           half = z / (1.0 + z2) * sqrt(p * (1.0 - p) / n + z2 / (4.0 * n));
    return (struct wilson){fmax(0.0, middle - half), fmin(1.0, middle + half)};
}
