/* Progress of work that takes long. A separate thread prints a line on stderr every 30 s, whatever
 * the main thread is doing and whether or not stderr is a terminal. */
#ifndef MATRIG_HOST_BASE_PROGRESS_H
#define MATRIG_HOST_BASE_PROGRESS_H

#include <pthread.h>
#include <stdbool.h>

/* time between two lines; users consider a minute without a line too long */
#define PROGRESS_EVERY_S 30.0

struct progress {
    const char *command; /* name of the command: "study"; not copied */
    const char *advice;  /* advice for a faster run: "fewer --draws"; not copied */
    pthread_t thread;
    pthread_mutex_t lock;
    char text[120]; /* progress text: how far the work has got */
    double begin_s, next_s;
    int stop_pipe[2]; /* a pipe; closing it ends the thread */
    bool is_running;
};

/* Starts the timer. With `quiet`, or if no thread can be started, nothing is printed. */
void progress_begin(struct progress *progress, const char *who, const char *quicker, bool quiet);
/* Sets the progress text; may be called from any thread. */
void progress_set(struct progress *progress, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* Stops the thread; nothing is printed after this call. */
void progress_end(struct progress *progress);

#endif
