#include "host/commands/ready_walk.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"
#include "host/base/output.h"
#include "host/base/steady.h"
#include "host/board/configtext.h"
#include "host/board/readykept.h"
#include "host/board/readytalk.h"
#include "host/board/readywalk.h"
#include "host/board/walksteps.h"

#define LIVE_S      30 /* a board whose host went away is quiet again after that */
#define RENEW_S     5.0
#define WALK_MEET_S 10.0
#define WALK_S      600.0

static const char *const kind_words[WALK_KINDS] = {"switches", "transducers", "gages"};
static const char *const kind_names[WALK_KINDS] = {"switch", "transducer", "gage"};
static const char *const kind_verbs[WALK_KINDS] = {"tripped", "pushed", "pulled"};

static volatile sig_atomic_t interrupted;

static void note_signal(int number)
{
    (void)number;
    interrupted = 1;
}

int ready_tell(const struct cli *cli, const char *kind, const struct ready_report *report,
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

struct walk {
    const struct ready_walk *request;
    const struct mr_config *config;
    struct walk_order order[WALK_KINDS];
    struct walk_motion transducers, gages;
    unsigned bounces[WALK_ITEMS], strange;
    struct walk_steps steps; /* where they are learned */
    bool gage_disturbed;     /* a transducer was pushed while a gage moved: that is the push */
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

/* In order, whatever name it was given. */
static void learn_edge(struct walk *walk, const struct mr_edge *edge)
{
    char text[80];
    unsigned position = walk_steps_take(&walk->steps, walk->config, edge->count,
                                        (double)edge->step_codes);
    if (!position)
        return;
    snprintf(text, sizeof text, " (%.1f ft): step of %.1f codes, configured %u",
             (double)walk->config->gate[position - 1].station_ft, (double)edge->step_codes,
             walk->config->gate[position - 1].step_codes);
    say(walk, WALK_SWITCHES, position, text);
}

static void take_edge(void *context, const struct mr_edge *edge)
{
    struct walk *walk = context;
    char text[80];
    if (walk->request->learn) {
        learn_edge(walk, edge);
        return;
    }
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
    if (walk->request->learn) {
        if (event->reason == MR_SWITCH_BOUNCE)
            walk_steps_bounced(&walk->steps, event->count);
        return;
    }
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
    float ratio = mr_channels_ratio(&walk->config->channel[MR_REFERENCE], block);
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

enum mr_status ready_walk_kinds(const char *of, bool wanted[WALK_KINDS], struct error *error)
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
        over = !walk->request->learn || walk_steps_over(&walk->steps, walk->config);
        for (int kind = 0; kind < WALK_KINDS; kind++)
            over &= walk->request->learn || walk_over(&walk->order[kind]);
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

/* The configuration with the steps as they are, into the file; or why not. */
static enum mr_status learn(const struct walk *walk, struct ready_report *report,
                            struct error *error)
{
    struct mr_config learned;
    struct walk_steps_found found;
    char why[sizeof((struct ready_check *)NULL)->value];
    if (!walk_steps_learn(&walk->steps, walk->config, &learned, &found, why, sizeof why)) {
        struct ready_check *c = ready_add(report, READY_NO_GO, "steps", "%s", why);
        snprintf(c->limit, sizeof c->limit, "each once, in order, %u codes apart",
                 MR_CONFIG_STEP_APART_CODES);
        snprintf(c->advice, sizeof c->advice, "nothing is written: %s", walk->request->learn);
        return MR_OK;
    }
    char *text = configtext_write(&learned);
    enum mr_status status = output_bytes(walk->request->learn, text, strlen(text), error);
    free(text);
    if (found.configured_stay)
        ready_add(
            report, READY_GO, "steps",
            "%u answered at most %.1f codes from those configured, which stay: learned, %u and "
            "%u would be %.1f codes apart; in %.200s, as configured",
            found.count, found.furthest_codes, found.near, found.near_other, found.apart_codes,
            walk->request->learn);
    else
        ready_add(
            report, READY_GO, "steps",
            "%u learned, at most %.1f codes from those configured; nearest to each other are %u "
            "and %u, %.1f codes apart; in %.200s, for matrig board config set",
            found.count, found.furthest_codes, found.near, found.near_other, found.apart_codes,
            walk->request->learn);
    return status;
}

int ready_walk(const struct ready_walk *request, struct ready_facts *f)
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
        fit_out(walk, request->wanted);
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
    if (status == MR_OK && request->learn)
        status = learn(walk, report, &error);
    else if (status == MR_OK)
        judge_walk(walk, report);
    if (status == MR_OK)
        status = readykept_save(store, &f->identity, "walk", report, NULL, made_us, &error);
    int exit_code = status == MR_OK ? ready_tell(request->cli, "walk", report, &f->identity,
                                                 made_us, steady_s() - begun_s)
                                    : cli_fail(&error);
    dialogue_close(&dialogue);
    store_close(store);
    free(talk);
    free(walk);
    free(report);
    return exit_code;
}
