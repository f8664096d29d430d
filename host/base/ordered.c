#include "host/base/ordered.h"

#include <stdlib.h>

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void order_numbers(double *values, size_t count)
{
    if (count > 1)
        qsort(values, count, sizeof *values, ascending);
}
