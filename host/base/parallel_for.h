/* Work shared by threads. Thread t of n does the pieces t, t + n, ..., so the result does not
 * depend on the order in which threads run. */
#ifndef MATRIG_HOST_BASE_PARALLEL_FOR_H
#define MATRIG_HOST_BASE_PARALLEL_FOR_H

#include <stddef.h>

#define PARALLEL_MAX 256u

/* Does the pieces `from`, `from + every`, ... of the context. */
typedef void parallel_work(void *context, size_t from, size_t every);

/* Runs 1 to PARALLEL_MAX threads and returns when all pieces are done. The caller does the pieces
 * of a thread that cannot be started. */
void parallel_for(unsigned threads, parallel_work *work, void *context);

#endif
