#include "host/store/store_journal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

static const char *or_null(const char *text)
{
    return text[0] ? text : NULL;
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

/* What held before: the newest value said, or what the board said. */
static enum mr_status find_was(struct store *store, const struct store_change *change, char was[STORE_JOURNAL_TEXT], struct error *error)
{
    struct store_landing landing;
    enum mr_status status = store_landing_get(store, change->run, &landing, error);
    was[0] = '\0';
    if (status == MR_OK && strcmp(change->field, "note") != 0)
        status = store_change_get(store, change->run, change->field, was, NULL, error);
    if (status == MR_OK && !was[0] && strcmp(change->field, "touchdown_ft") == 0 && !isnan(landing.touchdown_ft))
        snprintf(was, STORE_JOURNAL_TEXT, "%.10g", landing.touchdown_ft);
    return status;
}

enum mr_status store_change_add(struct store *store, const struct store_change *change, struct error *error)
{
    char was[STORE_JOURNAL_TEXT];
    enum mr_status status = find_was(store, change, was, error);
    return status == MR_OK ? store_run(store, error, STORE_CHANGE_ADD, change->run, change->made_us, or_null(change->who), change->field,
                                       change->value, or_null(change->reason), or_null(was))
                           : status;
}

enum mr_status store_changes(struct store *store, int64_t run, struct store_change **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *s;
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &s, STORE_CHANGES, run);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        *rows = grown(*rows, *count, sizeof **rows);
        struct store_change *row = &(*rows)[(*count)++];
        row->run = store_integer(s, 0);
        row->made_us = store_integer(s, 1);
        store_text(s, 2, row->who, sizeof row->who);
        store_text(s, 3, row->field, sizeof row->field);
        store_text(s, 4, row->was, sizeof row->was);
        store_text(s, 5, row->value, sizeof row->value);
        store_text(s, 6, row->reason, sizeof row->reason);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_change_get(struct store *store, int64_t run, const char *field, char value[STORE_JOURNAL_TEXT],
                                char reason[STORE_JOURNAL_TEXT], struct error *error)
{
    sqlite3_stmt *s;
    value[0] = '\0';
    if (reason)
        reason[0] = '\0';
    enum mr_status status = store_query(store, error, &s, STORE_CHANGE_NEWEST, run, field);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    store_text(s, 0, value, STORE_JOURNAL_TEXT);
    if (reason)
        store_text(s, 1, reason, STORE_JOURNAL_TEXT);
    store_reset(s);
    return MR_OK;
}

enum mr_status store_is_void(struct store *store, int64_t run, bool *is_void, char reason[STORE_JOURNAL_TEXT], struct error *error)
{
    char value[STORE_JOURNAL_TEXT];
    enum mr_status status = store_change_get(store, run, "void", value, reason, error);
    *is_void = strcmp(value, "yes") == 0;
    return status;
}

enum mr_status store_refuse_void(struct store *store, int64_t run, bool allowed, struct error *error)
{
    char reason[STORE_JOURNAL_TEXT];
    bool is_void;
    enum mr_status status = store_is_void(store, run, &is_void, reason, error);
    if (status != MR_OK || !is_void || allowed)
        return status;
    return error_set(error, MR_NOT_NOW, "RUN %lld is void (%s): %s; --void takes it all the same", (long long)run, reason, store->path);
}

enum mr_status store_observation_add(struct store *store, const struct store_observation *o, struct error *error)
{
    return store_run(store, error, STORE_OBSERVATION_ADD, o->run, o->made_us, or_null(o->who), o->kind, or_null(o->side), o->station_ft,
                     o->panels, STORE_NONE, o->height_in, o->time_s, or_null(o->form), or_null(o->note));
}

enum mr_status store_observation_withdraw(struct store *store, int64_t run, int64_t id, int64_t made_us, const char *who,
                                          const char *reason, struct error *error)
{
    struct store_observation *rows;
    size_t count;
    bool there = false, gone = false;
    enum mr_status status = store_observations(store, run, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        there |= rows[i].id == id;
        gone |= rows[i].id == id && rows[i].withdrawn;
    }
    free(rows);
    if (status == MR_OK && (!there || gone))
        status = error_set(error, MR_UNKNOWN, "no observation %lld to withdraw: RUN %lld of %s; matrig landing DB RUN lists them", (long long)id,
                           (long long)run, store->path);
    return status == MR_OK ? store_run(store, error, STORE_OBSERVATION_ADD, run, made_us, or_null(who), "withdrawal", NULL, (double)NAN,
                                       STORE_NONE, id, (double)NAN, (double)NAN, NULL, or_null(reason))
                           : status;
}

enum mr_status store_observations(struct store *store, int64_t run, struct store_observation **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *s;
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &s, STORE_OBSERVATIONS, run);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        *rows = grown(*rows, *count, sizeof **rows);
        struct store_observation *row = &(*rows)[(*count)++];
        row->id = store_integer(s, 0);
        row->run = run;
        row->made_us = store_integer(s, 1);
        store_text(s, 2, row->who, sizeof row->who);
        store_text(s, 3, row->kind, sizeof row->kind);
        store_text(s, 4, row->side, sizeof row->side);
        row->station_ft = store_real(s, 5);
        row->panels = store_integer(s, 6);
        row->height_in = store_real(s, 7);
        row->time_s = store_real(s, 8);
        store_text(s, 9, row->form, sizeof row->form);
        store_text(s, 10, row->note, sizeof row->note);
        row->withdrawn = store_integer(s, 11) != 0;
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_series_add(struct store *store, const struct store_series *s, struct error *error)
{
    return store_run(store, error, STORE_SERIES_ADD, s->made_us, or_null(s->who), s->name, or_null(s->runway), or_null(s->pattern),
                     or_null(s->modification), or_null(s->notes));
}

enum mr_status store_series_all(struct store *store, struct store_series **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *s;
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &s, STORE_SERIES);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        *rows = grown(*rows, *count, sizeof **rows);
        struct store_series *row = &(*rows)[(*count)++];
        row->id = store_integer(s, 0);
        row->made_us = store_integer(s, 1);
        store_text(s, 2, row->who, sizeof row->who);
        store_text(s, 3, row->name, sizeof row->name);
        store_text(s, 4, row->runway, sizeof row->runway);
        store_text(s, 5, row->pattern, sizeof row->pattern);
        store_text(s, 6, row->modification, sizeof row->modification);
        store_text(s, 7, row->notes, sizeof row->notes);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

/* Its own corrections stand for the landing alone. */
static enum mr_status overlay(struct store *store, int64_t run, const char *field, char *into, size_t size, struct error *error)
{
    char value[STORE_JOURNAL_TEXT];
    enum mr_status status = store_change_get(store, run, field, value, NULL, error);
    if (status == MR_OK && value[0])
        snprintf(into, size, "%.*s", (int)size - 1, value);
    return status;
}

enum mr_status store_series_of(struct store *store, const struct store_landing *landing, struct store_series *series, struct error *error)
{
    struct store_series *rows;
    size_t count;
    char name[STORE_JOURNAL_TEXT];
    *series = (struct store_series){0};
    enum mr_status status = store_series_all(store, &rows, &count, error);
    if (status == MR_OK)
        status = store_change_get(store, landing->id, "series", name, NULL, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (name[0] ? strcmp(rows[i].name, name) == 0 : rows[i].made_us <= landing->armed_us)
            *series = rows[i];
    }
    free(rows);
    if (status == MR_OK)
        status = overlay(store, landing->id, "runway", series->runway, sizeof series->runway, error);
    if (status == MR_OK)
        status = overlay(store, landing->id, "pattern", series->pattern, sizeof series->pattern, error);
    if (status == MR_OK)
        status = overlay(store, landing->id, "modification", series->modification, sizeof series->modification, error);
    return status;
}
