/* How much a test takes on: `make long` sets MATRIG_LONG, and then all cases are tried; `make test`
 * tries the first of them, or fewer points of the same kind. */
#ifndef TESTS_LONG_H
#define TESTS_LONG_H

#include <stdlib.h>

/* `few` of them in make test, `all` in make long */
static inline unsigned tests_take(unsigned few, unsigned all)
{
    return getenv("MATRIG_LONG") ? all : few;
}

#endif
