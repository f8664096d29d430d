#include "host/base/progress.h"

#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

#include "host/base/monotonic_clock.h"

#define POLL_MS 200

static void *print_lines(void *context)
{
    struct progress *u = context;
    struct pollfd end = {.fd = u->stop_pipe[0], .events = POLLIN};
    while (poll(&end, 1, POLL_MS) == 0) {
        double now_s = monotonic_s();
        pthread_mutex_lock(&u->lock);
        if (now_s >= u->next_s) {
            fprintf(stderr, "matrig: %s: running for %.0f s: %s%s%s%s\n", u->command,
                    now_s - u->begin_s, u->text, *u->advice ? "; " : "", u->advice,
                    *u->advice ? " would be quicker" : "");
            u->next_s = now_s + PROGRESS_EVERY_S;
        }
        pthread_mutex_unlock(&u->lock);
    }
    return NULL;
}

void progress_begin(struct progress *u, const char *who, const char *quicker, bool quiet)
{
    *u = (struct progress){.command = who, .advice = quicker, .text = "started"};
    u->begin_s = monotonic_s();
    u->next_s = u->begin_s + PROGRESS_EVERY_S;
    pthread_mutex_init(&u->lock, NULL);
    if (quiet || pipe(u->stop_pipe) != 0)
        return;
    u->is_running = pthread_create(&u->thread, NULL, print_lines, u) == 0;
    if (!u->is_running) {
        close(u->stop_pipe[0]);
        close(u->stop_pipe[1]);
    }
}

void progress_set(struct progress *u, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    pthread_mutex_lock(&u->lock);
    vsnprintf(u->text, sizeof u->text, format, arguments);
    pthread_mutex_unlock(&u->lock);
    va_end(arguments);
}

void progress_end(struct progress *u)
{
    if (u->is_running) {
        close(u->stop_pipe[1]); /* closing the pipe ends the thread */
        pthread_join(u->thread, NULL);
        close(u->stop_pipe[0]);
        u->is_running = false;
    }
    pthread_mutex_destroy(&u->lock);
}
