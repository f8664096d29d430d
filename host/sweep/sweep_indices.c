#include "host/sweep/sweep_indices.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "host/base/ordered.h"

#define LEAST_POINTS 8
#define DRAWS        1000

/* xorshift64 (Marsaglia 2003): the same draws in every run. */
static size_t draw(uint64_t *state, size_t count)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (size_t)((double)(*state >> 11) * 0x1p-53 * (double)count);
}

/* First order and total. */
struct pair {
    double first, total;
};

/* Of the points `row`; NaN where nothing varies. */
static struct pair pair_of(const double *values, size_t points, size_t key, const size_t *row,
                           size_t count)
{
    const double *a = values, *b = values + points, *ab = values + (2 + key) * points;
    double sum = 0.0, squares = 0.0, first = 0.0, total = 0.0, n = 2.0 * (double)count;
    for (size_t i = 0; i < count; i++) {
        size_t r = row[i];
        sum += a[r] + b[r];
        first += (b[r] - ab[r]) * (b[r] - ab[r]);
        total += (a[r] - ab[r]) * (a[r] - ab[r]);
    }
    for (size_t i = 0; i < count; i++) {
        double from_a = a[row[i]] - sum / n, from_b = b[row[i]] - sum / n;
        squares += from_a * from_a + from_b * from_b;
    }
    if (!(squares > 0.0))
        return (struct pair){(double)NAN, (double)NAN};
    double twice_variance = 2.0 * squares / n;
    return (struct pair){1.0 - first / (double)count / twice_variance,
                         total / (double)count / twice_variance};
}

static void bound(struct sweep_index *index, double *drawn, size_t count)
{
    order_numbers(drawn, count);
    index->low = count ? drawn[(size_t)(0.025 * (double)count)] : (double)NAN;
    index->high = count ? drawn[(size_t)(0.975 * (double)count)] : (double)NAN;
}

static void estimate(const double *values, size_t points, size_t key, const size_t *row,
                     size_t count, size_t *picked, double *drawn, struct sweep_influence *result)
{
    uint64_t state = 0x9e3779b97f4a7c15u;
    size_t good = 0;
    struct pair pair = pair_of(values, points, key, row, count);
    result->first.value = pair.first;
    result->total.value = pair.total;
    for (size_t d = 0; d < DRAWS; d++) {
        for (size_t i = 0; i < count; i++)
            picked[i] = row[draw(&state, count)];
        pair = pair_of(values, points, key, picked, count);
        if (isnan(pair.first))
            continue;
        drawn[good] = pair.first;
        drawn[DRAWS + good++] = pair.total;
    }
    bound(&result->first, drawn, good);
    bound(&result->total, drawn + DRAWS, good);
}

/* Points of which every value is there. */
static size_t complete(const double *values, size_t points, size_t keys, size_t *row)
{
    size_t count = 0;
    for (size_t i = 0; i < points; i++) {
        bool whole = true;
        for (size_t block = 0; block < keys + 2; block++)
            whole &= isfinite(values[block * points + i]) != 0;
        if (whole)
            row[count++] = i;
    }
    return count;
}

bool sweep_indices(const double *values, size_t points, size_t keys,
                   struct sweep_influence *influence, size_t *used)
{
    size_t *row = calloc(2 * points + 1, sizeof *row);
    double *drawn = calloc(2 * (size_t)DRAWS, sizeof *drawn);
    bool good = row && drawn;
    *used = good ? complete(values, points, keys, row) : 0;
    good = good && *used >= LEAST_POINTS && !isnan(pair_of(values, points, 0, row, *used).first);
    for (size_t k = 0; good && k < keys; k++)
        estimate(values, points, k, row, *used, row + points, drawn, &influence[k]);
    free(row);
    free(drawn);
    return good;
}
