#include "host/base/parallel_for.h"

#include <pthread.h>
#include <stdbool.h>

struct worker {
    pthread_t thread;
    parallel_work *work;
    void *context;
    size_t from, stride;
};

static void *run_worker(void *context)
{
    const struct worker *w = context;
    w->work(w->context, w->from, w->stride);
    return NULL;
}

void parallel_for(unsigned threads, parallel_work *work, void *context)
{
    struct worker worker[PARALLEL_THREADS_MAX];
    bool started[PARALLEL_THREADS_MAX] = {false};
    unsigned count = threads < 1u                   ? 1u
                   : threads < PARALLEL_THREADS_MAX ? threads
                                                    : PARALLEL_THREADS_MAX;
    for (unsigned t = 0; t < count; t++) {
        worker[t] = (struct worker){.work = work, .context = context, .from = t, .stride = count};
        started[t] = t > 0 && pthread_create(&worker[t].thread, NULL, run_worker, &worker[t]) == 0;
    }
    for (unsigned t = 0; t < count; t++) {
        if (!started[t])
            run_worker(&worker[t]);
    }
    for (unsigned t = 0; t < count; t++) {
        if (started[t])
            pthread_join(worker[t].thread, NULL);
    }
}
