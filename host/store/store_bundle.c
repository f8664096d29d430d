#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/store/store_readiness.h"
#include "host/store/store_sql.h"

#define SQL_MAX 4000

static enum mr_status execute(struct store *store, const char *sql, struct error *error)
{
    return sqlite3_exec(store->database, sql, NULL, NULL, NULL) == SQLITE_OK ? MR_OK
                                                                            : store_failed(store, "bundle", error);
}

/* Which rows of a table belong to the landing: ?1 is RUN, ?2 its session, ?3 its boot. Tables that know a landing by way of
 * another one, and faults of the board from before the landing, are said here; the others have a column for it. */
static const char *rows_of(const char *table, bool has_landing, bool has_session)
{
    if (strcmp(table, "landings") == 0)
        return "id=?1";
    if (strcmp(table, "sessions") == 0)
        return "id=?2";
    if (strcmp(table, "events") == 0)
        return "landing=?1 OR (landing IS NULL AND session=?2 AND boot=?3"
               " AND id<=coalesce((SELECT max(id) FROM main.events WHERE landing=?1), 0))";
    if (strcmp(table, "slack") == 0)
        return "survey IN (SELECT id FROM main.surveys WHERE landing=?1)";
    if (strcmp(table, "simulation_channels") == 0)
        return "simulation IN (SELECT id FROM main.simulations WHERE landing=?1)";
    if (strcmp(table, "readiness") == 0) /* that of the landing, and those before it within hours */
        return "board_uid=(SELECT board_uid FROM main.landings WHERE id=?1) AND (SELECT armed_us FROM main.landings WHERE id=?1)"
               " BETWEEN made_us AND made_us + " STORE_READINESS_TEXT;
    if (strcmp(table, "configurations") == 0)
        return "crc=(SELECT config_crc FROM main.landings WHERE id=?1)";
    return has_landing ? "landing=?1" : has_session ? "session=?2" : "0";
}

/* INSERT INTO bundle.T(columns) SELECT columns FROM main.T WHERE ..., with the landing as number 1. */
static enum mr_status copy_statement(struct store *store, const char *table, char sql[SQL_MAX], struct error *error)
{
    char columns[SQL_MAX / 4] = "", values[SQL_MAX / 4] = "";
    bool has_landing = false, has_session = false;
    sqlite3_stmt *statement;
    if (sqlite3_prepare_v2(store->database, "SELECT name FROM pragma_table_info(?, 'main')", -1, &statement, NULL) != SQLITE_OK)
        return store_failed(store, "bundle", error);
    sqlite3_bind_text(statement, 1, table, -1, SQLITE_STATIC);
    bool fits = true;
    while (sqlite3_step(statement) == SQLITE_ROW) {
        const char *name = (const char *)sqlite3_column_text(statement, 0);
        bool landing = strcmp(name, "landing") == 0;
        bool number = landing || (strcmp(table, "landings") == 0 && strcmp(name, "id") == 0);
        const char *comma = columns[0] ? "," : "";
        size_t at = strlen(columns), to = strlen(values);
        fits &= snprintf(columns + at, sizeof columns - at, "%s\"%s\"", comma, name) < (int)(sizeof columns - at);
        if (number) /* an event outside landings stays outside */
            fits &= snprintf(values + to, sizeof values - to, "%sCASE WHEN \"%s\" IS NULL THEN NULL ELSE 1 END", comma, name) <
                    (int)(sizeof values - to);
        else
            fits &= snprintf(values + to, sizeof values - to, "%s\"%s\"", comma, name) < (int)(sizeof values - to);
        has_landing |= landing;
        has_session |= strcmp(name, "session") == 0;
    }
    sqlite3_finalize(statement);
    fits &= snprintf(sql, SQL_MAX, "INSERT INTO bundle.\"%s\"(%s) SELECT %s FROM main.\"%s\" WHERE %s", table, columns, values,
                     table, rows_of(table, has_landing, has_session)) < SQL_MAX;
    return fits ? MR_OK
                : error_set(error, MR_TOO_LONG, "table %s has too many columns: %s; use the matrig that made it", table,
                            store->path);
}

static enum mr_status copy_table(struct store *store, const char *table, const struct store_landing *landing,
                                 struct error *error)
{
    char sql[SQL_MAX];
    sqlite3_stmt *statement;
    enum mr_status status = copy_statement(store, table, sql, error);
    if (status != MR_OK)
        return status;
    if (sqlite3_prepare_v2(store->database, sql, -1, &statement, NULL) != SQLITE_OK)
        return store_failed(store, "bundle", error);
    int parameters = sqlite3_bind_parameter_count(statement);
    if (parameters >= 1)
        sqlite3_bind_int64(statement, 1, landing->id);
    if (parameters >= 2)
        sqlite3_bind_int64(statement, 2, landing->session);
    if (parameters >= 3)
        sqlite3_bind_int64(statement, 3, landing->boot);
    if (sqlite3_step(statement) != SQLITE_DONE)
        status = store_failed(store, "bundle", error);
    sqlite3_finalize(statement);
    return status;
}

static enum mr_status copy_tables(struct store *store, const struct store_landing *landing, struct error *error)
{
    sqlite3_stmt *tables;
    enum mr_status status = MR_OK;
    /* In the order in which they were made: what refers to a row comes after it. */
    if (sqlite3_prepare_v2(store->database,
                           "SELECT name FROM main.sqlite_schema WHERE type='table' AND name NOT LIKE 'sqlite_%'"
                           " ORDER BY rowid",
                           -1, &tables, NULL) != SQLITE_OK)
        return store_failed(store, "bundle", error);
    while (status == MR_OK && sqlite3_step(tables) == SQLITE_ROW)
        status = copy_table(store, (const char *)sqlite3_column_text(tables, 0), landing, error);
    sqlite3_finalize(tables);
    return status;
}

static enum mr_status fill(struct store *store, const struct store_landing *landing, const char *path, struct error *error)
{
    char *attach = sqlite3_mprintf("ATTACH %Q AS bundle", path);
    if (!attach)
        return error_set(error, MR_FULL, "no memory: bundle %s; close other programs", path);
    enum mr_status status = execute(store, attach, error);
    sqlite3_free(attach);
    if (status != MR_OK)
        return status;
    status = execute(store, "BEGIN", error);
    if (status == MR_OK)
        status = copy_tables(store, landing, error);
    if (status == MR_OK)
        status = execute(store, "COMMIT", error);
    else
        sqlite3_exec(store->database, "ROLLBACK", NULL, NULL, NULL);
    /* One file, whole without a log beside it, to be sent or put where nothing can be written. */
    if (status == MR_OK)
        status = execute(store, "PRAGMA bundle.journal_mode=DELETE", error);
    sqlite3_exec(store->database, "DETACH bundle", NULL, NULL, NULL);
    return status;
}

enum mr_status store_bundle(struct store *store, int64_t run, const char *path, struct error *error)
{
    struct store_landing landing;
    struct store *bundle = NULL;
    enum mr_status status = store_landing_get(store, run, &landing, error);
    if (status != MR_OK)
        return status;
    if (access(path, F_OK) == 0)
        return error_set(error, MR_USAGE, "is there already: %s; give another file for the bundle", path);
    status = store_open(path, STORE_CREATE, &bundle, error);
    store_close(bundle);
    if (status == MR_OK)
        status = fill(store, &landing, path, error);
    if (status != MR_OK)
        unlink(path);
    return status;
}
