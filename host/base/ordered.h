/* Numbers in order, for medians and percentiles. */
#ifndef MATRIG_HOST_BASE_ORDERED_H
#define MATRIG_HOST_BASE_ORDERED_H

#include <stddef.h>

/* Sorts in place, the least first; none of them may be NaN. */
void order_numbers(double *values, size_t count);

#endif
