/* The end of matrig log: no more is read, what is in the queues is written, the session is closed.
 * A campaign that still takes nothing is waited for a while; then what is left goes into files
 * beside it, which matrig log reads. */
#include <fcntl.h>
#include <libgen.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "host/link/candump.h"
#include "host/log/logger.h"
#include "host/base/monotonic_clock.h"

/* for a campaign that takes nothing, at the end of the links or of --for; */
#define WAIT_US       60000000u
#define WAIT_ASKED_US 5000000u /* when somebody asked for the end */
/* nobody asks twice within it; `timeout` and `kill` of a group give one signal twice */
#define HURRY_US      500000u
#define LOOK_MS       20
#define COMMAND_MOST  300u     /* of an error's 600 characters */
#define BEFORE_US     5000000u /* the board says hello once a second, and the time ten times */

bool logger_signalled(struct logger *logger, int signals)
{
    struct signalfd_siginfo info;
    if (read(signals, &info, sizeof info) != (ssize_t)sizeof info)
        return false;
    uint64_t now_us = monotonic_us();
    logger->hurried = logger->ended_by &&
                      (!logger->signalled_us || now_us - logger->signalled_us > HURRY_US);
    if (!logger->signalled_us)
        logger->signalled_us = now_us;
    watch_end(&logger->watch);
    return true;
}

/* All that is in the queues. MR_TOO_FEW: nothing is left. */
static enum mr_status take_turn(struct logger *logger, struct error *error)
{
    bool ready[LINK_KINDS] = {false}, any = false;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        ready[link] = logger->reader[link] &&
                      link_queue_unread(link_reader_queue(logger->reader[link]));
        any |= ready[link];
    }
    if (!any)
        return MR_TOO_FEW;
    logger_keep_in_step(logger, ready);
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (ready[link] && logger_receive(logger, link, error) != MR_OK)
            return error->status;
    }
    return logger_commit_due(logger) ? logger_commit(logger, error) : MR_OK;
}

static enum mr_status write_end(struct logger *logger, struct error *error)
{
    enum mr_status status = logger_begin(logger, error);
    if (status == MR_OK)
        status = collector_end(logger->collector, logger->ended_by, error);
    return status == MR_OK ? logger_commit(logger, error) : status;
}

/* ---- what the campaign did not take ---- */

struct side_file {
    char path[4096];
    FILE *file;
};

static bool open_side_file(struct side_file *side, const char *db, const char *ending)
{
    char copy[sizeof side->path];
    snprintf(copy, sizeof copy, "%s", db);
    const char *folder = dirname(copy);
    if (access(folder, W_OK | X_OK) != 0)
        folder = ".";
    if (!logger_beside(folder, db, "unsaved", ending, side->path, sizeof side->path))
        return false;
    int fd = open(side->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    side->file = fd >= 0 ? fdopen(fd, "w") : NULL;
    if (fd >= 0 && !side->file)
        close(fd);
    return side->file != NULL;
}

static bool close_side_file(struct side_file *side)
{
    bool good = !ferror(side->file) && fflush(side->file) == 0 && fsync(fileno(side->file)) == 0;
    good = fclose(side->file) == 0 && good;
    if (!good)
        unlink(side->path);
    return good;
}

/* A link's since then, as a candump log or as bytes. False: it could not be written. */
static bool save_queue(struct logger *logger, unsigned link, uint64_t since_us,
                       struct side_file *side)
{
    struct link_queue *queue = link_reader_queue(logger->reader[link]);
    enum link_kind kind = (enum link_kind)link;
    struct link_item item;
    char line[CANDUMP_LINE_MAX];
    if (!open_side_file(side, store_path(logger->store), kind == LINK_CAN ? ".log" : ".bin"))
        return false;
    if (kind == LINK_CAN && logger->hello.length) /* without it nothing of a board is understood */
        fwrite(line, 1, candump_print(&logger->hello, line), side->file);
    for (bool begun = false; link_queue_take(queue, &item);) {
        /* from then on all: this computer's clock may have been set back */
        begun |= item.host_us >= since_us;
        if (item.kind == LINK_ITEM_FRAME && begun)
            fwrite(line, 1, candump_print(&item.frame, line), side->file);
        else if (item.kind == LINK_ITEM_BYTES && begun)
            fwrite(item.bytes, 1, item.length, side->file);
    }
    return close_side_file(side);
}

static bool is_gone(enum store_place place)
{
    return place == STORE_OVERWRITTEN || place == STORE_EMPTIED;
}

/* Goes back in the queues to the beginning of the landing that is going on: what is saved of it is
 * all of it, and can be understood. Of a campaign that is gone, to the beginning of what is kept.
 * Returns from when on it is to be saved. */
static uint64_t go_back(struct logger *logger)
{
    const int64_t since_us = collector_since_us(logger->collector);
    bool gone = is_gone(logger_place(logger));
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        if (logger->reader[link] && (gone || since_us != STORE_NONE))
            link_queue_rewind_all(link_reader_queue(logger->reader[link]));
    }
    return gone || since_us == STORE_NONE || since_us < (int64_t)BEFORE_US
             ? 0
             : (uint64_t)since_us - BEFORE_US;
}

/* How to take in what was saved. A command that an error has no room for is told before it, also
 * with --quiet: it must be whole. */
static enum mr_status tell_saved(const struct logger *logger, const char *reason, const char *what,
                                 const char *links, struct error *error)
{
    const char *db = store_path(logger->store);
    if (strlen(links) + strlen(db) < COMMAND_MOST)
        return error_set(
            error, MR_IO,
            "not in the campaign (%.120s): %s that came last; take them in: matrig log%s --db %s",
            reason, what, links, db);
    logger_clear_progress(logger);
    fprintf(stderr, "matrig log%s --db %s\n", links, db);
    return error_set(error, MR_IO,
                     "not in the campaign (%.120s): %s that came last; take them in by the command "
                     "that was told before this line",
                     reason, what);
}

/* The error names the files, or what is lost. */
static enum mr_status save_rest(struct logger *logger, const char *reason, struct error *error)
{
    struct side_file side[LINK_KINDS] = {0};
    char what[100], links[LINK_KINDS * (sizeof side[0].path + 60)] = "";
    bool good = true;
    watch_amount(&logger->watch, false, what, sizeof what);
    logger_take_back(logger);
    bool any = strcmp(what, "nothing") != 0 || is_gone(logger_place(logger));
    const uint64_t since_us = any ? go_back(logger) : 0;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        struct link_queue *queue = logger->reader[link] ? link_reader_queue(logger->reader[link])
                                                        : NULL;
        struct link_queue_depth depth = {0};
        char at[20] = "";
        if (queue)
            depth = link_queue_depth(queue);
        if (depth.frames + depth.octets == 0)
            continue;
        good = save_queue(logger, link, since_us, &side[link]) && good;
        size_t used = strlen(links);
        if (link_base(logger->link[link]))
            snprintf(at, sizeof at, ",base=0x%03x", link_base(logger->link[link]));
        snprintf(links + used, sizeof links - used, " --%s file:%s%s",
                 (enum link_kind)link == LINK_CAN ? "can" : "serial", side[link].path, at);
    }
    if (links[0] == '\0')
        return error_set(error, MR_IO,
                         "all that came is in the campaign, the end of the session is not: %.250s",
                         reason);
    if (!good)
        return error_set(
            error, MR_IO,
            "what came last could not be written, nor saved beside the campaign: lost: %s; %.250s",
            what, reason);
    return tell_saved(logger, reason, what, links, error);
}

static bool waited_enough(struct logger *logger, uint64_t began_us)
{
    uint64_t refused_us = watch_refused_us(&logger->watch), now_us = monotonic_us();
    uint64_t since_us = refused_us > began_us ? refused_us : began_us;
    bool asked = strcmp(logger->ended_by, "signal") == 0;
    return logger->hurried || (refused_us && now_us - since_us > (asked ? WAIT_ASKED_US : WAIT_US));
}

/* For a reason that does not pass, such as a file that is no campaign any more. */
static enum mr_status give_up(struct logger *logger, const struct error *why, struct error *error)
{
    struct error rest = {0};
    logger_take_back(logger);
    if (watch_permille(&logger->watch) > 0) {
        (void)save_rest(logger, why->text, &rest);
        logger_clear_progress(logger);
        cli_note(logger->cli, "%s", rest.text);
    }
    return error_set(error, why->status, "%s", why->text);
}

/* All is written: is the campaign still in its place? MR_TOO_FEW: it was not, and
 * comes again, for another one. */
static enum mr_status settle(struct logger *logger, struct error *error)
{
    (void)watch_place_now(&logger->watch);
    enum store_place place = logger_place(logger);
    logger->rescue_us = 0;
    enum mr_status status = logger_rescue(logger, error);
    if (status != MR_OK || !is_gone(place))
        return status;
    return is_gone(logger_place(logger)) ? save_rest(logger, logger->taken, error) : MR_TOO_FEW;
}

enum mr_status logger_finish(struct logger *logger, int signals, struct error *error)
{
    char reason[sizeof error->text] = "ended in a hurry";
    uint64_t began_us = monotonic_us();
    const bool failed = strcmp(logger->ended_by, "error") == 0;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        link_reader_stop(logger->reader[link]);
        logger->more[link] = false;
    }
    for (;;) {
        struct error why = {0};
        enum mr_status status = logger_rescue(logger, error);
        if (status != MR_OK)
            return status;
        bool went_wrong = failed && !logger->refilled;
        if (monotonic_us() >= logger->again_us) {
            status = went_wrong ? MR_TOO_FEW : take_turn(logger, &why);
            if (status == MR_TOO_FEW && write_end(logger, &why) == MR_OK) {
                status = settle(logger, error);
                if (status != MR_TOO_FEW)
                    return status;
                continue; /* all that is kept goes into the new one */
            }
            if (why.status != MR_OK)
                snprintf(reason, sizeof reason, "%s", why.text);
            if (went_wrong || logger_wait_for_store(logger, &why) != MR_OK)
                return give_up(logger, &why, error);
        } else {
            struct pollfd asked = {.fd = signals, .events = POLLIN};
            poll(&asked, 1, LOOK_MS);
        }
        (void)logger_signalled(logger, signals);
        if (waited_enough(logger, began_us))
            return save_rest(logger, reason, error);
    }
}
