/* Distributes pieces of work over threads. Thread t of n does the pieces t, t + n, ..., so the
 * result does not depend on the order in which threads run. */
#ifndef MATRIG_HOST_BASE_PARALLEL_FOR_H
#define MATRIG_HOST_BASE_PARALLEL_FOR_H

#include <stddef.h>

#define PARALLEL_THREADS_MAX 256u

/* Processes the pieces `from`, `from + every`, `from + 2 every`, ... of the work that `context`
 * describes. */
typedef void parallel_work(void *context, size_t from, size_t every);

/* Runs `threads` threads, 1 to PARALLEL_THREADS_MAX, and returns when all pieces are done. If a
 * thread cannot be started, the calling thread does its pieces. */
void parallel_for(unsigned threads, parallel_work *work, void *context);

#endif
