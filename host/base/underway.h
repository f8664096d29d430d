/* Underway: work that takes long says every 30 s that it goes on and how far it is, whatever it is
 * busy with: a thread of its own looks at the clock. On stderr, a line each, terminal or not. */
#ifndef MATRIG_HOST_BASE_UNDERWAY_H
#define MATRIG_HOST_BASE_UNDERWAY_H

#include <pthread.h>
#include <stdbool.h>

#define UNDERWAY_S 30.0 /* between two lines; a minute without one is too long */

struct underway {
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
void underway_begin(struct underway *underway, const char *who, const char *quicker, bool quiet);
/* How far it is, from any thread. */
void underway_at(struct underway *underway, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* Something was said in another way just now: the next line is due in 30 s. */
void underway_said(struct underway *underway);
/* After that nothing more is said. */
void underway_end(struct underway *underway);

#endif
