/* The command matrig log: records landings from a board in a campaign database. */
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "host/commands/commands.h"
#include "host/link/link.h"
#include "host/log/logger.h"
#include "host/base/output.h"
#include "host/base/monotonic_clock.h"

/* Smallest change of the clock, per cycle of the main loop, that is reported. Slewing by NTP is
 * below 500 ppm and is not reported. */
#define CLOCK_JUMP_MIN_US        50000
#define CYCLE_MAX_US             250000u /* longest cycle of the main loop */
/* longest cycle of the main loop while a commit is pending */
#define TRANSACTION_CYCLE_MAX_US 40000u
#define LOCK_RETRY_MS            20 /* time between two attempts to begin the session */
/* Longest absence of a device, s. A cable that is unplugged between landings must not end the
 * log. */
#define DEVICE_ABSENCE_MAX_S     3600.0
#define DEVICE_POLL_MS           250 /* time between two attempts to open a missing device */

/* If this computer's clock was set during logging, by the user or by NTP, records the change in the
 * campaign. Stored times are not corrected; deadlines use the monotonic clock and are not
 * affected. */
static void check_clock(struct logger *logger)
{
    int64_t ahead_us = (int64_t)link_wall_clock_offset_us();
    int64_t jump_us = logger->wall_clock_offset_us ? ahead_us - logger->wall_clock_offset_us : 0;
    logger->wall_clock_offset_us = ahead_us;
    if (jump_us > -CLOCK_JUMP_MIN_US && jump_us < CLOCK_JUMP_MIN_US)
        return;
    cli_note(logger->cli,
             "the clock of this computer was changed by %+.3f s: times of day before and after the "
             "change differ by this amount",
             (double)jump_us / 1e6);
    /* Queue the change on both links, after the data received earlier. Only one of the two entries
     * has the size of the jump. */
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        bool told = link > 0 && logger->is_link_open[0];
        if (logger->is_link_open[link])
            link_queue_put_clock_jump(link_reader_queue(logger->reader[link]), told ? 0 : jump_us);
    }
}

/* True if the campaign is locked by another program. */
static bool is_campaign_locked(const struct logger *logger)
{
    return monotonic_us() < logger->next_write_us;
}

/* Returns the time until the next deadline, but at most that of one cycle of the main loop. */
static int poll_timeout_ms(const struct logger *logger, uint64_t deadline_us)
{
    uint64_t now_us = monotonic_us(), until_us = now_us + CYCLE_MAX_US;
    if (logger->in_transaction &&
        logger->transaction_begun_us + TRANSACTION_CYCLE_MAX_US < until_us)
        until_us = logger->transaction_begun_us + TRANSACTION_CYCLE_MAX_US;
    if (is_campaign_locked(logger) && logger->next_write_us < until_us)
        until_us = logger->next_write_us;
    if (deadline_us < until_us)
        until_us = deadline_us;
    if (logger_next_silence_check_us(logger) < until_us)
        until_us = logger_next_silence_check_us(logger);
    return until_us <= now_us ? 0 : (int)((until_us - now_us + 999) / 1000);
}

/* Waits for received data, a finished recording, a signal, a typed line or a deadline. */
static enum mr_status wait_for_input(struct logger *logger, int signals, uint64_t deadline_us,
                                     bool ready[LINK_KINDS], bool *signalled, struct error *error)
{
    enum { POLL_SIGNALS = LINK_KINDS, POLL_KEYBOARD, POLL_QUEUE_EVENT, POLL_COUNT };
    struct pollfd polled[POLL_COUNT];
    bool held = is_campaign_locked(logger);
    int wait_ms = poll_timeout_ms(logger, deadline_us);
    uint64_t counted;
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        bool takes = logger->is_link_open[link] && !held;
        ready[link] = takes && (link_queue_request_event(link_reader_queue(logger->reader[link])) ||
                                logger->has_buffered_data[link]);
        polled[link] = (struct pollfd){.fd = takes ? link_reader_fd(logger->reader[link]) : -1,
                                       .events = POLLIN};
        if (ready[link])
            wait_ms = 0;
    }
    polled[POLL_SIGNALS] = (struct pollfd){.fd = signals, .events = POLLIN};
    polled[POLL_KEYBOARD] = (struct pollfd){.fd = typed_commands_fd(&logger->typed),
                                            .events = POLLIN};
    polled[POLL_QUEUE_EVENT] = (struct pollfd){.fd = held ? -1 : logger->event_fd,
                                               .events = POLLIN};
    if (poll(polled, POLL_COUNT, wait_ms) < 0 && errno != EINTR)
        return error_set(error, MR_IO,
                         "cannot wait for data from the links (%s); start matrig log again",
                         strerror(errno));
    if (polled[POLL_QUEUE_EVENT].revents & POLLIN &&
        read(logger->event_fd, &counted, sizeof counted) < 0 && errno != EAGAIN)
        return error_set(error, MR_IO,
                         "cannot wait for data from the links (%s); start matrig log again",
                         strerror(errno));
    for (unsigned link = 0; link < LINK_KINDS; link++)
        ready[link] = ready[link] || (polled[link].fd >= 0 && polled[link].revents) ||
                      (logger->is_link_open[link] && !held &&
                       link_queue_has_unread(link_reader_queue(logger->reader[link])));
    *signalled = polled[POLL_SIGNALS].revents & POLLIN && logger_has_end_signal(logger, signals);
    if (polled[POLL_KEYBOARD].fd >= 0 && polled[POLL_KEYBOARD].revents)
        typed_commands_read(&logger->typed);
    return MR_OK;
}

/* Does one cycle of the main loop: stores received data, commits if it is time, and reports
 * landings and links without data. */
static enum mr_status process_cycle(struct logger *logger, const bool ready[LINK_KINDS],
                                    struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned link = 0; link < LINK_KINDS && status == MR_OK; link++) {
        if (ready[link])
            status = logger_process_queue(logger, link, error);
    }
    if (status == MR_OK && logger_is_commit_due(logger))
        status = logger_commit(logger, error);
    if (status == MR_OK)
        status = logger_show_finished_landings(logger, error);
    return status ?: logger_show_silent_landing(logger, error);
}

static bool is_any_link_open(const struct logger *logger)
{
    bool any = false;
    for (unsigned link = 0; link < LINK_KINDS; link++)
        any |= logger->is_link_open[link];
    return any;
}

static enum mr_status collect_data(struct logger *logger, int signals, double duration_s,
                                   struct error *error)
{
    uint64_t deadline_us = isinf(duration_s) ? UINT64_MAX
                                             : monotonic_us() + (uint64_t)(duration_s * 1e6);
    while (!logger->ended_by) {
        bool ready[LINK_KINDS] = {false};
        bool signalled = false;
        enum mr_status status = wait_for_input(logger, signals, deadline_us, ready, &signalled,
                                               error)
                                  ?: logger_rescue_campaign(logger, error);
        if (status == MR_OK)
            logger_select_lagging_link(logger, ready);
        if (status == MR_OK && !is_campaign_locked(logger) &&
            process_cycle(logger, ready, error) != MR_OK)
            status = logger_wait_for_store(logger, error);
        if (status != MR_OK)
            return status;
        check_clock(logger);
        logger_request_configuration(logger);
        logger_send_live_command(logger);
        logger_note_answers(logger);
        typed_commands_update(logger);
        logger_note_health(logger);
        logger_note_different_boards(logger);
        logger_note_missing_board(logger);
        logger_check_board_presence(logger);
        logger_show_progress(logger, false);
        logger_print_pending(logger);
        if (signalled)
            logger->ended_by = "signal";
        else if (!is_any_link_open(logger))
            logger->ended_by = "end";
        else if (monotonic_us() >= deadline_us)
            logger->ended_by = "time";
    }
    return MR_OK;
}

static enum mr_status open_collector(struct logger *logger, struct error *error)
{
    const struct link *can = logger->link[LINK_CAN], *serial = logger->link[LINK_SERIAL];
    enum mr_status status = collector_open(logger->store, can ? link_get_spec(can) : NULL,
                                           logger->can_base, serial ? link_get_spec(serial) : NULL,
                                           &logger->collector, error);
    if (status == MR_OK &&
        !((can && link_is_from_recording(can)) || (serial && link_is_from_recording(serial))))
        collector_set_own_commands(logger->collector, &logger->own_commands);
    return status;
}

/* Begins the session as soon as the campaign is not locked. Until then, received data waits in the
 * queues. */
static enum mr_status begin_session(struct logger *logger, int signals, struct error *error)
{
    for (;;) {
        enum mr_status status = logger_begin_transaction(logger, error)
                                  ?: open_collector(logger, error);
        if (status == MR_OK)
            return MR_OK;
        enum store_refusal refused = store_refusal_pop(logger->store);
        /* wait only for a lock; report other errors at once, while the user is still present */
        if (refused != STORE_LOCKED)
            return status;
        watch_note_refusal(&logger->watch, refused, error->text);
        struct pollfd asked = {.fd = signals, .events = POLLIN};
        if (poll(&asked, 1, LOCK_RETRY_MS) > 0)
            return status;
        *error = (struct error){0};
    }
}

/* Opens a reader for each link. From then on, no received data is lost. */
static enum mr_status open_readers(struct logger *logger, struct error *error)
{
    logger->event_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    enum mr_status status = MR_OK;
    if (logger->event_fd < 0)
        return error_set(error, MR_IO,
                         "cannot create an eventfd (%s); check the limits of this system",
                         strerror(errno));
    for (unsigned link = 0; link < LINK_KINDS && status == MR_OK; link++) {
        if (logger->link[link])
            status = link_reader_open(logger->link[link], (enum link_kind)link, 0, logger->event_fd,
                                      watch_find_cause, &logger->watch, &logger->reader[link],
                                      error);
    }
    return status ?: watch_begin(&logger->watch, logger->reader, store_path(logger->store), error);
}

static enum mr_status run_session(struct logger *logger, int signals, double duration_s,
                                  struct error *error)
{
    enum mr_status status = open_readers(logger, error) ?: begin_session(logger, signals, error);
    if (status != MR_OK)
        return status;
    if (logger->live.hub)
        collector_set_listener(logger->collector, &logger->live.listener);
    /* commit now, so that the session is kept if a later transaction fails */
    status = logger_commit(logger, error);
    logger_set_nonblocking(logger, true);
    if (status == MR_OK)
        status = collect_data(logger, signals, duration_s, error);
    /* after an error, store the data received so far and close the session, if the database permits
     * it */
    struct error late = {0};
    if (status != MR_OK)
        logger->ended_by = "error";
    bool finished = logger_end_session(logger, signals, &late) == MR_OK;
    logger_set_nonblocking(logger, false);
    logger_print_pending(logger);
    if (finished)
        logger_show_finished_landings(logger, &late);
    logger_show_progress(logger, true);
    if (late.status != MR_OK)
        status = error_set(error, late.status, "%s", late.text);
    if (status == MR_OK && logger->file_problem_text[0])
        status =
            logger->saved_path[0]
                ? error_set(error, MR_IO, "%s; the data logged%s%s is in %s",
                            logger->file_problem_text,
                            logger->data_missing_until[0] ? " since " : "",
                            logger->data_missing_until, logger->saved_path)
                : error_set(error, MR_IO,
                            "%s; the data could not be saved in the folder of the campaign either",
                            logger->file_problem_text);
    if (status == MR_OK && logger->link_error.status != MR_OK)
        status = error_set(error, logger->link_error.status, "%s", logger->link_error.text);
    if (status == MR_OK)
        status = logger_check_received(logger, error);
    if (status == MR_OK && logger->shown_landing_count == 0)
        cli_note(logger->cli, "no landing was armed; %s contains the received data",
                 store_path(logger->store));
    return status;
}

static enum mr_status open_live(struct logger *logger, const char *where, const char *can,
                                const char *serial, const char *db, struct error *error)
{
    bool listens = logger->rejects_data[0] && logger->rejects_data[1];
    const struct live_source source = {
        .db = db,
        .can = can,
        .serial = serial,
        .accepts_commands = !listens,
        .uses_si = logger->cli->si,
        .no_commands_reason =
            listens ? "matrig log was started with --listen, so it sends no commands" : NULL};
    enum mr_status status = live_open(&logger->live, where, &source, error);
    /* printed even with --quiet, because the user has no other way to know the port */
    if (status == MR_OK) {
        fprintf(stderr, "live: %s\n", live_server_url(logger->live.server));
        fflush(stderr);
    }
    return status;
}

static enum mr_status open_store(struct logger *logger, const char *db, struct error *error)
{
    enum mr_status status = store_open(db, STORE_LOG, &logger->store, error);
    if (status == MR_OK)
        store_watch_file(logger->store);
    return status;
}

static enum mr_status open_link(struct logger *logger, unsigned link, const char *spec, int signals,
                                struct error *error)
{
    bool waits = !isnan(logger->absence_max_s) && link_is_device(spec), told = false, ends = false;
    uint64_t until_us = monotonic_us() + (uint64_t)(waits ? logger->absence_max_s * 1e6 : 0.0);
    enum mr_status status;
    /* without --wait, report a missing device as an error, because its name may be mistyped */
    while ((status = link_open(spec, (enum link_kind)link, &logger->link[link], error)) == MR_IO &&
           waits && !ends && monotonic_us() < until_us) {
        if (!told)
            cli_note(logger->cli, "%s (waiting %.3g s for it)", error->text, logger->absence_max_s);
        told = true;
        error->status = MR_OK;
        ends = poll(&(struct pollfd){.fd = signals, .events = POLLIN}, 1, DEVICE_POLL_MS) > 0;
    }
    if (status == MR_OK)
        link_set_absence_limit(logger->link[link], isnan(logger->absence_max_s)
                                                       ? DEVICE_ABSENCE_MAX_S
                                                       : logger->absence_max_s);
    logger->is_link_open[link] = status == MR_OK;
    return status;
}

/* Opens the database and all links. An existing database is checked before the links are opened; a
 * new database is created only after they were opened. */
static enum mr_status open_all(struct logger *logger, int signals, const char *can,
                               const char *serial, const char *db, const char *live,
                               struct error *error)
{
    enum mr_status status = MR_OK;
    if (access(db, F_OK) == 0)
        status = open_store(logger, db, error);
    if (status == MR_OK && live)
        status = open_live(logger, live, can, serial, db, error);
    if (status == MR_OK && can)
        status = open_link(logger, LINK_CAN, can, signals, error);
    if (status == MR_OK && can)
        logger->can_base = link_base(logger->link[LINK_CAN]);
    if (status == MR_OK && serial)
        status = open_link(logger, LINK_SERIAL, serial, signals, error);
    if (status == MR_OK && !logger->store) {
        status = open_store(logger, db, error);
        if (status == MR_OK) /* only a note, no question, because a log must start without a user */
            cli_note(logger->cli, "a new campaign: %s", db);
    }
    return status;
}

static bool close_all(struct logger *logger)
{
    collector_close(logger->collector);
    /* closing the database also writes its journal back, which may take long */
    watch_record_call(&logger->watch, true);
    bool closed = logger_close_store(logger);
    watch_record_call(&logger->watch, false);
    watch_close(&logger->watch);
    for (unsigned link = 0; link < LINK_KINDS; link++) {
        link_reader_close(logger->reader[link]);
        link_close(logger->link[link]);
    }
    if (logger->event_fd >= 0)
        close(logger->event_fd);
    return closed;
}

struct request {
    const char *can, *serial, *db, *live, *page;
    double duration_s, wait_s;
    bool listen, commands, all;
};

static int log_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {0};
    struct error error = {0};
    command_parse(&command_log, argc, argv, cli, &r, NULL, fatal);
    if (!r.can && !r.serial)
        error_set(
            fatal, MR_USAGE,
            "no link: matrig log needs --can LINK, --serial LINK or both; see matrig log --help");
    if (!r.db)
        error_set(fatal, MR_USAGE, "no database: matrig log needs --db DB; see matrig log --help");
    if (r.listen && r.commands)
        error_set(fatal, MR_USAGE,
                  "--listen and --commands exclude each other, because --listen sends nothing; "
                  "leave one out");
    output_check(r.page, r.db, fatal);

    /* use a signalfd, so that a signal between a check and a wait is not lost */
    sigset_t set;
    cli_fill_termination_signals(&set);
    sigprocmask(SIG_BLOCK, &set, NULL);
    /* do not end when the program that reads the output exits */
    signal(SIGPIPE, SIG_IGN);
    int signals = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);

    struct logger logger = {.cli = cli,
                            .landings_json = json_array(),
                            .absence_max_s = r.wait_s,
                            .db_path = r.db,
                            .page_path = r.page,
                            .prints_full_summaries = r.all};
    logger.event_fd = -1;
    for (unsigned link = 0; link < LINK_KINDS; link++)
        logger.rejects_data[link] = r.listen;
    watch_open(&logger.watch, cli);
    typed_commands_begin(&logger.typed, r.commands, r.listen);
    enum mr_status status = open_all(&logger, signals, r.can, r.serial, r.db, r.live, &error);
    if (status == MR_OK && logger.typed.is_enabled && logger.typed.is_terminal)
        cli_note(
            cli,
            "to arm the board, press Enter and type arm [N]; to disarm the board, type disarm");
    if (status == MR_OK)
        status = run_session(&logger, signals, r.duration_s, &error);
    int exit_code = status == MR_OK ? 0 : cli_fail(&error);
    if (logger.collector)
        exit_code = logger_show_session(&logger, r.db, &error, exit_code);
    logger_update_page(&logger, true);
    json_decref(logger.landings_json);
    free(logger.pending_output);
    logger_end_live(&logger, &error);
    if (!close_all(&logger) && exit_code == 0)
        exit_code = 3;
    close(signals);
    return exit_code;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    OPTION_TEXT("--can", "LINK", can, "the board's CAN bus"),
    OPTION_TEXT("--serial", "LINK", serial,
                "the board's serial port; give --can, --serial or both"),
    OPTION_TEXT("--db", "DB", db, "campaign database; created if missing"),
    OPTION_NUMBER("--for", "S", duration_s, "s", 0.001, 1e7, (double)INFINITY,
                  "end the log after S seconds; default: end when the links end, or on Ctrl-C"),
    OPTION_TEXT("--live", "PORT", live,
                "show a live page in a browser on this computer; the page can also arm and disarm"),
    OPTION_FLAG("--listen", listen,
                "send nothing to the board, not even the request for its configuration"),
    OPTION_FLAG("--commands", commands,
                "accept arm [N] and disarm, one per line, also if standard input is not a "
                "terminal. After arm, the next line must be yes"),
    OPTION_FLAG("--all", all, "print the full summary of each landing; default: its main lines"),
    OPTION_TEXT("--page", "F.html", page, "write the report F after each landing"),
    OPTION_NUMBER("--wait", "S", wait_s, "s", 0.0, 1e7, (double)NAN,
                  "wait S seconds for a device that is unplugged or down; default: 3600 for a "
                  "device lost during the log, 0 for a device missing at the start"),
    HELP_NOTE("matrig log prints which board answered, reports a silent board within 2 s, and "
              "prints a summary after each landing."),
    HELP_EXAMPLE("matrig log --can can:can0 --serial serial:/dev/ttyUSB0 --db campaign.db --page "
                 "landing.html"),
    HELP_NOTE("\n"
              "LINK is one of:"),
#define LINK_TRANSPORT(name, form, text) HELP_ITEM(form, text),
#include "host/link/kinds.def"
    HELP_NOTE(
        "Exit 3: " LINK_NO_HELLO
        " (no data, wrong bit rate, or error frames only); the message gives the reason. While "
        "serial data arrives, the landing is recorded from serial; after the landing, CAN frames "
        "fill the gaps. If a device is disconnected, matrig log waits until it is back, and "
        "reports the data lost. If the campaign is locked, or the disk slow or full, 60 s of data "
        "wait in memory; later data is dropped and counted as lost. If the campaign is moved, "
        "replaced, "
        "deleted or overwritten, logging continues in DB-saved-DATE.db in the same folder, with "
        "exit code 3."),
};

const struct command command_log = {
    "log",
    log_command,
    "--can LINK --serial LINK --db DB [--for S] [--live PORT] [--listen | --commands] "
    "[--page F] [--all] [--wait S]",
    "collect landings from a board",
    COMMAND_PARTS(parts),
    {0, 0, ""},
};
