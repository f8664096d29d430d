/* matrig ready: go or no-go before a landing, and the walk test. */
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <time.h>

#include "host/board/config_text.h"
#include "host/board/ready_client.h"
#include "host/board/walk.h"
#include "host/commands/commands.h"
#include "host/board/imagefile.h"
#include "host/store/store_readiness.h"
#include "host/base/output.h"
#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"

/* of campaign, links and talk; the last order and saving take the rest of 20 s */
#define LIMIT_S   16.0
#define CHECK_S   1.5 /* of going through the campaign */
#define BUSY_S    0.4 /* for another program that writes to it */
#define S_PER_DAY 86400
#define LIVE_S    30 /* a board whose host went away is quiet again after that */
#define RENEW_S   5.0
#define MEET_S    10.0
#define WALK_S    600.0

struct request {
    const struct cli *cli;
    const char *db, *serial, *can, *image, *expected, *learn;
    bool walk, force;
};

/* ---- what the campaign and this computer say ---- */

static enum mr_status open_campaign(const struct request *request, struct ready_facts *f,
                                    struct store **store, struct error *error)
{
    struct error wrong = {0};
    struct statvfs disk;
    char folder[PATH_MAX];
    int64_t bytes = 0, landings = 0;
    enum mr_status status = store_open(request->db, STORE_CREATE, store, error);
    if (status != MR_OK)
        return status;
    store_wait(*store, BUSY_S);
    if (store_check(*store, CHECK_S, &f->database_checked, &wrong) != MR_OK ||
        store_begin(*store, &wrong) != MR_OK || store_commit(*store, &wrong) != MR_OK)
        snprintf(f->database, sizeof f->database, "%.180s", wrong.text);
    wrong = (struct error){0};
    f->landing_bytes = READY_LANDING_BYTES;
    if (store_size(*store, &bytes, &landings, &wrong) == MR_OK && landings > 0 &&
        (double)bytes / (double)landings > f->landing_bytes)
        f->landing_bytes = (double)bytes / (double)landings;
    snprintf(folder, sizeof folder, "%s", request->db);
    if (statvfs(folder, &disk) != 0)
        return error_set(error, MR_IO,
                         "cannot ask for the space that is left: %s; is the disk there?",
                         request->db);
    f->free_bytes = (double)disk.f_bavail * (double)disk.f_frsize;
    return MR_OK;
}

static int show(const struct cli *cli, const char *kind, const struct ready_report *report,
                const struct identity *identity, int64_t made_us, double took_s)
{
    int exit_code = ready_verdict(report) == READY_GO ? 0 : mr_status_exit_code(MR_LIMIT);
    char uid[IDENTITY_UID_TEXT];
    identity_uid_text(identity, uid);
    if (cli->json)
        return cli_print_json(json_pack("{sssssssIsoso}", "kind", kind, "verdict",
                                        ready_verdict(report) == READY_GO ? "go" : "no-go", "board",
                                        uid, "made_us", (json_int_t)made_us, "took_s",
                                        cli_json_number(took_s, 4), "checks", ready_json(report)),
                              exit_code);
    ready_print(report, took_s, cli_columns(), stdout);
    return exit_code;
}

/* ---- ready ---- */

static enum mr_status examine(struct store *store, struct ready_client *talk, struct ready_facts *f,
                              struct error *error)
{
    enum mr_status status = ready_client_meet(talk, error);
    if (status != MR_OK || !f->hello)
        return status;
    status = ready_client_look_back(store, f, error);
    return status == MR_OK && f->identity.hello.state == MR_LANDING_IDLE
             ? ready_client_ask(talk, error)
             : status;
}

static int ready(const struct request *request, struct ready_facts *f)
{
    struct error error = {0};
    struct store *store = NULL;
    struct dialogue dialogue = {0};
    struct ready_client *talk = xcalloc(1, sizeof *talk);
    struct ready_report *report = xcalloc(1, sizeof *report);
    int64_t made_us = (int64_t)link_now_us();
    double begun_s = monotonic_s();
    enum mr_status status = open_campaign(request, f, &store, &error);
    if (status == MR_OK)
        status = dialogue_open(&dialogue, request->can, request->serial, &error);
    if (status == MR_OK) {
        ready_client_begin(talk, &dialogue, f, LIMIT_S - (monotonic_s() - begun_s));
        status = examine(store, talk, f, &error);
    }
    if (status == MR_OK)
        ready_judge(f, report);
    if (status == MR_OK && f->hello && !f->database[0])
        status = ready_client_save(store, &f->identity, "ready", report, f, made_us, &error);
    int exit_code = status == MR_OK ? show(request->cli, "ready", report, &f->identity, made_us,
                                           monotonic_s() - begun_s)
                                    : cli_fail(&error);
    /* no-go is of a board that was looked at */
    if (status == MR_OK && !f->hello && dialogue_no_hello(&dialogue, &error) != MR_OK)
        exit_code = cli_fail(&error);
    dialogue_close(&dialogue);
    store_close(store);
    free(talk);
    free(report);
    return exit_code;
}

/* ---- the walk ---- */

static volatile sig_atomic_t interrupted;

static void note_signal(int number)
{
    (void)number;
    interrupted = 1;
}

struct walking {
    const struct request *request;
    struct walk walk;
};

/* One line for each that answers. */
static void print_answer(const struct walking *w, enum walk_kind kind)
{
    const struct walk_answer *a = &w->walk.answer[kind][w->walk.count[kind] - 1];
    if (w->request->cli->quiet || w->request->cli->json)
        return;
    if (kind == WALK_SWITCH && a->number >= 1 && a->number <= MR_CONFIG_SWITCHES &&
        !w->request->learn)
        printf("switch %u (%.1f ft): step of %.1f codes, configured %u\n", a->number,
               (double)w->walk.config->gate[a->number - 1].station_ft, a->codes,
               w->walk.config->gate[a->number - 1].step_codes);
    else if (kind == WALK_SWITCH)
        printf("edge %u: step of %.1f codes\n", w->walk.count[kind], a->codes);
    else
        printf("%s %u\n", walk_names[kind], a->number);
    fflush(stdout);
}

static void take_edge(void *context, const struct mr_edge *edge)
{
    struct walking *w = context;
    if (walk_take_edge(&w->walk, edge))
        print_answer(w, WALK_SWITCH);
}

static void take_event(void *context, const struct mr_switch_event *event)
{
    struct walking *w = context;
    walk_take_event(&w->walk, event);
}

static void take_reading(void *context, const struct mr_block *block)
{
    struct walking *w = context;
    enum walk_kind kind;
    if (walk_take_reading(&w->walk, block, &kind))
        print_answer(w, kind);
}

static enum mr_status go_along(struct ready_client *talk, struct walking *w, struct error *error)
{
    double until_s = monotonic_s() + WALK_S, renew_s = 0.0;
    /* of the board: one that is emulated is faster than the clock on the wall */
    uint32_t renew_ms = 0;
    enum mr_status status = MR_OK;
    while (status == MR_OK && !walk_is_over(&w->walk, w->request->learn != NULL) && !interrupted &&
           monotonic_s() < until_s) {
        if (monotonic_s() >= renew_s || (int32_t)(talk->newest_clock - renew_ms) >= 0) {
            enum mr_status live = ready_client_live(talk, LIVE_S, error);
            if (error->status != MR_OK)
                return error->status;
            if (live != MR_OK)
                return error_set(error, live,
                                 "the board refuses the walk (%s): %s; it must be idle",
                                 mr_status_text(live), dialogue_spec(talk->dialogue));
            renew_s = monotonic_s() + RENEW_S;
            renew_ms = talk->newest_clock + (uint32_t)(1000.0 * RENEW_S);
        }
        status = dialogue_turn(talk->dialogue, DIALOGUE_TURN_S, error);
    }
    if (status == MR_CLOSED) { /* what was seen until then counts */
        *error = (struct error){0};
        return MR_OK;
    }
    if (status == MR_OK)
        (void)ready_client_live(talk, 0, error);
    return error->status;
}

static enum mr_status learn(const struct walking *w, struct ready_report *report,
                            struct error *error)
{
    static struct mr_config learned;
    if (!walk_learn(&w->walk, &learned, report))
        return MR_OK;
    char *text = config_text_write(&learned);
    enum mr_status status = output_bytes(w->request->learn, text, strlen(text), error);
    free(text);
    if (status == MR_OK)
        cli_note(w->request->cli, "the configuration with these steps: %s", w->request->learn);
    return status;
}

static int walk(const struct request *request, struct ready_facts *f)
{
    static struct walking walking;
    static struct ready_client talk;
    static struct ready_report report;
    struct error error = {0};
    struct store *store = NULL;
    struct dialogue dialogue = {0};
    int64_t made_us = (int64_t)link_now_us();
    double begun_s = monotonic_s();
    enum mr_status status = store_open(request->db, STORE_CREATE, &store, &error);
    if (status == MR_OK)
        status = dialogue_open(&dialogue, request->can, request->serial, &error);
    if (status == MR_OK) {
        ready_client_begin(&talk, &dialogue, f, MEET_S);
        status = ready_client_meet(&talk, &error);
    }
    if (status == MR_OK && !f->hello)
        status = dialogue_no_hello(&dialogue, &error);
    if (status == MR_OK && !f->config_known)
        status = error_set(&error, MR_TIMEOUT,
                           "the board did not send its configuration: %s; it must be idle, try "
                           "again",
                           request->serial);
    if (status == MR_OK) {
        walking.request = request;
        walk_start(&walking.walk, &f->config);
        talk.context = &walking;
        talk.edge = take_edge;
        talk.event = take_event;
        talk.reading = take_reading;
        talk.until_s = (double)INFINITY;
        cli_note(request->cli,
                 "walk along the rig; it ends when all have answered, after %.0f s, or with Ctrl-C",
                 WALK_S);
        signal(SIGINT, note_signal);
        status = go_along(&talk, &walking, &error);
    }
    if (status == MR_OK && request->learn)
        status = learn(&walking, &report, &error);
    else if (status == MR_OK)
        walk_judge(&walking.walk, &report);
    if (status == MR_OK)
        status = ready_client_save(store, &f->identity, "walk", &report, NULL, made_us, &error);
    int exit_code = status == MR_OK ? show(request->cli, "walk", &report, &f->identity, made_us,
                                           monotonic_s() - begun_s)
                                    : cli_fail(&error);
    dialogue_close(&dialogue);
    store_close(store);
    return exit_code;
}

/* ---- the command line ---- */

/* Eight hexadecimal digits, or a file of `matrig board config get`. */
static enum mr_status expected(const char *text, struct ready_facts *facts, struct error *error)
{
    static struct mr_config config;
    char *end;
    unsigned long value = strtoul(text, &end, 16);
    facts->crc_expected = true;
    facts->expected_crc = (uint32_t)value;
    if (strlen(text) == 8 && *end == '\0')
        return MR_OK;
    facts->expected_config = &config;
    return config_text_load(text, &config, error);
}

static enum mr_status check_request(const struct request *r, struct error *error)
{
    if (!r->serial)
        return error_set(error, MR_USAGE,
                         "no link: matrig ready needs --serial LINK; see matrig ready --help");
    if ((r->walk || r->learn) && (r->image || r->expected))
        return error_set(error, MR_USAGE,
                         "--walk and --learn go without --image and --expect-config: matrig ready; "
                         "see matrig ready --help");
    return MR_OK;
}

static int ready_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {.cli = cli};
    struct ready_facts *facts = xcalloc(1, sizeof *facts);
    struct imagefile image = {0};
    struct error error = {0};
    enum mr_status status = command_parse(&command_ready, argc, argv, cli, &request, &request.db,
                                          &error);
    if (status == MR_OK)
        status = check_request(&request, &error);
    if (status == MR_OK && request.learn)
        status = output_keep(request.learn, request.force, &error);
    if (status == MR_OK && request.learn)
        status = output_check(request.learn, NULL, &error);
    if (status == MR_OK && request.expected)
        status = expected(request.expected, facts, &error);
    if (status == MR_OK && request.image)
        status = imagefile_read(request.image, &image, &error);
    if (status == MR_OK && request.image && !image.stamped)
        status = error_set(&error, MR_UNKNOWN,
                           "an image without matrig's header: %s; nothing to compare with",
                           request.image);
    facts->image = request.image ? &image.header : NULL;
    facts->image_path = request.image;
    facts->can_used = request.can != NULL;
    facts->si = cli->si;
    facts->now_s = (int64_t)time(NULL);
    facts->today_day = (uint32_t)(facts->now_s / S_PER_DAY);
    signal(SIGPIPE, SIG_IGN);
    int exit_code = status != MR_OK               ? cli_fail(&error)
                  : request.walk || request.learn ? walk(&request, facts)
                                                  : ready(&request, facts);
    if (request.image)
        imagefile_free(&image);
    free(facts);
    return exit_code;
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database, made when it does not exist; what was found is kept in it, "
                    "with the landings of the next 12 h"),
    OPTION_TEXT("--serial", "LINK", serial,
                "the board's serial port (see matrig log --help); the board must be idle, or done "
                "with a landing"),
    OPTION_TEXT("--can", "LINK", can, "listen to its CAN bus too"),
    OPTION_TEXT("--image", "FILE", image,
                "(.elf, .hex, .bin) the board must run this; else what it ran in the campaign's "
                "last landing"),
    OPTION_TEXT("--expect-config", "CRC|FILE", expected,
                "it must be configured so (a file: but for the revision, which config set raises); "
                "else as in the\n"
                "campaign's last landing"),
    HELP_NOTE("Takes at most 20 s: readings at rest, shunt calibration, self-test (the warning "
              "lamp lights for 0.2 s). Exit 1: no-go."),
    OPTION_FLAG("--walk", walk,
                "walk along the rig: trip each switch, push at each transducer, pull at each gage, "
                "in order. Nothing is recorded.\n"
                "It ends when all have answered, after 600 s, or on Ctrl-C. Exit 1 when one did "
                "not answer or answered in another's\n"
                "place; of a kind of which none answered it is not done"),
    OPTION_TEXT("--learn", "FILE", learn,
                "learn the steps: walk along the switches alone, trip each once, upfield first. "
                "Writes the board's configuration\n"
                "with the steps as measured, for matrig board config set; refused where two come "
                "closer than 6 codes, or one lies\n"
                "16 or more beside the step configured"),
    OPTION_FLAG("--force", force, "replace FILE if it exists"),
    HELP_EXAMPLE("matrig ready campaign.db --serial serial:/dev/ttyUSB0 --can can:can0"),
};

const struct command command_ready = {
    "ready",
    ready_command,
    "DB --serial LINK [--can LINK] [--image FILE] [--expect-config CRC|FILE] |\n"
    "                         DB --serial LINK (--walk | --learn FILE [--force])",
    "go or no-go before a landing, and the walk test",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
