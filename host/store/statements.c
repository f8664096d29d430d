/* Statements, prepared at their first use, and run. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/store/store_sql.h"

#define NO_ROW STORE_TABLE_COUNT

static const struct {
    const char *name, *sql;
    enum store_table_number row;
    bool listed;
} statements[STORE_STATEMENT_COUNT] = {
#define LISTED(NAME, row, sql) {#NAME, sql, STORE_TABLE_##row, true},
#define GIVEN(NAME, row, sql)  {#NAME, sql, STORE_TABLE_##row, false},
#define STATEMENT(NAME, sql)   {#NAME, sql, NO_ROW, false},
#include "host/store/queries.def"
};

/* A statement that does not fit what is said of it: nothing that is read or written by it could be
 * trusted. */
static void refuse(const char *name, const char *why)
{
    fprintf(stderr, "matrig: statement %s of host/store: %s\n", name, why);
    abort();
}

static enum mr_status prepare(struct store *store, char *sql, sqlite3_stmt **statement,
                              struct error *error)
{
    int code = sql ? sqlite3_prepare_v3(store->database, sql, -1, SQLITE_PREPARE_PERSISTENT,
                                        statement, NULL)
                   : SQLITE_NOMEM;
    sqlite3_free(sql);
    return code == SQLITE_OK ? MR_OK : store_failed(store, "use", error);
}

static void check_columns(sqlite3_stmt *statement, const struct store_table *table,
                          const char *name)
{
    int at = 0;
    for (unsigned i = 0; i < table->count; i++) {
        const struct store_column *column = &table->columns[i];
        if (column->kind == STORE_OWNER)
            continue;
        const char *is = sqlite3_column_name(statement, at++);
        if (!is || strcmp(is, column->field) != 0)
            refuse(name, "its columns are not those of its struct");
    }
    if (sqlite3_column_count(statement) != at)
        refuse(name, "it has more columns than its struct");
}

static enum mr_status prepare_named(struct store *store, struct error *error,
                                    enum store_statement which)
{
    sqlite3_stmt **statement = &store->statement[which];
    const struct store_table *row = statements[which].row == NO_ROW
                                      ? NULL
                                      : store_table(statements[which].row);
    if (*statement)
        return MR_OK;
    char *list = statements[which].listed ? store_read_text(row) : NULL;
    char *sql = list ? sqlite3_mprintf("SELECT %s FROM %s", list, statements[which].sql)
                     : sqlite3_mprintf("%s", statements[which].sql);
    sqlite3_free(list);
    enum mr_status status = prepare(store, sql, statement, error);
    if (status == MR_OK && row)
        check_columns(*statement, row, statements[which].name);
    return status;
}

static enum mr_status prepare_insert(struct store *store, struct error *error,
                                     enum store_table_number which)
{
    return store->insert[which] ? MR_OK
                                : prepare(store, store_insert_text(store_table(which), 1),
                                          &store->insert[which], error);
}

static enum mr_status prepare_update(struct store *store, struct error *error,
                                     enum store_table_number which)
{
    return store->update[which]
             ? MR_OK
             : prepare(store, store_update_text(store_table(which)), &store->update[which], error);
}

enum mr_status store_prepare_all(struct store *store, struct error *error)
{
    enum mr_status status = MR_OK;
    for (int i = 0; i < STORE_STATEMENT_COUNT && status == MR_OK; i++)
        status = prepare_named(store, error, (enum store_statement)i);
    for (int i = 0; i < STORE_TABLE_COUNT && status == MR_OK; i++) {
        if (store_table((enum store_table_number)i)->name)
            status = prepare_insert(store, error, (enum store_table_number)i);
    }
    return status == MR_OK ? prepare_update(store, error, STORE_TABLE_landing) : status;
}

void store_each_statement(struct store *store, int (*each)(sqlite3_stmt *statement))
{
    for (size_t i = 0; i < STORE_STATEMENT_COUNT; i++)
        each(store->statement[i]);
    for (size_t i = 0; i < STORE_TABLE_COUNT; i++) {
        each(store->insert[i]);
        each(store->update[i]);
    }
    each(store->frames_put);
}

/* One that gives no rows. */
static enum mr_status run_bound(struct store *store, struct error *error, sqlite3_stmt *statement,
                                int bound)
{
    enum mr_status status = MR_OK;
    if (bound != SQLITE_OK)
        return store_failed(store, "use", error);
    if (sqlite3_step(statement) != SQLITE_DONE)
        status = store_failed(store, "write", error);
    sqlite3_reset(statement);
    return status;
}

/* ---- rows in ---- */

enum mr_status store_insert(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, const int64_t *owners)
{
    int at = 1;
    enum mr_status status = prepare_insert(store, error, which);
    if (status != MR_OK)
        return status;
    sqlite3_stmt *statement = store->insert[which];
    return run_bound(
        store, error, statement,
        store_bind_row(statement, store_table(which), owners, row, STORE_ALL_RULES, &at));
}

enum mr_status store_update(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, int64_t id)
{
    int at = 1;
    enum mr_status status = prepare_update(store, error, which);
    if (status != MR_OK)
        return status;
    sqlite3_stmt *statement = store->update[which];
    int code = store_bind_row(statement, store_table(which), NULL, row, 1u << STORE_TAKE, &at);
    return run_bound(store, error, statement,
                     code == SQLITE_OK ? sqlite3_bind_int64(statement, at, id) : code);
}

/* ---- statements by name ---- */

static enum mr_status bind_named(struct store *store, struct error *error,
                                 enum store_statement which, const struct store_value *values,
                                 size_t count)
{
    enum mr_status status = prepare_named(store, error, which);
    if (status != MR_OK)
        return status;
    if (sqlite3_bind_parameter_count(store->statement[which]) != (int)count)
        refuse(statements[which].name, "it takes another number of values");
    return store_bind_values(store->statement[which], values, count) == SQLITE_OK
             ? MR_OK
             : store_failed(store, "use", error);
}

enum mr_status store_run(struct store *store, struct error *error, enum store_statement which,
                         const struct store_value *values, size_t count)
{
    enum mr_status status = bind_named(store, error, which, values, count);
    return status == MR_OK ? run_bound(store, error, store->statement[which], SQLITE_OK) : status;
}

enum mr_status store_query(struct store *store, struct error *error, enum store_statement which,
                           sqlite3_stmt **statement, const struct store_value *values, size_t count)
{
    enum mr_status status = store_frames_flush(store, error);
    if (status == MR_OK)
        status = bind_named(store, error, which, values, count);
    *statement = store->statement[which];
    return status;
}

enum mr_status store_step(struct store *store, sqlite3_stmt *statement, struct error *error)
{
    int code = sqlite3_step(statement);
    if (code == SQLITE_ROW)
        return MR_OK;
    enum mr_status status = code == SQLITE_DONE ? MR_TOO_FEW : store_failed(store, "read", error);
    sqlite3_reset(statement);
    return status;
}

enum mr_status store_next(struct store *store, struct error *error, enum store_statement which,
                          sqlite3_stmt *statement, void *row)
{
    enum mr_status status = store_step(store, statement, error);
    if (status == MR_OK)
        store_take_row(statement, store_table(statements[which].row), row);
    return status;
}

/* A row is kept after its statement has gone on: what its pointers point to would be gone. */
static void refuse_pointers(enum store_statement which)
{
    const struct store_table *table = store_table(statements[which].row);
    for (unsigned i = 0; i < table->count; i++) {
        if (table->columns[i].kind == STORE_POINTER || table->columns[i].kind == STORE_BLOB)
            refuse(statements[which].name,
                   "its rows have pointers, which hold until the next one only");
    }
}

enum mr_status store_one(struct store *store, struct error *error, enum store_statement which,
                         void *row, const struct store_value *values, size_t count)
{
    sqlite3_stmt *statement;
    refuse_pointers(which);
    enum mr_status status = store_query(store, error, which, &statement, values, count);
    if (status == MR_OK)
        status = store_next(store, error, which, statement, row);
    if (status == MR_OK)
        sqlite3_reset(statement);
    return status;
}

enum mr_status store_number(struct store *store, struct error *error, enum store_statement which,
                            int64_t *value, const struct store_value *values, size_t count)
{
    sqlite3_stmt *statement;
    enum mr_status status = store_query(store, error, which, &statement, values, count);
    if (status == MR_OK)
        status = store_step(store, statement, error);
    if (status != MR_OK)
        return status;
    *value = store_integer(statement, 0);
    sqlite3_reset(statement);
    return MR_OK;
}

enum mr_status store_all(struct store *store, struct error *error, enum store_statement which,
                         void **rows, size_t *count, const struct store_value *values,
                         size_t values_count)
{
    size_t size = store_table(statements[which].row)->row_size;
    sqlite3_stmt *statement;
    refuse_pointers(which);
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, which, &statement, values, values_count);
    while (status == MR_OK) {
        if (!list_grow(rows, *count, size)) {
            sqlite3_reset(statement);
            status = error_set(error, MR_FULL, "no memory: reading %s; close other programs",
                               store->path);
        } else if ((status = store_next(store, error, which, statement,
                                        (char *)*rows + *count * size)) == MR_OK) {
            ++*count;
        }
    }
    if (status == MR_TOO_FEW && *count > 0)
        return MR_OK;
    free(*rows);
    *rows = NULL;
    *count = 0;
    return status == MR_TOO_FEW ? MR_OK : status;
}
