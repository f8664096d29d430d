#include "host/base/parallel_for.h"

#include <pthread.h>
#include <stdbool.h>

struct worker {
    pthread_t thread;
    parallel_work *work;
    void *context;
    size_t from, every;
};

static void *begin(void *context)
{
    const struct worker *w = context;
    w->work(w->context, w->from, w->every);
    return NULL;
}

void parallel_for(unsigned threads, parallel_work *work, void *context)
{
    struct worker worker[PARALLEL_MOST];
    bool started[PARALLEL_MOST] = {false};
    unsigned count = threads < 1u ? 1u : threads < PARALLEL_MOST ? threads : PARALLEL_MOST;
    for (unsigned t = 0; t < count; t++) {
        worker[t] = (struct worker){.work = work, .context = context, .from = t, .every = count};
        started[t] = t > 0 && pthread_create(&worker[t].thread, NULL, begin, &worker[t]) == 0;
    }
    for (unsigned t = 0; t < count; t++) {
        if (!started[t])
            begin(&worker[t]);
    }
    for (unsigned t = 0; t < count; t++) {
        if (started[t])
            pthread_join(worker[t].thread, NULL);
    }
}
