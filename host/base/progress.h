/* Progress of work that takes long: a thread of its own prints a line on stderr every 30 s,
 * whatever the work is busy with, terminal or not. */
#ifndef MATRIG_HOST_BASE_PROGRESS_H
#define MATRIG_HOST_BASE_PROGRESS_H

#include <pthread.h>
#include <stdbool.h>

#define PROGRESS_EVERY_S 30.0 /* between two lines; a minute without one is too long */

struct progress {
    const char *who;     /* the command: "study"; borrowed */
    const char *quicker; /* what else there is to do: "fewer --draws"; borrowed */
    pthread_t thread;
    pthread_mutex_t lock;
    char at[120]; /* how far it is */
    double begin_s, next_s;
    int wake[2]; /* a pipe, whose end ends the thread */
    bool runs;
};

/* Counting begins now. With `quiet`, or where no thread can be had, nothing is said. */
void progress_begin(struct progress *progress, const char *who, const char *quicker, bool quiet);
/* How far it is, from any thread. */
void progress_at(struct progress *progress, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* After that nothing more is said. */
void progress_end(struct progress *progress);

#endif
