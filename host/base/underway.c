#include "host/base/underway.h"

#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

#include "host/base/steady.h"

#define LOOK_MS 200

static void *watch(void *context)
{
    struct underway *u = context;
    struct pollfd end = {.fd = u->wake[0], .events = POLLIN};
    while (poll(&end, 1, LOOK_MS) == 0) {
        double now_s = steady_s();
        pthread_mutex_lock(&u->lock);
        if (now_s >= u->next_s) {
            fprintf(stderr, "matrig: %s: goes on after %.0f s: %s%s%s%s\n", u->who,
                    now_s - u->begin_s, u->at, *u->quicker ? "; " : "", u->quicker,
                    *u->quicker ? " is quicker" : "");
            u->next_s = now_s + UNDERWAY_S;
        }
        pthread_mutex_unlock(&u->lock);
    }
    return NULL;
}

void underway_begin(struct underway *u, const char *who, const char *quicker, bool quiet)
{
    *u = (struct underway){.who = who, .quicker = quicker, .at = "it has begun"};
    u->begin_s = steady_s();
    u->next_s = u->begin_s + UNDERWAY_S;
    pthread_mutex_init(&u->lock, NULL);
    if (quiet || pipe(u->wake) != 0)
        return;
    u->runs = pthread_create(&u->thread, NULL, watch, u) == 0;
    if (!u->runs) {
        close(u->wake[0]);
        close(u->wake[1]);
    }
}

void underway_at(struct underway *u, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    pthread_mutex_lock(&u->lock);
    vsnprintf(u->at, sizeof u->at, format, arguments);
    pthread_mutex_unlock(&u->lock);
    va_end(arguments);
}

void underway_said(struct underway *u)
{
    pthread_mutex_lock(&u->lock);
    u->next_s = steady_s() + UNDERWAY_S;
    pthread_mutex_unlock(&u->lock);
}

void underway_end(struct underway *u)
{
    if (u->runs) {
        close(u->wake[1]); /* the thread reads the end of the pipe */
        pthread_join(u->thread, NULL);
        close(u->wake[0]);
        u->runs = false;
    }
    pthread_mutex_destroy(&u->lock);
}
