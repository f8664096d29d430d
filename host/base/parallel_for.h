/* Work shared by threads: thread t of n does pieces t, t + n, ... so the result does not depend on
 * which thread did a piece. */
#ifndef MATRIG_HOST_BASE_PARALLEL_FOR_H
#define MATRIG_HOST_BASE_PARALLEL_FOR_H

#include <stddef.h>

#define PARALLEL_MOST 256u

/* Pieces `from`, `from + every` ... of the context's. */
typedef void parallel_work(void *context, size_t from, size_t every);

/* Returns when all is done, by 1 to PARALLEL_MOST threads; the caller does the pieces of a thread
 * that cannot be started. */
void parallel_for(unsigned threads, parallel_work *work, void *context);

#endif
