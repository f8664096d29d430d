#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "host/store/store.h"
#include "common/version.h"
#include "host/store/store_log.h"
#include "host/store/store_sql.h"
#include "host/store/table.h"

/* another program may hold the file; what comes meanwhile waits in the links */
#define BUSY_WAIT_MS 30000

/* A statement ends by itself when it takes many more steps than a file of this size can need: pages
 * can lead in circles. A scan takes below 2 steps a byte; sorting, and what is looked up for each
 * row, do not make it ten times as many. */
#define STEPS_ALWAYS    20000000
#define STEPS_A_BYTE    32
#define STEPS_EACH      10000
/* the longest that matrig writes is an imported channel: 18 h at 1 kHz */
#define VALUE_BYTES_MAX 268435456

#define INTEGERS_EXACT 9007199254740992.0 /* 2^53: below, a double is the integer that it says */

enum mr_status store_failed(struct store *store, const char *doing, struct error *error)
{
    int code = sqlite3_errcode(store->database) & 0xff;
    const char *text = sqlite3_errmsg(store->database);
    store->refused = (int)store_refusal_of(code);
    switch (code) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
        return error_set(
            error, MR_MALFORMED,
            "no campaign database, or a damaged one (%s): %s; name a database that matrig log made",
            text, store->path);
    case SQLITE_INTERRUPT:
        return error_set(error, MR_MALFORMED,
                         "no end of what is to be read, more than the file can hold: %s; it is "
                         "damaged, take a copy of "
                         "before",
                         store->path);
    case SQLITE_TOOBIG:
        return error_set(
            error, MR_MALFORMED,
            "a value longer than matrig writes any (%s): %s; it is damaged, take a copy of before",
            text, store->path);
    case SQLITE_FULL:
        return error_set(error, MR_FULL, "cannot %s (%s): %s; make room on the disk", doing, text,
                         store->path);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return error_set(error, MR_IO, "cannot %s (%s): %s; another program is writing to it",
                         doing, text, store->path);
    default:
        return error_set(error, MR_IO, "cannot %s (%s): %s; check path, rights and disk", doing,
                         text, store->path);
    }
}

void store_guard_settings(sqlite3 *database)
{
    if (!database)
        return;
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, VALUE_BYTES_MAX);
}

static int64_t file_bytes(const struct store *store)
{
    char journal[4200];
    struct stat info;
    int64_t bytes = stat(store->path, &info) == 0 ? (int64_t)info.st_size : 0;
    snprintf(journal, sizeof journal, "%s-wal", store->path);
    return bytes + (stat(journal, &info) == 0 ? (int64_t)info.st_size : 0);
}

static int too_many_steps(void *context)
{
    struct store *store = context;
    store->steps += STEPS_EACH;
    return store->steps > STEPS_ALWAYS &&
           store->steps > STEPS_ALWAYS + STEPS_A_BYTE * file_bytes(store);
}

/* The steps of a statement that begins while another one gives rows belong to that one. */
static int statement_begins(unsigned event, void *context, void *begins, void *text)
{
    struct store *store = context;
    (void)event, (void)text;
    if (store->steps == 0)
        return 0;
    for (sqlite3_stmt *s = sqlite3_next_stmt(store->database, NULL); s;
         s = sqlite3_next_stmt(store->database, s)) {
        if (s != begins && sqlite3_stmt_busy(s))
            return 0;
    }
    store->steps = 0;
    return 0;
}

void store_limit_steps(struct store *store)
{
    sqlite3_progress_handler(store->database, STEPS_EACH, too_many_steps, store);
    sqlite3_trace_v2(store->database, SQLITE_TRACE_STMT, statement_begins, store);
}

enum mr_status store_execute(struct store *store, const char *sql, const char *doing,
                             struct error *error)
{
    return sqlite3_exec(store->database, sql, NULL, NULL, NULL) == SQLITE_OK
             ? MR_OK
             : store_failed(store, doing, error);
}

static enum mr_status pragma(struct store *store, const char *sql, int64_t *value,
                             struct error *error)
{
    sqlite3_stmt *statement;
    if (sqlite3_prepare_v2(store->database, sql, -1, &statement, NULL) != SQLITE_OK)
        return store_failed(store, "read", error);
    int code = sqlite3_step(statement);
    *value = code == SQLITE_ROW ? sqlite3_column_int64(statement, 0) : 0;
    enum mr_status status = code == SQLITE_ROW ? MR_OK : store_failed(store, "read", error);
    sqlite3_finalize(statement);
    return status;
}

/* Sets up a new, empty file. All of it or nothing: another process never sees half a schema, and of
 * two that set up the same file at once the second finds it done. */
static enum mr_status create_tables(struct store *store, struct error *error)
{
    char numbers[160];
    int64_t tables = 0;
    uint32_t own = 0; /* by which matrig log knows the file again (store_log.c) */
    if (getrandom(&own, sizeof own, 0) != (ssize_t)sizeof own)
        own = (uint32_t)time(NULL);
    snprintf(numbers, sizeof numbers,
             "PRAGMA application_id=%d; PRAGMA user_version=%d; PRAGMA schema_version=%u;",
             STORE_APPLICATION, STORE_VERSION, own >> 1);
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_DEFENSIVE, 0, NULL);
    enum mr_status status = store_execute(store, "BEGIN IMMEDIATE", "set up", error);
    if (status == MR_OK)
        status = pragma(store, "SELECT count(*) FROM sqlite_schema", &tables, error);
    if (status == MR_OK && tables == 0)
        status = store_tables_make(store->database) == SQLITE_OK
                   ? MR_OK
                   : store_failed(store, "set up", error);
    if (status == MR_OK && tables == 0)
        status = store_execute(store, numbers, "set up", error);
    if (status == MR_OK)
        status = store_execute(store, "COMMIT", "set up", error);
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    return status;
}

#define OBJECTS "SELECT type, name, tbl_name, sql FROM main.sqlite_schema"

static int count_changes(sqlite3 *database, const char *sql, sqlite3_stmt *row)
{
    sqlite3_stmt *s = NULL;
    sqlite3_prepare_v2(database, sql, -1, &s, NULL);
    for (int i = 0; i < 4; i++)
        sqlite3_bind_value(s, i + 1, sqlite3_column_value(row, i));
    bool done = sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    return done ? sqlite3_changes(database) : 0;
}

/* A schema can hold programs (a view that never ends, a trigger that runs at every row), so a
 * campaign has the schema of a fresh one and nothing else. `what`: the first object that a fresh
 * one has not, or that this one lacks. */
static bool same_schema(sqlite3 *database, char what[STORE_TEXT])
{
    sqlite3 *fresh = NULL;
    sqlite3_stmt *row = NULL;
    int code = sqlite3_open(":memory:", &fresh) | store_tables_make(fresh);
    code |= sqlite3_exec(fresh, "ANALYZE; CREATE TEMP TABLE known AS " OBJECTS, NULL, NULL, NULL) |
            sqlite3_prepare_v2(database, OBJECTS " ORDER BY type DESC", -1, &row, NULL);
    bool same = code == SQLITE_OK;
    while (same && (code = sqlite3_step(row)) == SQLITE_ROW)
        same = count_changes(
                   fresh, "DELETE FROM known WHERE type=? AND name=? AND tbl_name=? AND sql IS ?",
                   row) == 1;
    if (code == SQLITE_DONE) {
        sqlite3_finalize(row);
        sqlite3_prepare_v2(fresh,
                           "SELECT 'no '||type, name FROM known WHERE name NOT LIKE 'sqlite_stat%'",
                           -1, &row, NULL);
        same = (code = sqlite3_step(row)) == SQLITE_DONE;
    }
    if (code == SQLITE_ROW) {
        char type[40], name[100];
        store_text(row, 0, type, sizeof type);
        store_text(row, 1, name, sizeof name);
        snprintf(what, STORE_TEXT, "%s %s", type, name);
    } else {
        snprintf(what, STORE_TEXT, "%s", sqlite3_errmsg(database));
    }
    sqlite3_finalize(row);
    sqlite3_close(fresh);
    return same;
}

/* Before anything of it is used. */
static enum mr_status refuse_foreign(struct store *store, struct error *error)
{
    char what[STORE_TEXT];
    if (same_schema(store->database, what))
        return MR_OK;
    return error_set(
        error, MR_MALFORMED,
        "a campaign whose tables are not those that matrig makes (%s): %s; drop what is "
        "not matrig's with sqlite3, or take a copy of before",
        what, store->path);
}

/* What a file says of itself. */
struct header {
    int64_t application, version, tables;
};

/* In one transaction: what another log has set up meanwhile is seen whole or not at all. */
static enum mr_status read_header(struct store *store, struct header *header, struct error *error)
{
    enum mr_status status = store_execute(store, "BEGIN", "read", error);
    if (status != MR_OK)
        return status;
    status = pragma(store, "PRAGMA application_id", &header->application, error);
    if (status == MR_OK)
        status = pragma(store, "PRAGMA user_version", &header->version, error);
    if (status == MR_OK)
        status = pragma(store, "SELECT count(*) FROM sqlite_schema", &header->tables, error);
    sqlite3_exec(store->database, "ROLLBACK", NULL, NULL, NULL); /* only read */
    return status;
}

/* Every version has the column sessions.matrig. */
static enum mr_status refuse_version(struct store *store, int64_t version, struct error *error)
{
    sqlite3_stmt *statement = NULL;
    char by[40] = "(unknown)";
    if (sqlite3_prepare_v2(store->database, "SELECT matrig FROM sessions ORDER BY id DESC LIMIT 1",
                           -1, &statement, NULL) == SQLITE_OK &&
        sqlite3_step(statement) == SQLITE_ROW)
        store_text(statement, 0, by, sizeof by);
    sqlite3_finalize(statement);
    return error_set(
        error, MR_VERSION,
        "campaign database of version %lld, written by matrig %s; this is matrig " VERSION_TEXT
        " and reads version %d: %s; use the matrig that wrote it",
        (long long)version, by, STORE_VERSION, store->path);
}

static enum mr_status check_version(struct store *store, enum store_mode mode, struct error *error)
{
    struct header header;
    enum mr_status status = read_header(store, &header, error);
    if (status != MR_OK)
        return status;
    if (mode == STORE_CREATE && header.application == 0 && header.version == 0 &&
        header.tables == 0) {
        status = create_tables(store, error);
        return status == MR_OK ? check_version(store, STORE_OPEN, error) : status;
    }
    if (header.application != STORE_APPLICATION)
        return error_set(error, MR_MALFORMED,
                         "no campaign database: %s; name a database that matrig log made",
                         store->path);
    if (header.version != STORE_VERSION)
        return refuse_version(store, header.version, error);
    return refuse_foreign(store, error);
}

enum mr_status store_open(const char *path, enum store_mode mode, struct store **store,
                          struct error *error)
{
    struct stat info;
    if (mode != STORE_CREATE && stat(path, &info) != 0)
        return error_set(error, MR_IO, "no such database: %s; name a database that matrig log made",
                         path);
    struct store *made = calloc(1, sizeof *made);
    char *copy = strdup(path);
    if (!made || !copy) {
        free(made);
        free(copy);
        return error_set(error, MR_FULL, "no memory: database %s; close other programs", path);
    }
    made->path = copy;
    int flags = SQLITE_OPEN_READWRITE | (mode == STORE_CREATE ? SQLITE_OPEN_CREATE : 0);
    enum mr_status status = MR_OK;
    if (sqlite3_open_v2(path, &made->database, flags, NULL) != SQLITE_OK)
        status = store_failed(made, "open", error);
    if (status == MR_OK) {
        sqlite3_busy_timeout(made->database, BUSY_WAIT_MS);
        store_guard_settings(made->database);
        store_limit_steps(made);
        /* another program's database keeps its journal as it is */
        sqlite3_db_config(made->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
        status = check_version(made, mode, error);
        sqlite3_db_config(made->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, status != MR_OK, NULL);
    }
    if (status == MR_OK && mode == STORE_READ)
        status = store_execute(made, "PRAGMA query_only=1", "open", error);
    /* FULL: a commit is on disk, not only with the kernel, when it returns. A file system that
     * refuses writing leaves the journal as it is; reading goes on. */
    if (status == MR_OK && mode == STORE_CREATE)
        status = store_execute(made, "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;", "set up",
                               error);
    if (status != MR_OK) {
        store_close(made);
        return status;
    }
    *store = made;
    return MR_OK;
}

/* The lock of flock(2) has nothing to do with those that SQLite takes, but those are of the process
 * and go when it closes any descriptor of the file: this one is closed after the database. */
enum mr_status store_take_alone(struct store *store, struct error *error)
{
    int fd = open(store->path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return error_set(error, MR_IO, "cannot open (%s): %s; check path and rights",
                         strerror(errno), store->path);
    store->alone = fd;
    if (flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return error_set(error, MR_IO,
                         "another matrig log writes to this campaign: %s; end it first, or name "
                         "another database",
                         store->path);
    return MR_OK;
}

/* The descriptor stays open, for the same reason. */
bool store_is_logged(struct store *store)
{
    if (!store->alone)
        store->alone = open(store->path, O_RDONLY | O_CLOEXEC);
    if (store->alone <= 0) {
        store->alone = 0;
        return false;
    }
    bool held = flock(store->alone, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!held)
        flock(store->alone, LOCK_UN);
    return held;
}

void store_close(struct store *store)
{
    if (!store)
        return;
    store_each_statement(store, sqlite3_finalize);
    sqlite3_close(store->database);
    if (store->alone)
        close(store->alone);
    free(store->path);
    free(store);
}

const char *store_path(const struct store *store)
{
    return store->path;
}

enum mr_status store_begin(struct store *store, struct error *error)
{
    return store_execute(store, "BEGIN IMMEDIATE", "write", error);
}

enum mr_status store_commit(struct store *store, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    return status == MR_OK ? store_execute(store, "COMMIT", "write", error) : status;
}

/* A value of another kind than matrig writes there is absent, as one that was never written. It is
 * looked at where it lies, which costs half of asking SQLite for kind and value: a statement is one
 * thread's at a time. */
int64_t store_integer(sqlite3_stmt *statement, int column)
{
    sqlite3_value *value = sqlite3_column_value(statement, column);
    int type = sqlite3_value_type(value);
    double real = type == SQLITE_FLOAT ? sqlite3_value_double(value) : 0.0;
    if (type != SQLITE_INTEGER && (type != SQLITE_FLOAT || !(fabs(real) < INTEGERS_EXACT)))
        return STORE_NONE;
    return sqlite3_value_int64(value);
}

double store_real(sqlite3_stmt *statement, int column)
{
    sqlite3_value *value = sqlite3_column_value(statement, column);
    int type = sqlite3_value_type(value);
    double real = type == SQLITE_FLOAT || type == SQLITE_INTEGER ? sqlite3_value_double(value)
                                                                 : (double)NAN;
    return isfinite(real) ? real : (double)NAN;
}

void store_text(sqlite3_stmt *statement, int column, char *out, size_t size)
{
    const char *text = (const char *)sqlite3_column_text(statement, column);
    snprintf(out, size, "%s", text ? text : "");
    size_t length = strlen(out), cut = length;
    if (text && text[length]) { /* no half of a character at the end */
        while (cut > 0 && ((unsigned char)text[cut] & 0xc0) == 0x80)
            cut--;
        out[cut] = '\0';
    }
    for (char *p = out; *p; p++) {
        /* somebody else may have written it: nothing that a terminal takes for an order (C0, DEL,
         * C1 as UTF-8) */
        if ((unsigned char)*p < 0x20 || *p == 0x7f)
            *p = ' ';
        else if ((unsigned char)*p == 0xc2 && ((unsigned char)p[1] & 0xe0) == 0x80)
            p[0] = p[1] = ' ';
    }
}

/* ---- schema ----
 *
 * The tables as SQLite has them. */

static void say_columns(sqlite3_str *sql, const struct store_table *table)
{
    bool first = true;
    for (unsigned i = 0; i < table->count; i++) {
        const struct store_column *column = &table->columns[i];
        if (!column->name)
            continue;
        sqlite3_str_appendf(sql, "%s%s %s%s%s", first ? "" : ", ", column->name, column->type,
                            column->constraint[0] ? " " : "", column->constraint);
        first = false;
    }
}

static int make_table(sqlite3 *database, enum store_table_number which)
{
    const struct store_table *table = store_table(which);
    sqlite3_str *sql = sqlite3_str_new(database);
    sqlite3_str_appendf(sql, "CREATE TABLE %s(", table->name);
    say_columns(sql, table);
    sqlite3_str_appendf(sql, "%s", table->key);
    char *text = sqlite3_str_finish(sql);
    int code = text ? sqlite3_exec(database, text, NULL, NULL, NULL) : SQLITE_NOMEM;
    sqlite3_free(text);
    return code;
}

int store_tables_make(sqlite3 *database)
{
    int code = SQLITE_OK;
#define TABLE(row, table)  \
    if (code == SQLITE_OK) \
        code = make_table(database, STORE_TABLE_##row);
#define NO_VIEWS
#define ALSO(sql)          \
    if (code == SQLITE_OK) \
        code = sqlite3_exec(database, sql, NULL, NULL, NULL);
#include "host/store/tables.def"
    return code;
}
