/* Indices of sensitivity: what share of a quantity's variance a key makes.
 *
 * First order: what knowing that key alone would take off the variance,
 * S = 1 - E[(f_B - f_ABk)^2] / 2V. Total: what is left when all others are known,
 * T = E[(f_A - f_ABk)^2] / 2V (Jansen 1999, Saltelli 2010). A and B are two samples of points, ABk
 * is A with key k from B, V is the variance over A and B. T - S is what the key does together with
 * others. Intervals: 95 % by bootstrap over points. An estimate may lie a little below 0 or above
 * 1. */
#ifndef MATRIG_HOST_SWEEP_INDICES_H
#define MATRIG_HOST_SWEEP_INDICES_H

#include <stdbool.h>
#include <stddef.h>

struct sweep_index {
    double value, low, high;
};

struct sweep_influence {
    struct sweep_index first, total;
};

/* `values` by block, as design_radial: A, B, AB1 ..; NaN: none. A point of which any value is
 * missing is left out. `keys` results into `influence`; points that were of use into *used. False,
 * and nothing is said: fewer than 8 points, no variance, no memory. */
bool sweep_indices(const double *values, size_t points, size_t keys,
                   struct sweep_influence *influence, size_t *used);

#endif
