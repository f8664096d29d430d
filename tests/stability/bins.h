/* Bins: ratios of a difference to what was stated, counted up to 0.1, 0.3, 1, 3, 10 and beyond. */
#ifndef MATRIG_TESTS_STABILITY_BINS_H
#define MATRIG_TESTS_STABILITY_BINS_H

#include <stddef.h>

#define BINS 6

struct bins {
    size_t counts[BINS];
    double worst;
};

void bins_add(struct bins *bins, double ratio);

/* One line on standard output. */
void bins_print(const struct bins *bins, const char *what);

#endif
