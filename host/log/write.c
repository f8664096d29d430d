/* Writing into the campaign: transactions, and what happens when the campaign takes nothing for a
 * while. What a transaction held stays in the queues until it is on disk; one that failed is taken
 * back, collector and all, and is written again when it can be. */
#include "host/log/logger.h"
#include "host/base/monotonic_clock.h"

/* A kill at any time may cost at most 100 ms of what was received; half of it is left for a slow
 * disk. */
#define COMMIT_US       40000u
#define COMMIT_MOST_US  1000000u
#define MUCH_PERMILLE   10u  /* of a queue: 0.6 s */
#define READ_WAIT_MS    5000 /* a summary: another program closes the campaign, for a moment */
/* until the next try: another program may hold the campaign for a moment only, */
#define AGAIN_LOCKED_US 20000u
#define AGAIN_US        250000u /* a disk is full for longer */

/* Somebody may have put another content into the campaign, as sqlite3's .restore does. */
static enum mr_status look_for_session(struct logger *logger, struct error *error)
{
    bool there = true;
    enum mr_status status = store_session_there(logger->store, &there, error);
    if (status != MR_OK || there)
        return status;
    logger->emptied = true;
    return error_set(error, MR_IO,
                     "what was logged is no longer in the campaign: %s; log into another one",
                     store_path(logger->store));
}

enum mr_status logger_begin(struct logger *logger, struct error *error)
{
    if (logger->in_transaction)
        return MR_OK;
    watch_call(&logger->watch, true);
    store_patience(logger->store, 0); /* the loop waits, and does all else meanwhile */
    enum mr_status status = store_begin(logger->store, error);
    store_patience(logger->store, READ_WAIT_MS);
    watch_call(&logger->watch, false);
    logger->in_transaction = status == MR_OK;
    logger->begun_us = monotonic_us();
    if (status == MR_OK && logger->collector)
        status = look_for_session(logger, error);
    const struct watch_hold *hold = &logger->hold;
    if (status == MR_OK && logger->collector)
        status = collector_mark(logger->collector, error);
    /* What kept up the transaction before, as an event. */
    if (status == MR_OK && logger->collector && hold->cause != WATCH_NONE)
        status = collector_held(logger->collector, logger->hold_run, (int64_t)hold->cause,
                                hold->permille, (int64_t)hold->us, error);
    return status;
}

enum mr_status logger_commit(struct logger *logger, struct error *error)
{
    if (!logger->in_transaction)
        return MR_OK;
    enum mr_status status = collector_put_counts(logger->collector, error);
    if (status == MR_OK)
        status = store_note_logged(logger->store, collector_session(logger->collector), error);
    if (status == MR_OK && store_overwritten(logger->store)) /* nothing goes into that file */
        status = error_set(error, MR_IO, "was overwritten: %s; log into another one",
                           store_path(logger->store));
    if (status != MR_OK)
        return status;
    watch_call(&logger->watch, true);
    uint64_t from_us = monotonic_us();
    status = store_commit(logger->store, error);
    watch_call(&logger->watch, false);
    if (status == MR_OK) {
        store_logged_committed(logger->store);
        logger->hold = watch_written(&logger->watch);
        logger->hold_run = collector_marked_run(logger->collector);
        logger->in_transaction = false;
        for (unsigned link = 0; link < LINK_KINDS; link++) {
            if (logger->reader[link])
                link_queue_release(link_reader_queue(logger->reader[link]));
        }
    }
    logger->commit_us = monotonic_us() - from_us;
    if (status == MR_OK && !logger->followed) /* now there is a journal, too */
        watch_follow(&logger->watch, store_path(logger->store));
    logger->followed |= status == MR_OK;
    return status;
}

/* Each commit waits for the disk once: while much is to be made up for, one that is slow is asked
 * less often. */
bool logger_commit_due(struct logger *logger)
{
    uint64_t after_us = COMMIT_US;
    if (logger->commit_us > COMMIT_US && watch_permille(&logger->watch) > MUCH_PERMILLE)
        after_us = logger->commit_us > COMMIT_MOST_US ? COMMIT_MOST_US : logger->commit_us;
    return logger->in_transaction && monotonic_us() - logger->begun_us >= after_us;
}

void logger_take_back(struct logger *logger)
{
    store_roll_back(logger->store);
    if (logger->in_transaction && logger->collector)
        collector_back_to_mark(logger->collector);
    logger->in_transaction = false;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (logger->reader[link])
            link_queue_rewind(link_reader_queue(logger->reader[link]));
    }
}

enum mr_status logger_wait_for_store(struct logger *logger, struct error *error)
{
    enum store_refusal refused = store_take_refusal(logger->store);
    /* whatever it said of that */
    bool other = logger_place(logger) == STORE_OVERWRITTEN || logger_place(logger) == STORE_EMPTIED;
    if (error->status == MR_OK || (refused == STORE_TAKES && !other))
        return error->status;
    logger_take_back(logger);
    if (other) { /* logger_rescue goes on elsewhere */
        *error = (struct error){0};
        return MR_OK;
    }
    watch_refused(&logger->watch, refused, error->text);
    logger->again_us = monotonic_us() + (refused == STORE_LOCKED ? AGAIN_LOCKED_US : AGAIN_US);
    *error = (struct error){0};
    return MR_OK;
}
