/* Band: solving with the banded matrices of a model, partial pivoting, O(n). Half-bandwidth
 * MODEL_BAND. */
#ifndef MATRIG_HOST_SIM_MODELS_BAND_H
#define MATRIG_HOST_SIM_MODELS_BAND_H

#include <stdbool.h>

#include "host/sim/models/model.h"

#define BAND_WIDTH (3 * MODEL_BAND + 1) /* room for what pivoting moves up */

/* a = x mass + y by_p + z by_v, rows spread out for band_factor: entry (i, k) at [i BAND_WIDTH + k
 * - i + MODEL_BAND]. */
void band_load(int size, double x, const double *mass, double y, const double *by_p, double z,
               const double *by_v, double *a);

/* Factor in place. False when singular or not finite. */
bool band_factor(int size, double *a, int *pivot);
void band_solve(int size, const double *a, const int *pivot, double *x);

/* y = rows (of model_linearise) times x. */
void band_multiply(int size, const double *rows, const double *x, double *y);

#endif
