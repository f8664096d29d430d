#include "host/sweep/sweep_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/sweep/sweep_results.h"
#include "host/sweep/sweep_share.h"
#include "host/base/list.h"

struct loading {
    struct sweep_table *table;
    const char *path;
};

const json_t *sweep_table_value(const struct table_row *row, const char *key)
{
    return json_object_get(json_object_get(row->line, "values"), key);
}

const json_t *sweep_table_field(const struct table_row *row, const char *field)
{
    return json_object_get(json_object_get(row->line, "result"), field);
}

const char *sweep_table_status(const struct table_row *row)
{
    const char *status = json_string_value(json_object_get(row->line, "status"));
    return status ? status : "";
}

double sweep_table_number(const json_t *value)
{
    if (json_is_boolean(value))
        return json_is_true(value) ? 1.0 : 0.0;
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

/* Keeps the line, without parsing it again: the reader's copy is shared. */
static enum mr_status add_line(void *ctx, size_t number, uint64_t id, const json_t *line,
                               const char *text, struct error *error)
{
    struct loading *l = ctx;
    struct sweep_table *t = l->table;
    size_t index = number;
    (void)text;
    if (t->study.cases && !sweep_study_find(&t->study, id, &index))
        return error_set(error, MR_MALFORMED,
                         "results of another sweep: %s line %zu: a case that is not in the sweep "
                         "beside it; move that one away",
                         l->path, number);
    if (!list_grow(&t->rows, t->count, sizeof *t->rows))
        return error_set(error, MR_FULL, "out of memory: %s: beyond %zu cases; report fewer",
                         l->path, t->count);
    t->rows[t->count++] = (struct table_row){json_incref((json_t *)(uintptr_t)line), index};
    return MR_OK;
}

static int by_index(const void *a, const void *b)
{
    const struct table_row *p = a, *q = b;
    return p->index < q->index ? -1 : p->index > q->index;
}

/* A case that is there twice (files put together by hand): one of them. */
static void drop_repeated(struct sweep_table *table)
{
    size_t kept = 0;
    qsort(table->rows, table->count, sizeof *table->rows, by_index);
    for (size_t i = 0; i < table->count; i++) {
        if (kept > 0 && table->rows[kept - 1].index == table->rows[i].index) {
            json_decref(table->rows[i].line);
            table->repeated++;
        } else {
            table->rows[kept++] = table->rows[i];
        }
    }
    table->count = kept;
}

static bool listed(const json_t *names, const char *name)
{
    for (size_t i = 0; i < json_array_size(names); i++) {
        if (strcmp(json_string_value(json_array_get(names, i)), name) == 0)
            return true;
    }
    return false;
}

static void list_names(json_t *names, const json_t *object)
{
    const char *name;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)object, name, value)
    {
        if (!listed(names, name))
            json_array_append_new(names, json_string(name));
    }
}

static void look_through(struct sweep_table *table)
{
    table->keys = json_array();
    table->fields = json_array();
    for (size_t i = 0; i < table->count; i++) {
        const json_t *line = table->rows[i].line;
        list_names(table->keys, json_object_get(line, "values"));
        list_names(table->fields, json_object_get(line, "result"));
        table->finds |= json_object_get(line, "find") != NULL;
        table->failed += strcmp(sweep_table_status(&table->rows[i]), "ok") != 0;
    }
    table->missing = table->study.cases ? table->study.cases - table->count : 0;
}

enum mr_status sweep_table_load(struct sweep_table *table, const char *path, struct error *error)
{
    char copy[SWEEP_PATH_MAX + 40];
    struct loading loading = {.table = table, .path = path};
    *table = (struct sweep_table){0};
    if (strlen(path) >= SWEEP_PATH_MAX)
        return error_set(error, MR_TOO_LONG, "path too long: %.100s...; give a shorter one", path);
    sweep_study_path(path, copy);
    if (access(copy, F_OK) == 0 && sweep_study_load(&table->study, copy, error) != MR_OK)
        return error->status;
    if (access(path, R_OK) != 0)
        error_set(error, MR_IO, "cannot open results: %s; check path and rights", path);
    if (error->status == MR_OK && sweep_results_read(path, add_line, &loading, error) == MR_OK &&
        table->count == 0)
        error_set(error, MR_TOO_FEW, "no results yet: %s; run matrig sweep first", path);
    if (error->status != MR_OK) {
        sweep_table_free(table);
        return error->status;
    }
    drop_repeated(table);
    look_through(table);
    return MR_OK;
}

void sweep_table_free(struct sweep_table *table)
{
    for (size_t i = 0; i < table->count; i++)
        json_decref(table->rows[i].line);
    free(table->rows);
    json_decref(table->keys);
    json_decref(table->fields);
    sweep_study_free(&table->study);
    *table = (struct sweep_table){0};
}
