/* Reports of matrig log while its writing thread waits: for another program that holds the
 * campaign, for a slow disk, for disk space. A separate thread checks five times a second, because
 * the writing thread may be waiting for the disk. It also checks that the campaign's file is still
 * in place, and ends the program if the disk hangs when the log should end. */
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
    WATCH_FAILING_DISK,
    WATCH_PROCESSOR,
    WATCH_CAUSE_COUNT,
    WATCH_NONE = WATCH_CAUSE_COUNT
};

struct watch {
    const struct cli *cli;
    pthread_mutex_t lock;
    pthread_cond_t wake_condition;
    pthread_t thread;
    bool is_running, must_stop;
    struct link_reader *reader[LINK_KINDS]; /* NULL: the link is not used */

    /* Times in this struct are microseconds of the monotonic clock. */
    enum store_refusal refusal;
    char refusal_reason[200];       /* reason for the refusal, as the store reported it */
    uint64_t refusal_start_us;      /* start of the refusal */
    uint64_t call_start_us;         /* start of the current call of the store; 0: no call */
    uint64_t last_call_duration_us; /* duration of the last call */
    uint64_t total_call_us;         /* total duration of calls of the store since caught_up_us */
    uint64_t caught_up_us;          /* last time at which the queues were almost empty */
    uint64_t end_requested_us;      /* time at which the end was requested; 0: not yet */
    char campaign_path[4096];
    struct store_file_identity file_identity;
    enum store_file_state file_state;
    uint64_t last_file_check_us;

    enum watch_cause reported_cause; /* cause of the delay that was last reported to the user */
    uint64_t reported_us;
    /* total duration of delays in the session, by cause */
    uint64_t delay_us[WATCH_CAUSE_COUNT];
    /* maximum fill of a queue in the session, in thousandths */
    unsigned max_fill_permille;
    /* maximum fill since the queues were last emptied, in thousandths */
    unsigned max_fill_since_written_permille;
    /* minimum fill of a queue since the delay began, in thousandths */
    unsigned min_fill_permille;
};

void watch_open(struct watch *watch, const struct cli *cli);
/* Starts the thread. `path`: as for watch_set_path. MR_IO: the thread cannot be started. */
enum mr_status watch_begin(struct watch *watch, struct link_reader *const reader[LINK_KINDS],
                           const char *path, struct error *error);
void watch_close(struct watch *watch); /* stops the thread and waits for its end */

/* Sets the file of the campaign to watch. */
void watch_set_path(struct watch *watch, const char *path);
enum store_file_state watch_file_state(struct watch *watch);
/* As watch_file_state, but checks the file now. */
enum store_file_state watch_check_file_state(struct watch *watch);

/* ---- for the thread that writes ---- */

void watch_record_call(struct watch *watch, bool begins);
/* Notes that the store refused a write for a temporary reason. */
void watch_note_refusal(struct watch *watch, enum store_refusal refused, const char *reason);
/* Notes that the last call of the store succeeded. */
void watch_note_written(struct watch *watch);
/* Returns the time at which the store began to refuse data; 0: it accepts data. */
uint64_t watch_refusal_start_us(struct watch *watch);
/* Notes that the log should end; from now on a hanging call ends the program. */
void watch_note_end(struct watch *watch);

/* Finds the cause of a full queue; a link_loss_cause_finder function. */
enum link_fault watch_find_cause(void *watch);

/* ---- totals ---- */

/* Returns the current fill of the fuller queue, in thousandths. */
unsigned watch_fill_permille(struct watch *watch);
/* Writes the amount of waiting data: "12 CAN frames and 480 serial bytes", or "nothing"; with
 * `lost`, the amount of lost data. */
void watch_write_queue_amount(struct watch *watch, bool lost, char *out, size_t size);
json_t *watch_json(struct watch *watch);
/* Writes a line for the end of the session; "": there was no delay. */
void watch_session_text(struct watch *watch, char *out, size_t size);

#endif
