/* Wilson's interval of a share: within it the true one lies with 95 %. (E. B. Wilson, J. Am. Stat.
 * Assoc. 22 (1927) 209.) */
#ifndef MATRIG_HOST_BASE_WILSON_H
#define MATRIG_HOST_BASE_WILSON_H

#include <stddef.h>

struct wilson {
    double low, high;
};

/* `count` of `of`; of none: 0 to 1. */
struct wilson wilson_of(size_t count, size_t of);

#endif
