/* The work of matrig log: moves received data from the queues into the collector, in transactions.
 * Also: what to do when the campaign refuses data or its file is removed; the end of the log;
 * requests to the board. */
#include "host/log/logger.h"

#include <libgen.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "host/base/monotonic_clock.h"
#include "host/board/keyfile.h"

/* ---- writing: transactions ----
 *
 * Data of a transaction stays in the queues until it is on disk. A failed transaction is rolled
 * back, in the collector too, and written again when possible. */

/* Killing the program may lose at most the last 100 ms of received data: 40 ms between commits, and
 * the duration of the commit itself. With a backlog, commits are further apart. */
#define COMMIT_PERIOD_US       40000u
#define COMMIT_PERIOD_MAX_US   1000000u
/* a queue has a backlog if it is filled to this share of its capacity, 0.6 s of data */
#define BACKLOG_MIN_PERMILLE   10u
/* Time that a summary waits for the campaign, which another program locks for a moment when it
 * closes it. */
#define SUMMARY_TIMEOUT_MS     5000
/* Time until the next attempt to write. Another program usually locks the campaign only for a
 * moment; a disk usually stays full for longer. */
#define LOCKED_RETRY_PERIOD_US 20000u
#define WRITE_RETRY_PERIOD_US  250000u

/* Finds out whether the campaign's path still leads to the file that is being logged. */
static enum store_file_state find_file_state(struct logger *logger)
{
    enum store_file_state place = watch_file_state(&logger->watch);
    if (logger->campaign_lost)
        return STORE_FILE_EMPTIED;
    return place == STORE_FILE_UNCHANGED && store_is_overwritten(logger->store)
             ? STORE_FILE_OVERWRITTEN
             : place;
}

static bool is_content_lost(enum store_file_state place)
{
    return place == STORE_FILE_OVERWRITTEN || place == STORE_FILE_EMPTIED;
}

/* Checks that the session is still in the campaign. Another program may have replaced the content,
 * as sqlite3's .restore does. */
static enum mr_status check_session_data(struct logger *logger, struct error *error)
{
    bool has_data = true;
    enum mr_status status = store_has_session_data(logger->store, &has_data, error);
    if (status != MR_OK || has_data)
        return status;
    logger->campaign_lost = true;
    return error_set(error, MR_IO,
                     "the logged data is no longer in the campaign: %s; log to a different file",
                     store_path(logger->store));
}

enum mr_status logger_begin_transaction(struct logger *logger, struct error *error)
{
    if (logger->in_transaction)
        return MR_OK;
    watch_record_call(&logger->watch, true);
    /* SQLite must not block: the main loop tries again later and does its other work until then */
    store_set_wait_ms(logger->store, 0);
    enum mr_status status = store_begin(logger->store, error);
    store_set_wait_ms(logger->store, SUMMARY_TIMEOUT_MS);
    watch_record_call(&logger->watch, false);
    logger->in_transaction = status == MR_OK;
    logger->transaction_begun_us = monotonic_us();
    if (status == MR_OK && logger->collector)
        status = check_session_data(logger, error);
    if (status == MR_OK && logger->collector)
        status = collector_save_state(logger->collector, error);
    return status;
}

enum mr_status logger_commit(struct logger *logger, struct error *error)
{
    if (!logger->in_transaction)
        return MR_OK;
    enum mr_status status = collector_store_counts(logger->collector, error);
    if (status == MR_OK)
        status = store_record_progress(logger->store, collector_get_session(logger->collector),
                                       error);
    if (status == MR_OK &&
        /* do not write to a file that another program has overwritten */
        store_is_overwritten(logger->store))
        status = error_set(error, MR_IO, "the file was overwritten: %s; log to a different file",
                           store_path(logger->store));
    if (status != MR_OK)
        return status;
    watch_record_call(&logger->watch, true);
    uint64_t from_us = monotonic_us();
    status = store_commit(logger->store, error);
    watch_record_call(&logger->watch, false);
    if (status == MR_OK) {
        store_confirm_progress(logger->store);
        watch_note_written(&logger->watch);
        logger->in_transaction = false;
        for (unsigned link = 0; link < LINK_KINDS; link++) {
            if (logger->reader[link])
                link_queue_release(link_reader_queue(logger->reader[link]));
        }
    }
    logger->commit_duration_us = monotonic_us() - from_us;
    /* the journal file exists only after the first commit */
    if (status == MR_OK && !logger->is_file_watched)
        watch_set_path(&logger->watch, store_path(logger->store));
    logger->is_file_watched |= status == MR_OK;
    return status;
}

/* True if it is time to commit. Each commit waits for the disk, so commits are less frequent while
 * a slow disk leaves a backlog in the queues. */
bool logger_is_commit_due(struct logger *logger)
{
    uint64_t after_us = COMMIT_PERIOD_US;
    if (logger->commit_duration_us > COMMIT_PERIOD_US &&
        watch_fill_permille(&logger->watch) > BACKLOG_MIN_PERMILLE)
        after_us = logger->commit_duration_us > COMMIT_PERIOD_MAX_US ? COMMIT_PERIOD_MAX_US
                                                                     : logger->commit_duration_us;
    return logger->in_transaction && monotonic_us() - logger->transaction_begun_us >= after_us;
}

static void roll_back(struct logger *logger)
{
    store_roll_back(logger->store);
    if (logger->in_transaction && logger->collector)
        collector_restore_state(logger->collector);
    logger->in_transaction = false;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (logger->reader[link])
            link_queue_rewind(link_reader_queue(logger->reader[link]));
    }
}

static enum mr_status continue_after_size_limit(struct logger *logger, const char *original);

enum mr_status logger_wait_for_store(struct logger *logger, struct error *error)
{
    enum store_refusal refused = store_refusal_pop(logger->store);
    /* check the file even if the store did not refuse anything */
    bool other = is_content_lost(find_file_state(logger));
    if (error->status == MR_OK || (refused == STORE_NO_RETRY && !other))
        return error->status;
    roll_back(logger);
    if (other) { /* do not commit: logger_rescue_campaign continues in another file */
        *error = (struct error){0};
        return MR_OK;
    }
    if (refused == STORE_SIZE_LIMIT && !store_checkpoint(logger->store) &&
        continue_after_size_limit(logger, store_path(logger->store)) == MR_OK) {
        *error = (struct error){0};
        return MR_OK;
    }
    watch_note_refusal(&logger->watch, refused, error->text);
    logger->next_write_us = monotonic_us() + (refused == STORE_LOCKED ? LOCKED_RETRY_PERIOD_US
                                                                      : WRITE_RETRY_PERIOD_US);
    *error = (struct error){0};
    return MR_OK;
}

/* ---- data from the queues into the collector ---- */

/* less than a board sends in a second, so that the two links are read in step */
#define QUEUE_FRAMES_PER_CALL 64u
#define QUEUE_BYTES_PER_CALL  LINK_QUEUE_READ_MAX

/* Handles the end of a link, for any reason. The first error is stored, and the other links
 * continue. */
static enum mr_status end_link(struct logger *logger, unsigned link, const struct error *reason,
                               struct error *error)
{
    struct error tail = {0};
    logger->is_link_open[link] = false;
    enum mr_status status = logger_begin_transaction(logger, error);
    if (status == MR_OK) {
        status = collector_end_link(logger->collector, (enum link_kind)link, &tail);
        if (status == MR_TRUNCATED)
            status = MR_OK;
        else if (status != MR_OK)
            error_set(error, status, "%s", tail.text);
    }
    if (logger->link_error.status == MR_OK)
        logger->link_error = reason->status != MR_OK ? *reason : tail;
    return status;
}

/* Records and reports the link's faults since the last call. */
static enum mr_status record_link_faults(struct logger *logger, unsigned link, struct error *error)
{
    if (!logger->faults_changed[link])
        return MR_OK;
    logger_note_link_faults(logger, link);
    enum mr_status status = logger_begin_transaction(logger, error);
    if (status == MR_OK)
        status = collector_count_link_faults(logger->collector, (enum link_kind)link,
                                             &logger->counters[link], error);
    logger->faults_changed[link] = status != MR_OK;
    return status;
}

static enum mr_status handle_clock_jump(struct logger *logger, unsigned link, int64_t jump_us,
                                        struct error *error)
{
    if (jump_us != 0)
        return collector_handle_clock_jump(logger->collector, jump_us, error);
    collector_discard_clock_offset(logger->collector, (enum link_kind)link);
    return MR_OK;
}

static enum mr_status handle_item(struct logger *logger, unsigned link,
                                  const struct link_item *item, struct error *error)
{
    if (item->kind == LINK_ITEM_COUNTERS) {
        logger->counters[link] = item->counters;
        logger->faults_changed[link] = true;
        return MR_OK;
    }
    if (logger->live.hub) /* skip the live page for repeated items, which it has already shown */
        collector_set_listener(logger->collector,
                               item->is_repeated ? NULL : &logger->live.listener);
    enum mr_status status = logger_begin_transaction(logger, error);
    if (status == MR_OK)
        status = record_link_faults(logger, link, error);
    if (status != MR_OK)
        return status;
    switch (item->kind) {
    case LINK_ITEM_FRAME:
        logger_note_other_board(logger, &item->frame);
        return collector_receive_frame(logger->collector, &item->frame, error);
    case LINK_ITEM_BYTES:
        return collector_receive_bytes(logger->collector, item->bytes, item->length, item->host_us,
                                       error);
    case LINK_ITEM_CLOCK_JUMP: return handle_clock_jump(logger, link, item->jump_us, error);
    default: return end_link(logger, link, &item->end_reason, error);
    }
}

enum mr_status logger_process_queue(struct logger *logger, unsigned link, struct error *error)
{
    struct link_reader *reader = logger->reader[link];
    struct link_queue *queue = link_reader_queue(reader);
    struct link_item item;
    enum mr_status status = MR_OK;
    /* The turn ends when the queue is empty; otherwise, data of this turn remains in the queue. */
    if (!link_queue_has_unread(queue))
        logger->has_buffered_data[link] = link_reader_fd(reader) >= 0 && link_reader_read(reader);
    size_t most = (enum link_kind)link == LINK_CAN ? QUEUE_FRAMES_PER_CALL : QUEUE_BYTES_PER_CALL;
    for (size_t handled = 0; handled < most && status == MR_OK && link_queue_read(queue, &item);) {
        handled += item.kind == LINK_ITEM_BYTES ? item.length : 1;
        status = handle_item(logger, link, &item, error);
    }
    return status == MR_OK ? record_link_faults(logger, link, error) : status;
}

/* If both links have data, selects only the link that is behind in board time. Thus both links are
 * read in step, however much is buffered, and neither waits for the other. */
void logger_select_lagging_link(const struct logger *logger, bool ready[LINK_KINDS])
{
    if (!ready[LINK_CAN] || !ready[LINK_SERIAL])
        return;
    ready[1 - collector_get_lagging_link(logger->collector)] = false;
}

/* ---- requests to the board: automatic ones, and those of the live page's viewers ---- */

#define CONFIG_REQUEST_PERIOD_US 1000000u /* time between two requests for the configuration */
/* Maximum number of requests for the configuration. A board that does not answer, or whose
 * configuration has another layout, gets no more. */
#define CONFIG_REQUESTS_MAX      5u
/* an idle board without CAN sends readings for this time after a request */
#define LIVE_READINGS_DURATION_S 30
#define LIVE_REQUEST_PERIOD_US   20000000u /* time between two requests for readings */

/* Sends the operator's proof for a command, if the board requires one. */
static void send_proof(struct logger *logger, unsigned link, const uint8_t *command)
{
    struct collector_progress p;
    struct error why = {0};
    uint8_t proof[MR_PROOF_BYTES];
    if (mr_command_privilege(command[0]) != MR_PRIVILEGE_OPERATOR)
        return;
    collector_get_progress(logger->collector, &p);
    if (!p.key || p.key->state != MR_KEY_SET || !p.nonce)
        return;
    if (keyfile_compute_proof(p.board_uid, p.uid, p.nonce, command, proof, &why) == MR_OK) {
        memcpy(logger->last_command_nonce, p.nonce, sizeof logger->last_command_nonce);
        (void)link_send_message(logger->link[link], logger->can_base, 0, MR_ID_PROOF, proof,
                                sizeof proof, &why);
    }
    if (why.status != MR_OK) {
        logger_clear_progress(logger);
        cli_note(logger->cli, "%s", why.text);
    }
}

bool logger_repeat_command(struct logger *logger)
{
    struct collector_progress p;
    collector_get_progress(logger->collector, &p);
    return p.nonce &&
           memcmp(logger->last_command_nonce, p.nonce, sizeof logger->last_command_nonce) != 0 &&
           logger_send(logger, &logger->typed.command, false);
}

bool logger_send(struct logger *logger, const struct mr_command *command, bool is_automatic)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    size_t length = mr_command_put(command, payload);
    collector_add_own_command(&logger->own_commands, command);
    for (int kind = LINK_KINDS - 1; kind >= 0; kind--) {
        unsigned link = (unsigned)kind;
        struct error reason = {0};
        if (!logger->is_link_open[link] || (is_automatic && logger->rejects_data[link]))
            continue;
        send_proof(logger, link, payload);
        enum mr_status status = link_send_message(logger->link[link], logger->can_base, 0,
                                                  MR_ID_COMMAND, payload, length, &reason);
        logger->rejects_data[link] = logger->rejects_data[link] ||
                                     (is_automatic && status != MR_OK);
        if (status == MR_OK)
            return true;
    }
    return false;
}

/* Asks the board for its configuration, over serial if possible. A link that does not accept the
 * request, such as a file, is asked only once. */
void logger_request_configuration(struct logger *logger)
{
    const struct mr_command command = {.code = MR_COMMAND_CONFIG_READ};
    uint64_t now_us = monotonic_us();
    if (!collector_needs_configuration(logger->collector)) {
        struct collector_progress p;
        collector_get_progress(logger->collector, &p);
        /* the board stops its answer when it is armed, so request it again after the landing */
        if (p.run)
            logger->config_request_us = logger->config_requests = 0;
        return;
    }
    if (logger->config_requests == CONFIG_REQUESTS_MAX ||
        (logger->config_request_us &&
         now_us - logger->config_request_us < CONFIG_REQUEST_PERIOD_US))
        return;
    logger->config_request_us = now_us;
    logger->config_requests++;
    (void)logger_send(logger, &command, true);
}

/* Requests block records every 20 ms for the live page if CAN is not connected: an idle board sends
 * its readings only on CAN. */
static void request_live_readings(struct logger *logger)
{
    struct mr_command command = {.code = MR_COMMAND_LIVE, .argument = LIVE_READINGS_DURATION_S};
    struct collector_progress p;
    collector_get_progress(logger->collector, &p);
    uint64_t now_us = monotonic_us();
    if (logger->is_link_open[LINK_CAN] || p.run || !p.hello_received ||
        (logger->live_request_us && now_us - logger->live_request_us < LIVE_REQUEST_PERIOD_US))
        return;
    logger->live_request_us = now_us;
    (void)logger_send(logger, &command, true);
}

void logger_send_live_command(struct logger *logger)
{
    struct mr_command command;
    if (!logger->live.hub)
        return;
    request_live_readings(logger);
    live_update(&logger->live, logger->collector);
    if (live_pop_command(&logger->live, &command))
        (void)logger_send(logger, &command, false);
}

/* ---- a campaign that was taken away ----
 *
 * Another program has moved, replaced or deleted the campaign while it is logged. The open file
 * still exists, without its name or under another name. Its committed data is copied to a new file
 * beside the old path, and the log continues there. A file that was overwritten can no longer be
 * copied. A new campaign then begins beside it, and all data that the queues have kept is written
 * into it. */

#define SAVED_SUFFIX             "-saved-"
#define LARGE_CAMPAIGN_MIN_BYTES 500000000
#define SAVE_RETRY_PERIOD_US     5000000u /* time between two attempts to save the campaign */
#define FILE_NAME_TRIES_MAX      100      /* number of names tried in one folder */
#define PATH_SIZE                4096

/* Writes the file name without folder and extension: "campaign" for /home/runway/campaign.db. */
static void write_file_stem(const char *path, char *out, size_t size)
{
    char copy[PATH_SIZE];
    snprintf(copy, sizeof copy, "%s", path);
    const char *name = basename(copy);
    size_t length = strlen(name);
    /* a campaign that was itself saved keeps the original stem, so that names do not grow */
    const char *saved = strstr(name, SAVED_SUFFIX);
    if (saved && saved > name)
        length = (size_t)(saved - name);
    else if (length > 3 && strcmp(name + length - 3, ".db") == 0)
        length -= 3;
    snprintf(out, size, "%.*s", (int)length, name);
}

/* Finds an unused name in `folder`: STEM-WHAT-DATE plus extension, with the stem of the campaign's
 * path. Returns false if there is none. */
static bool find_free_name(const char *folder, const char *path, const char *what,
                           const char *ending, char *out, size_t size)
{
    char stem[300], date[40];
    time_t now = time(NULL);
    struct tm local;
    write_file_stem(path, stem, sizeof stem);
    localtime_r(&now, &local);
    strftime(date, sizeof date, "%Y%m%d-%H%M%S", &local);
    for (int i = 1; i <= FILE_NAME_TRIES_MAX; i++) {
        char more[12] = "";
        if (i > 1)
            snprintf(more, sizeof more, "-%d", i);
        int length = snprintf(out, size, "%s/%s-%s-%s%s%s", folder, stem, what, date, more, ending);
        if (length < 0 || (size_t)length >= size)
            return false;
        if (access(out, F_OK) != 0)
            return true;
    }
    return false;
}

static const char *get_file_folder(const char *path, char folder[PATH_SIZE])
{
    snprintf(folder, PATH_SIZE, "%s", path);
    return dirname(folder);
}

/* Saves a copy of the campaign in the folder of the path `beside`, if that folder exists. */
static bool save_copy(struct logger *logger, const char *beside, char *out, size_t size,
                      struct error *error)
{
    char folder[PATH_SIZE];
    if (!beside[0] || access(get_file_folder(beside, folder), W_OK | X_OK) != 0 ||
        !find_free_name(folder, store_path(logger->store), "saved", ".db", out, size))
        return false;
    *error = (struct error){0};
    return store_copy_to(logger->store, out, error) == MR_OK;
}

static void switch_store(struct logger *logger, struct store *store, const char *path)
{
    logger->store = store;
    snprintf(logger->saved_path, sizeof logger->saved_path, "%s", path);
    logger->db_path = logger->saved_path;
    watch_set_path(&logger->watch, path);
    logger->campaign_lost = logger->is_file_watched = false;
}

/* Continues in the copy of the campaign. `shared`: other programs may be using the old file. */
static enum mr_status continue_in_copy(struct logger *logger, const char *path, bool shared,
                                       struct error *error)
{
    struct store *saved;
    enum mr_status status = store_open(path, STORE_LOG, &saved, error);
    if (status != MR_OK)
        return status;
    store_watch_file(saved);
    collector_set_store(logger->collector, saved);
    store_close_detached(logger->store, !shared);
    switch_store(logger, saved, path);
    return MR_OK;
}

static void report_file_change(struct logger *logger, enum store_file_state place,
                               const char *original, const char *now)
{
    char where[4200];
    snprintf(where, sizeof where, now[0] ? "was moved to %s" : "was deleted", now);
    snprintf(logger->file_problem_text, sizeof logger->file_problem_text,
             "%s %s while it was logged", original,
             place == STORE_FILE_NO_JOURNAL    ? "lost its journal (-wal)"
             : place == STORE_FILE_NO_INDEX    ? "lost its journal's index (-shm)"
             : place == STORE_FILE_REPLACED    ? "was replaced by a different file"
             : place == STORE_FILE_OVERWRITTEN ? "was overwritten by another program"
             : place == STORE_FILE_EMPTIED     ? "lost the logged data"
                                               : where);
}

/* ---- overwritten ---- */

/* Returns the time of the oldest data in the queues; 0: none. Sets *whole if the queues still have
 * all data since the beginning. */
static uint64_t get_oldest_queued_us(const struct logger *logger, bool *whole)
{
    uint64_t since_us = 0;
    *whole = true;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        struct link_queue *queue = logger->reader[link] ? link_reader_queue(logger->reader[link])
                                                        : NULL;
        uint64_t oldest_us = queue ? link_queue_oldest_us(queue) : 0;
        *whole = *whole && (!queue || link_queue_is_complete(queue));
        since_us = oldest_us && (since_us == 0 || oldest_us < since_us) ? oldest_us : since_us;
    }
    return since_us;
}

/* Creates the new campaign with a session of its own. */
static enum mr_status create_campaign(const struct logger *logger, const char *path, bool whole,
                                      bool goes_on, struct store **store,
                                      struct collector **collector, struct error *error)
{
    *store = NULL;
    *collector = NULL;
    enum mr_status status = store_open(path, STORE_LOG, store, error);
    if (status == MR_OK)
        store_watch_file(*store);
    if (status == MR_OK)
        status = store_begin(*store, error);
    if (status == MR_OK)
        status = collector_reopen(logger->collector, *store, whole, goes_on, collector, error);
    if (status == MR_OK)
        status = store_commit(*store, error);
    if (status != MR_OK) {
        collector_close(*collector);
        store_close(*store);
        unlink(path); /* the new file is empty, so remove it */
    }
    return status;
}

/* Closes a campaign file that another program has overwritten. `kept`: path of the saved journal;
 * "": not saved. */
static void close_overwritten_campaign(struct store *store, const char *original,
                                       char kept[PATH_SIZE])
{
    char folder[PATH_SIZE];
    bool aside = find_free_name(get_file_folder(original, folder), original, "journal", ".wal",
                                kept, PATH_SIZE);
    store_close_detached(store, false);
    if (!aside || !store_journal_rename(original, kept))
        kept[0] = '\0';
}

bool logger_close_store(struct logger *logger)
{
    char original[PATH_SIZE], kept[PATH_SIZE];
    if (!logger->store || !store_is_overwritten(logger->store)) {
        store_close(logger->store);
        return true;
    }
    snprintf(original, sizeof original, "%s", store_path(logger->store));
    close_overwritten_campaign(logger->store, original, kept);
    fprintf(stderr, "matrig: %s was overwritten by another program before it was closed%s%s\n",
            original, kept[0] ? "; its journal is " : "", kept);
    return false;
}

/* Discards the landings whose summaries were shown: their data is written again and gets new
 * numbers. */
static void discard_landings(struct logger *logger)
{
    json_array_clear(logger->landings_json);
    logger->shown_landing_count = 0;
}

/* Begins another campaign beside `original`, or else in the working folder, and writes all data of
 * the queues into it. `again`: includes data that was already written to the old campaign. */
static enum mr_status continue_in_new_campaign(struct logger *logger, enum store_file_state place,
                                               const char *original, bool again)
{
    char folder[PATH_SIZE], kept[PATH_SIZE], saved[sizeof logger->saved_path], since[40];
    const char *const folders[] = {get_file_folder(original, folder), "."};
    struct error why = {0};
    struct store *store = NULL;
    struct collector *collector = NULL;
    struct tm local;
    bool whole = false;
    roll_back(logger);
    const time_t since_s = again ? (time_t)(get_oldest_queued_us(logger, &whole) / 1000000u)
                                 : time(NULL);
    whole = whole && again;
    watch_record_call(&logger->watch, true);
    enum mr_status status = MR_IO;
    for (size_t i = 0; i < 2 && status != MR_OK; i++) {
        if (access(folders[i], W_OK | X_OK) == 0 &&
            find_free_name(folders[i], original, "saved", ".db", saved, sizeof saved))
            status = create_campaign(logger, saved, whole, !again, &store, &collector, &why);
    }
    watch_record_call(&logger->watch, false);
    logger_clear_progress(logger);
    if (status != MR_OK) {
        cli_note(logger->cli, "%s, and no new campaign can be created (%s)",
                 logger->file_problem_text, why.text[0] ? why.text : "no writable folder");
        return status;
    }
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (logger->reader[link] && again)
            link_queue_rewind_all(link_reader_queue(logger->reader[link]));
    }
    logger->queues_rewound |= again;
    collector_close(logger->collector);
    logger->collector = collector;
    if (place == STORE_FILE_OVERWRITTEN)
        close_overwritten_campaign(logger->store, original, kept);
    /* otherwise only SQLite wrote to the file, so it is intact */
    else
        store_close(logger->store);
    switch_store(logger, store, saved);
    if (again)
        discard_landings(logger);
    localtime_r(&since_s, &local);
    strftime(since, sizeof since, "%H:%M:%S", &local);
    fprintf(
        stderr,
        "matrig: %s: all data received since %s was saved in %s, and the log continues there%s\n",
        logger->file_problem_text, since, saved, whole || !again ? "" : "; earlier data is lost");
    fflush(stderr);
    if (!whole)
        snprintf(logger->data_missing_until, sizeof logger->data_missing_until, "%s", since);
    return MR_OK;
}

/* Continues in another file when the file has reached its size limit. The old file keeps its data
 * and its journal. Unless the file is small, the data that the queues still have is written to the
 * new file too, so that a landing is complete there. */
static enum mr_status continue_after_size_limit(struct logger *logger, const char *original)
{
    struct stat info;
    char from[PATH_SIZE];
    snprintf(from, sizeof from, "%s", original);
    bool again = stat(from, &info) == 0 && info.st_size >= LARGE_CAMPAIGN_MIN_BYTES;
    snprintf(
        logger->file_problem_text, sizeof logger->file_problem_text,
        "%s has reached the maximum file size (by ulimit -f or the file system) and keeps its data",
        from);
    return continue_in_new_campaign(logger, STORE_FILE_UNCHANGED, from, again);
}

/* ---- a campaign file that was moved, removed or replaced ---- */

static enum mr_status save_removed_campaign(struct logger *logger, enum store_file_state place,
                                            const char *original, const char *now,
                                            struct error *error)
{
    struct error why = {0};
    char saved[sizeof logger->saved_path];
    /* the rollback loses nothing, because uncommitted data is still in the queues */
    roll_back(logger);
    watch_record_call(&logger->watch, true);
    bool copied = save_copy(logger, original, saved, sizeof saved, &why) ||
                  save_copy(logger, now, saved, sizeof saved, &why) ||
                  save_copy(logger, "./here", saved, sizeof saved, &why);
    watch_record_call(&logger->watch, false);
    (void)store_refusal_pop(logger->store);
    logger_clear_progress(logger);
    /* without a copy, continue in the open file, which still accepts data */
    if (!copied) {
        cli_note(logger->cli, "%s, and its data cannot be saved (%s): matrig tries again in 5 s",
                 logger->file_problem_text, why.text[0] ? why.text : "no writable folder");
        return MR_OK;
    }
    const struct store_file_identity before = logger->watch.file_identity;
    const bool shared = place == STORE_FILE_NO_INDEX;
    enum mr_status status = continue_in_copy(logger, saved, shared, error);
    if (status == MR_OK) {
        if (!shared)
            store_journal_remove(original, &before);
        /* printed even with --quiet */
        fprintf(stderr, "matrig: %s: all data was saved in %s, and the log continues there\n",
                logger->file_problem_text, saved);
        fflush(stderr);
    }
    logger->rescue_attempt_us = 0;
    return status;
}

enum mr_status logger_rescue_campaign(struct logger *logger, struct error *error)
{
    enum store_file_state place = find_file_state(logger);
    uint64_t now_us = monotonic_us();
    if (place == STORE_FILE_UNCHANGED && !logger->saved_path[0])
        /* the file is in its place again, so it need not be saved */
        logger->file_problem_text[0] = '\0';
    if (place == STORE_FILE_UNCHANGED ||
        (logger->rescue_attempt_us && now_us - logger->rescue_attempt_us < SAVE_RETRY_PERIOD_US))
        return MR_OK;
    char original[sizeof logger->saved_path], now[sizeof logger->saved_path];
    logger->rescue_attempt_us = now_us;
    snprintf(original, sizeof original, "%s", store_path(logger->store));
    store_find_current_path(logger->store, now, sizeof now);
    report_file_change(logger, place, original, now);
    if (!is_content_lost(place))
        return save_removed_campaign(logger, place, original, now, error);
    if (continue_in_new_campaign(logger, place, original, true) == MR_OK)
        logger->rescue_attempt_us = 0;
    else
        logger->next_write_us =
            now_us +
            /* write nothing to the overwritten file; received data stays in the queues */
            SAVE_RETRY_PERIOD_US;
    return MR_OK;
}

/* ---- the end ----
 *
 * Reading stops, the data in the queues is written, and the session is closed. If the campaign
 * still refuses data after a while, the data in the queues goes into a new campaign beside it. */

/* Longest time to wait for a campaign that refuses data after the log should end: at the end of the
 * links, at the time limit of --for, or after a signal. */
#define END_TIMEOUT_US       60000000u
#define SIGNAL_WAIT_MAX_US   5000000u
/* Two signals within this time count as one: no user is that fast, but `timeout` and `kill` of a
 * process group deliver one signal twice. */
#define SECOND_SIGNAL_MIN_US 500000u
#define POLL_MS              20

bool logger_has_end_signal(struct logger *logger, int signals)
{
    struct signalfd_siginfo info;
    if (read(signals, &info, sizeof info) != (ssize_t)sizeof info)
        return false;
    uint64_t now_us = monotonic_us();
    logger->end_requested_twice = logger->ended_by &&
                                  (!logger->end_request_us ||
                                   now_us - logger->end_request_us > SECOND_SIGNAL_MIN_US);
    if (!logger->end_request_us)
        logger->end_request_us = now_us;
    watch_note_end(&logger->watch);
    return true;
}

/* Writes the next data from the queues to the campaign. MR_TOO_FEW: the queues are empty. */
static enum mr_status write_queued_data(struct logger *logger, struct error *error)
{
    bool ready[LINK_KINDS] = {false}, any = false;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        ready[link] = logger->reader[link] &&
                      link_queue_has_unread(link_reader_queue(logger->reader[link]));
        any |= ready[link];
    }
    if (!any)
        return MR_TOO_FEW;
    logger_select_lagging_link(logger, ready);
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (ready[link] && logger_process_queue(logger, link, error) != MR_OK)
            return error->status;
    }
    return logger_is_commit_due(logger) ? logger_commit(logger, error) : MR_OK;
}

static enum mr_status write_session_end(struct logger *logger, struct error *error)
{
    enum mr_status status = logger_begin_transaction(logger, error);
    if (status == MR_OK)
        status = collector_end(logger->collector, logger->ended_by, error);
    return status == MR_OK ? logger_commit(logger, error) : status;
}

static bool is_refusal_wait_over(struct logger *logger, uint64_t began_us)
{
    uint64_t refused_us = watch_refusal_start_us(&logger->watch), now_us = monotonic_us();
    uint64_t since_us = refused_us > began_us ? refused_us : began_us;
    bool asked = strcmp(logger->ended_by, "signal") == 0;
    return logger->end_requested_twice ||
           (refused_us && now_us - since_us > (asked ? SIGNAL_WAIT_MAX_US : END_TIMEOUT_US));
}

/* Writes the data of the queues into a new campaign, because the present one refuses data. Any
 * status except MR_OK means that there was nothing left to write or that data is lost; `error`
 * states which. */
static enum mr_status switch_to_new_campaign(struct logger *logger, bool *beside,
                                             const char *reason, struct error *error)
{
    char what[100];
    watch_write_queue_amount(&logger->watch, false, what, sizeof what);
    roll_back(logger);
    if (watch_fill_permille(&logger->watch) == 0 && strcmp(what, "nothing") == 0)
        return error_set(error, MR_IO,
                         "all received data is in the campaign, but the end of the session is not "
                         "recorded: %.250s",
                         reason);
    snprintf(logger->file_problem_text, sizeof logger->file_problem_text,
             "%s accepted no more data (%.200s)", store_path(logger->store), reason);
    if (*beside || continue_in_new_campaign(logger, STORE_FILE_UNCHANGED, store_path(logger->store),
                                            true) != MR_OK)
        return error_set(error, MR_IO,
                         "the newest data was lost (%s), because it could neither be written to "
                         "the campaign nor saved in the same folder; %.250s",
                         what, reason);
    *beside = true;
    logger->end_requested_twice = false;
    logger->next_write_us = 0;
    return MR_OK;
}

/* After everything is written, checks that the campaign file is still in its place. MR_TOO_FEW: it
 * is not, and the data of the queues must be written into another campaign. */
static enum mr_status check_campaign_location(struct logger *logger, struct error *error)
{
    (void)watch_check_file_state(&logger->watch);
    bool gone = is_content_lost(find_file_state(logger));
    logger->rescue_attempt_us = 0;
    enum mr_status status = logger_rescue_campaign(logger, error);
    if (status != MR_OK || !gone)
        return status;
    return is_content_lost(find_file_state(logger))
             ? error_set(error, MR_IO,
                         "%s, and no new campaign could be created: the logged data is lost",
                         logger->file_problem_text)
             : MR_TOO_FEW;
}

enum mr_status logger_end_session(struct logger *logger, int signals, struct error *error)
{
    char reason[sizeof error->text] = "interrupted while writing";
    uint64_t began_us = monotonic_us();
    const bool failed = strcmp(logger->ended_by, "error") == 0;
    bool beside = false;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        link_reader_stop(logger->reader[link]);
        logger->has_buffered_data[link] = false;
    }
    for (;;) {
        struct error why = {0};
        enum mr_status status = logger_rescue_campaign(logger, error);
        if (status != MR_OK)
            return status;
        bool went_wrong = failed && !logger->queues_rewound, gives_up = false;
        if (monotonic_us() >= logger->next_write_us) {
            status = went_wrong ? MR_TOO_FEW : write_queued_data(logger, &why);
            if (status == MR_TOO_FEW && write_session_end(logger, &why) == MR_OK) {
                status = check_campaign_location(logger, error);
                if (status != MR_TOO_FEW)
                    return status;
                /* the loop then writes all data that the queues kept into the new campaign */
                continue;
            }
            if (why.status != MR_OK)
                snprintf(reason, sizeof reason, "%s", why.text);
            /* give up at once if waiting cannot help */
            gives_up = went_wrong || logger_wait_for_store(logger, &why) != MR_OK;
        } else {
            struct pollfd asked = {.fd = signals, .events = POLLIN};
            poll(&asked, 1, POLL_MS);
        }
        (void)logger_has_end_signal(logger, signals);
        if (!gives_up && !is_refusal_wait_over(logger, began_us))
            continue;
        if (switch_to_new_campaign(logger, &beside, reason, error) != MR_OK)
            return error->status;
        began_us = monotonic_us();
    }
}
