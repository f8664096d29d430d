#include "host/store/store_migrate.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/store/store_guard.h"
#include "host/store/store_sql.h"

#define BACKUPS_MOST 99  /* of one version beside one campaign */
#define BACKUP_PAGES 256 /* at once */
#define BUSY_TRIES   600 /* of 50 ms */

/* Columns in order, then what is unique: two tables with the same of it take the same
 * statements. */
#define SIGNATURE                                                                                  \
    "SELECT (SELECT group_concat(name||' '||type||' '||\"notnull\"||' '||pk) FROM (SELECT * FROM " \
    "pragma_table_info(?1)"                                                                        \
    " ORDER BY cid)) || ';' || coalesce((SELECT group_concat(columns, ';') FROM (SELECT (SELECT "  \
    "group_concat(name) FROM"                                                                      \
    " pragma_index_info(l.name)) AS columns FROM pragma_index_list(?1) AS l WHERE l.origin='u' "   \
    "ORDER BY columns)), '')"

/* Columns whose content changed with a version: what they become. */
static const struct change {
    int64_t before; /* this version */
    const char *table, *column, *becomes;
} changes[] = {
    /* block records say which channels the rig lacks: three bytes behind index and tick
     * (common/block.h) */
    {2, "blocks", "record", "CAST(substr(record, 1, 8) || x'000000' || substr(record, 9) AS BLOB)"},
};
#define CHANGES (sizeof changes / sizeof changes[0])

static void (*tell_user)(const char *line);

void store_on_migration(void (*tell)(const char *line))
{
    tell_user = tell;
}

static enum mr_status execute(struct store *store, struct error *error, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    char *sql = sqlite3_vmprintf(format, values);
    va_end(values);
    if (!sql)
        abort();
    enum mr_status status = store_execute(store, sql, "bring forward", error);
    sqlite3_free(sql);
    return status;
}

/* First column of the first row as text, NULL when there is none; the caller frees it. */
static char *text_of(sqlite3 *database, const char *sql, const char *one, const char *two)
{
    sqlite3_stmt *s;
    char *text = NULL;
    if (sqlite3_prepare_v2(database, sql, -1, &s, NULL) != SQLITE_OK)
        return NULL;
    if (one)
        sqlite3_bind_text(s, 1, one, -1, SQLITE_STATIC);
    if (two)
        sqlite3_bind_text(s, 2, two, -1, SQLITE_STATIC);
    if (sqlite3_step(s) == SQLITE_ROW && sqlite3_column_type(s, 0) != SQLITE_NULL)
        text = strdup((const char *)sqlite3_column_text(s, 0));
    sqlite3_finalize(s);
    return text;
}

static bool same_text(char *one, char *two)
{
    bool same = one && two ? strcmp(one, two) == 0 : one == two;
    free(one);
    free(two);
    return same;
}

static bool has(sqlite3 *database, const char *sql, const char *one, const char *two)
{
    char *text = text_of(database, sql, one, two);
    free(text);
    return text != NULL;
}

static bool has_object(sqlite3 *database, const char *name)
{
    return has(database, "SELECT 1 FROM main.sqlite_schema WHERE name=?1", name, NULL);
}

static bool has_column(sqlite3 *database, const char *table, const char *column)
{
    return has(database, "SELECT 1 FROM pragma_table_info(?1, 'main') WHERE name=?2", table,
               column);
}

static bool same_table(sqlite3 *database, sqlite3 *wanted, const char *table)
{
    return same_text(text_of(database, SIGNATURE, table, NULL),
                     text_of(wanted, SIGNATURE, table, NULL));
}

/* The tables as this version has them. */
static enum mr_status wanted_tables(struct store *store, sqlite3 **wanted, struct error *error)
{
    if (sqlite3_open(":memory:", wanted) != SQLITE_OK || store_tables_make(*wanted) != SQLITE_OK) {
        sqlite3_close(*wanted);
        *wanted = NULL;
        return error_set(error, MR_FULL,
                         "no memory for the tables of this version: %s; close other programs",
                         store->path);
    }
    return MR_OK;
}

/* Calls `each` for the tables, indexes, triggers and views of this version, in the order in which
 * they are made. */
struct object {
    sqlite3 *wanted;
    const char *type, *name, *sql;
};
static enum mr_status each_object(struct store *store,
                                  enum mr_status (*each)(struct store *, const struct object *,
                                                         void *, struct error *),
                                  void *context, struct error *error)
{
    sqlite3 *wanted;
    sqlite3_stmt *s = NULL;
    enum mr_status status = wanted_tables(store, &wanted, error);
    if (status != MR_OK)
        return status;
    if (sqlite3_prepare_v2(
            wanted,
            "SELECT type, name, sql FROM sqlite_schema WHERE sql IS NOT NULL ORDER BY rowid", -1,
            &s, NULL) != SQLITE_OK)
        status = error_set(error, MR_FULL,
                           "no memory for the tables of this version: %s; close other programs",
                           store->path);
    while (status == MR_OK && sqlite3_step(s) == SQLITE_ROW) {
        struct object object = {wanted, (const char *)sqlite3_column_text(s, 0),
                                (const char *)sqlite3_column_text(s, 1),
                                (const char *)sqlite3_column_text(s, 2)};
        status = each(store, &object, context, error);
    }
    sqlite3_finalize(s);
    sqlite3_close(wanted);
    return status;
}

static enum mr_status look(struct store *store, const struct object *object, void *due,
                           struct error *error)
{
    (void)error;
    if (!has_object(store->database, object->name) ||
        (strcmp(object->type, "table") == 0 &&
         !same_table(store->database, object->wanted, object->name)))
        *(bool *)due = true;
    return MR_OK;
}

enum mr_status store_migrate_due(struct store *store, bool *due, struct error *error)
{
    *due = false;
    return each_object(store, look, due, error);
}

/* ---- forward ---- */

/* Adds the columns that can be added; the others, and another order, are left to rebuild. */
static enum mr_status add_columns(struct store *store, const struct object *object,
                                  struct error *error)
{
    sqlite3_stmt *s;
    enum mr_status status = MR_OK;
    if (sqlite3_prepare_v2(object->wanted,
                           "SELECT name, type, \"notnull\", dflt_value, pk FROM "
                           "pragma_table_info(?1) ORDER BY cid",
                           -1, &s, NULL) != SQLITE_OK)
        return error_set(error, MR_FULL,
                         "no memory for the columns of %s: %s; close other programs", object->name,
                         store->path);
    sqlite3_bind_text(s, 1, object->name, -1, SQLITE_STATIC);
    while (status == MR_OK && sqlite3_step(s) == SQLITE_ROW) {
        const char *column = (const char *)sqlite3_column_text(s, 0),
                   *fallback = (const char *)sqlite3_column_text(s, 3);
        bool not_null = sqlite3_column_int(s, 2), key = sqlite3_column_int(s, 4);
        if (key || (not_null && !fallback) || has_column(store->database, object->name, column))
            continue;
        status = execute(store, error, "ALTER TABLE main.\"%w\" ADD COLUMN \"%w\" %s%s%s%s",
                         object->name, column, (const char *)sqlite3_column_text(s, 1),
                         not_null ? " NOT NULL" : "", fallback ? " DEFAULT " : "",
                         fallback ? fallback : "");
    }
    sqlite3_finalize(s);
    return status;
}

/* A column that only the file has would be lost. */
static enum mr_status refuse_foreign(struct store *store, const struct object *object,
                                     struct error *error)
{
    sqlite3_stmt *s;
    enum mr_status status = MR_OK;
    if (sqlite3_prepare_v2(store->database, "SELECT name FROM pragma_table_info(?1, 'main')", -1,
                           &s, NULL) != SQLITE_OK)
        return store_failed(store, "bring forward", error);
    sqlite3_bind_text(s, 1, object->name, -1, SQLITE_STATIC);
    while (status == MR_OK && sqlite3_step(s) == SQLITE_ROW) {
        const char *column = (const char *)sqlite3_column_text(s, 0);
        if (!has_column(object->wanted, object->name, column))
            status = error_set(
                error, MR_VERSION,
                "column %s of table %s is not known here: %s; use the matrig that made it", column,
                object->name, store->path);
    }
    sqlite3_finalize(s);
    return status;
}

static enum mr_status rebuild(struct store *store, const struct object *object, struct error *error)
{
    char *columns = text_of(
        store->database, "SELECT group_concat('\"'||name||'\"') FROM pragma_table_info(?1, 'main')",
        object->name, NULL);
    const char *bracket = strchr(object->sql, '(');
    if (!columns || !bracket)
        abort();
    /* what refers to the table does so by its name, which stays */
    enum mr_status status = execute(store, error, "CREATE TABLE main.\"new of %w\"%s", object->name,
                                    bracket);
    if (status == MR_OK)
        status = execute(store, error,
                         "INSERT INTO main.\"new of %w\"(%s) SELECT %s FROM main.\"%w\"",
                         object->name, columns, columns, object->name);
    if (status == MR_OK)
        status = execute(store, error, "DROP TABLE main.\"%w\"", object->name);
    if (status == MR_OK)
        status = execute(store, error, "ALTER TABLE main.\"new of %w\" RENAME TO \"%w\"",
                         object->name, object->name);
    free(columns);
    return status;
}

static enum mr_status forward(struct store *store, const struct object *object, void *context,
                              struct error *error)
{
    (void)context;
    if (!has_object(store->database, object->name))
        return execute(store, error, "%s", object->sql);
    if (strcmp(object->type, "table") != 0 ||
        same_table(store->database, object->wanted, object->name))
        return MR_OK;
    enum mr_status status = refuse_foreign(store, object, error);
    if (status == MR_OK)
        status = add_columns(store, object, error);
    if (status == MR_OK && !same_table(store->database, object->wanted, object->name))
        status = rebuild(store, object, error);
    if (status == MR_OK && !same_table(store->database, object->wanted, object->name))
        status = error_set(error, MR_MALFORMED,
                           "table %s cannot be brought forward: %s; use the matrig that made it",
                           object->name, store->path);
    return status;
}

static enum mr_status change_content(struct store *store, int64_t version, struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < CHANGES && status == MR_OK; i++) {
        if (version < changes[i].before)
            status = execute(store, error, "UPDATE main.\"%w\" SET \"%w\"=%s", changes[i].table,
                             changes[i].column, changes[i].becomes);
    }
    return status;
}

/* ---- the copy ---- */

static enum mr_status copy_pages(struct store *store, const char *to, struct error *error)
{
    sqlite3 *source = NULL, *copy = NULL;
    sqlite3_backup *backup = NULL;
    int code = sqlite3_open_v2(store->path, &source, SQLITE_OPEN_READONLY, NULL);
    if (code == SQLITE_OK)
        code = sqlite3_open_v2(to, &copy, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, NULL);
    store_guard_settings(source);
    store_guard_settings(copy);
    if (code == SQLITE_OK && !(backup = sqlite3_backup_init(copy, "main", source, "main")))
        code = sqlite3_errcode(copy);
    for (int tries = 0; code == SQLITE_OK ||
                        ((code == SQLITE_BUSY || code == SQLITE_LOCKED) && tries < BUSY_TRIES);) {
        code = sqlite3_backup_step(backup, BACKUP_PAGES);
        if (code == SQLITE_BUSY || code == SQLITE_LOCKED) {
            tries++;
            sqlite3_sleep(50);
        }
    }
    int finished = sqlite3_backup_finish(backup);
    code = code == SQLITE_DONE ? finished : code;
    /* one file, without a journal beside it */
    if (code == SQLITE_OK)
        code = sqlite3_exec(copy, "PRAGMA journal_mode=DELETE", NULL, NULL, NULL);
    sqlite3_close(copy);
    sqlite3_close(source);
    if (code == SQLITE_OK)
        return MR_OK;
    return error_set(error, code == SQLITE_FULL ? MR_FULL : MR_IO,
                     "cannot keep a copy before bringing the campaign forward (%s): %s; make room "
                     "there, or: matrig migrate DB --no-backup",
                     sqlite3_errstr(code), to);
}

/* PATH.v2, PATH.v2-2 and so on: none is written over. `path` receives it. */
static enum mr_status make_copy(struct store *store, int64_t version, char *path, size_t size,
                                struct error *error)
{
    char partial[4200];
    if (snprintf(partial, sizeof partial, "%s.v%lld-partial", store->path, (long long)version) >=
        (int)sizeof partial)
        return error_set(error, MR_TOO_LONG, "path too long: %s; give a shorter one", store->path);
    snprintf(path, size, "%s.v%lld", store->path, (long long)version);
    for (int i = 2; access(path, F_OK) == 0 && i <= BACKUPS_MOST; i++)
        snprintf(path, size, "%s.v%lld-%d", store->path, (long long)version, i);
    if (access(path, F_OK) == 0)
        return error_set(error, MR_USAGE, "%d copies are there already: %s; move them away",
                         BACKUPS_MOST, path);
    unlink(partial); /* of one that was killed */
    enum mr_status status = copy_pages(store, partial, error);
    if (status == MR_OK && rename(partial, path) != 0)
        status = error_set(error, MR_IO, "cannot name the copy: %s; check rights", path);
    if (status != MR_OK)
        unlink(partial);
    return status;
}

static int64_t version_of(struct store *store)
{
    char *text = text_of(store->database, "PRAGMA user_version", NULL, NULL);
    int64_t version = text ? strtoll(text, NULL, 10) : -1;
    free(text);
    return version;
}

enum mr_status store_migrate(struct store *store, bool backup, struct error *error)
{
    char copy[4200] = "", line[9000];
    enum mr_status status = execute(store, error, "BEGIN IMMEDIATE");
    if (status != MR_OK)
        return status;
    int64_t version = version_of(store);
    bool due = false; /* another process may have done it while this one waited */
    status = store_migrate_due(store, &due, error);
    due |= version < STORE_VERSION;
    if (status == MR_OK && due && backup)
        status = make_copy(store, version, copy, sizeof copy, error);
    if (status == MR_OK && due)
        status = each_object(store, forward, NULL, error);
    if (status == MR_OK && due)
        status = change_content(store, version, error);
    if (status == MR_OK && due)
        status = execute(store, error, "PRAGMA user_version=%d", STORE_VERSION);
    if (status == MR_OK)
        status = execute(store, error, "COMMIT");
    if (status != MR_OK) {
        sqlite3_exec(store->database, "ROLLBACK", NULL, NULL, NULL);
        return status;
    }
    if (due && tell_user) {
        char what[80] = "tables of this matrig added";
        if (version < STORE_VERSION)
            snprintf(what, sizeof what, "brought forward from version %lld to %d",
                     (long long)version, STORE_VERSION);
        snprintf(line, sizeof line, "%s: %s%s%s", what, store->path,
                 backup ? "; as it was: " : ", no copy kept", copy);
        tell_user(line);
    }
    return MR_OK;
}

/* ---- as it is ---- */

/* What a column of this version is in the file's words. */
static char *read_as(struct store *store, int64_t version, const char *table, const char *column,
                     const char *fallback, bool *lacks)
{
    for (size_t i = 0; i < CHANGES; i++) {
        if (version < changes[i].before && strcmp(table, changes[i].table) == 0 &&
            strcmp(column, changes[i].column) == 0) {
            *lacks = true;
            return sqlite3_mprintf("%s AS \"%w\"", changes[i].becomes, column);
        }
    }
    if (has_column(store->database, table, column))
        return sqlite3_mprintf("\"%w\"", column);
    *lacks = true;
    return sqlite3_mprintf("%s AS \"%w\"", fallback, column);
}

/* Names without a schema find the temporary ones first. */
static enum mr_status view(struct store *store, const struct object *object, void *version,
                           struct error *error)
{
    if (strcmp(object->type, "table") != 0)
        return MR_OK;
    if (!has_object(store->database, object->name))
        return execute(store, error, "CREATE TEMP TABLE \"%w\"%s", object->name,
                       strchr(object->sql, '('));
    sqlite3_stmt *s;
    sqlite3_str *columns = sqlite3_str_new(NULL);
    bool lacks = false;
    if (sqlite3_prepare_v2(
            object->wanted,
            "SELECT name, coalesce(dflt_value, 'NULL') FROM pragma_table_info(?1) ORDER BY cid", -1,
            &s, NULL) != SQLITE_OK)
        abort();
    sqlite3_bind_text(s, 1, object->name, -1, SQLITE_STATIC);
    while (sqlite3_step(s) == SQLITE_ROW) {
        char *as = read_as(store, *(int64_t *)version, object->name,
                           (const char *)sqlite3_column_text(s, 0),
                           (const char *)sqlite3_column_text(s, 1), &lacks);
        sqlite3_str_appendf(columns, "%s%s", sqlite3_str_length(columns) ? ", " : "", as);
        sqlite3_free(as);
    }
    sqlite3_finalize(s);
    char *list = sqlite3_str_finish(columns);
    enum mr_status status = MR_OK;
    if (lacks)
        status = execute(store, error, "CREATE TEMP VIEW \"%w\" AS SELECT %s FROM main.\"%w\"",
                         object->name, list, object->name);
    sqlite3_free(list);
    return status;
}

enum mr_status store_migrate_view(struct store *store, struct error *error)
{
    int64_t version = version_of(store);
    return each_object(store, view, &version, error);
}
