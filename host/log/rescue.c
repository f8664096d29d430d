/* A campaign that somebody moved, replaced or deleted while it is logged. The file that is open goes on to exist without its name, or
 * under another one; what is committed to it is copied to a fresh name beside the old one, and the log goes on there. */
#include <libgen.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host/log/logger.h"

#define AGAIN_US 5000000u /* between two tries to save */
#define NAMES 100         /* tried in one folder, within a second */

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

bool logger_beside(const char *folder, const char *path, const char *what, const char *ending, char *out, size_t size)
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
static bool save_beside(struct logger *logger, const char *beside, char *out, size_t size, struct error *error)
{
    char copy[sizeof logger->saved];
    if (!beside[0])
        return false;
    snprintf(copy, sizeof copy, "%s", beside);
    const char *folder = dirname(copy);
    if (access(folder, W_OK | X_OK) != 0 || !logger_beside(folder, store_path(logger->store), "saved", ".db", out, size))
        return false;
    *error = (struct error){0};
    return store_copy_to(logger->store, out, error) == MR_OK;
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
    collector_move(logger->collector, saved);
    store_leave(logger->store);
    logger->store = saved;
    snprintf(logger->saved, sizeof logger->saved, "%s", path);
    logger->look.db = logger->saved;
    watch_follow(&logger->watch, path);
    logger->followed = false;
    return MR_OK;
}

static void say_what_happened(struct logger *logger, enum store_place place, const char *original, const char *now)
{
    char where[4200];
    snprintf(where, sizeof where, now[0] ? "was moved to %s" : "was deleted", now);
    snprintf(logger->taken, sizeof logger->taken, "%s %s while it was logged", original,
             place == STORE_NO_JOURNAL ? "lost its journal (-wal)"
             : place == STORE_REPLACED ? "was replaced by another file"
                                       : where);
}

enum mr_status logger_rescue(struct logger *logger, struct error *error)
{
    enum store_place place = watch_place(&logger->watch);
    uint64_t now_us = logger_now_us();
    if (place == STORE_IN_PLACE && !logger->saved[0])
        logger->taken[0] = '\0'; /* brought back before it could be saved */
    if (place == STORE_IN_PLACE || (logger->rescue_us && now_us - logger->rescue_us < AGAIN_US))
        return MR_OK;
    struct error why = {0};
    char original[sizeof logger->saved], now[sizeof logger->saved], saved[sizeof logger->saved];
    logger->rescue_us = now_us;
    snprintf(original, sizeof original, "%s", store_path(logger->store));
    store_whereabouts(logger->store, now, sizeof now);
    say_what_happened(logger, place, original, now);
    logger_take_back(logger); /* what is not committed is in the queues */
    watch_call(&logger->watch, true);
    bool copied = save_beside(logger, original, saved, sizeof saved, &why) || save_beside(logger, now, saved, sizeof saved, &why) ||
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
        store_journal_away(original, now, &before);
        fprintf(stderr, "matrig: %s: all of it was saved in %s, and the log goes on there\n", logger->taken, saved); /* also with --quiet */
        fflush(stderr);
    }
    logger->rescue_us = 0;
    return status;
}
