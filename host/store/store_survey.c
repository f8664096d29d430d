#include "host/store/store_survey.h"

#include <stdlib.h>

#include "host/store/store_sql.h"

enum mr_status store_durable(struct store *store, struct error *error)
{
    return sqlite3_exec(store->database, "PRAGMA synchronous=FULL", NULL, NULL, NULL) == SQLITE_OK
               ? MR_OK
               : store_failed(store, "set up", error);
}

enum mr_status store_gage_survey_add(struct store *store, struct store_gage_survey *survey, struct error *error)
{
    enum mr_status status = store_run(store, error, STORE_GAGE_SURVEY_ADD, survey->made_us, survey->pattern, survey->edges, survey->who,
                                      survey->error_in, survey->closed_in, survey->note);
    survey->id = sqlite3_last_insert_rowid(store->database);
    return status;
}

enum mr_status store_gage_survey_end(struct store *store, int64_t survey, int64_t ended_us, struct error *error)
{
    return store_run(store, error, STORE_GAGE_SURVEY_END, ended_us, survey);
}

/* Room for one more of `size` bytes behind `count`; doubled. */
static void *grown(void *rows, size_t count, size_t size)
{
    if (count & (count - 1))
        return rows;
    void *more = realloc(rows, (count ? 2 * count : 1) * size);
    if (!more)
        abort();
    return more;
}

enum mr_status store_gage_surveys(struct store *store, struct store_gage_survey **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *s;
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &s, STORE_GAGE_SURVEYS);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        *rows = grown(*rows, *count, sizeof **rows);
        struct store_gage_survey *row = &(*rows)[(*count)++];
        row->id = store_integer(s, 0);
        row->made_us = store_integer(s, 1);
        row->ended_us = store_integer(s, 2);
        store_text(s, 3, row->pattern, sizeof row->pattern);
        store_text(s, 4, row->edges, sizeof row->edges);
        store_text(s, 5, row->who, sizeof row->who);
        row->error_in = store_real(s, 6);
        row->closed_in = store_real(s, 7);
        store_text(s, 8, row->note, sizeof row->note);
        row->after_run = store_integer(s, 9);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_gage_reading_add(struct store *store, int64_t survey, const struct store_gage_reading *r, struct error *error)
{
    return store_run(store, error, STORE_GAGE_READING_ADD, survey, r->kind, r->line, r->place, r->value_in, r->skipped, r->confirmed,
                     r->taken_us, r->source, r->note[0] ? r->note : NULL);
}

enum mr_status store_gage_readings(struct store *store, int64_t survey, struct store_gage_reading **rows, size_t *count,
                                   struct error *error)
{
    sqlite3_stmt *s;
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &s, STORE_GAGE_READINGS, survey);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        *rows = grown(*rows, *count, sizeof **rows);
        struct store_gage_reading *row = &(*rows)[(*count)++];
        store_text(s, 0, row->kind, sizeof row->kind);
        row->line = store_integer(s, 1);
        row->place = store_integer(s, 2);
        row->value_in = store_real(s, 3);
        row->skipped = store_integer(s, 4);
        row->confirmed = store_integer(s, 5);
        row->taken_us = store_integer(s, 6);
        store_text(s, 7, row->source, sizeof row->source);
        store_text(s, 8, row->note, sizeof row->note);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_gage_load_add(struct store *store, int64_t survey, int64_t made_us, const char *link, int64_t segments,
                                   struct error *error)
{
    return store_run(store, error, STORE_GAGE_LOAD_ADD, survey, made_us, link, segments);
}

enum mr_status store_gage_load_get(struct store *store, int64_t survey, struct store_gage_load *load, struct error *error)
{
    sqlite3_stmt *s;
    *load = (struct store_gage_load){.made_us = STORE_NONE};
    enum mr_status status = store_query(store, error, &s, STORE_GAGE_LOAD_GET, survey);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    load->made_us = store_integer(s, 0);
    store_text(s, 1, load->link, sizeof load->link);
    load->segments = store_integer(s, 2);
    store_reset(s);
    return MR_OK;
}
