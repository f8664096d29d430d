/* A campaign that somebody moved, replaced or deleted while it is logged. The file that is open
 * goes on to exist without its name, or under another one; what is committed to it is copied to a
 * fresh name beside the old one, and the log goes on there.
 *
 * One that somebody wrote over is no longer there to be copied. A new campaign is begun beside it,
 * into which goes what the queues have kept, as if it came now. */
#include <libgen.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host/log/logger.h"
#include "host/base/monotonic_clock.h"

#define AGAIN_US 5000000u /* between two tries to save */
#define NAMES    100      /* tried in one folder, within a second */

/* "campaign" of /home/runway/campaign.db */
static void stem_of(const char *path, char *out, size_t size)
{
    char copy[sizeof((struct logger *)0)->saved];
    snprintf(copy, sizeof copy, "%s", path);
    const char *name = basename(copy);
    size_t length = strlen(name);
    if (length > 3 && strcmp(name + length - 3, ".db") == 0)
        length -= 3;
    snprintf(out, size, "%.*s", (int)length, name);
}

bool logger_beside(const char *folder, const char *path, const char *what, const char *ending,
                   char *out, size_t size)
{
    char stem[300], date[40];
    time_t now = time(NULL);
    struct tm local;
    stem_of(path, stem, sizeof stem);
    localtime_r(&now, &local);
    strftime(date, sizeof date, "%Y%m%d-%H%M%S", &local);
    for (int i = 1; i <= NAMES; i++) {
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

/* Into the folder of `beside`, if it is there. */
static bool save_beside(struct logger *logger, const char *beside, char *out, size_t size,
                        struct error *error)
{
    char copy[sizeof logger->saved];
    if (!beside[0])
        return false;
    snprintf(copy, sizeof copy, "%s", beside);
    const char *folder = dirname(copy);
    if (access(folder, W_OK | X_OK) != 0 ||
        !logger_beside(folder, store_path(logger->store), "saved", ".db", out, size))
        return false;
    *error = (struct error){0};
    return store_copy_to(logger->store, out, error) == MR_OK;
}

static void go_on_in(struct logger *logger, struct store *store, const char *path)
{
    logger->store = store;
    snprintf(logger->saved, sizeof logger->saved, "%s", path);
    logger->look.db = logger->saved;
    watch_follow(&logger->watch, path);
    logger->emptied = logger->followed = false;
}

/* Goes on in the copy. */
static enum mr_status move_to(struct logger *logger, const char *path, struct error *error)
{
    struct store *saved;
    enum mr_status status = store_open(path, STORE_CREATE, &saved, error);
    if (status == MR_OK)
        status = store_take_alone(saved, error);
    if (status != MR_OK)
        return status;
    store_watch_file(saved);
    collector_move(logger->collector, saved);
    store_leave(logger->store, true);
    go_on_in(logger, saved, path);
    return MR_OK;
}

static void say_what_happened(struct logger *logger, enum store_place place, const char *original,
                              const char *now)
{
    char where[4200];
    snprintf(where, sizeof where, now[0] ? "was moved to %s" : "was deleted", now);
    snprintf(logger->taken, sizeof logger->taken, "%s %s while it was logged", original,
             place == STORE_NO_JOURNAL    ? "lost its journal (-wal)"
             : place == STORE_REPLACED    ? "was replaced by another file"
             : place == STORE_OVERWRITTEN ? "was overwritten by another program"
             : place == STORE_EMPTIED     ? "lost what was logged into it"
                                          : where);
}

enum store_place logger_place(struct logger *logger)
{
    enum store_place place = watch_place(&logger->watch);
    if (logger->emptied)
        return STORE_EMPTIED;
    return place == STORE_IN_PLACE && store_overwritten(logger->store) ? STORE_OVERWRITTEN : place;
}

/* ---- overwritten ---- */

static bool new_name(const char *original, const char *what, const char *ending, char *out,
                     size_t size)
{
    char copy[sizeof((struct logger *)0)->saved];
    snprintf(copy, sizeof copy, "%s", original);
    const char *folder = dirname(copy);
    return (access(folder, W_OK | X_OK) == 0 &&
            logger_beside(folder, original, what, ending, out, size)) ||
           logger_beside(".", original, what, ending, out, size);
}

/* When the oldest of what is kept came; 0: nothing is. */
static uint64_t kept_since_us(const struct logger *logger, bool *whole)
{
    uint64_t since_us = 0;
    *whole = true;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        struct link_queue *queue = logger->reader[link] ? link_reader_queue(logger->reader[link])
                                                        : NULL;
        uint64_t oldest_us = queue ? link_queue_oldest_us(queue) : 0;
        *whole = *whole && (!queue || link_queue_is_whole(queue));
        since_us = oldest_us && (since_us == 0 || oldest_us < since_us) ? oldest_us : since_us;
    }
    return since_us;
}

/* The new campaign, with a session of its own. */
static enum mr_status begin_again(const struct logger *logger, const char *path, bool whole,
                                  struct store **store, struct collector **collector,
                                  struct error *error)
{
    enum mr_status status = store_open(path, STORE_CREATE, store, error);
    if (status != MR_OK)
        return status;
    status = store_take_alone(*store, error);
    if (status == MR_OK)
        store_watch_file(*store);
    if (status == MR_OK)
        status = store_begin(*store, error);
    if (status == MR_OK)
        status = collector_again(logger->collector, *store, whole, collector, error);
    if (status == MR_OK)
        status = store_commit(*store, error);
    if (status != MR_OK) {
        collector_close(*collector);
        store_close(*store);
        unlink(path); /* it was made here, and nothing is in it */
    }
    return status;
}

/* What is in the file now is somebody else's. */
static void leave_to_others(struct store *store, const char *original)
{
    char kept[sizeof((struct logger *)0)->saved];
    bool aside = new_name(original, "journal", ".wal", kept, sizeof kept);
    store_leave(store, false);
    if (aside)
        store_journal_aside(original, kept);
}

static void forget_landings(struct logger *logger) /* they come again, and have other numbers */
{
    json_array_clear(logger->landings);
    logger->shown = 0;
    logger->hold.cause = WATCH_NONE;
}

static enum mr_status start_over(struct logger *logger, enum store_place place,
                                 const char *original)
{
    char saved[sizeof logger->saved], since[40];
    struct error why = {0};
    struct store *store = NULL;
    struct collector *collector = NULL;
    struct tm local;
    bool whole;
    logger_take_back(logger);
    const time_t since_s = (time_t)(kept_since_us(logger, &whole) / 1000000u);
    watch_call(&logger->watch, true);
    enum mr_status status = new_name(original, "saved", ".db", saved, sizeof saved)
                              ? begin_again(logger, saved, whole, &store, &collector, &why)
                              : error_set(&why, MR_IO, "no folder to write to");
    watch_call(&logger->watch, false);
    logger_clear_progress(logger);
    if (status != MR_OK) {
        cli_note(logger->cli, "%s, and no other one can be begun (%s): tried again in 5 s",
                 logger->taken, why.text);
        return status;
    }
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (logger->reader[link])
            link_queue_rewind_all(link_reader_queue(logger->reader[link]));
    }
    logger->refilled = true;
    collector_close(logger->collector);
    logger->collector = collector;
    if (place == STORE_EMPTIED)
        store_close(logger->store); /* all that is in it was put there by SQLite */
    else
        leave_to_others(logger->store, original);
    go_on_in(logger, store, saved);
    forget_landings(logger);
    localtime_r(&since_s, &local);
    strftime(since, sizeof since, "%H:%M:%S", &local);
    fprintf(stderr,
            "matrig: %s: all that came since %s was saved in %s, and the log goes on there%s\n",
            logger->taken, since, saved, whole ? "" : "; what came before is lost");
    fflush(stderr);
    if (!whole)
        snprintf(logger->lost_before, sizeof logger->lost_before, "%s", since);
    return MR_OK;
}

/* ---- taken away ---- */

static enum mr_status save_and_go_on(struct logger *logger, const char *original, const char *now,
                                     struct error *error)
{
    struct error why = {0};
    char saved[sizeof logger->saved];
    logger_take_back(logger); /* what is not committed is in the queues */
    watch_call(&logger->watch, true);
    bool copied = save_beside(logger, original, saved, sizeof saved, &why) ||
                  save_beside(logger, now, saved, sizeof saved, &why) ||
                  save_beside(logger, "./here", saved, sizeof saved, &why);
    watch_call(&logger->watch, false);
    (void)store_take_refusal(logger->store);
    logger_clear_progress(logger);
    if (!copied) { /* what is open still takes what comes */
        cli_note(logger->cli, "%s, and cannot be saved (%s): tried again in 5 s", logger->taken,
                 why.text[0] ? why.text : "no folder to write to");
        return MR_OK;
    }
    const struct store_identity before = logger->watch.identity;
    enum mr_status status = move_to(logger, saved, error);
    if (status == MR_OK) {
        store_journal_remove(original, &before);
        /* also with --quiet */
        fprintf(stderr, "matrig: %s: all of it was saved in %s, and the log goes on there\n",
                logger->taken, saved);
        fflush(stderr);
    }
    logger->rescue_us = 0;
    return status;
}

enum mr_status logger_rescue(struct logger *logger, struct error *error)
{
    enum store_place place = logger_place(logger);
    uint64_t now_us = monotonic_us();
    if (place == STORE_IN_PLACE && !logger->saved[0])
        logger->taken[0] = '\0'; /* brought back before it could be saved */
    if (place == STORE_IN_PLACE || (logger->rescue_us && now_us - logger->rescue_us < AGAIN_US))
        return MR_OK;
    char original[sizeof logger->saved], now[sizeof logger->saved];
    logger->rescue_us = now_us;
    snprintf(original, sizeof original, "%s", store_path(logger->store));
    store_whereabouts(logger->store, now, sizeof now);
    say_what_happened(logger, place, original, now);
    if (place != STORE_OVERWRITTEN && place != STORE_EMPTIED)
        return save_and_go_on(logger, original, now, error);
    if (start_over(logger, place, original) == MR_OK)
        logger->rescue_us = 0;
    else
        logger->again_us = now_us + AGAIN_US; /* nothing goes into that file: what comes waits */
    return MR_OK;
}
