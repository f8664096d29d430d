/* The command matrig day: a test day as a checklist. All facts are read from the campaign, and the
 * next step is determined from them. The steps for a landing begin with the inspection after the
 * previous landing and end with the landing itself. */
#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "common/catalogue.h"
#include "host/base/answer.h"
#include "host/base/xmalloc.h"
#include "host/commands/annotation.h"
#include "host/commands/commands.h"
#include "host/commands/day.h"
#include "host/commands/program.h"
#include "host/link/link.h"
#include "host/store/store_journal.h"
#include "host/store/store_readiness.h"
#include "host/survey/survey.h"

/* Key and description of each step. */
#define DAY_STEP_TABLE(X)                                                          \
    X(LOOK, look, "inspect the mat after the landing and note observations")       \
    X(SERIES, series, "name the series of landings")                               \
    X(CALIBRATE, calibrate, "calibrate the channels that are due")                 \
    X(SURVEY, survey, "read the gage points of the mat")                           \
    X(LOAD, load, "load the joint openings measured in the survey into the board") \
    X(ADVISE, advise, "predict zones and recommend how hard to brake")             \
    X(READY, ready, "check board, sensors, links and disk (go or no-go)")          \
    X(LAND, land, "start the log in another terminal, arm the board, land")

enum day_step {
#define DAY_STEP(NAME, key, text) DAY_##NAME,
    DAY_STEP_TABLE(DAY_STEP)
#undef DAY_STEP
        DAY_STEPS
};

enum day_state { DAY_DONE, DAY_NEXT, DAY_LATER, DAY_SKIPPED, DAY_NOT_NEEDED };

struct day_status {
    int64_t now_us;
    char serial[200], can[200]; /* links to the board; "": not known; "none": no CAN */
    char series[80];            /* name of the newest series; "": none */
    /* the newest landing; 0: none */
    int64_t run, armed_us;
    int state;              /* enum mr_landing_state */
    bool has_notes;         /* the landing has at least one note */
    int64_t landings_today; /* landings armed since midnight, local time */
    /* the newest survey; 0: none. survey_ended_us: STORE_NONE while it is not finished */
    int64_t survey, survey_us, survey_ended_us;
    size_t survey_read_count, survey_item_count;
    char edges[16];
    int64_t runway_loaded_us; /* time at which the survey was loaded into a board; 0: never */
    /* time of the newest advice since the newest landing; 0: none */
    int64_t advice_made_us;
    char advice[8];
    /* time of the newest check by `matrig ready` in the last 12 h; 0: none */
    int64_t checks_made_us;
    bool is_go, calibration_due;
    char failed_checks[200]; /* first reason for a NO-GO; an overdue calibration has priority */
    /* matrig log has been running since logging_since_us */
    bool is_logging;
    int64_t logging_since_us;
    /* facts since the newest landing that only this process knows, because the campaign does not
     * store them */
    int64_t calibrated_us;
    bool is_skipped[DAY_STEPS];
};

struct day_plan {
    enum day_state state[DAY_STEPS];
    char reason[DAY_STEPS][240];
    enum day_step next;
};

/* ---- facts ---- */

static int64_t compute_local_midnight_us(int64_t now_us)
{
    time_t s = (time_t)(now_us / 1000000);
    struct tm day;
    localtime_r(&s, &day);
    day.tm_hour = day.tm_min = day.tm_sec = 0;
    day.tm_isdst = -1;
    return (int64_t)mktime(&day) * 1000000;
}

/* Reads the links that the newest log of the campaign used. */
static void read_links(struct store *store, struct day_status *f)
{
    struct store_session_row row = {0};
    int64_t session = 0;
    store_newest_logged_session_get(store, &session, fatal);
    if (!session)
        return;
    store_session_get(store, session, &row, fatal);
    f->logging_since_us = row.started_us;
    if (!f->serial[0] && row.serial_link[0]) {
        snprintf(f->serial, sizeof f->serial, "%.199s", row.serial_link);
        if (!f->can[0])
            snprintf(f->can, sizeof f->can, "%.199s", row.can_link[0] ? row.can_link : "none");
    }
}

static void read_landings(struct store *store, struct day_status *f)
{
    struct store_landing landing;
    char note[STORE_JOURNAL_TEXT_SIZE];
    store_newest_logged_run_get(store, &f->run, fatal);
    store_count_landings_since(store, compute_local_midnight_us(f->now_us), &f->landings_today,
                               fatal);
    if (!f->run)
        return;
    store_landing_get(store, f->run, &landing, fatal);
    store_change_get(store, f->run, "note", note, NULL, fatal);
    f->armed_us = landing.armed_us;
    f->state = (int)landing.state;
    f->has_notes = note[0] != '\0';
}

static void read_series(struct store *store, struct day_status *f)
{
    struct store_series *rows = NULL;
    size_t count = 0;
    store_all_series_get(store, &rows, &count, fatal);
    if (count)
        memcpy(f->series, rows[count - 1].name, sizeof f->series);
    free(rows);
}

static void read_survey(struct store *store, struct day_status *f)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    store_gage_surveys_get(store, &rows, &count, fatal);
    if (count) {
        const struct store_gage_survey *row = &rows[count - 1];
        struct survey *survey = xmalloc(sizeof *survey);
        f->survey = row->id;
        f->survey_ended_us = row->ended_us;
        f->survey_us = row->made_us;
        memcpy(f->edges, row->edges, sizeof f->edges);
        survey_load(store, row->id, survey, fatal);
        f->survey_read_count = survey_progress_count_read(&survey->progress);
        f->survey_item_count = survey->progress.plan.count;
        store_gage_load_time_get(store, row->id, &f->runway_loaded_us, fatal);
        free(survey);
    }
    free(rows);
}

static void read_advice(struct store *store, struct day_status *f)
{
    struct store_advice *rows = NULL;
    size_t count = 0;
    store_advices_get(store, &rows, &count, fatal);
    for (size_t i = 0; i < count; i++) {
        if (rows[i].made_us < f->armed_us)
            continue;
        f->advice_made_us = rows[i].made_us;
        memcpy(f->advice, rows[i].verdict, sizeof f->advice);
    }
    free(rows);
}

/* Finds the first NO-GO (an overdue calibration has priority) and any overdue calibration. */
static void read_checks(const char *checks, struct day_status *f)
{
    json_t *object = json_loads(checks, 0, NULL), *check;
    size_t i;
    json_array_foreach(json_object_get(object, "checks"), i, check)
    {
        const char *name = json_string_value(json_object_get(check, "name")),
                   *value = json_string_value(json_object_get(check, "value")),
                   *state = json_string_value(json_object_get(check, "verdict"));
        if (!name || !state || strcmp(state, "NO-GO") != 0)
            continue;
        bool due = strcmp(name, "calibration") == 0;
        if (!f->failed_checks[0] || (due && !f->calibration_due))
            snprintf(f->failed_checks, sizeof f->failed_checks, "%.40s: %.140s", name,
                     value ? value : "");
        f->calibration_due |= due;
    }
    json_decref(object);
}

static void read_ready(struct store *store, struct day_status *f)
{
    char uid[25];
    struct store_readiness row = {0};
    bool found = false;
    store_newest_board_get(store, uid, fatal);
    if (uid[0])
        store_readiness_get(store, uid, "ready", f->now_us, true, &row, &found, fatal);
    if (!found)
        return;
    f->checks_made_us = row.made_us;
    f->is_go = strcmp(row.verdict, "go") == 0;
    if (!f->is_go)
        read_checks(row.checks, f);
    free(row.checks);
}

/* Reads all facts from the campaign again, except the links. The time of calibration and the
 * skipped steps are kept until there is a new landing. */
static void day_status_read(struct store *store, int64_t now_us, struct day_status *f)
{
    const struct day_status was = *f;
    *f = (struct day_status){.now_us = now_us};
    memcpy(f->serial, was.serial, sizeof f->serial);
    memcpy(f->can, was.can, sizeof f->can);
    /* Read the lock before the other facts: a log that begins after this is then found by the next
     * call. */
    f->is_logging = store_is_being_logged(store);
    read_links(store, f);
    read_landings(store, f);
    read_series(store, f);
    read_survey(store, f);
    read_advice(store, f);
    read_ready(store, f);
    if (f->run == was.run) {
        f->calibrated_us = was.calibrated_us;
        memcpy(f->is_skipped, was.is_skipped, sizeof f->is_skipped);
    }
}

/* ---- plan ---- */

static const struct {
    const char *key, *text;
} step_texts[DAY_STEPS] = {
#define DAY_STEP(NAME, key, text) [DAY_##NAME] = {#key, text},
    DAY_STEP_TABLE(DAY_STEP)
#undef DAY_STEP
};

static const char *state_text(enum day_state state)
{
    static const char *const text[] = {[DAY_DONE] = "done",
                                       [DAY_NEXT] = "next",
                                       [DAY_LATER] = "later",
                                       [DAY_SKIPPED] = "skipped",
                                       [DAY_NOT_NEEDED] = "not needed"};
    return text[state];
}

/* Writes the reason for the state of a step and returns `state`. The reason does not depend on
 * earlier steps. */
static enum day_state set_reason(char reason[240], enum day_state state, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static enum day_state set_reason(char reason[240], enum day_state state, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(reason, 240, format, arguments);
    va_end(arguments);
    return state;
}

static const char *format_clock(int64_t us, char out[9])
{
    time_t s = (time_t)(us / 1000000);
    struct tm at;
    localtime_r(&s, &at);
    snprintf(out, 9, "%02d:%02d", at.tm_hour % 100, at.tm_min % 100);
    return out;
}

static bool is_landing_in_progress(const struct day_status *f)
{
    return f->run && (f->state == MR_LANDING_ARMED || f->state == MR_LANDING_LANDING ||
                      f->state == MR_LANDING_SETTLING);
}

static enum day_state look_step_state(const struct day_status *f, char reason[240])
{
    if (!f->run)
        return set_reason(reason, DAY_NOT_NEEDED, "no landing yet");
    if (f->has_notes)
        return set_reason(reason, DAY_DONE, "RUN %lld has a note", (long long)f->run);
    if (f->is_logging && is_landing_in_progress(f))
        return set_reason(reason, DAY_NOT_NEEDED, "RUN %lld has not ended", (long long)f->run);
    if (is_landing_in_progress(f))
        return set_reason(reason, DAY_NEXT,
                          "the record of RUN %lld ends in the state %s: matrig board list shows "
                          "whether the board has the rest",
                          (long long)f->run, mr_landing_state_text((uint8_t)f->state));
    return set_reason(reason, DAY_NEXT, "RUN %lld has no note", (long long)f->run);
}

static enum day_state series_step_state(const struct day_status *f, char reason[240])
{
    return f->series[0] ? set_reason(reason, DAY_DONE, "%.80s", f->series)
                        : set_reason(reason, DAY_NEXT, "the campaign has no series");
}

static enum day_state calibrate_step_state(const struct day_status *f, char reason[240])
{
    if (f->calibration_due && f->calibrated_us < f->checks_made_us)
        return set_reason(reason, DAY_NEXT, "%.200s", f->failed_checks);
    return f->calibrated_us
             ? set_reason(reason, DAY_DONE, "calibrated since the last check")
             : set_reason(reason, DAY_NOT_NEEDED, "matrig ready reports when a calibration is due");
}

static bool is_surveyed(const struct day_status *f)
{
    return f->survey && f->survey_ended_us != STORE_NONE && f->survey_us >= f->armed_us;
}

static enum day_state survey_step_state(const struct day_status *f, char reason[240])
{
    char at[9];
    if (f->survey && f->survey_ended_us == STORE_NONE)
        return set_reason(reason, DAY_NEXT, "survey %lld is not finished: %zu of %zu points read",
                          (long long)f->survey, f->survey_read_count, f->survey_item_count);
    if (is_surveyed(f))
        return set_reason(reason, DAY_DONE, "survey %lld, ended %s", (long long)f->survey,
                          format_clock(f->survey_ended_us, at));
    return f->run ? set_reason(reason, DAY_NEXT, "the mat has not been surveyed since RUN %lld",
                               (long long)f->run)
                  : set_reason(reason, DAY_NEXT, "the mat has not been surveyed yet");
}

static enum day_state load_step_state(const struct day_status *f, char reason[240])
{
    char at[9];
    if (!is_surveyed(f) && f->is_skipped[DAY_SURVEY])
        return set_reason(reason, DAY_NOT_NEEDED, "no survey to load");
    if (is_surveyed(f) && f->runway_loaded_us)
        return set_reason(reason, DAY_DONE, "the board has survey %lld, since %s",
                          (long long)f->survey, format_clock(f->runway_loaded_us, at));
    return set_reason(reason, DAY_NEXT, "the survey is not loaded into the board");
}

static enum day_state advise_step_state(const struct day_status *f, char reason[240])
{
    if (!f->run)
        return set_reason(reason, DAY_NOT_NEEDED,
                          "no advice yet, because the campaign has no landing");
    if (f->advice_made_us && (!is_surveyed(f) || f->advice_made_us > f->survey_ended_us))
        return set_reason(reason, DAY_DONE, "%s", f->advice);
    return set_reason(reason, DAY_NEXT, "no advice yet on how hard to brake");
}

static enum day_state ready_step_state(const struct day_status *f, char reason[240])
{
    char at[9];
    bool old = f->checks_made_us < f->armed_us || f->checks_made_us < f->calibrated_us ||
               (is_surveyed(f) && f->checks_made_us < f->runway_loaded_us);
    if (!f->checks_made_us)
        return set_reason(reason, DAY_NEXT, "board and sensors are not checked yet");
    format_clock(f->checks_made_us, at);
    if (old)
        return set_reason(reason, DAY_NEXT, "the last check, at %s, was before %s", at,
                          f->checks_made_us < f->armed_us        ? "the last landing"
                          : f->checks_made_us < f->calibrated_us ? "the calibration"
                                                                 : "the loaded survey");
    return f->is_go ? set_reason(reason, DAY_DONE, "go, at %s", at)
                    : set_reason(reason, DAY_NEXT, "no-go at %s: %.180s", at, f->failed_checks);
}

static enum day_state land_step_state(const struct day_status *f, char reason[240])
{
    long long run = (long long)f->run;
    if (!f->is_logging)
        return set_reason(reason, DAY_NEXT, "start the log in another terminal");
    if (is_landing_in_progress(f))
        return set_reason(reason, DAY_NEXT, "RUN %lld: %s", run,
                          mr_landing_state_text((uint8_t)f->state));
    if (f->run && f->armed_us >= f->logging_since_us)
        return set_reason(reason, DAY_NEXT,
                          "RUN %lld is recorded: end the log with Ctrl-C in its terminal", run);
    return set_reason(
        reason, DAY_NEXT,
        "the log runs, but the board is not armed: type arm in the terminal of the log");
}

static void day_plan_make(const struct day_status *f, struct day_plan *plan)
{
    static enum day_state (*const of[DAY_STEPS])(const struct day_status *, char[240]) = {
#define DAY_STEP(NAME, key, text) [DAY_##NAME] = key##_step_state,
        DAY_STEP_TABLE(DAY_STEP)
#undef DAY_STEP
    };
    bool found = false;
    plan->next = DAY_LAND;
    for (enum day_step step = 0; step < DAY_STEPS; step++) {
        plan->state[step] = of[step](f, plan->reason[step]);
        if (plan->state[step] == DAY_NEXT && f->is_skipped[step])
            plan->state[step] = DAY_SKIPPED;
        /* while a log runs, the next step is the landing, even if earlier steps are open */
        if (plan->state[step] == DAY_NEXT && f->is_logging && step != DAY_LAND)
            plan->state[step] = DAY_LATER;
        if (plan->state[step] != DAY_NEXT)
            continue;
        if (found)
            plan->state[step] = DAY_LATER;
        else
            plan->next = step;
        if (found && step == DAY_LAND)
            set_reason(plan->reason[step], DAY_LATER, "needs all steps above");
        found = true;
    }
}

/* ---- the command ---- */

#define NO_CAN          "none"
#define STANDARD_SERIES "standard"

struct request {
    const char *db, *serial, *can;
};

struct day {
    struct request r;
    const struct cli *cli;
    struct store *store;
    struct day_status facts;
    struct day_plan plan;
    bool is_operator_known, has_asked_weight;
    struct error error; /* error of a step; printed and cleared after it */
};

static void refresh_status(struct day *day)
{
    day_status_read(day->store, (int64_t)link_now_us(), &day->facts);
    day_plan_make(&day->facts, &day->plan);
}

/* Makes the command line of a step. Returns false if the step asks questions or runs several
 * commands. */
static bool make_step_command_line(const struct day *day, enum day_step step,
                                   struct command_line *line)
{
    static char landing[24], page[4200];
    const struct day_status *f = &day->facts;
    const char *can = strcmp(f->can, NO_CAN) == 0 ? NULL : f->can, *db = day->r.db;
    switch (step) {
    case DAY_LOOK:
        snprintf(landing, sizeof landing, "%lld", (long long)f->run);
        *line = day_make_command_line("show", db);
        day_add_word(line, landing);
        return true;
    case DAY_SURVEY: /* use the same edges as the last survey */
        *line = day_make_command_line("survey", db);
        day_add_option(line, "--edges", f->edges);
        return true;
    case DAY_LOAD:
        *line = day_make_command_line("survey", db);
        day_add_option(line, "--load", f->serial);
        return true;
    case DAY_ADVISE:
        *line = day_make_command_line("advise", db);
        day_add_word(line, "--keep");
        day_add_word(line, "--load");
        day_add_option(line, "--serial", f->serial);
        return true;
    case DAY_READY:
        *line = day_make_command_line("ready", db);
        day_add_option(line, "--serial", f->serial);
        day_add_option(line, "--can", can);
        return true;
    case DAY_LAND:
        snprintf(page, sizeof page, "%s-landing.html", db);
        *line = day_make_command_line("log", NULL);
        day_add_option(line, "--serial", f->serial);
        day_add_option(line, "--can", can);
        day_add_option(line, "--db", db);
        day_add_option(line, "--page", page);
        return true;
    default: return false;
    }
}

/* ---- steps ---- */

/* Checks a LINK and copies it. Returns false if it is not valid. */
static bool ask_link(struct day *day, const char *given, enum link_kind kind, char into[200])
{
    bool none = strcmp(given, NO_CAN) == 0 && kind == LINK_CAN;
    if (!none && link_check(given, &day->error) != MR_OK)
        return false;
    if (strlen(given) >= 200) {
        error_set(&day->error, MR_TOO_LONG,
                  "link too long: '%.60s...'; give at most 199 characters", given);
        return false;
    }
    memcpy(into, given, strlen(given) + 1);
    return true;
}

static bool ask_missing_links(struct day *day)
{
    struct day_status *f = &day->facts;
    char text[200];
    if (!f->serial[0] &&
        (!day_ask("the board's serial port (such as serial:/dev/ttyUSB0): ", text, sizeof text) ||
         !text[0] || !ask_link(day, text, LINK_SERIAL, f->serial)))
        return false;
    return f->can[0] ||
           (day_ask("the board's CAN bus (such as can:can0; Enter: none): ", text, sizeof text) &&
            ask_link(day, text[0] ? text : NO_CAN, LINK_CAN, f->can));
}

/* Asks once a day for the operator's name. The commands that are started read it from USER. */
static bool ask_operator(struct day *day)
{
    char question[140], name[64];
    struct store_series *rows = NULL;
    size_t count = 0;
    if (day->is_operator_known)
        return true;
    store_all_series_get(day->store, &rows, &count, fatal);
    if (count && rows[count - 1].made_us >= compute_local_midnight_us(day->facts.now_us))
        snprintf(name, sizeof name, "%.63s", rows[count - 1].who);
    else
        name[0] = '\0';
    free(rows);
    snprintf(question, sizeof question, "operator (Enter: %.60s): ", annotation_author(NULL));
    if (!name[0] && !day_ask(question, name, sizeof name))
        return false;
    if (name[0])
        setenv("USER", name, 1);
    day->is_operator_known = true;
    return true;
}

/* Copies the aircraft's weight from an earlier landing of the day; if there is none, asks for
 * it. */
static bool ask_weight(struct day *day)
{
    struct store_landing landing;
    char weight[STORE_JOURNAL_TEXT_SIZE] = "", run_text[24], correction[sizeof weight + 20];
    int64_t run_number = day->facts.run;
    store_change_get(day->store, run_number, "weight_lb", weight, NULL, fatal);
    if (weight[0])
        return true;
    while (!weight[0] && --run_number > 0) {
        struct error none = {0};
        if (store_landing_get(day->store, run_number, &landing, &none) != MR_OK ||
            landing.armed_us < compute_local_midnight_us(day->facts.now_us))
            break;
        store_change_get(day->store, run_number, "weight_lb", weight, NULL, fatal);
    }
    if (!weight[0] && !day->has_asked_weight &&
        !day_ask("weight of the aircraft (such as 1300 lb; Enter: the value of the board): ",
                 weight, 40))
        return false;
    day->has_asked_weight = true;
    if (!weight[0])
        return true;
    snprintf(run_text, sizeof run_text, "%lld", (long long)day->facts.run);
    snprintf(correction, sizeof correction, "weight_lb=%s", weight);
    struct command_line line = day_make_command_line("landing", day->r.db);
    day_add_word(&line, run_text);
    day_add_option(&line, "--correct", correction);
    day_add_option(&line, "--reason", "weight of the day");
    day_run_command_line(&line, &day->error);
    return true;
}

/* Asks for the station and the number of panels of each wave that was observed. */
static bool ask_waves(struct day *day)
{
    char run_text[24], station[40], panels[40];
    snprintf(run_text, sizeof run_text, "%lld", (long long)day->facts.run);
    for (;;) {
        if (!day_ask("station of a wave in the mat, ft (Enter: no further wave): ", station,
                     sizeof station))
            return false;
        if (!station[0])
            return true;
        if (!day_ask("number of panels in the wave (the gear can cross a wave of 2 panels; Enter: "
                     "not counted): ",
                     panels, sizeof panels))
            return false;
        struct command_line line = day_make_command_line("landing", day->r.db);
        day_add_word(&line, run_text);
        day_add_option(&line, "--observe", "wave");
        day_add_option(&line, "--station", station);
        day_add_option(&line, "--panels", panels);
        day_run_command_line(&line, &day->error);
    }
}

static void run_note_step(struct day *day)
{
    struct command_line line;
    struct store_change note = {.run = day->facts.run, .field = "note"};
    if (!day->facts.run)
        return;
    make_step_command_line(day, DAY_LOOK, &line);
    day_run_command_line(&line, &day->error);
    printf("Enter: no answer, or the value in brackets; q ends the questions\n");
    if (!ask_operator(day) || !ask_weight(day) || !ask_waves(day))
        return;
    day_ask_records(day->store, day->r.db, day->facts.run, &day->error);
    if (!day_ask("other observations (Enter: no note): ", note.value, sizeof note.value) ||
        !note.value[0])
        return;
    note.made_us = (int64_t)link_now_us();
    annotation_copy(note.who, sizeof note.who, annotation_author(NULL));
    store_change_add(day->store, &note, &day->error);
}

static void run_series_step(struct day *day)
{
    struct store_series row = {.made_us = (int64_t)link_now_us()};
    if (!day_ask("name of the series of landings (subject of the test): ", row.name,
                 sizeof row.name) ||
        !row.name[0] ||
        !day_ask("state of the runway (such as 'relaid, bands tensioned'; Enter: no note): ",
                 row.runway, sizeof row.runway) ||
        !day_ask("pattern of the mats (Enter: no note): ", row.pattern, sizeof row.pattern) ||
        !ask_operator(day))
        return;
    annotation_copy(row.who, sizeof row.who, annotation_author(NULL));
    if (store_series_add(day->store, &row, &day->error) == MR_OK)
        printf("landings recorded from now on belong to the series\n");
}

static void run_calibrate_step(struct day *day)
{
    char channel[16], file[4200];
    if (day->facts.calibration_due)
        printf("%s\n", day->facts.failed_checks);
    snprintf(file, sizeof file, "%s-calibrated.cfg", day->r.db);
    while (day_ask("channel to calibrate (d1 to d8, t1 to t14; Enter: no further channel): ",
                   channel, sizeof channel) &&
           channel[0]) {
        struct command_line line = day_make_command_line("calibrate", channel);
        remove(file);
        day_add_option(&line, "--serial", day->facts.serial);
        day_add_option(&line, "-o", file);
        if (!day_run_command_line(&line, &day->error))
            continue;
        line = day_make_command_line("board", NULL);
        day_add_option(&line, "--serial", day->facts.serial);
        day_add_word(&line, "config");
        day_add_option(&line, "set", file);
        day_add_option(&line, "--db", day->r.db);
        if (day_run_command_line(&line, &day->error))
            day->facts.calibrated_us = (int64_t)link_now_us();
    }
}

static void run_advise_step(struct day *day)
{
    struct command_line line;
    char speed[40], deceleration[40];
    make_step_command_line(day, DAY_ADVISE, &line);
    if (!day_ask("planned speed at touchdown (such as 35ft/s; Enter: as in the last landing): ",
                 speed, sizeof speed) ||
        !day_ask("planned mean deceleration (such as 4.5ft/s2; Enter: as in the last landing): ",
                 deceleration, sizeof deceleration))
        return;
    day_add_option(&line, "--speed", speed);
    day_add_option(&line, "--deceleration", deceleration);
    day_run_command_line(&line, &day->error);
}

static void run_land_step(struct day *day)
{
    struct command_line line;
    make_step_command_line(day, DAY_LAND, &line);
    char *text = day_format_command_line(&line);
    if (day->facts.is_logging)
        printf("%s\n", day->plan.reason[DAY_LAND]);
    else
        printf("run the following command in another terminal; type arm there to arm the board, "
               "and press Ctrl-C there to end the log:\n$ %s --commands\n",
               text);
    free(text);
}

static void run_step(struct day *day, enum day_step step)
{
    struct command_line line;
    bool needs_links = step == DAY_CALIBRATE || step == DAY_LOAD || step == DAY_ADVISE ||
                       step == DAY_READY || step == DAY_LAND;
    if (needs_links && !ask_missing_links(day))
        return;
    switch (step) {
    case DAY_LOOK: run_note_step(day); return;
    case DAY_SERIES: run_series_step(day); return;
    case DAY_CALIBRATE: run_calibrate_step(day); return;
    case DAY_ADVISE: run_advise_step(day); return;
    case DAY_LAND: run_land_step(day); return;
    default: make_step_command_line(day, step, &line); day_run_command_line(&line, &day->error);
    }
}

static void write_report(struct day *day)
{
    char page[4200];
    struct command_line line = day_make_command_line("report", day->r.db);
    snprintf(page, sizeof page, "%s-report.html", day->r.db);
    day_add_option(&line, "-o", page);
    day_run_command_line(&line, &day->error);
}

/* ---- the checklist ---- */

static void print_list(const struct day *day)
{
    const struct day_status *f = &day->facts;
    const struct day_plan *plan = &day->plan;
    struct command_line line;
    printf("\n%s: %lld landing%s today%s%s\n", day->r.db, (long long)f->landings_today,
           f->landings_today == 1 ? "" : "s", f->series[0] ? ", series " : "", f->series);
    for (enum day_step step = 0; step < DAY_STEPS; step++)
        printf("%c %d %-10s %-11s %s\n", step == plan->next ? '>' : ' ', (int)step + 1,
               step_texts[step].key, state_text(plan->state[step]), plan->reason[step]);
    printf("Enter: %s: %s\n", step_texts[plan->next].key, step_texts[plan->next].text);
    if (make_step_command_line(day, plan->next, &line)) {
        char *text = day_format_command_line(&line);
        printf("       %s\n", text);
        free(text);
    }
}

static int run_day(struct day *day)
{
    char key[8];
    for (;; refresh_status(day)) {
        print_list(day);
        if (!day_ask("Enter: next step, 1-8: that step, s: skip, r: report, q: quit > ", key,
                     sizeof key))
            break;
        /* read the facts again, because the prompt may have waited for an hour */
        refresh_status(day);
        if (key[0] >= '1' && key[0] < '1' + DAY_STEPS)
            run_step(day, (enum day_step)(key[0] - '1'));
        else if (!key[0])
            run_step(day, day->plan.next);
        else if (key[0] == 's')
            day->facts.is_skipped[day->plan.next] = day->plan.next != DAY_LAND;
        else if (key[0] == 'r')
            write_report(day);
        day_print_error(&day->error);
    }
    return 0;
}

static int show_day(const struct day *day)
{
    struct command_line line;
    struct answer *answer = answer_new(false);
    answer_add_text(answer, "db", NULL, "%s", day->r.db);
    answer_add_text(answer, "next", NULL, "%s", step_texts[day->plan.next].key);
    answer_add_text(answer, "reason", NULL, "%s", day->plan.reason[day->plan.next]);
    char *text = make_step_command_line(day, day->plan.next, &line) ? day_format_command_line(&line)
                                                                    : NULL;
    answer_add_text_or_missing(answer, "command", NULL, text, NULL);
    free(text);
    answer_add_flag(answer, "logging", NULL, day->facts.is_logging);
    answer_add_count(answer, "run", NULL, day->facts.run);
    answer_add_count(answer, "landings_today", NULL, day->facts.landings_today);
    answer_open_table(answer, "steps", "");
    for (enum day_step step = 0; step < DAY_STEPS; step++) {
        answer_open_row(answer);
        answer_add_text(answer, "step", NULL, "%s", step_texts[step].key);
        answer_add_text(answer, "state", NULL, "%s", state_text(day->plan.state[step]));
        answer_add_text(answer, "reason", NULL, "%s", day->plan.reason[step]);
    }
    answer_close_group(answer);
    return answer_print(day->cli, answer, 0);
}

/* Asks before a new campaign is created, because the name may be mistyped. */
static bool confirm_new_campaign(const char *db)
{
    struct stat there;
    char key[8];
    if (stat(db, &there) == 0)
        return true;
    printf("%s does not exist. ", db);
    return day_ask("Begin a new campaign? y: ", key, sizeof key) && key[0] == 'y';
}

static int day_command(int argc, char **argv, const struct cli *cli)
{
    static struct day day;
    day.cli = cli;
    command_parse(&command_day, argc, argv, cli, &day.r, &day.r.db, fatal);
    setvbuf(stdin, NULL, _IONBF, 0);
    if (!cli->json && !confirm_new_campaign(day.r.db))
        error_set(fatal, MR_USAGE, "the campaign %s does not exist, and none was created",
                  day.r.db);
    day.store = program_open_campaign(day.r.db, cli->json ? STORE_READ : STORE_CREATE);
    if (day.r.serial)
        ask_link(&day, day.r.serial, LINK_SERIAL, day.facts.serial);
    if (day.r.can)
        ask_link(&day, day.r.can, LINK_CAN, day.facts.can);
    if (day.error.status != MR_OK)
        return cli_fail(&day.error);
    refresh_status(&day);
    return cli->json ? show_day(&day) : run_day(&day);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database; created if missing"),
    HELP_NOTE(
        "Steps: look (inspect the mat), series, calibrate, survey, load (send the survey to the "
        "board), advise, ready, land. The Enter key runs the next step; 1 to 8 run the step of "
        "that number; s skips the next step until after the landing; r writes the report; q quits. "
        "The log runs in a separate terminal, with the command that the checklist shows."),
    OPTION_TEXT(
        "--serial", "LINK", serial,
        "the board's serial port; default: that of the last log, otherwise the program asks"),
    OPTION_TEXT("--can", "LINK", can, "the board's CAN bus, or none; default: as for --serial"),
    HELP_NOTE("--json prints the completed steps and the next step as one object."),
    HELP_EXAMPLE("matrig day campaign.db --serial serial:/dev/ttyUSB0 --can can:can0"),
};

const struct command command_day = {
    "day",
    day_command,
    "DB [--serial LINK] [--can LINK]",
    "checklist of a test day: completed steps and the next step, with reasons",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
