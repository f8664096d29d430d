#include <pthread.h>
#include <stdlib.h>

#include "host/campaign/play.h"

struct work {
    const struct campaign *campaign;
    bool all;
    struct campaign_run *runs;
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
        size_t mine = work->next < work->campaign->seeds ? work->next++ : SIZE_MAX;
        pthread_mutex_unlock(&work->lock);
        if (mine == SIZE_MAX)
            return NULL;
        campaign_play(work->campaign, work->campaign->first_seed + mine, work->all,
                      &work->runs[mine]);
        pthread_mutex_lock(&work->lock);
        work->done++;
        if (work->progress)
            work->progress(work->ctx, work->done, work->campaign->seeds);
        pthread_mutex_unlock(&work->lock);
    }
}

enum mr_status campaign_ensemble(const struct campaign *campaign, int jobs, bool all,
                                 void (*progress)(void *ctx, size_t done, size_t of), void *ctx,
                                 struct campaign_run *runs, struct error *error)
{
    struct work work = {
        .campaign = campaign, .all = all, .runs = runs, .progress = progress, .ctx = ctx};
    size_t threads = (size_t)jobs < campaign->seeds ? (size_t)jobs : campaign->seeds, started = 0;
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
