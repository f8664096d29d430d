/* matrig ready: go or no-go before a landing, and the walk test. */
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <time.h>

#include "common/channels.h"
#include "host/board/configtext.h"
#include "host/board/readykept.h"
#include "host/board/readytalk.h"
#include "host/board/readywalk.h"
#include "host/calibrate/jump.h"
#include "host/commands/commands.h"
#include "host/flash/imagefile.h"
#include "host/store/store_readiness.h"
#include "host/base/steady.h"

/* of campaign, links and talk; the last order and saving take the rest of 20 s */
#define LIMIT_S     16.0
#define CHECK_S     1.5 /* of going through the campaign */
#define BUSY_S      0.4 /* for another program that writes to it */
#define S_PER_DAY   86400
#define LIVE_S      30 /* a board whose host went away is quiet again after that */
#define RENEW_S     5.0
#define WALK_MEET_S 10.0
#define WALK_S      600.0

enum walk_kind { WALK_SWITCHES, WALK_TRANSDUCERS, WALK_GAGES, WALK_KINDS };

static const char *const kind_words[WALK_KINDS] = {"switches", "transducers", "gages"};
static const char *const kind_names[WALK_KINDS] = {"switch", "transducer", "gage"};
static const char *const kind_verbs[WALK_KINDS] = {"tripped", "pushed", "pulled"};

struct request {
    const struct cli *cli;
    const char *db, *serial, *can, *image, *expected, *of, *changed;
    double room_mb, for_s; /* 0, NaN: not given */
    bool walk;
};

static volatile sig_atomic_t interrupted;

static void note_signal(int number)
{
    (void)number;
    interrupted = 1;
}

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

/* ---- telling ---- */

static int tell(const struct request *request, const char *kind, const struct ready_report *report,
                const struct identity *identity, int64_t made_us, double took_s)
{
    int exit_code = ready_verdict(report) == READY_GO ? 0 : mr_status_exit_code(MR_LIMIT);
    char uid[IDENTITY_UID_TEXT];
    identity_uid_text(identity, uid);
    if (request->cli->json)
        return cli_print_json(json_pack("{sssssssIsoso}", "kind", kind, "verdict",
                                        ready_verdict(report) == READY_GO ? "go" : "no-go", "board",
                                        uid, "made_us", (json_int_t)made_us, "took_s",
                                        cli_json_number(took_s, 4), "checks", ready_json(report)),
                              exit_code);
    ready_print(report, took_s, cli_columns(), stdout);
    return exit_code;
}

/* ---- ready ---- */

/* "d3: a longer rod" or "d3,t4: ...": what is said of these channels becomes part of what the
 * campaign knows. */
static enum mr_status say_changed(const char *text, struct store *store, struct ready_facts *f,
                                  struct error *error)
{
    char uid[IDENTITY_UID_TEXT];
    uint32_t channels = 0;
    unsigned input;
    const char *note = strchr(text, ':'), *p = text;
    if (!note || !note[1 + strspn(note + 1, " ")])
        return error_set(error, MR_USAGE,
                         "which channel, and what was changed? '%s' for --changed; write for "
                         "example 'd3: a longer rod'",
                         text);
    for (size_t length; p < note; p += length + 1) {
        length = strcspn(p, ",:");
        if (!jump_channel_read(p, length, &input) ||
            !mr_channel_measures(&f->config.channel[input]))
            return error_set(
                error, MR_USAGE,
                "no channel that is fitted: '%.*s' for --changed; d1 to d%u, t1 to t%u",
                (int)length, p, MR_TRANSDUCERS, MR_GAGES);
        channels |= 1u << input;
    }
    identity_uid_text(&f->identity, uid);
    note += 1 + strspn(note + 1, " ");
    snprintf(f->changed, sizeof f->changed, "%.*s", (int)sizeof f->changed - 1, text);
    enum mr_status status = calibrationpast_say(store, uid, &f->config, channels, note,
                                                (int64_t)link_now_us(), error);
    return status == MR_OK ? calibrationpast_read(store, uid, &f->past, error) : status;
}

static enum mr_status examine(const struct request *request, struct store *store,
                              struct readytalk *talk, struct ready_facts *f, struct error *error)
{
    enum mr_status status = readytalk_meet(talk, error);
    if (status != MR_OK || !f->hello)
        return status;
    status = readykept_look_back(store, f, error);
    if (status == MR_OK && request->changed && !f->config_known)
        return error_set(error, MR_TIMEOUT,
                         "the board did not tell its configuration, so that nothing is kept of the "
                         "change: %s; try again",
                         request->serial);
    if (status == MR_OK && request->changed)
        status = say_changed(request->changed, store, f, error);
    return status == MR_OK && f->identity.hello.state == MR_LANDING_IDLE
             ? readytalk_ask(talk, error)
             : status;
}

static int ready(const struct request *request, struct ready_facts *f)
{
    struct error error = {0};
    struct store *store = NULL;
    struct dialogue dialogue = {0};
    struct readytalk *talk = calloc(1, sizeof *talk);
    struct ready_report *report = calloc(1, sizeof *report);
    int64_t made_us = (int64_t)link_now_us();
    double begun_s = steady_s();
    if (!talk || !report)
        abort();
    enum mr_status status = open_campaign(request, f, &store, &error);
    if (status == MR_OK)
        status = dialogue_open(&dialogue, request->can, request->serial, &error);
    if (status == MR_OK) {
        readytalk_begin(talk, &dialogue, f, LIMIT_S - (steady_s() - begun_s));
        status = examine(request, store, talk, f, &error);
    }
    if (status == MR_OK)
        ready_judge(f, report);
    if (status == MR_OK && f->hello && !f->database[0])
        status = readykept_save(store, &f->identity, "ready", report, f, made_us, &error);
    int exit_code = status == MR_OK
                      ? tell(request, "ready", report, &f->identity, made_us, steady_s() - begun_s)
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

struct walk {
    const struct request *request;
    const struct mr_config *config;
    struct walk_order order[WALK_KINDS];
    struct walk_motion transducers, gages;
    unsigned bounces[WALK_ITEMS], strange;
    bool gage_disturbed; /* a transducer was pushed while a gage moved: that is the push */
};

static void say(const struct walk *walk, enum walk_kind kind, unsigned n, const char *detail)
{
    if (walk->request->cli->quiet || walk->request->cli->json)
        return;
    printf("%s %u%s\n", kind_names[kind], n, detail);
    fflush(stdout);
}

static void answer(struct walk *walk, enum walk_kind kind, unsigned n, const char *detail)
{
    char text[200];
    struct walk_order *order = &walk->order[kind];
    unsigned next = walk_next(order);
    if (!order->fitted)
        return;
    switch (walk_take(order, n)) {
    case WALK_NEXT: say(walk, kind, n, detail); break;
    case WALK_ANOTHER:
        snprintf(text, sizeof text, "%s: %s %u was next; swapped?", detail, kind_names[kind], next);
        say(walk, kind, n, text);
        break;
    case WALK_AGAIN:
        snprintf(text, sizeof text, "%s: once more", detail);
        say(walk, kind, n, text);
        break;
    case WALK_NOT_FITTED:
        snprintf(text, sizeof text, "%s: not fitted", detail);
        say(walk, kind, n, text);
        break;
    }
}

static void take_edge(void *context, const struct mr_edge *edge)
{
    struct walk *walk = context;
    char text[80];
    if (edge->position == 0 || edge->position > MR_CONFIG_SWITCHES)
        return; /* its event tells why */
    snprintf(text, sizeof text, " (%.1f ft): step of %.1f codes, configured %u",
             (double)walk->config->gate[edge->position - 1].station_ft, (double)edge->step_codes,
             walk->config->gate[edge->position - 1].step_codes);
    answer(walk, WALK_SWITCHES, edge->position, text);
}

static void take_event(void *context, const struct mr_switch_event *event)
{
    struct walk *walk = context;
    bool unnamed = event->reason == MR_SWITCH_NO_STEP || event->reason == MR_SWITCH_OTHER_STEP ||
                   event->reason == MR_SWITCH_TOO_NEAR;
    if (event->reason == MR_SWITCH_BOUNCE && event->position >= 1 && event->position <= WALK_ITEMS)
        walk->bounces[event->position - 1]++;
    if (!unnamed || !walk->order[WALK_SWITCHES].fitted)
        return;
    walk->strange++;
    say(walk, WALK_SWITCHES, 0, "?: ");
    if (!walk->request->cli->quiet && !walk->request->cli->json)
        printf("    %s\n", mr_switch_reason_text(event->reason));
}

static void take_reading(void *context, const struct mr_block *block)
{
    struct walk *walk = context;
    float in[MR_TRANSDUCERS], lb[MR_GAGES];
    float ratio = mr_channels_ratio(block);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        in[i] = mr_channel_read(&walk->config->channel[i], block, i, ratio).value;
    for (unsigned i = 0; i < MR_GAGES; i++)
        lb[i] = mr_channel_read(&walk->config->channel[MR_TRANSDUCERS + i], block,
                                MR_TRANSDUCERS + i, ratio)
                    .value;
    unsigned pushed = walk_motion_take(&walk->transducers, in);
    unsigned pulled = walk_motion_take(&walk->gages, lb);
    walk->gage_disturbed |= walk->gages.moving && walk->transducers.moving;
    if (pushed)
        answer(walk, WALK_TRANSDUCERS, walk->config->channel[pushed - 1].number, ": pushed");
    if (pulled && !walk->gage_disturbed)
        answer(walk, WALK_GAGES, walk->config->channel[MR_TRANSDUCERS + pulled - 1].number,
               ": pulled");
    if (!walk->gages.moving && !walk->transducers.moving)
        walk->gage_disturbed = false;
}

/* What is fitted of the kinds that were asked for, by number. */
static void fit_out(struct walk *walk, const bool wanted[WALK_KINDS])
{
    for (unsigned i = 0; wanted[WALK_SWITCHES] && i < MR_CONFIG_SWITCHES; i++) {
        if (walk->config->gate[i].step_codes)
            walk->order[WALK_SWITCHES].fitted |= 1u << i;
    }
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        const struct mr_channel_config *channel = &walk->config->channel[i];
        enum walk_kind kind = i < MR_TRANSDUCERS ? WALK_TRANSDUCERS : WALK_GAGES;
        if (wanted[kind] && mr_channel_measures(channel) && channel->number >= 1)
            walk->order[kind].fitted |= 1u << (channel->number - 1);
    }
}

static enum mr_status wanted_kinds(const char *of, bool wanted[WALK_KINDS], struct error *error)
{
    for (const char *p = of; p && *p;) {
        size_t length = strcspn(p, ",");
        int kind = 0;
        while (kind < WALK_KINDS &&
               (strlen(kind_words[kind]) != length || strncmp(kind_words[kind], p, length) != 0))
            kind++;
        if (kind == WALK_KINDS)
            return error_set(error, MR_USAGE,
                             "not switches, transducers or gages: '%s' for --of; write for example "
                             "switches,transducers",
                             of);
        wanted[kind] = true;
        p += length + (p[length] == ',');
    }
    for (int kind = 0; !of && kind < WALK_KINDS; kind++)
        wanted[kind] = true;
    return MR_OK;
}

static enum mr_status go_along(struct readytalk *talk, struct walk *walk, double for_s,
                               struct error *error)
{
    double until_s = steady_s() + for_s, renew_s = 0.0;
    /* of the board: one that is emulated is faster than the clock on the wall */
    uint32_t renew_ms = 0;
    enum mr_status status = MR_OK;
    bool over = false;
    while (status == MR_OK && !over && !interrupted && steady_s() < until_s) {
        if (steady_s() >= renew_s || (int32_t)(talk->newest_clock - renew_ms) >= 0) {
            enum mr_status live = readytalk_live(talk, LIVE_S, error);
            if (error->status != MR_OK)
                return error->status;
            if (live != MR_OK)
                return error_set(
                    error, live,
                    "the board does not let itself be walked (%s): %s; it must be idle",
                    mr_status_text(live), dialogue_spec(talk->dialogue));
            renew_s = steady_s() + RENEW_S;
            renew_ms = talk->newest_clock + (uint32_t)(1000.0 * RENEW_S);
        }
        status = dialogue_turn(talk->dialogue, DIALOGUE_TURN_S, error);
        over = true;
        for (int kind = 0; kind < WALK_KINDS; kind++)
            over &= walk_over(&walk->order[kind]);
    }
    if (status == MR_CLOSED) { /* what was seen until then counts */
        *error = (struct error){0};
        return MR_OK;
    }
    if (status == MR_OK)
        (void)readytalk_live(talk, 0, error);
    return error->status;
}

static void judge_walk(const struct walk *walk, struct ready_report *report)
{
    for (int kind = 0; kind < WALK_KINDS; kind++)
        walk_judge(&walk->order[kind], kind_names[kind], kind_verbs[kind], report);
    for (unsigned i = 0; i < WALK_ITEMS; i++) {
        char name[20];
        snprintf(name, sizeof name, "switch %u", i + 1);
        if (walk->bounces[i])
            ready_add(report, READY_GO, name, "bounced %u times: its first edge counts",
                      walk->bounces[i]);
        if (walk->order[WALK_SWITCHES].again[i])
            ready_add(report, READY_GO, name, "answered %u times more",
                      walk->order[WALK_SWITCHES].again[i]);
    }
    if (walk->strange) {
        struct ready_check *c = ready_add(report, READY_NO_GO, "edges",
                                          "%u edges of no switch of the table", walk->strange);
        snprintf(c->advice, sizeof c->advice,
                 "does a step of the configuration differ from its resistor? is a contact bad?");
    }
}

static int walk_along(const struct request *request, struct ready_facts *f,
                      const bool wanted[WALK_KINDS])
{
    double for_s = isnan(request->for_s) ? WALK_S : request->for_s;
    struct error error = {0};
    struct store *store = NULL;
    struct dialogue dialogue = {0};
    struct readytalk *talk = calloc(1, sizeof *talk);
    struct walk *walk = calloc(1, sizeof *walk);
    struct ready_report *report = calloc(1, sizeof *report);
    int64_t made_us = (int64_t)link_now_us();
    double begun_s = steady_s();
    if (!talk || !walk || !report)
        abort();
    enum mr_status status = store_open(request->db, STORE_CREATE, &store, &error);
    if (status == MR_OK)
        status = dialogue_open(&dialogue, request->can, request->serial, &error);
    if (status == MR_OK) {
        readytalk_begin(talk, &dialogue, f, WALK_MEET_S);
        status = readytalk_meet(talk, &error);
    }
    if (status == MR_OK && !f->hello)
        status = dialogue_no_hello(&dialogue, &error);
    if (status == MR_OK && !f->config_known)
        status =
            error_set(&error, MR_TIMEOUT,
                      "the board did not tell its configuration: %s; it must be idle, try again",
                      request->serial);
    if (status == MR_OK) {
        *walk = (struct walk){.request = request, .config = &f->config};
        fit_out(walk, wanted);
        walk_motion_start(&walk->transducers, MR_TRANSDUCERS, WALK_PUSH_IN);
        walk_motion_start(&walk->gages, MR_GAGES, WALK_PULL_LB);
        talk->context = walk;
        talk->edge = take_edge;
        talk->event = take_event;
        talk->reading = take_reading;
        talk->until_s = (double)INFINITY;
        cli_note(request->cli,
                 "walk along the rig; it ends when all have answered, after %.0f s, or with Ctrl-C",
                 for_s);
        signal(SIGINT, note_signal);
        status = go_along(talk, walk, for_s, &error);
    }
    if (status == MR_OK)
        judge_walk(walk, report);
    if (status == MR_OK)
        status = readykept_save(store, &f->identity, "walk", report, NULL, made_us, &error);
    int exit_code = status == MR_OK
                      ? tell(request, "walk", report, &f->identity, made_us, steady_s() - begun_s)
                      : cli_fail(&error);
    dialogue_close(&dialogue);
    store_close(store);
    free(talk);
    free(walk);
    free(report);
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
    return configtext_load(text, &config, error);
}

static enum mr_status check_request(const struct request *r, struct error *error)
{
    if (!r->serial)
        return error_set(error, MR_USAGE,
                         "no link: matrig ready needs --serial LINK; see matrig ready --help");
    if (r->walk && (r->image || r->expected || r->room_mb > 0.0))
        return error_set(error, MR_USAGE,
                         "--walk goes without --image, --expect-config and --room: walk apart; see "
                         "matrig ready --help");
    if (r->walk && r->changed)
        return error_set(error, MR_USAGE,
                         "--changed goes without --walk: matrig ready; see matrig ready --help");
    if (!r->walk && (!isnan(r->for_s) || r->of))
        return error_set(error, MR_USAGE,
                         "--for and --of are --walk's: matrig ready; see matrig ready --help");
    return MR_OK;
}

static int ready_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {.cli = cli};
    struct ready_facts *facts = calloc(1, sizeof *facts);
    struct imagefile image = {0};
    struct error error = {0};
    bool wanted[WALK_KINDS] = {false, false, false};
    if (!facts)
        abort();
    enum mr_status status = command_parse(&command_ready, argc, argv, cli, &request, &request.db,
                                          &error);
    if (status == MR_OK)
        status = check_request(&request, &error);
    if (status == MR_OK)
        status = wanted_kinds(request.of, wanted, &error);
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
    facts->wanted_bytes = 1e6 * request.room_mb;
    facts->today_day = (uint32_t)(time(NULL) / S_PER_DAY);
    signal(SIGPIPE, SIG_IGN);
    int exit_code = status != MR_OK ? cli_fail(&error)
                  : request.walk    ? walk_along(&request, facts, wanted)
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
    OPTION_NUMBER("--room", "MB", room_mb, "MB", 0.001, 1e9, 0.0,
                  "so much of the disk must be free; else ten landings"),
    OPTION_TEXT("--changed", "T", changed,
                "'d3: a longer rod', 'd3,t4: ...': what was changed of these channels. Without, it "
                "is no-go when the gain of a\n"
                "channel has jumped since the campaign's landings and checks (a tenth; half of "
                "another transducer, five times\n"
                "of another gage, by serial number), or its zero (0.25 in, 10 lb). Kept in the "
                "campaign (table readiness)"),
    HELP_NOTE("Takes at most 20 s: readings at rest, shunt calibration, self-test (the warning "
              "lamp lights for 0.2 s). Exit 1: no-go."),
    OPTION_FLAG(
        "--walk", walk,
        "walk along the rig: trip each switch, push at each transducer, pull at each gage, in "
        "order. Nothing is recorded.\n"
        "Names what did not answer and what answered in another's place. Exit 1 when there is any"),
    OPTION_NUMBER(
        "--for", "S", for_s, "s", 1.0, 86400.0, (double)NAN,
        "the walk ends after S seconds; else after 600, when all have answered, or on Ctrl-C"),
    OPTION_TEXT("--of", "KINDS", of, "only these, of switches,transducers,gages"),
    HELP_EXAMPLE("matrig ready campaign.db --serial serial:/dev/ttyUSB0 --can can:can0"),
};

const struct command command_ready = {
    "ready",
    ready_command,
    "DB --serial LINK [--can LINK] [--image FILE] [--expect-config CRC|FILE] [--room MB] "
    "[--changed T] | DB --serial LINK --walk [--for S] [--of KINDS]",
    "go or no-go before a landing, and the walk test",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
