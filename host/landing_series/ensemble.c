#include <pthread.h>
#include <stdlib.h>

#include "host/landing_series/play.h"

struct work {
    const struct landing_series *series;
    bool all;
    struct series_run *runs;
    pthread_mutex_t lock;
    size_t next, done;
    void (*progress)(void *ctx, size_t done, size_t of);
    void *ctx;
};

static void *work_on(void *argument)
{
    struct work *work = argument;
    for (;;) {
        pthread_mutex_lock(&work->lock);
        size_t mine = work->next < work->series->seeds ? work->next++ : SIZE_MAX;
        pthread_mutex_unlock(&work->lock);
        if (mine == SIZE_MAX)
            return NULL;
        series_play(work->series, work->series->first_seed + mine, work->all, &work->runs[mine]);
        pthread_mutex_lock(&work->lock);
        work->done++;
        if (work->progress)
            work->progress(work->ctx, work->done, work->series->seeds);
        pthread_mutex_unlock(&work->lock);
    }
}

enum mr_status series_ensemble(const struct landing_series *series, int jobs, bool all,
                               void (*progress)(void *ctx, size_t done, size_t of), void *ctx,
                               struct series_run *runs, struct error *error)
{
    struct work work = {
        .series = series, .all = all, .runs = runs, .progress = progress, .ctx = ctx};
    size_t threads = (size_t)jobs < series->seeds ? (size_t)jobs : series->seeds, started = 0;
    pthread_t *thread = calloc(threads + 1, sizeof *thread);
    if (!thread)
        return error_set(error, MR_FULL, "out of memory: %zu threads; give a smaller -j", threads);
    pthread_mutex_init(&work.lock, NULL);
    while (started + 1 < threads && pthread_create(&thread[started], NULL, work_on, &work) == 0)
        started++;
    work_on(&work); /* this thread is one of them, and enough alone */
    for (size_t i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
    pthread_mutex_destroy(&work.lock);
    free(thread);
    return MR_OK;
}
