#include "host/log/watch.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host/base/monotonic_clock.h"

#define POLL_MS                200
#define REPORT_DELAY_US        700000u  /* time after which a problem is reported */
#define REPORT_PERIOD_US       5000000u /* time between two reports of a problem */
#define SLOW_CALL_MIN_US       250000u
/* time between two checks that the campaign file is in its place */
#define FILE_CHECK_PERIOD_US   500000u
/* The log is behind if a queue is filled to this share (3 s of data) although the store refuses
 * nothing. */
#define BEHIND_MIN_PERMILLE    50u
#define CAUGHT_UP_MAX_PERMILLE 5u
/* time after a request to end when a call of the store is considered to hang */
#define END_CALL_TIMEOUT_US    10000000u

static unsigned compute_queue_fill_permille(const struct watch *watch)
{
    unsigned most = 0;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (!watch->reader[link])
            continue;
        struct link_queue_depth depth = link_queue_depth(link_reader_queue(watch->reader[link]));
        unsigned full = (unsigned)(1000u * (uint64_t)depth.bytes / depth.capacity);
        most = full > most ? full : most;
    }
    return most;
}

unsigned watch_fill_permille(struct watch *watch)
{
    pthread_mutex_lock(&watch->lock);
    unsigned full = compute_queue_fill_permille(watch);
    pthread_mutex_unlock(&watch->lock);
    return full;
}

static void write_queue_amount(const struct watch *watch, bool lost, char *out, size_t size)
{
    uint64_t count[LINK_KINDS] = {0};
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (!watch->reader[link])
            continue;
        enum link_kind kind = (enum link_kind)link;
        struct link_queue_depth depth = link_queue_depth(link_reader_queue(watch->reader[link]));
        uint64_t waits = kind == LINK_CAN ? depth.can_frames : depth.serial_bytes;
        count[kind] += lost ? link_reader_lost_count(watch->reader[link]) : waits;
    }
    const unsigned long long frames = count[LINK_CAN], bytes = count[LINK_SERIAL];
    if (frames && bytes)
        snprintf(out, size, "%llu CAN frames and %llu serial bytes", frames, bytes);
    else if (frames)
        snprintf(out, size, "%llu CAN frames", frames);
    else if (bytes)
        snprintf(out, size, "%llu serial bytes", bytes);
    else
        snprintf(out, size, "nothing");
}

void watch_write_queue_amount(struct watch *watch, bool lost, char *out, size_t size)
{
    pthread_mutex_lock(&watch->lock);
    write_queue_amount(watch, lost, out, size);
    pthread_mutex_unlock(&watch->lock);
}

/* Finds the current cause of a delay, and its start time. */
static enum watch_cause find_cause(const struct watch *watch, uint64_t at_us, uint64_t *since_us)
{
    static const enum watch_cause causes[] = {WATCH_NONE, WATCH_LOCK, WATCH_FULL_DISK,
                                              WATCH_FAILING_DISK, WATCH_FULL_DISK};
    if (watch->refusal != STORE_NO_RETRY) {
        *since_us = watch->refusal_start_us;
        return causes[watch->refusal];
    }
    *since_us = watch->call_start_us;
    if (watch->call_start_us && at_us - watch->call_start_us > SLOW_CALL_MIN_US)
        return WATCH_SLOW_DISK;
    *since_us = watch->caught_up_us;
    if (compute_queue_fill_permille(watch) < BEHIND_MIN_PERMILLE)
        return WATCH_NONE;
    uint64_t in_calls_us = watch->total_call_us +
                           (watch->call_start_us ? at_us - watch->call_start_us : 0);
    return 2 * in_calls_us > at_us - watch->caught_up_us ? WATCH_SLOW_DISK : WATCH_PROCESSOR;
}

enum link_fault watch_find_cause(void *context)
{
    struct watch *watch = context;
    uint64_t since_us;
    pthread_mutex_lock(&watch->lock);
    enum watch_cause cause = find_cause(watch, monotonic_us(), &since_us);
    pthread_mutex_unlock(&watch->lock);
    switch (cause) {
    case WATCH_LOCK: return LINK_LOST_LOCK;
    case WATCH_FULL_DISK: return LINK_LOST_FULL_DISK;
    case WATCH_SLOW_DISK:
    case WATCH_FAILING_DISK: return LINK_LOST_SLOW_DISK;
    default: return LINK_LOST_PROCESSOR;
    }
}

static const char *get_cause_name(enum watch_cause cause)
{
    static const char *const names[WATCH_CAUSE_COUNT] = {"lock", "slow_disk", "full_disk",
                                                         "failing_disk", "processor"};
    return cause < WATCH_CAUSE_COUNT ? names[cause] : "none";
}

/* Prints a line. Call it without the lock: standard error may be a pipe that nobody reads. */
static void print_note(const struct watch *watch, const char *line)
{
    if (watch->cli->quiet || !line[0])
        return;
    /* clear the progress line first */
    fprintf(stderr, "%smatrig: %s\n", cli_is_stderr_terminal() ? "\r\033[K" : "", line);
    fflush(stderr);
}

static void write_lost_text(const struct watch *watch, char *out, size_t size)
{
    char what[100];
    write_queue_amount(watch, true, what, sizeof what);
    if (strcmp(what, "nothing") == 0)
        snprintf(out, size, "nothing lost");
    else
        snprintf(out, size, "lost so far in this session: %s", what);
}

static bool is_blocked(const struct watch *watch)
{
    bool any = false;
    for (unsigned link = 0; link < LINK_KINDS; link++)
        any |= watch->reader[link] && link_reader_is_blocked(watch->reader[link]);
    return any;
}

static void describe_delay(const struct watch *watch, enum watch_cause cause, uint64_t lasts_us,
                           char *line, size_t size)
{
    char what[320], lost[200];
    unsigned full = compute_queue_fill_permille(watch);
    switch (cause) {
    case WATCH_LOCK:
        snprintf(what, sizeof what, "another program has locked the campaign: waiting");
        break;
    case WATCH_SLOW_DISK:
        snprintf(what, sizeof what, "the disk has been slow for %.1f s: waiting",
                 (double)lasts_us / 1e6);
        break;
    case WATCH_FULL_DISK:
        snprintf(what, sizeof what, "the disk of the campaign is full: waiting for space");
        break;
    case WATCH_FAILING_DISK:
        snprintf(what, sizeof what, "the campaign cannot be written (%s): waiting",
                 watch->refusal_reason);
        break;
    default: snprintf(what, sizeof what, "this computer is too slow to store the data"); break;
    }
    write_lost_text(watch, lost, sizeof lost);
    snprintf(line, size, "%s, queue %u %% full%s, %s: %s", what, full / 10,
             is_blocked(watch) ? ", the board has to wait" : "", lost, watch->campaign_path);
}

static void check_store_call(struct watch *watch, uint64_t at_us)
{
    sigset_t pending, ends, both;
    sigemptyset(&pending);
    /* The writing thread, which normally receives the signals, is inside a call of the store; look
     * for pending signals here. */
    sigpending(&pending);
    cli_fill_termination_signals(&ends);
    sigandset(&both, &pending, &ends);
    if (watch->end_requested_us == 0 && watch->call_start_us && !sigisemptyset(&both))
        watch->end_requested_us = at_us;
    if (watch->end_requested_us == 0 || watch->call_start_us == 0)
        return;
    uint64_t since_us = watch->end_requested_us > watch->call_start_us ? watch->end_requested_us
                                                                       : watch->call_start_us;
    if (at_us - since_us < END_CALL_TIMEOUT_US)
        return;
    char what[100];
    write_queue_amount(watch, false, what, sizeof what);
    fprintf(stderr,
            "%smatrig: the disk has accepted no data for %.0f s: %s; check the disk; the newest %s "
            "are not saved\n",
            cli_is_stderr_terminal() ? "\r\033[K" : "",
            (double)(at_us - watch->call_start_us) / 1e6, watch->campaign_path, what);
    fflush(stderr);
    _exit(3); /* do not close the campaign: that would wait for the same disk */
}

/* Checks once for delays. Sets `line` to the message to print. */
static void check_delays(struct watch *watch, uint64_t at_us, char *line, size_t size)
{
    uint64_t since_us;
    enum watch_cause cause = find_cause(watch, at_us, &since_us);
    unsigned full = compute_queue_fill_permille(watch);
    watch->max_fill_permille = full > watch->max_fill_permille ? full : watch->max_fill_permille;
    watch->max_fill_since_written_permille = full > watch->max_fill_since_written_permille
                                               ? full
                                               : watch->max_fill_since_written_permille;
    bool again = watch->reported_cause == cause && at_us - watch->reported_us < REPORT_PERIOD_US;
    watch->min_fill_permille = full < watch->min_fill_permille ? full : watch->min_fill_permille;
    bool catching_up = since_us == watch->caught_up_us &&
                       full < watch->min_fill_permille + BEHIND_MIN_PERMILLE / 2;
    if (cause != WATCH_NONE && at_us - since_us >= REPORT_DELAY_US && !again && !catching_up) {
        watch->reported_cause = cause;
        watch->reported_us = at_us;
        describe_delay(watch, cause, at_us - since_us, line, size);
    }
    check_store_call(watch, at_us);
}

/* Checks that the campaign file is in its place. Call it without the lock: the disk can be slow. */
static void check_file(struct watch *watch, uint64_t at_us, bool now)
{
    char path[sizeof watch->campaign_path];
    pthread_mutex_lock(&watch->lock);
    bool must_check = now || at_us - watch->last_file_check_us >= FILE_CHECK_PERIOD_US;
    struct store_file_identity identity = watch->file_identity;
    memcpy(path, watch->campaign_path, sizeof path);
    pthread_mutex_unlock(&watch->lock);
    if (!must_check)
        return;
    enum store_file_state place = store_check_file_identity(path, &identity);
    pthread_mutex_lock(&watch->lock);
    watch->last_file_check_us = at_us;
    if (strcmp(path, watch->campaign_path) == 0 &&
        identity.file_inode == watch->file_identity.file_inode)
        watch->file_state = place;
    pthread_mutex_unlock(&watch->lock);
}

static void *run_watch_thread(void *context)
{
    struct watch *watch = context;
    pthread_mutex_lock(&watch->lock);
    while (!watch->must_stop) {
        struct timespec until;
        clock_gettime(CLOCK_MONOTONIC, &until);
        until.tv_nsec += POLL_MS * 1000000l;
        until.tv_sec += until.tv_nsec / 1000000000l;
        until.tv_nsec %= 1000000000l;
        pthread_cond_timedwait(&watch->wake_condition, &watch->lock, &until);
        if (watch->must_stop)
            break;
        char line[sizeof watch->campaign_path + 700] = "";
        uint64_t at_us = monotonic_us();
        check_delays(watch, at_us, line, sizeof line);
        pthread_mutex_unlock(&watch->lock);
        print_note(watch, line);
        check_file(watch, at_us, false);
        pthread_mutex_lock(&watch->lock);
    }
    pthread_mutex_unlock(&watch->lock);
    return NULL;
}

void watch_open(struct watch *watch, const struct cli *cli)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    *watch =
        (struct watch){.cli = cli, .reported_cause = WATCH_NONE, .caught_up_us = monotonic_us()};
    pthread_mutex_init(&watch->lock, NULL);
    pthread_cond_init(&watch->wake_condition, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

enum mr_status watch_begin(struct watch *watch, struct link_reader *const reader[LINK_KINDS],
                           const char *path, struct error *error)
{
    pthread_mutex_lock(&watch->lock);
    memcpy(watch->reader, reader, sizeof watch->reader);
    pthread_mutex_unlock(&watch->lock);
    watch_set_path(watch, path);
    watch->is_running = pthread_create(&watch->thread, NULL, run_watch_thread, watch) == 0;
    return watch->is_running
             ? MR_OK
             : error_set(error, MR_IO,
                         "cannot create a thread: logging to %s; check the limits of this system",
                         path);
}

void watch_close(struct watch *watch)
{
    if (watch->is_running) {
        pthread_mutex_lock(&watch->lock);
        watch->must_stop = true;
        pthread_cond_broadcast(&watch->wake_condition);
        pthread_mutex_unlock(&watch->lock);
        pthread_join(watch->thread, NULL);
    }
    watch->is_running = false;
    pthread_cond_destroy(&watch->wake_condition);
    pthread_mutex_destroy(&watch->lock);
}

void watch_set_path(struct watch *watch, const char *path)
{
    pthread_mutex_lock(&watch->lock);
    snprintf(watch->campaign_path, sizeof watch->campaign_path, "%s", path);
    store_file_identity_get(path, &watch->file_identity);
    watch->file_state = STORE_FILE_UNCHANGED;
    pthread_mutex_unlock(&watch->lock);
}

enum store_file_state watch_file_state(struct watch *watch)
{
    pthread_mutex_lock(&watch->lock);
    enum store_file_state place = watch->file_state;
    pthread_mutex_unlock(&watch->lock);
    return place;
}

enum store_file_state watch_check_file_state(struct watch *watch)
{
    check_file(watch, monotonic_us(), true);
    return watch_file_state(watch);
}

void watch_record_call(struct watch *watch, bool begins)
{
    uint64_t at_us = monotonic_us();
    pthread_mutex_lock(&watch->lock);
    if (!begins) {
        watch->last_call_duration_us = at_us - watch->call_start_us;
        watch->total_call_us += watch->last_call_duration_us;
    }
    watch->call_start_us = begins ? at_us : 0;
    pthread_mutex_unlock(&watch->lock);
}

void watch_note_refusal(struct watch *watch, enum store_refusal refused, const char *reason)
{
    uint64_t at_us = monotonic_us();
    pthread_mutex_lock(&watch->lock);
    if (watch->refusal != refused) {
        if (watch->refusal == STORE_NO_RETRY)
            watch->refusal_start_us = at_us;
        watch->refusal = refused;
        snprintf(watch->refusal_reason, sizeof watch->refusal_reason, "%s", reason);
    }
    pthread_mutex_unlock(&watch->lock);
}

void watch_note_written(struct watch *watch)
{
    char line[400] = "";
    uint64_t at_us = monotonic_us(), since_us, held_us = 0;
    /* cause of the delay that has just ended; WATCH_NONE: none */
    enum watch_cause cause = WATCH_NONE;
    pthread_mutex_lock(&watch->lock);
    unsigned full = compute_queue_fill_permille(watch);
    watch->max_fill_permille = full > watch->max_fill_permille ? full : watch->max_fill_permille;
    if (watch->refusal != STORE_NO_RETRY) {
        cause = find_cause(watch, at_us, &since_us);
        held_us = at_us - watch->refusal_start_us;
    } else if (watch->last_call_duration_us > SLOW_CALL_MIN_US) {
        cause = WATCH_SLOW_DISK;
        held_us = watch->last_call_duration_us;
    }
    if (cause != WATCH_NONE) { /* after a delay, report it again only if the queue grows */
        watch->delay_us[cause] += held_us;
        watch->min_fill_permille = full;
    }
    full = full > watch->max_fill_since_written_permille ? full
                                                         : watch->max_fill_since_written_permille;
    watch->max_fill_since_written_permille = 0;
    watch->refusal = STORE_NO_RETRY;
    if (watch->reported_cause == cause && cause != WATCH_NONE) {
        char lost[200];
        write_lost_text(watch, lost, sizeof lost);
        snprintf(line, sizeof line,
                 "the campaign can be written again after %.1f s; the queue was %u %% full, %s",
                 (double)held_us / 1e6, full / 10, lost);
        watch->reported_cause = WATCH_NONE;
    }
    if (compute_queue_fill_permille(watch) <= CAUGHT_UP_MAX_PERMILLE) {
        watch->caught_up_us = at_us;
        watch->total_call_us = 0;
        watch->reported_cause = WATCH_NONE;
    }
    pthread_mutex_unlock(&watch->lock);
    print_note(watch, line);
}

uint64_t watch_refusal_start_us(struct watch *watch)
{
    pthread_mutex_lock(&watch->lock);
    uint64_t since_us = watch->refusal == STORE_NO_RETRY ? 0 : watch->refusal_start_us;
    pthread_mutex_unlock(&watch->lock);
    return since_us;
}

void watch_note_end(struct watch *watch)
{
    pthread_mutex_lock(&watch->lock);
    if (watch->end_requested_us == 0)
        watch->end_requested_us = monotonic_us();
    pthread_mutex_unlock(&watch->lock);
}

json_t *watch_json(struct watch *watch)
{
    json_t *held = json_object();
    pthread_mutex_lock(&watch->lock);
    for (int cause = 0; cause < WATCH_CAUSE_COUNT; cause++) {
        if (watch->delay_us[cause])
            json_object_set_new(held, get_cause_name((enum watch_cause)cause),
                                json_real((double)watch->delay_us[cause] / 1e6));
    }
    json_t *object = json_pack("{sisfso}", "capacity_s", (int)LINK_QUEUE_CAPACITY_S, "most_percent",
                               (double)watch->max_fill_permille / 10.0, "held_s", held);
    pthread_mutex_unlock(&watch->lock);
    return object;
}

void watch_session_text(struct watch *watch, char *out, size_t size)
{
    static const char *const texts[] = {"another program held the campaign", "the disk was slow",
                                        "the disk was full", "the disk accepted no data"};
    size_t used = 0;
    out[0] = '\0';
    pthread_mutex_lock(&watch->lock);
    for (int cause = 0; cause < WATCH_PROCESSOR && used < size; cause++) {
        if (watch->delay_us[cause] >= REPORT_DELAY_US)
            used += (size_t)snprintf(out + used, size - used, "%s%s for %.1f s", used ? ", " : "",
                                     texts[cause], (double)watch->delay_us[cause] / 1e6);
    }
    if (watch->max_fill_permille >= (used > 0 ? 10 : BEHIND_MIN_PERMILLE) && used < size)
        snprintf(out + used, size - used, "%sthe queue was at most %u %% full", used ? "; " : "",
                 watch->max_fill_permille / 10);
    pthread_mutex_unlock(&watch->lock);
}
