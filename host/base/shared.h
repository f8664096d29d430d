/* Work shared by threads: each does every so-maniest piece, so what comes out does not depend on
 * who did it. */
#ifndef MATRIG_HOST_BASE_SHARED_H
#define MATRIG_HOST_BASE_SHARED_H

#include <stddef.h>

#define SHARED_MOST 16u

/* Pieces `from`, `from + every` ... of the context's. */
typedef void shared_work(void *context, size_t from, size_t every);

/* Returns when all is done, by 1 to SHARED_MOST threads; what no thread can be had for, the caller
 * does. */
void shared_run(unsigned threads, shared_work *work, void *context);

#endif
