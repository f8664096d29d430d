#include "host/day/facts.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host/store/store_journal.h"
#include "host/store/store_readiness.h"
#include "host/survey/campaign.h"

static int64_t midnight_us(int64_t now_us)
{
    time_t s = (time_t)(now_us / 1000000);
    struct tm day;
    localtime_r(&s, &day);
    day.tm_hour = day.tm_min = day.tm_sec = 0;
    day.tm_isdst = -1;
    return (int64_t)mktime(&day) * 1000000;
}

static enum mr_status read_landings(struct store *store, struct day_facts *f, struct error *error)
{
    struct store_landing landing;
    enum mr_status status = store_day_newest(store, &f->run, error);
    if (status == MR_OK)
        status = store_day_count(store, midnight_us(f->now_us), &f->today, error);
    if (status != MR_OK || !f->run)
        return status;
    status = store_landing_get(store, f->run, &landing, error);
    f->armed_us = landing.armed_us;
    f->state = (int)landing.state;
    return status;
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
        struct survey *survey = malloc(sizeof *survey);
        if (!survey)
            abort();
        f->survey = row->id;
        f->survey_ended_us = row->ended_us;
        f->survey_us = row->made_us;
        memcpy(f->pattern, row->pattern, sizeof f->pattern);
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

/* The first check that is a no-go, and whether it is of calibrations. */
static void take_checks(const char *checks, struct day_facts *f)
{
    json_t *object = json_loads(checks, 0, NULL), *check;
    size_t i;
    json_array_foreach(json_object_get(object, "checks"), i, check)
    {
        const char *name = json_string_value(json_object_get(check, "name")),
                   *said = json_string_value(json_object_get(check, "value")),
                   *state = json_string_value(json_object_get(check, "verdict"));
        if (!name || !state || strcmp(state, "NO-GO") != 0)
            continue;
        bool due = strcmp(name, "calibration") == 0;
        if (!f->no_go[0] || (due && !f->calibration_due))
            snprintf(f->no_go, sizeof f->no_go, "%.40s: %.140s", name, said ? said : "");
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
        take_checks(row.checks, f);
    free(row.checks);
    return MR_OK;
}

static enum mr_status read_words(struct store *store, struct day_facts *f, struct error *error)
{
    struct store_day_word *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_day_words(store, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        const struct store_day_word *w = &rows[i];
        enum day_step step = day_step_find(w->value);
        if (strcmp(w->word, "serial") == 0)
            snprintf(f->serial, sizeof f->serial, "%.199s", w->value);
        if (strcmp(w->word, "can") == 0)
            snprintf(f->can, sizeof f->can, "%.199s", w->value);
        if (strcmp(w->word, "calibrated") == 0)
            f->calibrated_us = w->made_us;
        if (w->after_run != f->run)
            continue;
        f->looked |= strcmp(w->word, "looked") == 0;
        if (strcmp(w->word, "skip") == 0 && step < DAY_STEPS)
            f->skipped[step] = true;
    }
    free(rows);
    return status;
}

enum mr_status day_facts_read(struct store *store, int64_t now_us, struct day_facts *f,
                              struct error *error)
{
    *f = (struct day_facts){.now_us = now_us, .logging = f->logging};
    enum mr_status status = read_landings(store, f, error);
    if (status == MR_OK)
        status = read_series(store, f, error);
    if (status == MR_OK)
        status = read_survey(store, f, error);
    if (status == MR_OK)
        status = read_advice(store, f, error);
    if (status == MR_OK)
        status = read_ready(store, f, error);
    return status == MR_OK ? read_words(store, f, error) : status;
}

enum mr_status day_say(struct store *store, const struct day_facts *f, const char *who,
                       const char *word, const char *value, struct error *error)
{
    struct store_day_word row = {.made_us = f->now_us, .after_run = f->run};
    snprintf(row.who, sizeof row.who, "%s", who ? who : "");
    snprintf(row.word, sizeof row.word, "%s", word);
    snprintf(row.value, sizeof row.value, "%s", value ? value : "");
    return store_day_word_add(store, &row, error);
}
