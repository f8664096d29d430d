#include "host/day/day.h"

#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/catalogue.h"
#include "host/base/xmalloc.h"
#include "host/store/store_journal.h"
#include "host/store/store_readiness.h"
#include "host/survey/survey.h"

/* ---- facts ---- */

static int64_t midnight_us(int64_t now_us)
{
    time_t s = (time_t)(now_us / 1000000);
    struct tm day;
    localtime_r(&s, &day);
    day.tm_hour = day.tm_min = day.tm_sec = 0;
    day.tm_isdst = -1;
    return (int64_t)mktime(&day) * 1000000;
}

/* The links of the newest log are used again. */
static enum mr_status read_links(struct store *store, struct day_facts *f, struct error *error)
{
    struct store_session_row row = {0};
    int64_t session = 0;
    enum mr_status status = store_day_session(store, &session, error);
    if (status == MR_OK && session)
        status = store_session_get(store, session, &row, error);
    if (status != MR_OK || !session)
        return status;
    f->logging_since_us = row.started_us;
    if (!f->serial[0] && row.serial_link[0]) {
        snprintf(f->serial, sizeof f->serial, "%.199s", row.serial_link);
        if (!f->can[0])
            snprintf(f->can, sizeof f->can, "%.199s", row.can_link[0] ? row.can_link : "none");
    }
    return MR_OK;
}

static enum mr_status read_landings(struct store *store, struct day_facts *f, struct error *error)
{
    struct store_landing landing;
    char note[STORE_JOURNAL_TEXT];
    enum mr_status status = store_day_newest(store, &f->run, error);
    if (status == MR_OK)
        status = store_day_count(store, midnight_us(f->now_us), &f->today, error);
    if (status != MR_OK || !f->run)
        return status;
    status = store_landing_get(store, f->run, &landing, error);
    if (status == MR_OK)
        status = store_change_get(store, f->run, "note", note, NULL, error);
    if (status != MR_OK)
        return status;
    f->armed_us = landing.armed_us;
    f->state = (int)landing.state;
    f->noted = note[0] != '\0';
    return MR_OK;
}

static enum mr_status read_series(struct store *store, struct day_facts *f, struct error *error)
{
    struct store_series *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_series_all(store, &rows, &count, error);
    if (status == MR_OK && count)
        memcpy(f->series, rows[count - 1].name, sizeof f->series);
    free(rows);
    return status;
}

static enum mr_status read_survey(struct store *store, struct day_facts *f, struct error *error)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_gage_surveys(store, &rows, &count, error);
    if (status == MR_OK && count) {
        const struct store_gage_survey *row = &rows[count - 1];
        struct survey *survey = xmalloc(sizeof *survey);
        f->survey = row->id;
        f->survey_ended_us = row->ended_us;
        f->survey_us = row->made_us;
        memcpy(f->edges, row->edges, sizeof f->edges);
        status = survey_get(store, row->id, survey, error);
        if (status == MR_OK) {
            f->survey_read = survey_desk_read(&survey->desk);
            f->survey_of = survey->desk.plan.count;
            status = store_gage_loaded(store, row->id, &f->loaded_us, error);
        }
        free(survey);
    }
    free(rows);
    return status;
}

static enum mr_status read_advice(struct store *store, struct day_facts *f, struct error *error)
{
    struct store_advice *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_advices(store, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (rows[i].made_us < f->armed_us)
            continue;
        f->advised_us = rows[i].made_us;
        memcpy(f->advice, rows[i].verdict, sizeof f->advice);
    }
    free(rows);
    return status;
}

/* The first check that is a no-go, and whether it is one of calibrations. */
static void read_checks(const char *checks, struct day_facts *f)
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
        if (!f->no_go[0] || (due && !f->calibration_due))
            snprintf(f->no_go, sizeof f->no_go, "%.40s: %.140s", name, value ? value : "");
        f->calibration_due |= due;
    }
    json_decref(object);
}

static enum mr_status read_ready(struct store *store, struct day_facts *f, struct error *error)
{
    char uid[25];
    struct store_readiness row = {0};
    bool found = false;
    enum mr_status status = store_board_newest(store, uid, error);
    if (status == MR_OK && uid[0])
        status = store_readiness_get(store, uid, "ready", f->now_us, true, &row, &found, error);
    if (status != MR_OK || !found)
        return status;
    f->ready_us = row.made_us;
    f->go = strcmp(row.verdict, "go") == 0;
    if (!f->go)
        read_checks(row.checks, f);
    free(row.checks);
    return MR_OK;
}

enum mr_status day_facts_read(struct store *store, int64_t now_us, struct day_facts *f,
                              struct error *error)
{
    const struct day_facts was = *f;
    *f = (struct day_facts){.now_us = now_us};
    memcpy(f->serial, was.serial, sizeof f->serial);
    memcpy(f->can, was.can, sizeof f->can);
    /* the lock of the log first: a log that begins now is seen by the next reading */
    f->logging = store_is_logged(store);
    enum mr_status status = read_links(store, f, error);
    if (status == MR_OK)
        status = read_landings(store, f, error);
    if (status == MR_OK)
        status = read_series(store, f, error);
    if (status == MR_OK)
        status = read_survey(store, f, error);
    if (status == MR_OK)
        status = read_advice(store, f, error);
    if (status == MR_OK)
        status = read_ready(store, f, error);
    if (f->run == was.run) {
        f->calibrated_us = was.calibrated_us;
        memcpy(f->skipped, was.skipped, sizeof f->skipped);
    }
    return status;
}

/* ---- plan ---- */

const struct day_word day_step_words[DAY_STEPS] = {
#define DAY_STEP(NAME, key, text) [DAY_##NAME] = {#key, text},
    DAY_STEPS_EACH(DAY_STEP)
#undef DAY_STEP
};

const char *day_state_text(enum day_state state)
{
    static const char *const text[] = {[DAY_DONE] = "done",
                                       [DAY_NEXT] = "next",
                                       [DAY_LATER] = "later",
                                       [DAY_SKIPPED] = "skipped",
                                       [DAY_NOT_NEEDED] = "not needed"};
    return text[state];
}

/* A step's state without regard to the steps before it, and the reason. */
static enum day_state because(char reason[240], enum day_state state, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static enum day_state because(char reason[240], enum day_state state, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(reason, 240, format, arguments);
    va_end(arguments);
    return state;
}

static const char *clock_text(int64_t us, char out[9])
{
    time_t s = (time_t)(us / 1000000);
    struct tm at;
    localtime_r(&s, &at);
    snprintf(out, 9, "%02d:%02d", at.tm_hour % 100, at.tm_min % 100);
    return out;
}

static bool is_going_on(const struct day_facts *f)
{
    return f->run && (f->state == MR_LANDING_ARMED || f->state == MR_LANDING_LANDING ||
                      f->state == MR_LANDING_SETTLING);
}

static enum day_state look(const struct day_facts *f, char reason[240])
{
    if (!f->run)
        return because(reason, DAY_NOT_NEEDED, "no landing yet");
    if (f->noted)
        return because(reason, DAY_DONE, "landing %lld has a note", (long long)f->run);
    if (f->logging && is_going_on(f))
        return because(reason, DAY_NOT_NEEDED, "landing %lld is not over", (long long)f->run);
    if (is_going_on(f))
        return because(reason, DAY_NEXT,
                       "landing %lld was cut off while it was %s: matrig board list shows whether "
                       "the board has the rest of it",
                       (long long)f->run, mr_landing_state_text((uint8_t)f->state));
    return because(reason, DAY_NEXT, "landing %lld has no note", (long long)f->run);
}

static enum day_state series(const struct day_facts *f, char reason[240])
{
    return f->series[0] ? because(reason, DAY_DONE, "%.80s", f->series)
                        : because(reason, DAY_NEXT, "the campaign has no series");
}

static enum day_state calibrate(const struct day_facts *f, char reason[240])
{
    if (f->calibration_due && f->calibrated_us < f->ready_us)
        return because(reason, DAY_NEXT, "%.200s", f->no_go);
    return f->calibrated_us ? because(reason, DAY_DONE, "calibrated since the last check")
                            : because(reason, DAY_NOT_NEEDED, "ready reports when it is due");
}

static bool is_surveyed(const struct day_facts *f)
{
    return f->survey && f->survey_ended_us != STORE_NONE && f->survey_us >= f->armed_us;
}

static enum day_state survey(const struct day_facts *f, char reason[240])
{
    char at[9];
    if (f->survey && f->survey_ended_us == STORE_NONE)
        return because(reason, DAY_NEXT, "survey %lld is not finished: %zu of %zu read",
                       (long long)f->survey, f->survey_read, f->survey_of);
    if (is_surveyed(f))
        return because(reason, DAY_DONE, "survey %lld, ended %s", (long long)f->survey,
                       clock_text(f->survey_ended_us, at));
    return f->run ? because(reason, DAY_NEXT, "the mat has not been read since landing %lld",
                            (long long)f->run)
                  : because(reason, DAY_NEXT, "the mat has not been read yet");
}

static enum day_state load(const struct day_facts *f, char reason[240])
{
    char at[9];
    if (!is_surveyed(f) && f->skipped[DAY_SURVEY])
        return because(reason, DAY_NOT_NEEDED, "no survey to load");
    if (is_surveyed(f) && f->loaded_us)
        return because(reason, DAY_DONE, "the board has survey %lld, since %s",
                       (long long)f->survey, clock_text(f->loaded_us, at));
    return because(reason, DAY_NEXT, "the board does not have the survey");
}

static enum day_state advise(const struct day_facts *f, char reason[240])
{
    if (!f->run)
        return because(reason, DAY_NOT_NEEDED, "it learns from landings, and there is none yet");
    if (f->advised_us && (!is_surveyed(f) || f->advised_us > f->survey_ended_us))
        return because(reason, DAY_DONE, "%s", f->advice);
    return because(reason, DAY_NEXT, "no advice on how hard to brake yet");
}

static enum day_state ready(const struct day_facts *f, char reason[240])
{
    char at[9];
    bool old = f->ready_us < f->armed_us || f->ready_us < f->calibrated_us ||
               (is_surveyed(f) && f->ready_us < f->loaded_us);
    if (!f->ready_us)
        return because(reason, DAY_NEXT, "board and sensors are not checked yet");
    clock_text(f->ready_us, at);
    if (old)
        return because(reason, DAY_NEXT, "the last check, at %s, predates %s", at,
                       f->ready_us < f->armed_us        ? "the last landing"
                       : f->ready_us < f->calibrated_us ? "the calibration"
                                                        : "the loaded survey");
    return f->go ? because(reason, DAY_DONE, "go, at %s", at)
                 : because(reason, DAY_NEXT, "no-go at %s: %.180s", at, f->no_go);
}

static enum day_state land(const struct day_facts *f, char reason[240])
{
    long long run = (long long)f->run;
    if (!f->logging)
        return because(reason, DAY_NEXT, "start the log in another terminal");
    if (is_going_on(f))
        return because(reason, DAY_NEXT, "landing %lld: %s", run,
                       mr_landing_state_text((uint8_t)f->state));
    if (f->run && f->armed_us >= f->logging_since_us)
        return because(reason, DAY_NEXT, "landing %lld is recorded: end the log (Ctrl-C there)",
                       run);
    return because(reason, DAY_NEXT, "the log runs, nothing is armed: type arm there");
}

void day_plan_make(const struct day_facts *f, struct day_plan *plan)
{
    static enum day_state (*const of[DAY_STEPS])(const struct day_facts *, char[240]) = {
        [DAY_LOOK] = look,     [DAY_SERIES] = series, [DAY_CALIBRATE] = calibrate,
        [DAY_SURVEY] = survey, [DAY_LOAD] = load,     [DAY_ADVISE] = advise,
        [DAY_READY] = ready,   [DAY_LAND] = land};
    bool found = false;
    plan->next = DAY_LAND;
    for (enum day_step step = 0; step < DAY_STEPS; step++) {
        plan->state[step] = of[step](f, plan->reason[step]);
        if (plan->state[step] == DAY_NEXT && f->skipped[step])
            plan->state[step] = DAY_SKIPPED;
        /* while a log runs, the landing is next, whatever is open before it */
        if (plan->state[step] == DAY_NEXT && f->logging && step != DAY_LAND)
            plan->state[step] = DAY_LATER;
        if (plan->state[step] != DAY_NEXT)
            continue;
        if (found)
            plan->state[step] = DAY_LATER;
        else
            plan->next = step;
        if (found && step == DAY_LAND)
            because(plan->reason[step], DAY_LATER, "after the steps above");
        found = true;
    }
}
