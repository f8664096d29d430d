#include "tests/stability/bins.h"

#include <math.h>
#include <stdio.h>

static const double edges[BINS - 1] = {0.1, 0.3, 1.0, 3.0, 10.0};

void bins_add(struct bins *bins, double ratio)
{
    size_t i = 0;
    while (i < BINS - 1 && ratio > edges[i])
        i++;
    bins->counts[i]++;
    bins->worst = fmax(bins->worst, ratio);
}

void bins_print(const struct bins *bins, const char *what)
{
    printf("  %-5s", what);
    for (size_t i = 0; i < BINS - 1; i++)
        printf("  <=%g: %zu", edges[i], bins->counts[i]);
    printf("  more: %zu  worst: %.3g\n", bins->counts[BINS - 1], bins->worst);
}
