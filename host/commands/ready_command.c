/* The command matrig ready: go or no-go before a landing, and the walk test. */
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <time.h>

#include "host/board/config_text.h"
#include "host/board/ready.h"
#include "host/board/config_client.h"
#include "host/board/walk.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/board/imagefile.h"
#include "host/store/store_readiness.h"
#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"

/* Time limit in seconds for campaign, links and dialogue. The whole command must end within 20 s;
 * the rest is for the last request to the board and for saving. */
#define CHECKS_TIMEOUT_S        16.0
#define DATABASE_CHECK_MAX_S    1.5 /* time limit for checking the database, s */
/* time to wait for another program that writes to the campaign, s */
#define LOCK_TIMEOUT_S          0.4
#define S_PER_DAY               86400
#define LIVE_DURATION_S         30 /* time after which the board stops live readings by itself, s */
#define LIVE_RENEWAL_INTERVAL_S 5.0
#define WALK_TIMEOUT_S          600.0

struct request {
    const struct cli *cli;
    const char *db, *serial, *can, *image, *expected;
    bool walk;
};

/* ---- facts of campaign and computer ---- */

static struct store *open_campaign(const struct request *request, struct ready_inputs *f)
{
    struct error wrong = {0};
    struct statvfs disk;
    int64_t bytes = 0, landings = 0;
    struct store *store = program_open_or_create_campaign(request->cli, request->db);
    store_set_wait_s(store, LOCK_TIMEOUT_S);
    if (store_check_integrity(store, DATABASE_CHECK_MAX_S, &f->database_checked, &wrong) != MR_OK ||
        store_begin(store, &wrong) != MR_OK || store_commit(store, &wrong) != MR_OK)
        snprintf(f->database_fault, sizeof f->database_fault, "%.180s", wrong.text);
    wrong = (struct error){0};
    f->bytes_per_landing = READY_DEFAULT_LANDING_BYTES;
    if (store_size_get(store, &bytes, &landings, &wrong) == MR_OK && landings > 0 &&
        (double)bytes / (double)landings > f->bytes_per_landing)
        f->bytes_per_landing = (double)bytes / (double)landings;
    if (statvfs(request->db, &disk) != 0)
        error_set(fatal, MR_IO,
                  "cannot determine the free space: %s; check that the disk is connected",
                  request->db);
    f->free_bytes = (double)disk.f_bavail * (double)disk.f_frsize;
    return store;
}

static int show_report(const struct cli *cli, const char *kind, const struct ready_report *report,
                       const struct identity *identity, int64_t made_us, double duration_s)
{
    int exit_code = ready_verdict(report) == READY_GO ? 0 : mr_status_exit_code(MR_LIMIT);
    char uid[IDENTITY_UID_SIZE];
    identity_uid_text(identity, uid);
    if (cli->json)
        return cli_print_json(json_pack("{sssssssIsoso}", "kind", kind, "verdict",
                                        ready_verdict(report) == READY_GO ? "go" : "no-go", "board",
                                        uid, "made_us", (json_int_t)made_us, "took_s",
                                        cli_json_number(duration_s, 4), "checks",
                                        ready_json(report)),
                              exit_code);
    ready_print(report, duration_s, cli_terminal_columns(), stdout);
    return exit_code;
}

/* ---- ready ---- */

/* Reads the shunt spans, lb, that the last check of this board stored. */
static void read_shunt_spans(const char *checks, float span_lb[MR_GAGES])
{
    json_t *object = json_loads(checks, 0, NULL), *spans = json_object_get(object, "spans_lb");
    for (unsigned i = 0; i < MR_GAGES; i++) {
        json_t *span = json_array_get(spans, i);
        if (json_is_number(span))
            span_lb[i] = (float)json_number_value(span);
    }
    json_decref(object);
}

/* Reads the results of this board's last landing and last shunt calibration, and its
 * certificates. */
static void read_recent_results(struct store *store, struct ready_inputs *f)
{
    char uid[IDENTITY_UID_SIZE];
    struct store_landing *rows = NULL;
    struct store_readiness last = {.checks = NULL};
    size_t count = 0;
    bool found = false;
    int64_t kept_us = STORE_NONE;
    identity_uid_text(&f->identity, uid);
    store_landings_get(store, &rows, &count, fatal);
    for (size_t i = 0; i < count; i++) {
        if (strcmp(rows[i].board_uid, uid) != 0)
            continue;
        f->has_previous_landing = true;
        f->previous_run = rows[i].id;
        f->previous_image_crc = rows[i].image_crc;
        f->previous_config_crc = rows[i].config_crc;
    }
    free(rows);
    store_newest_shunt_spans_get(store, uid, f->previous_span_lb, &kept_us, fatal);
    store_readiness_get(store, uid, "ready", (int64_t)link_now_us(), false, &last, &found, fatal);
    if (found && last.made_us > kept_us)
        read_shunt_spans(last.checks, f->previous_span_lb);
    free(last.checks);
    certificates_read(store, uid, &f->certificates, fatal);
}

/* Adds a row to the table readiness: {"checks": [...], "spans_lb": [...]}. `kind` is "ready" or
 * "walk". `shunts` is NULL for a walk test. */
static void save_report(struct store *store, const struct identity *identity, const char *kind,
                        const struct ready_report *report, const struct shunts *shunts,
                        int64_t made_us)
{
    char uid[IDENTITY_UID_SIZE];
    json_t *spans = json_array();
    for (unsigned i = 0; i < MR_GAGES; i++)
        json_array_append_new(spans, json_null());
    for (unsigned i = 0; shunts && i < shunts->count; i++)
        json_array_set_new(spans, shunts->result[i].gage - 1u,
                           cli_json_number((double)shunts->result[i].span_lb, 7));
    json_t *object = json_pack("{soso}", "checks", ready_json(report), "spans_lb", spans);
    struct store_readiness row = {.made_us = made_us, .checks = json_dumps(object, JSON_COMPACT)};
    json_decref(object);
    if (!row.checks)
        abort();
    snprintf(row.verdict, sizeof row.verdict, "%s",
             ready_verdict(report) == READY_GO ? "go" : "no-go");
    identity_uid_text(identity, uid);
    store_begin(store, fatal);
    store_readiness_put(store, uid, kind, &row, fatal);
    store_commit(store, fatal);
    free(row.checks);
}

static int run_checks(const struct request *request, struct ready_inputs *f)
{
    static struct ready_report report;
    int64_t made_us = (int64_t)link_now_us();
    double begun_s = monotonic_s();
    struct store *store = open_campaign(request, f);
    struct dialogue *dialogue = dialogue_open_for_command(request->can, request->serial);
    ready_query_inputs(dialogue, CHECKS_TIMEOUT_S - (monotonic_s() - begun_s), f, fatal);
    dialogue_close(dialogue);
    read_recent_results(store, f);
    ready_check_all(f, &report);
    if (!f->database_fault[0])
        save_report(store, &f->identity, "ready", &report, &f->shunts, made_us);
    return show_report(request->cli, "ready", &report, &f->identity, made_us,
                       monotonic_s() - begun_s);
}

/* ---- the walk ---- */

static volatile sig_atomic_t interrupted;

static void handle_interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

struct walk_session {
    const struct request *request;
    struct walk_test walk;
    uint32_t newest_clock; /* newest clock of the board, ms */
};

/* Prints one line for each switch or gage that responds. */
static void print_response(const struct walk_session *w, enum walk_item_kind kind)
{
    const struct walk_response *a = &w->walk.response[kind][w->walk.response_count[kind] - 1];
    if (w->request->cli->quiet || w->request->cli->json)
        return;
    if (kind == WALK_SWITCH && a->number >= 1 && a->number <= MR_CONFIG_SWITCHES)
        printf("switch %u (%.1f ft): step of %.1f codes, configured step %u\n", a->number,
               (double)w->walk.config->gate[a->number - 1].station_ft, a->step_codes,
               w->walk.config->gate[a->number - 1].step_codes);
    else if (kind == WALK_SWITCH)
        printf("edge %u: step of %.1f codes\n", w->walk.response_count[kind], a->step_codes);
    else
        printf("%s %u\n", walk_item_kind_names[kind], a->number);
    fflush(stdout);
}

static enum mr_status handle_message(void *context, const struct dialogue_message *message,
                                     struct error *error)
{
    struct walk_session *w = context;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    struct mr_edge edge;
    struct mr_switch_event event;
    struct mr_block block;
    struct mr_clock clock;
    enum walk_item_kind kind;
    (void)error;
    if (message->kind == LINK_CAN)
        return MR_OK;
    if (message->id == MR_ID_EDGE && mr_edge_get(&edge, bytes, length) == MR_OK &&
        walk_add_edge(&w->walk, &edge))
        print_response(w, WALK_SWITCH);
    if (message->id == MR_ID_SWITCH_EVENT && mr_switch_event_get(&event, bytes, length) == MR_OK)
        walk_add_event(&w->walk, &event);
    if (message->id == MR_ID_BLOCK && mr_block_decode(&block, bytes, length) == MR_OK &&
        walk_add_reading(&w->walk, &block, &kind))
        print_response(w, kind);
    if (message->id == MR_ID_CLOCK && mr_clock_get(&clock, bytes, length) == MR_OK)
        w->newest_clock = clock.block;
    return MR_OK;
}

static enum mr_status run_walk(struct dialogue *dialogue, struct walk_session *w,
                               struct error *error)
{
    double until_s = monotonic_s() + WALK_TIMEOUT_S, renew_s = 0.0;
    /* renew by the board's clock: it stops live readings by that clock, which may run faster than
     * real time on an emulated board */
    uint32_t renew_ms = 0;
    enum mr_status status = MR_OK;
    while (status == MR_OK && !walk_is_complete(&w->walk) && !interrupted &&
           monotonic_s() < until_s) {
        if (monotonic_s() >= renew_s || (int32_t)(w->newest_clock - renew_ms) >= 0) {
            status = config_client_set_live_duration(dialogue, LIVE_DURATION_S, error);
            renew_s = monotonic_s() + LIVE_RENEWAL_INTERVAL_S;
            renew_ms = w->newest_clock + (uint32_t)(1000.0 * LIVE_RENEWAL_INTERVAL_S);
        }
        if (status == MR_OK)
            status = dialogue_receive(dialogue, DIALOGUE_RECEIVE_MAX_S, error);
    }
    if (status == MR_CLOSED) { /* use the answers received before the link closed */
        *error = (struct error){0};
        return MR_OK;
    }
    return status ?: config_client_set_live_duration(dialogue, 0, error);
}

static int run_walk_test(const struct request *request, struct ready_inputs *f)
{
    static struct walk_session walking;
    static struct config_client talk;
    static struct ready_report report;
    struct error error = {0};
    int64_t made_us = (int64_t)link_now_us();
    double begun_s = monotonic_s();
    struct store *store = program_open_or_create_campaign(request->cli, request->db);
    struct dialogue *dialogue = dialogue_open_for_command(request->can, request->serial);
    config_client_begin_and_get(&talk, dialogue, &f->config, &f->config_crc, fatal);
    walking.request = request;
    walk_start(&walking.walk, &f->config);
    dialogue_subscribe(dialogue, handle_message, &walking);
    cli_note(request->cli,
             "walk along the rig; the test ends when all sensors have responded, after %.0f s, or "
             "with Ctrl-C",
             WALK_TIMEOUT_S);
    signal(SIGINT, handle_interrupt);
    if (run_walk(dialogue, &walking, &error) != MR_OK)
        return cli_fail(&error);
    walk_check_responses(&walking.walk, &report);
    save_report(store, &dialogue->identity, "walk", &report, NULL, made_us);
    return show_report(request->cli, "walk", &report, &dialogue->identity, made_us,
                       monotonic_s() - begun_s);
}

/* ---- the command line ---- */

/* Reads the expected CRC of the configuration: eight hexadecimal digits, or a file written by
 * `matrig board config get`. */
static void read_expected(const char *text, struct ready_inputs *facts)
{
    static struct mr_config config;
    char *end;
    unsigned long value = strtoul(text, &end, 16);
    facts->has_expected_crc = true;
    facts->expected_crc = (uint32_t)value;
    if (strlen(text) == 8 && *end == '\0')
        return;
    facts->expected_config = &config;
    config_text_load(text, &config, fatal);
}

static void check_request(const struct request *r)
{
    if (!r->serial)
        error_set(fatal, MR_USAGE,
                  "no link: matrig ready needs --serial LINK; see matrig ready --help");
    if (r->walk && (r->image || r->expected))
        error_set(fatal, MR_USAGE,
                  "--walk excludes --image and --expect-config; see matrig ready --help");
}

static int ready_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {.cli = cli};
    struct ready_inputs *facts = xcalloc(1, sizeof *facts);
    struct imagefile image = {0};
    command_parse(&command_ready, argc, argv, cli, &request, &request.db, fatal);
    check_request(&request);
    if (request.expected)
        read_expected(request.expected, facts);
    if (request.image)
        imagefile_read(request.image, &image, fatal);
    if (request.image && !image.has_header)
        error_set(fatal, MR_UNKNOWN,
                  "the image has no matrig header: %s; give an image built by matrig",
                  request.image);
    facts->image = request.image ? &image.header : NULL;
    facts->image_path = request.image;
    facts->is_can_used = request.can != NULL;
    facts->si = cli->si;
    facts->now_s = (int64_t)time(NULL);
    facts->today_day = (uint32_t)(facts->now_s / S_PER_DAY);
    signal(SIGPIPE, SIG_IGN);
    int exit_code = request.walk ? run_walk_test(&request, facts) : run_checks(&request, facts);
    if (request.image)
        imagefile_free(&image);
    free(facts);
    return exit_code;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database; created if missing. The result belongs to the landings of "
                    "the next 12 h"),
    OPTION_TEXT("--serial", "LINK", serial,
                "the board's serial port (see matrig log --help); the state of the board must be "
                "idle or done"),
    OPTION_TEXT("--can", "LINK", can, "also listen on the board's CAN bus"),
    OPTION_TEXT("--image", "FILE", image,
                "expected firmware of the board (.elf or .bin); default: that of the campaign's "
                "last landing"),
    OPTION_TEXT("--expect-config", "CRC|FILE", expected,
                "expected configuration of the board; its revision may differ; default: that of "
                "the campaign's last landing"),
    HELP_NOTE("Checks image, configuration, calibrations, readings at rest, black box, faults, "
              "links and database in at most 20 s. Runs the shunt calibration and the self-test, "
              "which lights the warning lamp for 0.2 s. Exit 1: no-go."),
    OPTION_FLAG(
        "--walk", walk,
        "walk test: you trip each switch, push each transducer and pull each gage, in order. No "
        "landing is recorded. The test ends when all sensors have responded, after 600 s, or on "
        "Ctrl-C. Exit 1 when a sensor does not respond, or a different one responds. If none of "
        "the switches (or transducers, or gages) responds, they are reported as not tested"),
    HELP_EXAMPLE("matrig ready campaign.db --serial serial:/dev/ttyUSB0 --can can:can0"),
};

const struct command command_ready = {
    "ready",
    ready_command,
    "DB --serial LINK [--can LINK] [--image FILE] [--expect-config CRC|FILE]\nDB --serial LINK "
    "--walk",
    "check board, sensors and disk before a landing (go or no-go); walk test",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
