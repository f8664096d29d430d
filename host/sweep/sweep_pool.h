/* Cases in processes of their own, several at a time: a case that crashes or hangs costs that
 * case. */
#ifndef MATRIG_HOST_SWEEP_POOL_H
#define MATRIG_HOST_SWEEP_POOL_H

#include <signal.h>

#include "host/sweep/sweep_case.h"
#include "host/sweep/sweep_results.h"

struct sweep_pool {
    const struct sweep_study *study;
    sweep_simulate *simulate;
    struct sweep_results *results;
    const size_t *todo; /* indices of cases, in the order they are started */
    size_t count;
    unsigned jobs;    /* processes at a time, 1.. */
    double timeout_s; /* of a case; INFINITY: none */
    /* set by a signal: processes are ended, their cases not recorded */
    volatile sig_atomic_t *stop;
    void (*progress)(void *ctx, size_t done, size_t failed);
    void *progress_ctx;
    size_t done, failed; /* so far; failed are recorded too */
};

/* MR_OK also when it was stopped. MR_IO: a line could not be written; nothing goes on then. No
 * process is left behind, whatever the end; when this process is killed the kernel ends them. */
enum mr_status sweep_pool_run(struct sweep_pool *pool, struct error *error);

#endif
