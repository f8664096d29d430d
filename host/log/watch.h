/* What matrig log tells while its writing thread waits: for another program that holds the
 * campaign, for a slow disk, for room. A thread of its own looks five times a second, because the
 * writing thread may be inside a call to the disk. It also looks whether the campaign is still
 * where it was, and ends the program when a disk that hangs would keep it from ending. */
#ifndef MATRIG_HOST_LOG_WATCH_H
#define MATRIG_HOST_LOG_WATCH_H

#include <jansson.h>
#include <pthread.h>

#include "host/base/cli.h"
#include "host/link/queue.h"
#include "host/link/link.h"
#include "host/store/store.h"

enum watch_cause {
    WATCH_LOCK,
    WATCH_SLOW_DISK,
    WATCH_FULL_DISK,
    WATCH_FAILING,
    WATCH_PROCESSOR, /* nothing but this computer */
    WATCH_CAUSES,
    WATCH_NONE = WATCH_CAUSES
};

struct watch {
    const struct cli *cli;
    pthread_mutex_t lock;
    pthread_cond_t wake;
    pthread_t thread;
    bool on, stop;
    struct link_reader *reader[LINK_KINDS]; /* NULL: not used */

    /* Times are monotonic, microseconds. */
    enum store_refusal refused;
    char reason[200];      /* in the store's words */
    uint64_t refused_us;   /* since then */
    uint64_t call_us;      /* a call of the store began; 0: none is under way */
    uint64_t call_took_us; /* the last one */
    uint64_t in_calls_us;  /* of the time since caught_up_us */
    uint64_t caught_up_us; /* the queues held next to nothing */
    uint64_t end_us;       /* the end was asked for; 0: not */
    char path[4096];
    struct store_identity identity;
    enum store_place place;
    uint64_t place_us;

    enum watch_cause told; /* what goes on, to the user */
    uint64_t told_us;
    uint64_t held_us[WATCH_CAUSES]; /* in the session */
    unsigned most_permille;         /* of a queue, in the session */
    unsigned hold_permille;         /* since the last time all was written */
    unsigned low_permille;          /* of a queue, the least since something was in the way */
};

void watch_open(struct watch *watch, const struct cli *cli);
/* Begins to look. `path` as watch_follow. MR_IO: no thread. */
enum mr_status watch_begin(struct watch *watch, struct link_reader *const reader[LINK_KINDS],
                           const char *path, struct error *error);
void watch_close(struct watch *watch); /* waits for the thread */

/* From now on the campaign is this file. */
void watch_follow(struct watch *watch, const char *path);
enum store_place watch_place(struct watch *watch);
/* The same, looked for now. */
enum store_place watch_place_now(struct watch *watch);

/* ---- by the thread that writes ---- */

void watch_call(struct watch *watch, bool begins);
/* The store took nothing, for a reason that may pass. */
void watch_refused(struct watch *watch, enum store_refusal refused, const char *reason);
/* It took all that was put, in the call that ended last. */
void watch_written(struct watch *watch);
/* Since when it takes nothing; 0: it does. */
uint64_t watch_refused_us(struct watch *watch);
/* The end was asked for: a call that hangs is no longer waited for. */
void watch_end(struct watch *watch);

/* By which the queue is full, as link_blame. */
enum link_trouble watch_blame(void *watch);

/* ---- what it came to ---- */

/* Of the fuller queue, now, in thousandths. */
unsigned watch_permille(struct watch *watch);
/* "12 frames of CAN and 480 bytes of serial", or "nothing"; what waits, or with `lost` what was
 * lost. */
void watch_amount(struct watch *watch, bool lost, char *out, size_t size);
json_t *watch_json(struct watch *watch);
/* A line for the end of the session; "": nothing was in the way. */
void watch_session(struct watch *watch, char *out, size_t size);

#endif
