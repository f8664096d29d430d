#include "host/store/table.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "host/base/xmalloc.h"

/* A statement is stopped after many more steps than a file of this size can need, because pages of
 * a damaged file can form circles. A scan takes less than 2 steps per byte; sorting and look-ups
 * for each row take less than ten times as many. */
#define STEPS_ALWAYS 20000000
#define STEPS_A_BYTE 32
#define STEPS_EACH   10000

/* 2^53: below it, a double represents every integer exactly */
#define INTEGERS_EXACT 9007199254740992.0

/* ---- the tables, described ---- */

/* Kind of a field. An expression turns an array of characters into a pointer; only the type of its
 * address shows that it is an array. */
/* clang-format off */
#define KIND(row, field)                                                     \
    _Generic(((const struct store_##row *)0)->field,                         \
             int64_t: STORE_INT64,                                           \
             int: STORE_INT,                                                 \
             bool: STORE_BOOL,                                               \
             double: STORE_DOUBLE,                                           \
             const char *: _Generic(&((const struct store_##row *)0)->field, \
                                    const char *const *: STORE_POINTER,      \
                                    default: STORE_CHARACTERS),              \
             struct store_bytes: STORE_BLOB)
/* clang-format on */

/* Does not compile if a field has the wrong type for its column. */
#define IS_INTEGER(kind) ((kind) == STORE_INT64 || (kind) == STORE_INT || (kind) == STORE_BOOL)
#define IS_REAL(kind)    ((kind) == STORE_DOUBLE)
#define IS_TEXT(kind)    ((kind) == STORE_CHARACTERS || (kind) == STORE_POINTER)
#define IS_BLOB(kind)    ((kind) == STORE_BLOB)
#define COLUMN(row, column, declaration, field, type, constraint, merge, empty, read) \
    _Static_assert(IS_##type(KIND(row, field)),                                       \
                   "the field of column " #column " of struct store_" #row " is no " #type);
#include "host/store/tables.def"

/* Row without values: columns of integers are STORE_NONE, except those of type int and bool, which
 * are 0. */
/* clang-format off */
#define BLANK_INTEGER(row, field) \
    .field = _Generic(((const struct store_##row *)0)->field, int64_t: STORE_NONE, default: 0),
#define BLANK_REAL(row, field) .field = (double)NAN,
#define BLANK_TEXT(row, field)
#define BLANK_BLOB(row, field)
#define NO_VIEWS
#define TABLE(row, table) const struct store_##row store_blank_##row = {
#define COLUMN(row, column, declaration, field, type, constraint, merge, empty, read) \
    BLANK_##type(row, field)
#define END(row, key, put) };
#include "host/store/tables.def"

#define EMPTY_TEXT false
#define EMPTY_NOTHING true
#define FIELD(row, name)                          \
    .offset = offsetof(struct store_##row, name), \
        .size = sizeof(((const struct store_##row *)0)->name), .kind = KIND(row, name)
#define TABLE(row, table) static const struct store_column columns_of_##row[] = {
#define OWNER(row, column, words)                                                           \
    {.name = #column, .type = "INTEGER", .constraint = words, .field = #column, .read = "", \
     .kind = STORE_OWNER},
#define COLUMN(row, column, declaration, member, sql, words, rule, empty, instead)          \
    {.name = #column, .type = #sql, .constraint = words, .field = #column, .read = instead, \
     .merge = STORE_##rule,                                                                 \
     .empty_is_null = EMPTY_##empty, FIELD(row, member)},
#define COMPUTED(row, declaration, member, words) \
    {.field = #member, .read = words, .merge = STORE_GIVEN, FIELD(row, member)},
#define END(row, key, put) };
/* clang-format on */
#include "host/store/tables.def"

static const struct store_table tables[STORE_TABLE_COUNT] = {
/* clang-format off */
#define TABLE(row, called)                                               \
    [STORE_TABLE_##row] = {.name = #called, .columns = columns_of_##row, \
        .row_size = sizeof(struct store_##row),
#define VIEW(row) \
    [STORE_TABLE_##row] = {.columns = columns_of_##row, .row_size = sizeof(struct store_##row),
#define END(row, key_text, put_rule)                                                \
    .count = sizeof columns_of_##row / sizeof columns_of_##row[0], .key = key_text, \
        .put = STORE_PUT_##put_rule},
/* clang-format on */
#include "host/store/tables.def"
};

const struct store_table *store_table(enum store_table_number which)
{
    return &tables[which];
}

/* ---- SQL text from the descriptions ---- */

/* Computed columns have the rule GIVEN, like the number of a row. */
static bool is_put(const struct store_column *column, unsigned rules)
{
    return (rules >> column->merge & 1u) != 0;
}

static void write_names(sqlite3_str *sql, const struct store_table *table)
{
    bool first = true;
    for (unsigned i = 0; i < table->count; i++) {
        if (!is_put(&table->columns[i], STORE_ALL_RULES))
            continue;
        sqlite3_str_appendf(sql, "%s%s", first ? "" : ", ", table->columns[i].name);
        first = false;
    }
}

static void write_places(sqlite3_str *sql, const struct store_table *table)
{
    const char *before = "(";
    for (unsigned i = 0; i < table->count; i++) {
        if (!is_put(&table->columns[i], STORE_ALL_RULES))
            continue;
        sqlite3_str_appendf(sql, "%s?", before);
        before = ",";
    }
    sqlite3_str_appendall(sql, ")");
}

static void write_merge(sqlite3_str *sql, const struct store_table *table)
{
    static const char *const becomes[] = {[STORE_FILL] = "coalesce(%s, excluded.%s)",
                                          [STORE_NEWER] = "coalesce(excluded.%s, %s)",
                                          [STORE_TAKE] = "excluded.%s",
                                          [STORE_JOIN] = "%s|excluded.%s"};
    const char *before = " ON CONFLICT DO UPDATE SET ";
    for (unsigned i = 0; i < table->count; i++) {
        const struct store_column *column = &table->columns[i];
        if (column->kind == STORE_OWNER || column->merge == STORE_KEEP ||
            column->merge == STORE_GIVEN)
            continue;
        sqlite3_str_appendf(sql, "%s%s=", before, column->name);
        sqlite3_str_appendf(sql, becomes[column->merge], column->name, column->name);
        before = ", ";
    }
}

char *store_insert_text(const struct store_table *table, unsigned rows)
{
    static const char *const verbs[] = {[STORE_PUT_ADD] = "INSERT",
                                        [STORE_PUT_FIRST] = "INSERT OR IGNORE",
                                        [STORE_PUT_LAST] = "INSERT OR REPLACE",
                                        [STORE_PUT_MERGE] = "INSERT"};
    sqlite3_str *sql = sqlite3_str_new(NULL);
    sqlite3_str_appendf(sql, "%s INTO %s(", verbs[table->put], table->name);
    write_names(sql, table);
    sqlite3_str_appendall(sql, ") VALUES");
    for (unsigned i = 0; i < rows; i++) {
        sqlite3_str_appendall(sql, i ? "," : "");
        write_places(sql, table);
    }
    if (table->put == STORE_PUT_MERGE)
        write_merge(sql, table);
    return sqlite3_str_finish(sql);
}

static char *store_update_text(const struct store_table *table)
{
    sqlite3_str *sql = sqlite3_str_new(NULL);
    const char *before = " SET ";
    sqlite3_str_appendf(sql, "UPDATE %s", table->name);
    for (unsigned i = 0; i < table->count; i++) {
        if (!is_put(&table->columns[i], 1u << STORE_TAKE))
            continue;
        sqlite3_str_appendf(sql, "%s%s=?", before, table->columns[i].name);
        before = ", ";
    }
    sqlite3_str_appendall(sql, " WHERE id=?");
    return sqlite3_str_finish(sql);
}

char *store_read_text(const struct store_table *table)
{
    sqlite3_str *sql = sqlite3_str_new(NULL);
    const char *before = "";
    for (unsigned i = 0; i < table->count; i++) {
        const struct store_column *column = &table->columns[i];
        if (column->kind == STORE_OWNER)
            continue;
        sqlite3_str_appendf(sql, column->read[0] ? "%s%s AS %s" : "%s%s", before,
                            column->read[0] ? column->read : column->field, column->field);
        before = ", ";
    }
    return sqlite3_str_finish(sql);
}

/* ---- values to and from SQLite ---- */

static int bind_integer(sqlite3_stmt *statement, int at, int64_t value)
{
    return value == STORE_NONE ? sqlite3_bind_null(statement, at)
                               : sqlite3_bind_int64(statement, at, value);
}

static int bind_real(sqlite3_stmt *statement, int at, double value)
{
    return isnan(value) ? sqlite3_bind_null(statement, at)
                        : sqlite3_bind_double(statement, at, value);
}

static int bind_field(sqlite3_stmt *statement, int at, const struct store_column *column,
                      const void *field)
{
    const struct store_bytes *bytes;
    switch ((enum store_kind)column->kind) {
    case STORE_INT: return sqlite3_bind_int(statement, at, *(const int *)field);
    case STORE_BOOL: return sqlite3_bind_int(statement, at, *(const bool *)field);
    case STORE_DOUBLE: return bind_real(statement, at, *(const double *)field);
    case STORE_POINTER:
        return sqlite3_bind_text(statement, at, *(const char *const *)field, -1, SQLITE_STATIC);
    case STORE_BLOB:
        bytes = field;
        return sqlite3_bind_blob64(statement, at, bytes->length ? bytes->data : "", bytes->length,
                                   SQLITE_STATIC);
    case STORE_CHARACTERS: break;
    case STORE_INT64:
    case STORE_OWNER: abort(); /* store_bind_row binds owners */
    }
    const char *text = field;
    return sqlite3_bind_text(statement, at, column->empty_is_null && !text[0] ? NULL : text, -1,
                             SQLITE_STATIC);
}

int store_bind_row(sqlite3_stmt *statement, const struct store_table *table, const int64_t *owners,
                   const void *row, unsigned rules, int *at)
{
    const struct store_column *end = table->columns + table->count;
    int code = SQLITE_OK, place = *at;
    for (const struct store_column *column = table->columns; column < end && code == SQLITE_OK;
         column++) {
        const void *field = (const char *)row + column->offset;
        if (!is_put(column, rules))
            continue;
        if (column->kind == STORE_INT64) /* fast path: most columns are integers */
            code = bind_integer(statement, place++, *(const int64_t *)field);
        else if (column->kind == STORE_OWNER)
            code = bind_integer(statement, place++, *owners++);
        else
            code = bind_field(statement, place++, column, field);
    }
    *at = place;
    return code;
}

static int store_bind_values(sqlite3_stmt *statement, const struct store_value *values,
                             size_t count)
{
    int code = SQLITE_OK;
    for (size_t i = 0; i < count && code == SQLITE_OK; i++) {
        int at = (int)i + 1;
        if (values[i].kind == STORE_INT64)
            code = bind_integer(statement, at, values[i].integer);
        else if (values[i].kind == STORE_DOUBLE)
            code = bind_real(statement, at, values[i].real);
        else
            code = sqlite3_bind_text(statement, at, values[i].text, -1, SQLITE_TRANSIENT);
    }
    return code;
}

/* A value of another type than matrig writes counts as absent. The value is read in place, which
 * takes half the time of asking SQLite for type and value. This is safe because only one thread
 * uses a statement. */
static int64_t store_integer(sqlite3_stmt *statement, int column)
{
    sqlite3_value *value = sqlite3_column_value(statement, column);
    int type = sqlite3_value_type(value);
    double real = type == SQLITE_FLOAT ? sqlite3_value_double(value) : 0.0;
    if (type != SQLITE_INTEGER && (type != SQLITE_FLOAT || !(fabs(real) < INTEGERS_EXACT)))
        return STORE_NONE;
    return sqlite3_value_int64(value);
}

static double store_real(sqlite3_stmt *statement, int column)
{
    sqlite3_value *value = sqlite3_column_value(statement, column);
    int type = sqlite3_value_type(value);
    double real = type == SQLITE_FLOAT || type == SQLITE_INTEGER ? sqlite3_value_double(value)
                                                                 : (double)NAN;
    return isfinite(real) ? real : (double)NAN;
}

static void take_field(sqlite3_stmt *statement, int at, const struct store_column *column,
                       void *field)
{
    switch ((enum store_kind)column->kind) {
    case STORE_INT: *(int *)field = (int)store_integer(statement, at); break;
    case STORE_BOOL: *(bool *)field = store_integer(statement, at) != 0; break;
    case STORE_DOUBLE: *(double *)field = store_real(statement, at); break;
    case STORE_POINTER:
        *(const char **)field = (const char *)sqlite3_column_text(statement, at);
        break;
    case STORE_CHARACTERS: store_text(statement, at, field, column->size); break;
    case STORE_BLOB: /* get the pointer before the length: SQLite may convert the value */
        ((struct store_bytes *)field)->data = sqlite3_column_blob(statement, at);
        ((struct store_bytes *)field)->length = (size_t)sqlite3_column_bytes(statement, at);
        break;
    case STORE_INT64:
    case STORE_OWNER: abort(); /* store_take_row handles these */
    }
}

void store_take_row(sqlite3_stmt *statement, const struct store_table *table, void *row)
{
    const struct store_column *end = table->columns + table->count;
    int at = 0;
    for (const struct store_column *column = table->columns; column < end; column++) {
        void *field = (char *)row + column->offset;
        if (column->kind == STORE_INT64) /* fast path: most columns are integers */
            *(int64_t *)field = store_integer(statement, at++);
        else if (column->kind != STORE_OWNER)
            take_field(statement, at++, column, field);
    }
}

/* ---- an open campaign ---- */

/* Last error number of the file system for one of the two files. */
static int last_number(sqlite3 *database, int which)
{
    sqlite3_file *file = NULL;
    int number = 0;
    if (sqlite3_file_control(database, "main", which, &file) == SQLITE_OK && file && file->pMethods)
        file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &number);
    return number;
}

/* System error number of the last failed call; 0: SQLite's code is enough. */
static int system_error_number(sqlite3 *database, int code)
{
    if (code == SQLITE_CORRUPT && last_number(database, SQLITE_FCNTL_FILE_POINTER) == EIO)
        return EIO; /* SQLite's code for a page that could not be read */
    if (code != SQLITE_IOERR && code != SQLITE_CANTOPEN)
        return 0;
    int journal = last_number(database, SQLITE_FCNTL_JOURNAL_POINTER),
        number = journal ? journal : last_number(database, SQLITE_FCNTL_FILE_POINTER);
    number = number ? number : sqlite3_system_errno(database);
    return number == ENOENT ? 0 : number; /* some files are optional */
}

enum mr_status store_failed(struct store *store, const char *doing, struct error *error)
{
    int code = sqlite3_errcode(store->database) & 0xff;
    const char *text = sqlite3_errmsg(store->database);
    char system[STORE_TEXT];
    int number = system_error_number(store->database, code);
    if (number == ENOSPC || number == EDQUOT)
        code = SQLITE_FULL;
    if (number == EIO)
        code = SQLITE_IOERR;
    text = number ? strerror(number) : text;
    store->refused = code;
    store->grown = number == EFBIG;
    if (store->grown || code == SQLITE_FULL || number)
        store_file_system(store->path, system);
    if (store->grown)
        return error_set(error, MR_FULL,
                         "cannot %s (the file has reached the size limit of ulimit -f or of the "
                         "file system, %s): %s; continue in a new campaign",
                         doing, system, store->path);
    switch (code) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
        return error_set(
            error, MR_MALFORMED,
            "not a campaign database, or damaged (%s): %s; give a database that matrig log created",
            text, store->path);
    case SQLITE_INTERRUPT:
        return error_set(
            error, MR_MALFORMED,
            "more data than the file can hold: %s; the campaign is damaged, use an earlier copy",
            store->path);
    case SQLITE_TOOBIG:
        return error_set(error, MR_MALFORMED,
                         "a value longer than any that matrig writes (%s): %s; the campaign is "
                         "damaged, use an earlier copy",
                         text, store->path);
    case SQLITE_FULL:
        return error_set(error, MR_FULL, "cannot %s (%s; %s): %s; free space on the disk", doing,
                         text, system, store->path);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        store_holder(store->path, system);
        return error_set(error, MR_IO, "cannot %s (%s): %s; %s", doing, text, store->path, system);
    default:
        return error_set(error, MR_IO, "cannot %s (%s%s%s): %s; check path, rights and disk", doing,
                         text, number ? "; " : "", number ? system : "", store->path);
    }
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

/* If a statement begins while another one returns rows, its steps count for the other one. */
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

void store_text(sqlite3_stmt *statement, int column, char *out, size_t size)
{
    const char *text = (const char *)sqlite3_column_text(statement, column);
    snprintf(out, size, "%s", text ? text : "");
    size_t length = strlen(out), cut = length;
    if (text && text[length]) { /* do not cut a UTF-8 character */
        while (cut > 0 && ((unsigned char)text[cut] & 0xc0) == 0x80)
            cut--;
        out[cut] = '\0';
    }
    for (char *p = out; *p; p++) {
        /* another program may have written the text: remove control characters (C0, DEL, C1 as
         * UTF-8), which a terminal would execute */
        if ((unsigned char)*p < 0x20 || *p == 0x7f)
            *p = ' ';
        else if ((unsigned char)*p == 0xc2 && ((unsigned char)p[1] & 0xe0) == 0x80)
            p[0] = p[1] = ' ';
    }
}

/* ---- statements, prepared at their first use ---- */

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

/* Abort: the statement does not match its declaration, so none of its results can be trusted. */
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
    if (store->insert[which])
        return MR_OK;
    if (STORE_IS_LATE(which) && !store_has_late(store->database) &&
        store_tables_make(store->database, true) != SQLITE_OK)
        return store_failed(store, "set up", error);
    return prepare(store, store_insert_text(store_table(which), 1), &store->insert[which], error);
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
    for (int i = 0; i < STORE_TABLE_COUNT && status == MR_OK; i++) {
        if (store_table((enum store_table_number)i)->name)
            status = prepare_insert(store, error, (enum store_table_number)i);
    }
    for (int i = 0; i < STORE_STATEMENT_COUNT && status == MR_OK; i++)
        status = prepare_named(store, error, (enum store_statement)i);
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

/* Run a statement without result rows. */
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

/* ---- inserting rows ---- */

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
    if (status == MR_OK && STORE_IS_LATE(statements[which].row) && !store_has_late(store->database))
        status = MR_TOO_FEW;
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

/* A row outlives the step of its statement, so its pointers would point to freed memory. */
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
            status = error_set(error, MR_FULL, "out of memory, reading %s; close other programs",
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

/* ---- schema ----
 *
 * The tables as SQL. */

static void write_columns(sqlite3_str *sql, const struct store_table *table)
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
    write_columns(sql, table);
    sqlite3_str_appendf(sql, "%s", table->key);
    char *text = sqlite3_str_finish(sql);
    int code = text ? sqlite3_exec(database, text, NULL, NULL, NULL) : SQLITE_NOMEM;
    sqlite3_free(text);
    return code;
}

int store_tables_make(sqlite3 *database, bool late)
{
    int code = SQLITE_OK;
    bool wanted = false; /* what a table has besides it follows it */
#define TABLE(row, table)                              \
    wanted = STORE_IS_LATE(STORE_TABLE_##row) == late; \
    if (wanted && code == SQLITE_OK)                   \
        code = make_table(database, STORE_TABLE_##row);
#define NO_VIEWS
#define ALSO(sql)                    \
    if (wanted && code == SQLITE_OK) \
        code = sqlite3_exec(database, sql, NULL, NULL, NULL);
#include "host/store/tables.def"
    return code;
}

bool store_has_late(sqlite3 *database)
{
    sqlite3_stmt *s = NULL;
    sqlite3_prepare_v2(database, "SELECT 1 FROM main.sqlite_schema WHERE name='records'", -1, &s,
                       NULL);
    bool has = sqlite3_step(s) == SQLITE_ROW;
    sqlite3_finalize(s);
    return has;
}
