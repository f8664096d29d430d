#include "host/base/progress.h"

#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

#include "host/base/monotonic_clock.h"

#define POLL_MS 200

static void *print_lines(void *context)
{
    struct progress *progress = context;
    struct pollfd end = {.fd = progress->stop_pipe[0], .events = POLLIN};
    while (poll(&end, 1, POLL_MS) == 0) {
        double now_s = monotonic_s();
        pthread_mutex_lock(&progress->lock);
        if (now_s >= progress->next_s) {
            fprintf(stderr, "matrig: %s: running for %.0f s: %s%s%s%s\n", progress->command,
                    now_s - progress->begin_s, progress->text, *progress->advice ? "; " : "",
                    progress->advice, *progress->advice ? " would be quicker" : "");
            progress->next_s = now_s + PROGRESS_INTERVAL_S;
        }
        pthread_mutex_unlock(&progress->lock);
    }
    return NULL;
}

void progress_begin(struct progress *progress, const char *who, const char *quicker, bool quiet)
{
    *progress = (struct progress){.command = who, .advice = quicker, .text = "started"};
    progress->begin_s = monotonic_s();
    progress->next_s = progress->begin_s + PROGRESS_INTERVAL_S;
    pthread_mutex_init(&progress->lock, NULL);
    if (quiet || pipe(progress->stop_pipe) != 0)
        return;
    progress->is_running = pthread_create(&progress->thread, NULL, print_lines, progress) == 0;
    if (!progress->is_running) {
        close(progress->stop_pipe[0]);
        close(progress->stop_pipe[1]);
    }
}

void progress_set(struct progress *progress, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    pthread_mutex_lock(&progress->lock);
    vsnprintf(progress->text, sizeof progress->text, format, arguments);
    pthread_mutex_unlock(&progress->lock);
    va_end(arguments);
}

void progress_end(struct progress *progress)
{
    if (progress->is_running) {
        close(progress->stop_pipe[1]); /* closing the pipe ends the thread */
        pthread_join(progress->thread, NULL);
        close(progress->stop_pipe[0]);
        progress->is_running = false;
    }
    pthread_mutex_destroy(&progress->lock);
}
