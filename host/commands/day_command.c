/* matrig day: a day at the runway, step by step. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/catalogue.h"
#include "host/base/answer.h"
#include "host/base/steady.h"
#include "host/commands/commands.h"
#include "host/commands/said.h"
#include "host/day/desk.h"
#include "host/day/facts.h"
#include "host/day/logging.h"
#include "host/day/page.h"
#include "host/day/walk.h"
#include "host/link/link.h"
#include "host/store/store_journal.h"

#define TURN_MS 200  /* between two looks at a log that runs */
#define STOP_S  60.0 /* for a log to write what it has */
#define ASKED_S 15.0 /* for whether arming is meant */
#define NO_CAN  "none"

struct request {
    const char *db, *serial, *can, *pattern, *edges, *image, *who, *page;
    int64_t live;
};

struct day {
    struct request r;
    const struct cli *cli;
    struct store *store;
    struct day_facts facts;
    struct day_plan plan;
    struct day_logging logging;
    struct day_page *page; /* NULL: none is wanted */
    struct error error;    /* the last one; said, and then forgotten */
};

/* ---- what is so ---- */

static enum mr_status look_around(struct day *day)
{
    day->facts.logging = day_logging_runs(&day->logging);
    enum mr_status status = day_facts_read(day->store, (int64_t)link_now_us(), &day->facts,
                                           &day->error);
    day->facts.held = !day->facts.logging && day_landing_goes_on(&day->facts) &&
                      store_is_logged(day->store);
    day_plan_make(&day->facts, &day->plan);
    return status;
}

static enum mr_status say(struct day *day, const char *word, const char *value)
{
    day->facts.now_us = (int64_t)link_now_us();
    return day_say(day->store, &day->facts, said_by(day->r.who), word, value, &day->error);
}

static const char *can_of(const struct day *day)
{
    return strcmp(day->facts.can, NO_CAN) == 0 ? NULL : day->facts.can;
}

/* ---- the programs of the steps ---- */

/* False: this step is a question, or several programs. */
static bool command_of(const struct day *day, enum day_step step, struct desk_command *command)
{
    const struct day_facts *f = &day->facts;
    static char run[24], page[DAY_PATH + 16], live[24];
    switch (step) {
    case DAY_LOOK:
        snprintf(run, sizeof run, "%lld", (long long)f->run);
        desk_command_begin(command, "show");
        desk_command_add(command, day->r.db);
        desk_command_add(command, run);
        return true;
    case DAY_SURVEY:
        desk_command_begin(command, "survey");
        desk_command_add(command, day->r.db);
        /* as the last one: only then two can be compared */
        desk_command_option(command, "--pattern", f->survey ? f->pattern : day->r.pattern);
        desk_command_option(command, "--edges", f->survey ? f->edges : day->r.edges);
        desk_command_option(command, "--who", day->r.who);
        return true;
    case DAY_LOAD:
        desk_command_begin(command, "survey");
        desk_command_add(command, day->r.db);
        desk_command_option(command, "--load", f->serial);
        return true;
    case DAY_ADVISE:
        desk_command_begin(command, "advise");
        desk_command_add(command, day->r.db);
        desk_command_add(command, "--keep");
        desk_command_add(command, "--load");
        desk_command_option(command, "--serial", f->serial);
        return true;
    case DAY_READY:
        desk_command_begin(command, "ready");
        desk_command_add(command, day->r.db);
        desk_command_option(command, "--serial", f->serial);
        desk_command_option(command, "--can", can_of(day));
        desk_command_option(command, "--image", day->r.image);
        return true;
    case DAY_LAND:
        desk_command_begin(command, "log");
        desk_command_option(command, "--serial", f->serial);
        desk_command_option(command, "--can", can_of(day));
        desk_command_option(command, "--db", day->r.db);
        desk_command_add(command, "--commands");
        snprintf(page, sizeof page, "%s/landing.html", day->logging.folder);
        desk_command_option(command, "--page", page);
        snprintf(live, sizeof live, "%lld", (long long)day->r.live);
        desk_command_option(command, "--live", day->r.live ? live : NULL);
        return true;
    default: return false;
    }
}

/* What is so, for programs and for the page. */
static struct answer *state_answer(const struct day *day)
{
    struct desk_command command;
    char text[2000];
    struct answer *answer = answer_new(false);
    answer_words(answer, "db", NULL, "%s", day->r.db);
    answer_words(answer, "next", NULL, "%s", day_step_words[day->plan.next].key);
    answer_words(answer, "reason", NULL, "%s", day->plan.reason[day->plan.next]);
    if (command_of(day, day->plan.next, &command))
        answer_words(answer, "command", NULL, "%s", desk_command_text(&command, text, sizeof text));
    else
        answer_none(answer, "command", NULL, NULL);
    answer_flag(answer, "logging", NULL, day->facts.logging);
    answer_count(answer, "run", NULL, day->facts.run);
    answer_count(answer, "landings_today", NULL, day->facts.today);
    answer_table(answer, "steps", "");
    for (enum day_step step = 0; step < DAY_STEPS; step++) {
        answer_row(answer);
        answer_words(answer, "step", NULL, "%s", day_step_words[step].key);
        answer_words(answer, "state", NULL, "%s", day_state_text(day->plan.state[step]));
        answer_words(answer, "reason", NULL, "%s", day->plan.reason[step]);
    }
    answer_close(answer);
    return answer;
}

/* `busy`: what goes on at the terminal; NULL: keys are waited for. */
static void show_page(struct day *day, const char *keys, const char *busy)
{
    if (!day->page)
        return;
    json_t *state = answer_into_json(state_answer(day));
    json_object_set_new(state, "busy", busy ? json_string(busy) : json_null());
    day_page_tell(day->page, state, keys);
}

static void run(struct day *day, const struct desk_command *command)
{
    char text[2000];
    printf("$ %s\n", desk_command_text(command, text, sizeof text));
    fflush(stdout);
    int code = desk_run(command, &day->error);
    if (code > 1)
        printf("that did not end well (exit %d): what it said stands above\n", code);
}

/* ---- the steps ---- */

static void say_error(struct day *day)
{
    if (day->error.status != MR_OK)
        cli_fail(&day->error);
    day->error = (struct error){0};
}

/* A link as it is written whole, kept; false: it is none, or could not be kept. */
static bool keep_link(struct day *day, const char *word, const char *given, enum link_kind kind,
                      char *into, size_t size)
{
    char spec[LINK_SPEC_MAX];
    if (strcmp(given, NO_CAN) == 0 && kind == LINK_CAN)
        snprintf(spec, sizeof spec, "%s", given);
    else if (link_complete(given, kind, spec, &day->error) != MR_OK)
        return false;
    size_t length = strlen(spec);
    if (length >= size) {
        error_set(&day->error, MR_TOO_LONG, "link too long: '%.60s...'; at most %zu characters",
                  spec, size - 1);
        return false;
    }
    if (say(day, word, spec) != MR_OK)
        return false;
    memcpy(into, spec, length + 1);
    return true;
}

/* Links that were given with the command hold from now on. */
static enum mr_status take_links(struct day *day)
{
    struct day_facts *f = &day->facts;
    if (day->r.serial && strcmp(day->r.serial, f->serial) != 0)
        keep_link(day, "serial", day->r.serial, LINK_SERIAL, f->serial, sizeof f->serial);
    if (day->error.status == MR_OK && day->r.can && strcmp(day->r.can, f->can) != 0)
        keep_link(day, "can", day->r.can, LINK_CAN, f->can, sizeof f->can);
    return day->error.status;
}

/* The board's links, once. False: not told. */
static bool have_links(struct day *day)
{
    struct day_facts *f = &day->facts;
    char text[200];
    if (!f->serial[0] &&
        (!desk_ask("the board's serial port (such as serial:/dev/ttyUSB0): ", text, sizeof text) ||
         !text[0] || !keep_link(day, "serial", text, LINK_SERIAL, f->serial, sizeof f->serial)))
        return false;
    return f->can[0] ||
           (desk_ask("its CAN bus (such as can:can0; Enter: none): ", text, sizeof text) &&
            keep_link(day, "can", text[0] ? text : NO_CAN, LINK_CAN, f->can, sizeof f->can));
}

static void look(struct day *day)
{
    struct desk_command command;
    struct store_change note = {.run = day->facts.run, .field = "note"};
    if (!day->facts.run)
        return;
    command_of(day, DAY_LOOK, &command);
    run(day, &command);
    if (!desk_ask("what was seen? (a note; Enter: nothing to say): ", note.value,
                  sizeof note.value))
        return;
    /* both or neither: a note is not asked for twice, and not lost */
    note.made_us = (int64_t)link_now_us();
    said_fill(note.who, sizeof note.who, said_by(day->r.who));
    enum mr_status status = store_begin(day->store, &day->error);
    if (status == MR_OK && note.value[0])
        status = store_change_add(day->store, &note, &day->error);
    if (status == MR_OK)
        status = say(day, "looked", "");
    if (status == MR_OK)
        store_commit(day->store, &day->error);
}

static void series(struct day *day)
{
    struct store_series row = {.made_us = (int64_t)link_now_us()};
    if (!desk_ask("what is tested? A name for the series: ", row.name, sizeof row.name) ||
        !row.name[0] ||
        !desk_ask("the runway (such as 'relaid, bands tensioned'; Enter: not said): ", row.runway,
                  sizeof row.runway))
        return;
    said_fill(row.who, sizeof row.who, said_by(day->r.who));
    if (store_series_add(day->store, &row, &day->error) == MR_OK)
        printf("series begun: landings that are armed from now on belong to it\n");
}

static void advise(struct day *day)
{
    struct desk_command command;
    char speed[40], deceleration[40];
    command_of(day, DAY_ADVISE, &command);
    if (!desk_ask("planned speed at touchdown (35ft/s; Enter: the last landing's): ", speed,
                  sizeof speed) ||
        !desk_ask("planned mean deceleration (4.5ft/s2; Enter: the last landing's): ", deceleration,
                  sizeof deceleration))
        return;
    desk_command_option(&command, "--speed", speed);
    desk_command_option(&command, "--deceleration", deceleration);
    run(day, &command);
}

static void calibrate(struct day *day)
{
    struct day_walk walk = {
        .db = day->r.db, .serial = day->facts.serial, .folder = day->logging.folder};
    if (day_walk(&walk, &day->error) == MR_OK && walk.ended)
        say(day, "calibrated", "");
}

/* ---- the log ---- */

/* A landing that this log has seen to its end. */
static bool has_landed(const struct day *day)
{
    return day->facts.run > day->logging.before && !day_landing_goes_on(&day->facts);
}

static void end_log(struct day *day)
{
    if (!day_logging_stop(&day->logging, STOP_S))
        printf("the log has more to write; it ends by itself\n");
    day_logging_show(&day->logging, stdout);
}

static void order(struct day *day, const char *word, const char *reply)
{
    if (!day_logging_order(&day->logging, word) ||
        (reply && !day_logging_order(&day->logging, reply)))
        printf("the log takes no orders: it has ended, or is about to\n");
}

/* A key of a log that runs. `*asked_s`: until when `y` arms; 0: it was not asked. False: the person
 * leaves. */
static bool take_log_key(struct day *day, char key, double *asked_s)
{
    bool asked = steady_s() < *asked_s;
    if (key)
        *asked_s = 0.0;
    if (key == 'a' && !asked) {
        printf("arm for the next landing? y: ");
        *asked_s = steady_s() + ASKED_S;
    } else if (asked && key) {
        printf("\n%s", key == 'y' ? "" : "not armed\n");
        if (key == 'y')
            order(day, "arm", "yes");
    } else if (key == 'd') {
        order(day, "disarm", day_landing_goes_on(&day->facts) ? "yes" : NULL);
    } else if (key == 'e') {
        end_log(day);
    }
    fflush(stdout);
    return key != DESK_END || asked;
}

/* Until the landing is there, the log has ended, or the person leaves. False: leaves the day. */
static bool watch(struct day *day)
{
    double asked_s = 0.0;
    printf("a arm   d disarm   e end the log   q leave: the log goes on\n");
    while (look_around(day) == MR_OK) {
        day_logging_show(&day->logging, stdout);
        if (!day->facts.logging) {
            printf("the log has ended\n");
            return true;
        }
        if (has_landed(day)) {
            end_log(day);
            return true;
        }
        show_page(day, steady_s() < asked_s ? "" : "ade", NULL);
        if (!take_log_key(day, desk_key(TURN_MS), &asked_s))
            return false;
    }
    say_error(day);
    return true;
}

static bool land(struct day *day)
{
    struct desk_command command;
    char text[2000];
    if (!day->facts.logging) {
        command_of(day, DAY_LAND, &command);
        printf("$ %s\n", desk_command_text(&command, text, sizeof text));
        if (day->facts.held) {
            printf("%s\n", day->plan.reason[DAY_LAND]);
            return true;
        }
        if (day_logging_start(&day->logging, command.words, day->facts.run, &day->error) != MR_OK)
            return true;
    }
    return watch(day);
}

/* ---- one after the other ---- */

/* False: the person leaves. */
static bool take_step(struct day *day, enum day_step step)
{
    struct desk_command command;
    bool goes_over_links = step == DAY_CALIBRATE || step == DAY_LOAD || step == DAY_ADVISE ||
                           step == DAY_READY || step == DAY_LAND;
    if (goes_over_links && !have_links(day))
        return true;
    switch (step) {
    case DAY_LOOK: look(day); return true;
    case DAY_SERIES: series(day); return true;
    case DAY_CALIBRATE: calibrate(day); return true;
    case DAY_ADVISE: advise(day); return true;
    case DAY_LAND: return land(day);
    default:
        command_of(day, step, &command);
        run(day, &command);
        return true;
    }
}

static void report(struct day *day)
{
    struct desk_command command;
    char page[DAY_PATH + 16];
    snprintf(page, sizeof page, "%s/report/", day->logging.folder);
    desk_command_begin(&command, "report");
    desk_command_add(&command, day->r.db);
    desk_command_option(&command, "-o", page);
    run(day, &command);
}

/* What the board noted by itself, a row a minute, over night too. */
static void slow(struct day *day)
{
    struct desk_command command;
    if (!have_links(day))
        return;
    desk_command_begin(&command, "board");
    desk_command_option(&command, "--serial", day->facts.serial);
    desk_command_add(&command, "slow");
    desk_command_option(&command, "--db", day->r.db);
    run(day, &command);
}

static void note(struct day *day)
{
    struct store_change row = {.run = day->facts.run, .field = "note"};
    if (!row.run) {
        printf("no landing yet that a note could be of\n");
        return;
    }
    printf("RUN %lld: ", (long long)row.run);
    if (!desk_ask("note: ", row.value, sizeof row.value) || !row.value[0])
        return;
    row.made_us = (int64_t)link_now_us();
    said_fill(row.who, sizeof row.who, said_by(day->r.who));
    store_change_add(day->store, &row, &day->error);
}

static void skip(struct day *day)
{
    const char *step = day_step_words[day->plan.next].key;
    if (day->plan.next == DAY_LAND) {
        printf("a landing is not skipped; q leaves the day\n");
        return;
    }
    printf("leave out %s for the landing to come? y: ", step);
    fflush(stdout);
    bool yes = desk_key(-1) == 'y';
    printf("\n");
    if (yes)
        say(day, "skip", step);
}

static void draw(const struct day *day)
{
    struct desk_command command;
    char text[2000];
    const struct day_facts *f = &day->facts;
    printf("\n%s: %lld landing%s today%s%s\n", day->r.db, (long long)f->today,
           f->today == 1 ? "" : "s", f->series[0] ? ", series " : "", f->series);
    for (enum day_step step = 0; step < DAY_STEPS; step++)
        printf("%c %d %-10s %-11s %s\n", day->plan.state[step] == DAY_NEXT ? '>' : ' ', step + 1,
               day_step_words[step].key, day_state_text(day->plan.state[step]),
               day->plan.reason[step]);
    printf("Enter: %s: %s\n", day_step_words[day->plan.next].key,
           day_step_words[day->plan.next].text);
    if (command_of(day, day->plan.next, &command) && (f->serial[0] || day->plan.next == DAY_SURVEY))
        printf("       %s\n", desk_command_text(&command, text, sizeof text));
    printf("1-%d that step   s skip   n note   r report   o the board's slow log   q leave > ",
           DAY_STEPS);
    fflush(stdout);
}

static int guide(struct day *day)
{
    while (look_around(day) == MR_OK) {
        draw(day);
        show_page(day, "\n12345678sro", NULL);
        char key = desk_key(-1);
        printf("\n");
        show_page(day, "",
                  day_step_words[key >= '1' && key < '1' + DAY_STEPS ? (enum day_step)(key - '1')
                                                                     : day->plan.next]
                      .key);
        bool stays = true;
        if (key == DESK_ENTER)
            stays = take_step(day, day->plan.next);
        else if (key >= '1' && key < '1' + DAY_STEPS)
            stays = take_step(day, (enum day_step)(key - '1'));
        else if (key == 's')
            skip(day);
        else if (key == 'n')
            note(day);
        else if (key == 'r')
            report(day);
        else if (key == 'o')
            slow(day);
        else if (key == DESK_END)
            stays = false;
        else
            printf("'%c' is no key of the day\n", key);
        say_error(day);
        desk_forget();
        if (!stays)
            break;
    }
    if (day->error.status != MR_OK)
        return cli_fail(&day->error);
    printf("%s: matrig day %s goes on here\n",
           day_logging_runs(&day->logging) ? "the log goes on" : "all is kept", day->r.db);
    return 0;
}

static int tell(struct day *day)
{
    return answer_end(day->cli, state_answer(day), 0, &day->error);
}

/* A name mistyped is no new campaign. */
static bool is_meant(const char *db)
{
    struct stat there;
    if (stat(db, &there) == 0)
        return true;
    printf("%s is not there. Begin a new campaign? y: ", db);
    fflush(stdout);
    bool yes = desk_key(-1) == 'y';
    printf("\n");
    return yes;
}

static int day_command(int argc, char **argv, const struct cli *cli)
{
    struct day *day = calloc(1, sizeof *day);
    const char *words[1];
    if (!day)
        abort();
    day->cli = cli;
    enum mr_status status = command_parse(&command_day, argc, argv, cli, &day->r, words,
                                          &day->error);
    day->r.db = words[0];
    desk_begin();
    if (status == MR_OK && !cli->json && !is_meant(day->r.db))
        status = error_set(&day->error, MR_USAGE, "no campaign: %s; nothing was made", day->r.db);
    if (status == MR_OK)
        status = store_open(day->r.db, cli->json ? STORE_READ : STORE_CREATE, &day->store,
                            &day->error);
    if (status == MR_OK)
        status = day_logging_begin(&day->logging, day->r.db, &day->error);
    if (status == MR_OK && !cli->json)
        status = day_logging_folder(&day->logging, &day->error);
    if (status == MR_OK)
        status = look_around(day);
    if (status == MR_OK && !cli->json)
        status = take_links(day);
    if (status == MR_OK && day->r.page && !cli->json) {
        status = day_page_open(day->r.page, day->r.db, &day->page, &day->error);
        if (status == MR_OK)
            printf("the day's page: %s\n", day_page_url(day->page));
        desk_listen(day_page_keys(day->page));
    }
    int code = status != MR_OK ? cli_fail(&day->error) : cli->json ? tell(day) : guide(day);
    day_page_close(day->page);
    store_close(day->store);
    free(day);
    return code;
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database, made when it does not exist. What is done and what is next "
                    "is read from it, so a day that\n"
                    "was broken off anywhere goes on where it was"),
    HELP_NOTE("Steps: look at the landing before, series, calibrate, survey, load it, advise, "
              "ready, land. Each begins with a key: Enter takes\n"
              "the next one and shows the command that it is; 1 to 8 takes another, s skips, n is "
              "a note, r the report, o fetches the\n"
              "board's slow log, q leaves. The log of a landing goes on when the day is left or "
              "killed, and the day finds it again."),
    OPTION_TEXT("--serial", "LINK", serial,
                "the board's serial port (see matrig log --help); else as last told, or it asks"),
    OPTION_TEXT("--can", "LINK", can, "its CAN bus, or none; likewise"),
    OPTION_CHOICE("--pattern", "P", pattern, "pattern", "standard|diagonal",
                  "of the first survey, and its edges; the next ones are as that was"),
    OPTION_CHOICE("--edges", "E", edges, "edges", "left|both|none", NULL),
    OPTION_TEXT("--image", "FILE", image, "the board must run this (see matrig ready --help)"),
    OPTION_TEXT("--page", "PORT", page,
                "the day on a page of this computer, with a button for each key; 0: any port that "
                "is free"),
    OPTION_WHOLE("--live", "PORT", live, 0, 65535, 0,
                 "show each landing in a browser of this computer; see matrig live --help"),
    OPTION_TEXT("--who", "W", who, "who is at it; else the user"),
    HELP_NOTE("With --json: what is done and what is next, as one object, and no more. Beside the "
              "campaign, in DB-day: the page of the last\n"
              "landing, the report, what the log said."),
    HELP_EXAMPLE("matrig day campaign.db --serial serial:/dev/ttyUSB0 --can can:can0"),
};

const struct command command_day = {
    "day",
    day_command,
    "DB [--serial LINK] [--can LINK] [--pattern P] [--edges E] [--image FILE] [--live PORT] "
    "[--page PORT] [--who W]",
    "a day at the runway, step by step: what is done, what is next",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
