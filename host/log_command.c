/* matrig log: collect landings from a board into a campaign database. */
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

#include "common/command.h"
#include "common/framing.h"
#include "host/analyse/summary.h"
#include "host/board/crash.h"
#include "host/cli.h"
#include "host/collect/collect.h"
#include "host/collect/quicklook.h"
#include "host/link/can_error.h"
#include "host/live/live.h"

/* A kill at any time may cost at most 100 ms of what was received; half of it is left for a slow disk. */
#define COMMIT_US 40000u
#define PROGRESS_US 200000u
#define CLOCK_JUMP_US 50000 /* within a turn; one that is slewed goes 500 ppm of it */
#define SERVICE_US 250000u /* links are looked after at least this often */
#define ASK_US 1000000u  /* between two requests for the configuration */
#define ASKS 5u          /* for the same; a board that does not answer, or of another table, is left alone then */
#define LIVE_S 30        /* so long a board without CAN tells readings while idle, */
#define LIVE_AGAIN_US 20000000u /* and so often it is asked */
#define AWAY_S 3600.0 /* a cable that is off between two landings ends no day of logging */
#define NOTE_US 1000000u /* the same trouble is told once a second */
#define FRAMES_PER_TURN 1024
#define BYTES_PER_TURN 16384

struct logger {
    const struct cli *cli;
    struct store *store;
    struct link *link[LINK_KINDS];
    bool open[LINK_KINDS];
    bool more[LINK_KINDS]; /* not drained: poll need not see what waits inside the link */
    struct collector *collector;
    uint64_t troubles[LINK_KINDS];              /* of the link's, taken */
    uint64_t noted[LINK_KINDS][LINK_TROUBLES];  /* of them, seen by the user */
    uint64_t noted_us[LINK_KINDS][LINK_TROUBLES];
    struct hil_symbols symbols; /* of --elf; none without it */
    bool in_transaction;
    uint64_t begun_us;
    uint64_t shown_us;
    uint64_t asked_us;       /* for the configuration; 0: not, or a landing came in between */
    unsigned asks;           /* since the beginning or the last landing */
    bool mute[LINK_KINDS];   /* nothing can be sent on it */
    double wait_s;           /* for a device that went away */
    const char *ended_by;    /* NULL: going on */
    struct error link_error; /* the first link that broke; logging went on with the other */
    json_t *landings;
    unsigned shown; /* landings summarised */
    struct quicklook look;
    struct live live; /* of --live; else all zero */
    int64_t clock_ahead_us; /* the time of day of the monotonic clock; 0: not looked at yet */
    uint64_t live_us; /* when the board was asked to be live; 0: not yet */
};

/* For deadlines: never jumps. */
static uint64_t monotonic_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

static enum mr_status ensure_transaction(struct logger *logger, struct error *error)
{
    if (logger->in_transaction)
        return MR_OK;
    enum mr_status status = store_begin(logger->store, error);
    logger->in_transaction = status == MR_OK;
    logger->begun_us = monotonic_us();
    return status;
}

static enum mr_status commit(struct logger *logger, struct error *error)
{
    if (!logger->in_transaction)
        return MR_OK;
    enum mr_status status = collector_put_counts(logger->collector, error);
    if (status == MR_OK)
        status = store_commit(logger->store, error);
    logger->in_transaction = false;
    return status;
}

/* The link is over, for whatever reason; a broken one is remembered, and the other one goes on. */
static enum mr_status end_link(struct logger *logger, enum link_kind kind, struct error *reason,
                               struct error *error)
{
    struct error tail = {0};
    logger->open[kind] = false;
    enum mr_status status = ensure_transaction(logger, error);
    if (status == MR_OK)
        status = collector_link_end(logger->collector, kind, &tail);
    if (status == MR_TRUNCATED)
        status = MR_OK;
    else if (status != MR_OK)
        error_set(error, status, "%s", tail.text);
    if (logger->link_error.status == MR_OK)
        logger->link_error = reason->status != MR_OK ? *reason : tail;
    return status;
}

/* Tells the user of troubles that are new, `text` (may be NULL) in place of their own. */
static void note_troubles(struct logger *logger, enum link_kind kind, const char *text)
{
    const struct link_counters *counters = link_counters(logger->link[kind]);
    uint64_t now_us = monotonic_us();
    bool told = false;
    for (unsigned i = 0; i < LINK_TROUBLES; i++) {
        uint64_t more = counters->trouble[i] - logger->noted[kind][i];
        bool lately = logger->noted_us[kind][i] != 0 && now_us - logger->noted_us[kind][i] < NOTE_US;
        if (more == 0 || lately)
            continue;
        if (!logger->cli->quiet && cli_terminal())
            fputs("\r\033[K", stderr); /* over the progress */
        logger->noted[kind][i] = counters->trouble[i];
        logger->noted_us[kind][i] = now_us;
        if (!text)
            cli_note(logger->cli, "%s: %s: %llu", link_spec(logger->link[kind]), link_trouble_text(i),
                     (unsigned long long)more);
        else if (!told)
            cli_note(logger->cli, "%s: %s", link_spec(logger->link[kind]), text);
        told = true;
    }
}

/* What the link saw since the last time: recorded, and told. `frame` is the error frame that tells it, if any. */
static enum mr_status take_troubles(struct logger *logger, enum link_kind kind, const struct link_frame *frame,
                                    struct error *error)
{
    const struct link_counters *counters = link_counters(logger->link[kind]);
    char text[CAN_ERROR_TEXT_MAX];
    if (counters->troubles == logger->troubles[kind])
        return MR_OK;
    logger->troubles[kind] = counters->troubles;
    bool error_frame = frame && frame->id & LINK_ID_ERROR;
    if (error_frame)
        can_error_text(frame, text);
    note_troubles(logger, kind, error_frame ? text : NULL);
    enum mr_status status = ensure_transaction(logger, error);
    return status == MR_OK ? collector_troubles(logger->collector, kind, counters, error) : status;
}

/* Keeps the links in order: a device that went away comes back, or ends its link. */
static enum mr_status service_links(struct logger *logger, struct error *error)
{
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct error reason = {0};
        if (!logger->open[kind])
            continue;
        enum mr_status serviced = link_service(logger->link[kind], &reason);
        enum mr_status status = take_troubles(logger, (enum link_kind)kind, NULL, error);
        if (status == MR_OK && serviced != MR_OK && serviced != MR_TOO_FEW)
            status = end_link(logger, (enum link_kind)kind, &reason, error);
        if (status != MR_OK)
            return status;
    }
    return MR_OK;
}

static enum mr_status receive_can(struct logger *logger, struct error *error)
{
    struct link_frame frame;
    struct error reason = {0};
    logger->more[LINK_CAN] = false;
    for (int i = 0; i < FRAMES_PER_TURN; i++) {
        enum mr_status status = link_receive_frame(logger->link[LINK_CAN], &frame, &reason);
        if (status == MR_TOO_FEW)
            return MR_OK;
        if (status != MR_OK)
            return end_link(logger, LINK_CAN, &reason, error);
        status = ensure_transaction(logger, error);
        if (status == MR_OK)
            status = take_troubles(logger, LINK_CAN, &frame, error);
        if (status == MR_OK)
            status = collector_frame(logger->collector, &frame, error);
        if (status != MR_OK)
            return status;
    }
    logger->more[LINK_CAN] = true;
    return MR_OK;
}

static enum mr_status receive_serial(struct logger *logger, struct error *error)
{
    uint8_t bytes[BYTES_PER_TURN];
    size_t length;
    uint64_t host_us;
    struct error reason = {0};
    logger->more[LINK_SERIAL] = false;
    enum mr_status status =
        link_receive_bytes(logger->link[LINK_SERIAL], bytes, sizeof bytes, &length, &host_us, &reason);
    if (status == MR_TOO_FEW)
        return MR_OK;
    if (status != MR_OK)
        return end_link(logger, LINK_SERIAL, &reason, error);
    logger->more[LINK_SERIAL] = true;
    status = ensure_transaction(logger, error);
    return status == MR_OK ? collector_bytes(logger->collector, bytes, length, host_us, error) : status;
}

static enum mr_status show_finished(struct logger *logger, struct error *error)
{
    int64_t run;
    while ((run = collector_take_finished(logger->collector)) != 0) {
        struct summary summary;
        struct error why = {0};
        enum mr_status status = commit(logger, error);
        if (status != MR_OK)
            return status;
        if (summary_load(logger->store, run, &summary, &why) != MR_OK) { /* it can be tried again later; what comes cannot */
            cli_note(logger->cli, "no summary of RUN %lld: %s", (long long)run, why.text);
            summary_free(&summary);
            continue;
        }
        if (logger->cli->json) {
            json_array_append_new(logger->landings, summary_json(&summary, logger->cli->si));
        } else {
            summary_print(&summary, logger->cli->si, stdout);
            fflush(stdout);
        }
        summary_free(&summary);
        logger->shown++;
        quicklook_write(&logger->look);
    }
    return MR_OK;
}

/* The links fell silent in the middle of a landing: what came of it until now. */
static enum mr_status show_silent(struct logger *logger, struct error *error)
{
    struct collector_progress progress;
    struct summary summary;
    collector_progress(logger->collector, &progress);
    quicklook_service(&logger->look, false);
    if (!quicklook_silent(&logger->look, &progress, monotonic_us()))
        return MR_OK;
    cli_note(logger->cli, "nothing comes any more of RUN %lld: are board and cables in order? What came until now is kept",
             (long long)progress.run);
    struct error why = {0};
    enum mr_status status = commit(logger, error);
    if (status != MR_OK)
        return status;
    if (summary_load(logger->store, progress.run, &summary, &why) != MR_OK) {
        cli_note(logger->cli, "no summary of RUN %lld: %s", (long long)progress.run, why.text);
    } else if (!logger->cli->json) {
        summary_print(&summary, logger->cli->si, stdout);
        fflush(stdout);
    }
    summary_free(&summary);
    quicklook_write(&logger->look);
    return MR_OK;
}

/* Sends it over serial when that can be, else over CAN. `unasked`: nobody waits for it, so a link that does not take it is not tried
 * again. */
static void send_command(struct logger *logger, const struct mr_command *command, bool unasked)
{
    struct link_frame can = {.id = MR_ID_COMMAND};
    uint8_t bytes[MR_FRAME_MAX];
    can.length = (uint8_t)mr_command_put(command, can.data);
    for (int kind = LINK_KINDS - 1; kind >= 0; kind--) {
        struct error reason = {0};
        if (!logger->open[kind] || (unasked && logger->mute[kind]))
            continue;
        enum mr_status status =
            kind == LINK_CAN ? link_send_frame(logger->link[kind], &can, &reason)
                             : link_send_bytes(logger->link[kind], bytes,
                                               mr_frame_encode(0, MR_ID_COMMAND, can.data, can.length, bytes), &reason);
        logger->mute[kind] = logger->mute[kind] || (unasked && status != MR_OK);
        if (status == MR_OK)
            return;
    }
}

/* Asks the board for its configuration, over serial when it can be. A link that does not take it, such as a file, is asked once. */
static void ask_for_configuration(struct logger *logger)
{
    struct mr_command command = {.code = MR_COMMAND_CONFIG_READ};
    uint64_t now_us = monotonic_us();
    if (!collector_lacks_configuration(logger->collector)) {
        struct collector_progress p;
        collector_progress(logger->collector, &p);
        if (p.run) /* what it was telling ended with the arming: ask at once when it is done */
            logger->asked_us = logger->asks = 0;
        return;
    }
    if (logger->asks == ASKS || (logger->asked_us && now_us - logger->asked_us < ASK_US))
        return;
    logger->asked_us = now_us;
    logger->asks++;
    send_command(logger, &command, true);
}

/* An idle board tells its readings on CAN alone. Without CAN it is asked for a record each 20 ms, so that something moves. */
static void keep_it_live(struct logger *logger)
{
    struct mr_command command = {.code = MR_COMMAND_LIVE, .argument = LIVE_S};
    struct collector_progress p;
    collector_progress(logger->collector, &p);
    uint64_t now_us = monotonic_us();
    if (logger->open[LINK_CAN] || p.run || !p.hello || (logger->live_us && now_us - logger->live_us < LIVE_AGAIN_US))
        return;
    logger->live_us = now_us;
    send_command(logger, &command, true);
}

/* The live view: events that are due, and what its viewers ask of the board. */
static void serve_live(struct logger *logger)
{
    struct mr_command command;
    if (!logger->live.hub)
        return;
    keep_it_live(logger);
    live_turn(&logger->live, logger->collector);
    if (live_take_command(&logger->live, &command))
        send_command(logger, &command, false);
}

/* What the board said of itself that nobody should have to look for. */
static void note_health(struct logger *logger)
{
    char text[300];
    const struct crash_report *crash = collector_take_crash(logger->collector);
    const struct mr_can_alarm *alarm = collector_take_alarm(logger->collector);
    if ((crash || alarm) && !logger->cli->quiet && cli_terminal())
        fputs("\r\033[K", stderr); /* over the progress */
    if (crash) {
        crash_headline(crash, &logger->symbols, text, sizeof text);
        cli_note(logger->cli, "%s", text);
    }
    if (alarm && alarm->state > MR_CAN_GOOD)
        cli_note(logger->cli, "the board says of CAN: %s (TEC %u)", mr_can_state_text(alarm->state), alarm->tec);
    else if (alarm && alarm->outages)
        cli_note(logger->cli, "the board says of CAN: good again after %.2f s; %u %s since its reset", (double)alarm->outage_s,
                 alarm->outages, alarm->outages == 1 ? "outage" : "outages");
}

/* The time of day is this computer's, which somebody, or NTP, may set while it is logging. Deadlines go by the monotonic clock; what has
 * been stamped keeps its stamp, and the campaign says from when on stamps are others. */
static enum mr_status watch_clock(struct logger *logger, struct error *error)
{
    int64_t ahead_us = (int64_t)(link_now_us() - monotonic_us());
    int64_t jump_us = logger->clock_ahead_us ? ahead_us - logger->clock_ahead_us : 0;
    logger->clock_ahead_us = ahead_us;
    if (jump_us > -CLOCK_JUMP_US && jump_us < CLOCK_JUMP_US)
        return MR_OK;
    cli_note(logger->cli, "this computer's clock was set by %+.3f s: times of day before and after it differ by that",
             (double)jump_us / 1e6);
    enum mr_status status = ensure_transaction(logger, error);
    return status == MR_OK ? collector_clock_set(logger->collector, jump_us, error) : status;
}

static void show_progress(struct logger *logger, bool last)
{
    if (logger->cli->quiet || !cli_terminal() || (!last && monotonic_us() - logger->shown_us < PROGRESS_US))
        return;
    struct collector_progress p;
    collector_progress(logger->collector, &p);
    logger->shown_us = monotonic_us();
    fprintf(stderr,
            "\r%s %8.3f s  %u switches  CAN %lld frames, %lld lost  serial %lld frames, %lld lost \033[K%s",
            p.run     ? collector_state_text(p.state)
            : p.hello ? "no landing"
                      : "waiting for a board",
            p.block < 0 ? 0.0 : (double)p.block / 1000.0, p.edges, (long long)p.counts[LINK_CAN].received,
            (long long)p.counts[LINK_CAN].lost, (long long)p.counts[LINK_SERIAL].received,
            (long long)p.counts[LINK_SERIAL].lost, last ? "\n" : "");
}

/* Waits until a link is readable, a signal or a deadline. */
static enum mr_status wait_for_news(const struct logger *logger, int signals, uint64_t deadline_us,
                                    bool ready[LINK_KINDS], bool *signalled, struct error *error)
{
    struct pollfd polled[LINK_KINDS + 1];
    uint64_t now_us = monotonic_us();
    uint64_t until_us = deadline_us;
    if (logger->in_transaction && logger->begun_us + COMMIT_US < until_us)
        until_us = logger->begun_us + COMMIT_US;
    if (until_us > now_us + SERVICE_US)
        until_us = now_us + SERVICE_US;
    int wait_ms = until_us <= now_us ? 0 : (int)((until_us - now_us + 999) / 1000);
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        polled[kind] =
            (struct pollfd){.fd = logger->open[kind] ? link_fd(logger->link[kind]) : -1, .events = POLLIN};
        if (logger->more[kind])
            wait_ms = 0;
    }
    polled[LINK_KINDS] = (struct pollfd){.fd = signals, .events = POLLIN};
    if (poll(polled, LINK_KINDS + 1, wait_ms) < 0 && errno != EINTR)
        return error_set(error, MR_IO, "cannot wait (%s): the links; try again", strerror(errno));
    for (int kind = 0; kind < LINK_KINDS; kind++)
        ready[kind] = logger->open[kind] && (logger->more[kind] || polled[kind].revents);
    *signalled = (polled[LINK_KINDS].revents & POLLIN) != 0;
    return MR_OK;
}

/* When both links have something, the one that is behind in board time goes first: they stay in step,
 * whatever waits in which buffer, and neither is ever waited for. */
static void keep_in_step(const struct logger *logger, bool ready[LINK_KINDS])
{
    if (ready[LINK_CAN] && ready[LINK_SERIAL]) {
        bool can_behind =
            collector_block(logger->collector, LINK_CAN) <= collector_block(logger->collector, LINK_SERIAL);
        ready[can_behind ? LINK_SERIAL : LINK_CAN] = false;
    }
}

static enum mr_status collect(struct logger *logger, int signals, double for_s, struct error *error)
{
    uint64_t deadline_us = isinf(for_s) ? UINT64_MAX : monotonic_us() + (uint64_t)(for_s * 1e6);
    while (!logger->ended_by) {
        bool ready[LINK_KINDS] = {false, false};
        bool signalled = false;
        enum mr_status status = service_links(logger, error);
        if (status == MR_OK)
            status = wait_for_news(logger, signals, deadline_us, ready, &signalled, error);
        if (status == MR_OK)
            keep_in_step(logger, ready);
        if (status == MR_OK && ready[LINK_CAN])
            status = receive_can(logger, error);
        if (status == MR_OK && ready[LINK_SERIAL])
            status = receive_serial(logger, error);
        if (status == MR_OK && logger->in_transaction && monotonic_us() - logger->begun_us >= COMMIT_US)
            status = commit(logger, error);
        if (status == MR_OK)
            status = show_finished(logger, error);
        if (status == MR_OK)
            status = show_silent(logger, error);
        if (status == MR_OK)
            status = watch_clock(logger, error);
        if (status != MR_OK)
            return status;
        ask_for_configuration(logger);
        serve_live(logger);
        note_health(logger);
        show_progress(logger, false);
        if (signalled)
            logger->ended_by = "signal"; /* it stays blocked and pending: the end is on its way */
        else if (!logger->open[LINK_CAN] && !logger->open[LINK_SERIAL])
            logger->ended_by = "end";
        else if (monotonic_us() >= deadline_us)
            logger->ended_by = "time";
    }
    return MR_OK;
}

/* Nobody spoke, or nobody that matrig understands. */
static enum mr_status check_heard(const struct logger *logger, const char *can, const char *serial,
                                  struct error *error)
{
    struct collector_progress p;
    collector_progress(logger->collector, &p);
    const struct store_link_counts *c = p.counts;
    if (p.hello || strcmp(logger->ended_by, "signal") == 0)
        return MR_OK;
    const char *and = can && serial ? " and " : "";
    if (c[LINK_CAN].bad + c[LINK_CAN].foreign + c[LINK_SERIAL].bad + c[LINK_SERIAL].foreign > 0 &&
        c[LINK_CAN].received + c[LINK_SERIAL].received == 0)
        return error_set(error, MR_MALFORMED,
                         "nothing of a matrig board: %s%s%s; is this the board's link, at its bit rate?",
                         can ? can : "", and, serial ? serial : "");
    return error_set(error, MR_TIMEOUT, "no board said hello: %s%s%s; is it running and connected?",
                     can ? can : "", and, serial ? serial : "");
}

static void troubles_of(const struct link *link, int64_t trouble[LINK_TROUBLES])
{
    for (unsigned i = 0; i < LINK_TROUBLES; i++)
        trouble[i] = (int64_t)link_counters(link)->trouble[i];
}

static json_t *troubles_json(const struct link *link)
{
    int64_t trouble[LINK_TROUBLES];
    troubles_of(link, trouble);
    return summary_troubles_json(trouble);
}

/* Messages that the board counted and nobody received, in the whole session. */
static void show_missing(int kind, const int64_t missing[MR_PLACES])
{
    bool any = false;
    for (unsigned place = 0; place < MR_PLACES; place++) {
        if (missing[place] == 0)
            continue;
        if (!any)
            printf("%s missed in this session:", summary_link_name(kind));
        printf("%s %s %lld", any ? "," : "", mr_message_text(place), (long long)missing[place]);
        any = true;
    }
    if (any)
        printf("\n");
}

/* Troubles of the whole session, in landings and outside. */
static void show_troubles(const struct logger *logger)
{
    struct collector_progress progress;
    collector_progress(logger->collector, &progress);
    for (int kind = 0; kind < LINK_KINDS && !logger->cli->json; kind++)
        show_missing(kind, progress.missing[kind]);
    for (int kind = 0; kind < LINK_KINDS && !logger->cli->json; kind++) {
        int64_t trouble[LINK_TROUBLES];
        char line[400];
        if (!logger->link[kind] || link_counters(logger->link[kind])->troubles == 0)
            continue;
        troubles_of(logger->link[kind], trouble);
        summary_troubles(trouble, line, sizeof line);
        printf("%s link in this session: %s\n", summary_link_name(kind), line);
    }
    fflush(stdout);
}

static json_t *log_json(const struct logger *logger, const char *db, const struct error *error)
{
    struct collector_progress p;
    collector_progress(logger->collector, &p);
    json_t *links = json_object();
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct store_link_counts *c = &p.counts[kind];
        json_t *missing = json_object();
        for (unsigned place = 0; place < MR_PLACES; place++) {
            if (p.missing[kind][place])
                json_object_set_new(missing, mr_message_text(place), json_integer(p.missing[kind][place]));
        }
        if (logger->link[kind])
            json_object_set_new(links, kind == LINK_CAN ? "can" : "serial",
                                json_pack("{sIsIsIsIsIsOso}", "received", (json_int_t)c->received, "lost",
                                          (json_int_t)c->lost, "dropped", (json_int_t)c->dropped, "bad",
                                          (json_int_t)c->bad, "foreign", (json_int_t)c->foreign, "missing", missing, "troubles",
                                          troubles_json(logger->link[kind])));
        json_decref(missing);
    }
    if (logger->link[LINK_CAN] && p.before_first >= 0)
        json_object_set_new(json_object_get(links, "can"), "before_logging", json_integer(p.before_first));
    return json_pack("{sssIsssosOss?}", "db", db, "session", (json_int_t)collector_session(logger->collector),
                     "ended_by", logger->ended_by, "links", links, "landings", logger->landings, "error",
                     error->status == MR_OK ? NULL : error->text);
}

static enum mr_status run(struct logger *logger, int signals, const char *can, const char *serial,
                          double for_s, struct error *error)
{
    enum mr_status status = ensure_transaction(logger, error);
    if (status == MR_OK)
        status = collector_open(logger->store, can, serial, &logger->collector, error);
    if (status != MR_OK)
        return status;
    if (logger->live.hub)
        collector_watch(logger->collector, &logger->live.watcher);
    status = collect(logger, signals, for_s, error);
    /* Whatever went wrong, what was received stays, and the session is closed if the database still takes it.
     */
    struct error late = {0};
    if (status != MR_OK)
        logger->ended_by = "error";
    if (ensure_transaction(logger, &late) == MR_OK &&
        collector_end(logger->collector, logger->ended_by, &late) == MR_OK && commit(logger, &late) == MR_OK)
        show_finished(logger, &late);
    show_troubles(logger);
    show_progress(logger, true);
    if (late.status != MR_OK)
        status = error_set(error, late.status, "%s", late.text);
    if (status == MR_OK && logger->link_error.status != MR_OK)
        status = error_set(error, logger->link_error.status, "%s", logger->link_error.text);
    if (status == MR_OK)
        status = check_heard(logger, can, serial, error);
    if (status == MR_OK && logger->shown == 0)
        cli_note(logger->cli, "no landing was armed; what came is in %s", store_path(logger->store));
    return status;
}

static enum mr_status open_live(struct logger *logger, const char *where, const char *can, const char *serial, const char *db,
                                struct error *error)
{
    bool listens = logger->mute[LINK_CAN] && logger->mute[LINK_SERIAL];
    const struct live_source source = {.db = db, .can = can, .serial = serial, .commands = !listens, .si = logger->cli->si,
                                       .no_commands = listens ? "matrig log was told to listen only (--listen)" : NULL};
    enum mr_status status = live_open(&logger->live, where, &source, error);
    if (status == MR_OK) { /* also with --quiet: nobody could guess it */
        fprintf(stderr, "live: %s\n", live_server_url(logger->live.server));
        fflush(stderr);
    }
    return status;
}

static enum mr_status open_store(struct logger *logger, const char *db, struct error *error)
{
    enum mr_status status = store_open(db, STORE_CREATE, &logger->store, error);
    return status == MR_OK ? store_take_alone(logger->store, error) : status;
}

/* An existing database is checked before any link is opened; a new one is made only once the links are open.
 */
static enum mr_status open_all(struct logger *logger, const char *can, const char *serial, const char *db, const char *live,
                               struct error *error)
{
    const char *const spec[LINK_KINDS] = {can, serial};
    enum mr_status status = MR_OK;
    if (access(db, F_OK) == 0)
        status = open_store(logger, db, error);
    if (status == MR_OK && live)
        status = open_live(logger, live, can, serial, db, error);
    for (int kind = 0; kind < LINK_KINDS && status == MR_OK; kind++) {
        if (spec[kind])
            status = link_open(spec[kind], (enum link_kind)kind, &logger->link[kind], error);
        if (spec[kind] && status == MR_OK)
            link_patience(logger->link[kind], logger->wait_s);
        logger->open[kind] = spec[kind] != NULL;
    }
    if (status == MR_OK && !logger->store)
        status = open_store(logger, db, error);
    return status;
}

int log_command(int argc, char **argv, const struct cli *cli)
{
    const char *can = NULL, *serial = NULL, *db = NULL, *for_text = NULL, *elf = NULL, *live = NULL, *page = NULL, *wait_text = NULL;
    bool listen = false;
    const struct cli_option options[] = {
        {"--can", &can, NULL}, {"--serial", &serial, NULL}, {"--db", &db, NULL}, {"--for", &for_text, NULL},
        {"--listen", NULL, &listen}, {"--elf", &elf, NULL}, {"--live", &live, NULL}, {"--page", &page, NULL},
        {"--wait", &wait_text, NULL}};
    struct error error = {0};
    double for_s = (double)INFINITY, wait_s = AWAY_S;
    enum mr_status status = cli_parse(argc, argv, options, sizeof options / sizeof options[0], NULL, 0, 0, "", &error);
    if (status == MR_OK && !can && !serial)
        status =
            error_set(&error, MR_USAGE,
                      "no link: matrig log needs --can LINK or --serial LINK or both; see matrig log --help");
    if (status == MR_OK && !db)
        status = error_set(&error, MR_USAGE, "no database: matrig log needs --db DB; see matrig log --help");
    if (status == MR_OK && for_text)
        status = cli_number(for_text, "--for", 0.001, 1e7, &for_s, &error);
    if (status == MR_OK && wait_text)
        status = cli_number(wait_text, "--wait", 0.0, 1e7, &wait_s, &error);
    struct hil_symbols symbols = {0};
    if (status == MR_OK)
        status = crash_symbols(&symbols, elf, &error);
    if (status != MR_OK) {
        hil_symbols_free(&symbols);
        return cli_fail(&error);
    }

    /* Signals come by a descriptor of their own, so none can slip in between a check and a wait. */
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigprocmask(SIG_BLOCK, &set, NULL);
    signal(SIGPIPE, SIG_IGN); /* a reader of the summary that went away must not end the logging */
    int signals = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);

    struct logger logger = {.cli = cli, .landings = json_array(), .mute = {listen, listen}, .symbols = symbols, .wait_s = wait_s,
                            .look = {.db = db, .page = page, .si = cli->si}};
    status = open_all(&logger, can, serial, db, live, &error);
    if (status == MR_OK)
        status = run(&logger, signals, can, serial, for_s, &error);
    int exit_code = status == MR_OK ? 0 : cli_fail(&error);
    if (logger.collector && cli->json)
        exit_code = cli_print_json(log_json(&logger, db, &error), exit_code);
    quicklook_service(&logger.look, true);
    json_decref(logger.landings);
    live_close(&logger.live);
    collector_close(logger.collector);
    for (int kind = 0; kind < LINK_KINDS; kind++)
        link_close(logger.link[kind]);
    store_close(logger.store);
    close(signals);
    hil_symbols_free(&logger.symbols);
    return exit_code;
}
