/* Progress of work that takes long. A separate thread prints a line on stderr every 30 s, even
 * while the main thread is busy, and whether or not stderr is a terminal. */
#ifndef MATRIG_HOST_BASE_PROGRESS_H
#define MATRIG_HOST_BASE_PROGRESS_H

#include <pthread.h>
#include <stdbool.h>

/* Seconds between two lines, short enough that users do not think the program hangs. */
#define PROGRESS_INTERVAL_S 30.0

struct progress {
    const char *command; /* name of the command, such as "study"; not copied */
    const char *advice;  /* advice for a faster run, such as "fewer --draws"; not copied */
    pthread_t thread;
    pthread_mutex_t lock;
    char text[120]; /* part of the work that is done, as text */
    double begin_s, next_s;
    int stop_pipe[2]; /* closing the write end ends the thread */
    bool is_running;
};

/* Starts the thread. If `quiet` is set or no thread can be started, nothing is printed. */
void progress_begin(struct progress *progress, const char *who, const char *quicker, bool quiet);
/* Sets the text that the next line shows; may be called from any thread. */
void progress_set(struct progress *progress, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* Stops the thread. Nothing is printed after this call. */
void progress_end(struct progress *progress);

#endif
