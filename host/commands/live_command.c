/* The command matrig live: shows a board on a web page. Reads the data from the campaign that a
 * running matrig log writes. */
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "host/analyse/summary.h"
#include "host/base/monotonic_clock.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/live/hub.h"
#include "host/live/server.h"
#include "host/store/store.h"

#define POLL_MS             25 /* time between two reads of the database */
/* Number of frames that are shown at the start although they were logged before: ten seconds of a
 * landing, or minutes outside of landings. */
#define FRAMES_AT_START_MAX 30000
#define FRAMES_PER_POLL     2000
/* time after the end of a landing until its outcome is shown: the log stores the last data */
#define OUTCOME_DELAY_MS    1000

struct live_view {
    const struct cli *cli;
    struct store *store;
    struct store_follow_position position;
    int64_t session;
    struct store_session_row links; /* links of the logged session */
    struct live_source source;
    struct live_hub *hub;
    struct live_server *server;
    int64_t finished_run,
        finished_ms; /* newest landing that has ended, and when that was noticed */
    int64_t last_check_ms;
    bool is_outcome_shown; /* of finished_run */
};

static void handle_frame(void *context, const struct store_frame *frame)
{
    struct live_view *view = context;
    bool foreign = frame->link == LINK_CAN &&
                   frame->id & (LINK_ID_EXTENDED | LINK_ID_REMOTE | LINK_ID_ERROR);
    struct mr_message message;
    if (frame->id > UINT16_MAX || foreign || frame->link < 0 || frame->link >= LINK_KINDS ||
        mr_message_decode(&message, (uint16_t)frame->id, frame->data, frame->length) != MR_OK)
        return;
    live_hub_add_message(view->hub, &(struct collector_event){.link = (enum link_kind)frame->link,
                                                              .message = &message,
                                                              .host_us = (uint64_t)frame->host_us,
                                                              .board_us = frame->board_us});
}

static void handle_record(void *context, const uint8_t *record, size_t length, int64_t host_us)
{
    struct live_view *view = context;
    struct mr_block block;
    if (mr_block_decode(&block, record, length) == MR_OK)
        live_hub_add_record(view->hub, &block, host_us);
}

/* Reads new frames and records, and if a new session has begun, its links. */
static enum mr_status poll_campaign(struct live_view *view, struct error *error)
{
    const struct store_follower follower = {handle_frame, handle_record, view};
    int64_t session = 0;
    bool more = true;
    enum mr_status status = MR_OK;
    for (int turn = 0; more && turn < 1 + FRAMES_AT_START_MAX / FRAMES_PER_POLL && status == MR_OK;
         turn++)
        status = store_follow(view->store, &view->position, FRAMES_PER_POLL, &follower, &more,
                              error);
    if (status == MR_OK)
        status = store_newest_session_get(view->store, &session, error);
    if (status == MR_OK && session != view->session) {
        view->session = session;
        status = store_session_get(view->store, session, &view->links, error);
        view->source.can = view->links.can_link[0] ? view->links.can_link : NULL;
        view->source.serial = view->links.serial_link[0] ? view->links.serial_link : NULL;
    }
    for (int kind = 0; kind < LINK_KINDS && session && status == MR_OK; kind++) {
        struct store_link_counts counts;
        bool found;
        status = store_link_get(view->store, session, kind, &counts, &found, error);
        if (status == MR_OK && found)
            live_hub_set_counts(view->hub, (enum link_kind)kind, &counts);
    }
    live_hub_publish_due_events(view->hub);
    return status;
}

/* Shows the outcome of the newest landing `delay_ms` after its end, in the words of matrig show. */
static enum mr_status show_outcome(struct live_view *view, int64_t delay_ms, struct error *error)
{
    struct store_landing *row = NULL;
    size_t count = 0;
    int64_t now_ms = monotonic_ms(), run = 0;
    if (view->last_check_ms && now_ms - view->last_check_ms < OUTCOME_DELAY_MS / 2)
        return MR_OK;
    view->last_check_ms = now_ms;
    enum mr_status status = store_landings_get(view->store, &row, &count, error);
    if (status == MR_OK && count && row[count - 1].state == MR_LANDING_DONE)
        run = row[count - 1].id;
    free(row);
    if (run != view->finished_run) {
        view->finished_run = run;
        view->finished_ms = now_ms;
        view->is_outcome_shown = false;
    }
    if (status != MR_OK || !run || view->is_outcome_shown || now_ms - view->finished_ms < delay_ms)
        return status;
    struct summary summary;
    char line[OUTCOME_LINE_SIZE], words[OUTCOME_LINE_SIZE + 40];
    view->is_outcome_shown = true;
    status = summary_load(view->store, run, &summary, error)
               ?: summary_load_outcome(view->store, &summary, error);
    if (status == MR_OK) {
        snprintf(words, sizeof words, "RUN %lld: %s", (long long)run,
                 outcome_record_format_line(&summary.outcome, line));
        live_hub_add_outcome(view->hub, words);
    }
    summary_free(&summary);
    return status;
}

/* Shows new data until a signal arrives. */
static enum mr_status run_live_view(struct live_view *view, struct error *error)
{
    sigset_t set;
    cli_fill_termination_signals(&set);
    sigprocmask(SIG_BLOCK, &set, NULL);
    struct pollfd signals = {.fd = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK),
                             .events = POLLIN};
    enum mr_status status = MR_OK;
    while (status == MR_OK) {
        status = poll_campaign(view, error) ?: show_outcome(view, OUTCOME_DELAY_MS, error);
        if (status == MR_OK && poll(&signals, 1, POLL_MS) > 0)
            break;
    }
    close(signals.fd);
    return status;
}

static void open_live_view(struct live_view *view, const char *db, const char *port)
{
    view->store = program_open_campaign(db, STORE_READ);
    view->source = (struct live_source){
        .db = db,
        .uses_si = view->cli->si,
        .no_commands_reason =
            "to arm and disarm, use the page of the running log (matrig log --live)"};
    store_follow_begin(view->store, FRAMES_AT_START_MAX, &view->position, fatal);
    live_hub_open(&view->source, &view->hub, fatal);
    if (view->cli->json)
        return;
    live_server_open(port, view->hub, &view->server, fatal);
    fprintf(stderr, "live: %s\n", live_server_url(view->server));
    fflush(stderr);
}

static int print_snapshot(struct live_view *view, struct error *error)
{
    if (poll_campaign(view, error) != MR_OK || show_outcome(view, 0, error) != MR_OK)
        return cli_fail(error);
    char *text = live_hub_snapshot(view->hub);
    json_t *snapshot = text ? json_loads(text, 0, NULL) : NULL;
    free(text);
    return cli_print_json(snapshot, 0);
}

struct request {
    const char *port;
};

static int live_command(int argc, char **argv, const struct cli *cli)
{
    const char *db = NULL;
    struct request r = {0};
    struct error error = {0};
    struct live_view view = {.cli = cli};
    command_parse(&command_live, argc, argv, cli, &r, &db, fatal);
    open_live_view(&view, db, r.port ? r.port : "8473");
    int exit_code = 0;
    if (cli->json)
        exit_code = print_snapshot(&view, &error);
    else if (run_live_view(&view, &error) != MR_OK)
        exit_code = cli_fail(&error);
    live_server_close(view.server, "matrig live has ended");
    live_hub_close(view.hub);
    return exit_code;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database to which matrig log writes at present; opened read-only"),
    OPTION_TEXT("--port", "PORT", port,
                "port of the page on 127.0.0.1; default: 8473; 0: any free port"),
    HELP_NOTE("--json prints the newest message of each kind as one object. This page is for "
              "viewing only; the page of matrig log "
              "--live can also arm and disarm. From another computer: ssh -L 8473:127.0.0.1:8473 "
              "HOST, then open the printed address."),
    HELP_EXAMPLE(
        "matrig log --can can:can0 --serial serial:/dev/ttyUSB0 --db campaign.db --live 8473\n"
        "         matrig live campaign.db --port 8474"),
};

const struct command command_live = {
    "live",
    live_command,
    "DB [--port PORT]",
    "watch a board on a web page",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
