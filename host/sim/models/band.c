#include "host/sim/models/band.h"

#include <math.h>
#include <string.h>

void band_load(int size, double x, const double *mass, double y, const double *by_p, double z,
               const double *by_v, double *a)
{
    for (int i = 0; i < size; i++) {
        double *row = a + (size_t)i * BAND_WIDTH;
        size_t from = (size_t)i * MODEL_ROW;
        for (size_t k = 0; k < MODEL_ROW; k++)
            row[k] = x * mass[from + k] + y * by_p[from + k] + z * by_v[from + k];
        for (size_t k = MODEL_ROW; k < BAND_WIDTH; k++)
            row[k] = 0.0;
    }
}

bool band_factor(int size, double *a, int *pivot)
{
    for (int i = 0; i < size; i++) {
        int below = i + MODEL_BAND < size ? MODEL_BAND : size - 1 - i;
        double *row = a + (size_t)i * BAND_WIDTH + MODEL_BAND; /* row[0] is the diagonal */
        int best = 0;
        double most = fabs(row[0]);
        for (int r = 1; r <= below; r++) {
            double value = fabs(a[(size_t)(i + r) * BAND_WIDTH + MODEL_BAND - (size_t)r]);
            if (value > most) {
                most = value;
                best = r;
            }
        }
        if (!(most > 0.0) || !isfinite(most))
            return false;
        pivot[i] = best;
        if (best > 0) {
            double *other = a + (size_t)(i + best) * BAND_WIDTH + MODEL_BAND - best;
            for (int k = 0; k <= 2 * MODEL_BAND; k++) {
                double kept = row[k];
                row[k] = other[k];
                other[k] = kept;
            }
        }
        double inverse = 1.0 / row[0];
        for (int r = 1; r <= below; r++) {
            double *under = a + (size_t)(i + r) * BAND_WIDTH + MODEL_BAND - r;
            if (under[0] == 0.0)
                continue;
            double factor = under[0] * inverse;
            under[0] = factor;
            for (int k = 1; k <= 2 * MODEL_BAND; k++)
                under[k] -= factor * row[k];
        }
    }
    return true;
}

void band_solve(int size, const double *a, const int *pivot, double *x)
{
    for (int i = 0; i < size; i++) {
        int below = i + MODEL_BAND < size ? MODEL_BAND : size - 1 - i;
        if (pivot[i] > 0) {
            double kept = x[i];
            x[i] = x[i + pivot[i]];
            x[i + pivot[i]] = kept;
        }
        for (int r = 1; r <= below; r++)
            x[i + r] -= a[(size_t)(i + r) * BAND_WIDTH + MODEL_BAND - (size_t)r] * x[i];
    }
    for (int i = size - 1; i >= 0; i--) {
        const double *row = a + (size_t)i * BAND_WIDTH + MODEL_BAND;
        int right = i + 2 * MODEL_BAND < size ? 2 * MODEL_BAND : size - 1 - i;
        double sum = x[i];
        for (int k = 1; k <= right; k++)
            sum -= row[k] * x[i + k];
        x[i] = sum / row[0];
    }
}

void band_multiply(int size, const double *rows, const double *x, double *y)
{
    for (int i = 0; i < size; i++) {
        int low = i < MODEL_BAND ? MODEL_BAND - i : 0;
        int high = i + MODEL_BAND < size ? 2 * MODEL_BAND : MODEL_BAND + size - 1 - i;
        double sum = 0.0;
        for (int k = low; k <= high; k++)
            sum += rows[(size_t)i * MODEL_ROW + (size_t)k] * x[i + k - MODEL_BAND];
        y[i] = sum;
    }
}
