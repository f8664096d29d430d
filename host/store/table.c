#include "host/store/table.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "host/base/output.h"
#include "host/base/xmalloc.h"

/* Pages of a damaged file can form a loop. A statement is therefore stopped after many more steps
 * than it could need in an undamaged file of that size. A scan needs fewer than 2 steps per byte;
 * sorting and look-ups for each row need less than ten times as many. */
#define SQL_STEP_LIMIT_MIN           20000000
#define SQL_STEP_LIMIT_PER_FILE_BYTE 32
#define SQL_STEPS_PER_CALLBACK       10000

/* 2^53: a double represents every smaller integer exactly */
#define EXACT_INTEGER_MAX 9007199254740992.0

/* ---- descriptions of the tables, from tables.def ---- */

/* Kind of a field, from its type. _Generic converts an array of characters to a pointer; the type
 * of its address distinguishes arrays from pointers. */
/* clang-format off */
#define FIELD_KIND(row, field)                                                     \
    _Generic(((const struct store_##row *)0)->field,                         \
             int64_t: STORE_INT64,                                           \
             int: STORE_INT,                                                 \
             bool: STORE_BOOL,                                               \
             double: STORE_DOUBLE,                                           \
             const char *: _Generic(&((const struct store_##row *)0)->field, \
                                    const char *const *: STORE_TEXT_POINTER,      \
                                    default: STORE_TEXT_ARRAY),              \
             struct store_bytes: STORE_BLOB)
/* clang-format on */

/* Compile-time check that each field has the right type for its column. */
#define IS_INTEGER(kind) ((kind) == STORE_INT64 || (kind) == STORE_INT || (kind) == STORE_BOOL)
#define IS_REAL(kind)    ((kind) == STORE_DOUBLE)
#define IS_TEXT(kind)    ((kind) == STORE_TEXT_ARRAY || (kind) == STORE_TEXT_POINTER)
#define IS_BLOB(kind)    ((kind) == STORE_BLOB)
#define COLUMN(row, column, declaration, field, type, constraint, merge, empty, read) \
    _Static_assert(IS_##type(FIELD_KIND(row, field)),                                 \
                   "the field of column " #column " of struct store_" #row " is no " #type);
#include "host/store/tables.def"

/* Rows in which every field is missing. Fields of type int and bool cannot be STORE_NONE and are
 * 0. */
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
#define TABLE_END(row, key, put) };
#include "host/store/tables.def"

#define EMPTY_AS_TEXT false
#define EMPTY_AS_NULL true
#define FIELD_LAYOUT(row, name)                          \
    .field_offset = offsetof(struct store_##row, name), \
        .field_size = sizeof(((const struct store_##row *)0)->name), .kind = FIELD_KIND(row, name)
#define TABLE(row, table) static const struct store_column columns_of_##row[] = {
#define OWNER(row, column, words)                                                           \
    {.name = #column, .type = "INTEGER", .constraint = words, .field = #column, .read_sql = "", \
     .kind = STORE_OWNER},
#define COLUMN(row, column, declaration, member, sql, words, rule, empty, instead)          \
    {.name = #column, .type = #sql, .constraint = words, .field = #column, .read_sql = instead, \
     .merge = STORE_MERGE_##rule,                                                                 \
     .empty_is_null = EMPTY_##empty, FIELD_LAYOUT(row, member)},
#define COMPUTED(row, declaration, member, words) \
    {.field = #member, .read_sql = words, .merge = STORE_MERGE_READ_ONLY,                   \
     FIELD_LAYOUT(row, member)},
#define TABLE_END(row, key, put) };
/* clang-format on */
#include "host/store/tables.def"

static const struct store_table tables[STORE_TABLE_COUNT] = {
/* clang-format off */
#define TABLE(row, called)                                               \
    [STORE_TABLE_##row] = {.name = #called, .columns = columns_of_##row, \
        .row_size = sizeof(struct store_##row),
#define VIEW(row) \
    [STORE_TABLE_##row] = {.columns = columns_of_##row, .row_size = sizeof(struct store_##row),
#define TABLE_END(row, key_text, put_rule)                                                \
    .column_count = sizeof columns_of_##row / sizeof columns_of_##row[0], .key = key_text, \
        .put = STORE_PUT_##put_rule},
/* clang-format on */
#include "host/store/tables.def"
};

const struct store_table *store_table_get(enum store_table_number which)
{
    return &tables[which];
}

/* ---- SQL text from the descriptions ---- */

/* True if a put function writes the column under these merge rules. */
static bool is_column_written(const struct store_column *column, unsigned rules)
{
    return (rules >> column->merge & 1u) != 0;
}

static void write_column_names(sqlite3_str *sql, const struct store_table *table)
{
    bool first = true;
    for (unsigned i = 0; i < table->column_count; i++) {
        if (!is_column_written(&table->columns[i], STORE_WRITTEN_MERGE_RULES))
            continue;
        sqlite3_str_appendf(sql, "%s%s", first ? "" : ", ", table->columns[i].name);
        first = false;
    }
}

static void write_placeholders(sqlite3_str *sql, const struct store_table *table)
{
    const char *before = "(";
    for (unsigned i = 0; i < table->column_count; i++) {
        if (!is_column_written(&table->columns[i], STORE_WRITTEN_MERGE_RULES))
            continue;
        sqlite3_str_appendf(sql, "%s?", before);
        before = ",";
    }
    sqlite3_str_appendall(sql, ")");
}

static void write_merge(sqlite3_str *sql, const struct store_table *table)
{
    static const char *const becomes[] = {[STORE_MERGE_FILL] = "coalesce(%s, excluded.%s)",
                                          [STORE_MERGE_PRESENT] = "coalesce(excluded.%s, %s)",
                                          [STORE_MERGE_REPLACE] = "excluded.%s",
                                          [STORE_MERGE_BITS] = "%s|excluded.%s"};
    const char *before = " ON CONFLICT DO UPDATE SET ";
    for (unsigned i = 0; i < table->column_count; i++) {
        const struct store_column *column = &table->columns[i];
        if (column->kind == STORE_OWNER || column->merge == STORE_MERGE_KEEP ||
            column->merge == STORE_MERGE_READ_ONLY)
            continue;
        sqlite3_str_appendf(sql, "%s%s=", before, column->name);
        sqlite3_str_appendf(sql, becomes[column->merge], column->name, column->name);
        before = ", ";
    }
}

char *store_make_insert_sql(const struct store_table *table, unsigned rows)
{
    static const char *const verbs[] = {[STORE_PUT_ADD] = "INSERT",
                                        [STORE_PUT_FIRST] = "INSERT OR IGNORE",
                                        [STORE_PUT_LAST] = "INSERT OR REPLACE",
                                        [STORE_PUT_MERGE] = "INSERT"};
    sqlite3_str *sql = sqlite3_str_new(NULL);
    sqlite3_str_appendf(sql, "%s INTO %s(", verbs[table->put], table->name);
    write_column_names(sql, table);
    sqlite3_str_appendall(sql, ") VALUES");
    for (unsigned i = 0; i < rows; i++) {
        sqlite3_str_appendall(sql, i ? "," : "");
        write_placeholders(sql, table);
    }
    if (table->put == STORE_PUT_MERGE)
        write_merge(sql, table);
    return sqlite3_str_finish(sql);
}

static char *make_update_sql(const struct store_table *table)
{
    sqlite3_str *sql = sqlite3_str_new(NULL);
    const char *before = " SET ";
    sqlite3_str_appendf(sql, "UPDATE %s", table->name);
    for (unsigned i = 0; i < table->column_count; i++) {
        if (!is_column_written(&table->columns[i], 1u << STORE_MERGE_REPLACE))
            continue;
        sqlite3_str_appendf(sql, "%s%s=?", before, table->columns[i].name);
        before = ", ";
    }
    sqlite3_str_appendall(sql, " WHERE id=?");
    return sqlite3_str_finish(sql);
}

char *store_make_column_list(const struct store_table *table)
{
    sqlite3_str *sql = sqlite3_str_new(NULL);
    const char *before = "";
    for (unsigned i = 0; i < table->column_count; i++) {
        const struct store_column *column = &table->columns[i];
        if (column->kind == STORE_OWNER)
            continue;
        sqlite3_str_appendf(sql, column->read_sql[0] ? "%s%s AS %s" : "%s%s", before,
                            column->read_sql[0] ? column->read_sql : column->field, column->field);
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
    switch ((enum store_field_kind)column->kind) {
    case STORE_INT: return sqlite3_bind_int(statement, at, *(const int *)field);
    case STORE_BOOL: return sqlite3_bind_int(statement, at, *(const bool *)field);
    case STORE_DOUBLE: return bind_real(statement, at, *(const double *)field);
    case STORE_TEXT_POINTER:
        return sqlite3_bind_text(statement, at, *(const char *const *)field, -1, SQLITE_STATIC);
    case STORE_BLOB:
        bytes = field;
        return sqlite3_bind_blob64(statement, at, bytes->length ? bytes->data : "", bytes->length,
                                   SQLITE_STATIC);
    case STORE_TEXT_ARRAY: break;
    case STORE_INT64:
    case STORE_OWNER: abort(); /* unreachable: store_bind_row binds owner columns */
    }
    const char *text = field;
    return sqlite3_bind_text(statement, at, column->empty_is_null && !text[0] ? NULL : text, -1,
                             SQLITE_STATIC);
}

int store_bind_row(sqlite3_stmt *statement, const struct store_table *table, const int64_t *owners,
                   const void *row, unsigned rules, int *at)
{
    const struct store_column *end = table->columns + table->column_count;
    int code = SQLITE_OK, place = *at;
    for (const struct store_column *column = table->columns; column < end && code == SQLITE_OK;
         column++) {
        const void *field = (const char *)row + column->field_offset;
        if (!is_column_written(column, rules))
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

static int bind_values(sqlite3_stmt *statement, const struct store_value *values, size_t count)
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

/* Reads an integer column; a value of another type is missing. Uses sqlite3_column_value, which is
 * twice as fast as reading type and value separately, and safe because only one thread uses a
 * statement. */
static int64_t read_integer(sqlite3_stmt *statement, int column)
{
    sqlite3_value *value = sqlite3_column_value(statement, column);
    int type = sqlite3_value_type(value);
    double real = type == SQLITE_FLOAT ? sqlite3_value_double(value) : 0.0;
    if (type != SQLITE_INTEGER && (type != SQLITE_FLOAT || !(fabs(real) < EXACT_INTEGER_MAX)))
        return STORE_NONE;
    return sqlite3_value_int64(value);
}

static double read_real(sqlite3_stmt *statement, int column)
{
    sqlite3_value *value = sqlite3_column_value(statement, column);
    int type = sqlite3_value_type(value);
    double real = type == SQLITE_FLOAT || type == SQLITE_INTEGER ? sqlite3_value_double(value)
                                                                 : (double)NAN;
    return isfinite(real) ? real : (double)NAN;
}

static void read_field(sqlite3_stmt *statement, int at, const struct store_column *column,
                       void *field)
{
    switch ((enum store_field_kind)column->kind) {
    case STORE_INT: *(int *)field = (int)read_integer(statement, at); break;
    case STORE_BOOL: *(bool *)field = read_integer(statement, at) != 0; break;
    case STORE_DOUBLE: *(double *)field = read_real(statement, at); break;
    case STORE_TEXT_POINTER:
        *(const char **)field = (const char *)sqlite3_column_text(statement, at);
        break;
    case STORE_TEXT_ARRAY: store_copy_text(statement, at, field, column->field_size); break;
    case STORE_BLOB: /* read the pointer before the length, because SQLite may convert the value */
        ((struct store_bytes *)field)->data = sqlite3_column_blob(statement, at);
        ((struct store_bytes *)field)->length = (size_t)sqlite3_column_bytes(statement, at);
        break;
    case STORE_INT64:
    case STORE_OWNER: abort(); /* unreachable: store_read_row reads owner columns */
    }
}

void store_read_row(sqlite3_stmt *statement, const struct store_table *table, void *row)
{
    const struct store_column *end = table->columns + table->column_count;
    int at = 0;
    for (const struct store_column *column = table->columns; column < end; column++) {
        void *field = (char *)row + column->field_offset;
        if (column->kind == STORE_INT64) /* fast path: most columns are integers */
            *(int64_t *)field = read_integer(statement, at++);
        else if (column->kind != STORE_OWNER)
            read_field(statement, at++, column, field);
    }
}

/* ---- an open campaign ---- */

/* Returns the last errno of a system call on the database file or the journal. */
static int get_last_errno(sqlite3 *database, int which)
{
    sqlite3_file *file = NULL;
    int number = 0;
    if (sqlite3_file_control(database, "main", which, &file) == SQLITE_OK && file && file->pMethods)
        file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &number);
    return number;
}

/* Returns the errno of the last failed call; 0: SQLite's own code describes the error well
 * enough. */
static int find_system_errno(sqlite3 *database, int code)
{
    if (code == SQLITE_CORRUPT && get_last_errno(database, SQLITE_FCNTL_FILE_POINTER) == EIO)
        return EIO; /* SQLite reports an unreadable page as a corrupt database */
    if (code != SQLITE_IOERR && code != SQLITE_CANTOPEN)
        return 0;
    int journal = get_last_errno(database, SQLITE_FCNTL_JOURNAL_POINTER),
        number = journal ? journal : get_last_errno(database, SQLITE_FCNTL_FILE_POINTER);
    number = number ? number : sqlite3_system_errno(database);
    /* ignore a missing file: some files of a database are optional */
    return number == ENOENT ? 0 : number;
}

enum mr_status store_set_error(struct store *store, const char *action, struct error *error)
{
    int code = sqlite3_errcode(store->database) & 0xff;
    const char *text = sqlite3_errmsg(store->database);
    char system[STORE_TEXT_SIZE];
    int number = find_system_errno(store->database, code);
    if (number == ENOSPC || number == EDQUOT)
        code = SQLITE_FULL;
    if (number == EIO)
        code = SQLITE_IOERR;
    text = number ? strerror(number) : text;
    store->last_failed_code = code;
    store->size_limit_reached = number == EFBIG;
    if (store->size_limit_reached || code == SQLITE_FULL || number)
        store_describe_file_system(store->path, system);
    if (store->size_limit_reached)
        return error_set(error, MR_FULL,
                         "cannot %s (the file has reached the size limit of ulimit -f or of the "
                         "file system, %s): %s; continue in a new campaign",
                         action, system, store->path);
    switch (code) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
        return error_set(
            error, MR_MALFORMED,
            "not a campaign database, or damaged (%s): %s; give a database that matrig log created",
            text, store->path);
    case SQLITE_INTERRUPT:
        return error_set(error, MR_MALFORMED,
                         "the campaign is damaged, because its tables refer to more data than the "
                         "file can contain: %s; use an earlier copy",
                         store->path);
    case SQLITE_TOOBIG:
        return error_set(error, MR_MALFORMED,
                         "the campaign is damaged, because it contains a value that is too long "
                         "(%s): %s; use an earlier copy",
                         text, store->path);
    case SQLITE_FULL:
        return error_set(error, MR_FULL, "cannot %s (%s; %s): %s; free space on the disk", action,
                         text, system, store->path);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        store_describe_lock_holder(store->path, system);
        return error_set(error, MR_IO, "cannot %s (%s): %s; %s", action, text, store->path, system);
    default:
        return error_set(error, MR_IO, "cannot %s (%s%s%s): %s; check path, rights and disk",
                         action, text, number ? "; " : "", number ? system : "", store->path);
    }
}

static int64_t get_file_bytes(const struct store *store)
{
    char journal[4200];
    struct stat info;
    int64_t bytes = stat(store->path, &info) == 0 ? (int64_t)info.st_size : 0;
    snprintf(journal, sizeof journal, "%s-wal", store->path);
    return bytes + (stat(journal, &info) == 0 ? (int64_t)info.st_size : 0);
}

static int is_step_limit_exceeded(void *context)
{
    struct store *store = context;
    store->sql_step_count += SQL_STEPS_PER_CALLBACK;
    return store->sql_step_count > SQL_STEP_LIMIT_MIN &&
           store->sql_step_count >
               SQL_STEP_LIMIT_MIN + SQL_STEP_LIMIT_PER_FILE_BYTE * get_file_bytes(store);
}

/* Called when a statement starts. Resets the count of steps, unless another statement is still
 * running. */
static int reset_step_count(unsigned event, void *context, void *begins, void *text)
{
    struct store *store = context;
    (void)event, (void)text;
    if (store->sql_step_count == 0)
        return 0;
    for (sqlite3_stmt *s = sqlite3_next_stmt(store->database, NULL); s;
         s = sqlite3_next_stmt(store->database, s)) {
        if (s != begins && sqlite3_stmt_busy(s))
            return 0;
    }
    store->sql_step_count = 0;
    return 0;
}

void store_limit_sql_steps(struct store *store)
{
    sqlite3_progress_handler(store->database, SQL_STEPS_PER_CALLBACK, is_step_limit_exceeded,
                             store);
    sqlite3_trace_v2(store->database, SQLITE_TRACE_STMT, reset_step_count, store);
}

enum mr_status store_execute(struct store *store, const char *sql, const char *action,
                             struct error *error)
{
    return sqlite3_exec(store->database, sql, NULL, NULL, NULL) == SQLITE_OK
             ? MR_OK
             : store_set_error(store, action, error);
}

void store_copy_text(sqlite3_stmt *statement, int column, char *out, size_t size)
{
    const char *text = (const char *)sqlite3_column_text(statement, column);
    snprintf(out, size, "%s", text ? text : "");
    size_t length = strlen(out), cut = length;
    if (text && text[length]) { /* do not split a UTF-8 character */
        while (cut > 0 && ((unsigned char)text[cut] & 0xc0) == 0x80)
            cut--;
        out[cut] = '\0';
    }
    text_blank_controls(out); /* another program may have written the text */
}

/* ---- statements, prepared at their first use ---- */

#define NO_TABLE STORE_TABLE_COUNT

static const struct {
    const char *name, *sql;
    enum store_table_number row;
    bool has_column_list;
} statements[STORE_STATEMENT_COUNT] = {
#define ROW_QUERY(NAME, row, sql) {#NAME, sql, STORE_TABLE_##row, true},
#define SQL_QUERY(NAME, row, sql) {#NAME, sql, STORE_TABLE_##row, false},
#define STATEMENT(NAME, sql)      {#NAME, sql, NO_TABLE, false},
#include "host/store/queries.def"
};

/* Ends the program: the statement does not match its declaration in queries.def. */
static void abort_invalid_statement(const char *name, const char *why)
{
    fprintf(stderr, "matrig: statement %s of host/store: %s\n", name, why);
    abort();
}

static enum mr_status prepare_sql(struct store *store, char *sql, sqlite3_stmt **statement,
                                  struct error *error)
{
    int code = sql ? sqlite3_prepare_v3(store->database, sql, -1, SQLITE_PREPARE_PERSISTENT,
                                        statement, NULL)
                   : SQLITE_NOMEM;
    sqlite3_free(sql);
    return code == SQLITE_OK ? MR_OK : store_set_error(store, "use", error);
}

static void check_columns(sqlite3_stmt *statement, const struct store_table *table,
                          const char *name)
{
    int at = 0;
    for (unsigned i = 0; i < table->column_count; i++) {
        const struct store_column *column = &table->columns[i];
        if (column->kind == STORE_OWNER)
            continue;
        const char *is = sqlite3_column_name(statement, at++);
        if (!is || strcmp(is, column->field) != 0)
            abort_invalid_statement(name, "the columns differ from the fields of the struct");
    }
    if (sqlite3_column_count(statement) != at)
        abort_invalid_statement(name, "the statement has more columns than the struct");
}

static enum mr_status prepare_statement(struct store *store, struct error *error,
                                        enum store_statement which)
{
    sqlite3_stmt **statement = &store->statement[which];
    const struct store_table *row = statements[which].row == NO_TABLE
                                      ? NULL
                                      : store_table_get(statements[which].row);
    if (*statement)
        return MR_OK;
    char *list = statements[which].has_column_list ? store_make_column_list(row) : NULL;
    char *sql = list ? sqlite3_mprintf("SELECT %s FROM %s", list, statements[which].sql)
                     : sqlite3_mprintf("%s", statements[which].sql);
    sqlite3_free(list);
    enum mr_status status = prepare_sql(store, sql, statement, error);
    if (status == MR_OK && row)
        check_columns(*statement, row, statements[which].name);
    return status;
}

static enum mr_status prepare_insert(struct store *store, struct error *error,
                                     enum store_table_number which)
{
    if (store->insert[which])
        return MR_OK;
    if (STORE_TABLE_IS_ON_DEMAND(which) && !store_has_on_demand_tables(store->database) &&
        store_create_tables(store->database, true) != SQLITE_OK)
        return store_set_error(store, "set up", error);
    return prepare_sql(store, store_make_insert_sql(store_table_get(which), 1),
                       &store->insert[which], error);
}

static enum mr_status prepare_update(struct store *store, struct error *error,
                                     enum store_table_number which)
{
    return store->update[which] ? MR_OK
                                : prepare_sql(store, make_update_sql(store_table_get(which)),
                                              &store->update[which], error);
}

enum mr_status store_prepare_all(struct store *store, struct error *error)
{
    enum mr_status status = MR_OK;
    for (int i = 0; i < STORE_TABLE_COUNT && status == MR_OK; i++) {
        if (store_table_get((enum store_table_number)i)->name)
            status = prepare_insert(store, error, (enum store_table_number)i);
    }
    for (int i = 0; i < STORE_STATEMENT_COUNT && status == MR_OK; i++)
        status = prepare_statement(store, error, (enum store_statement)i);
    return status == MR_OK ? prepare_update(store, error, STORE_TABLE_landing) : status;
}

void store_for_each_statement(struct store *store, int (*each)(sqlite3_stmt *statement))
{
    for (size_t i = 0; i < STORE_STATEMENT_COUNT; i++)
        each(store->statement[i]);
    for (size_t i = 0; i < STORE_TABLE_COUNT; i++) {
        each(store->insert[i]);
        each(store->update[i]);
    }
    each(store->insert_frames);
}

/* Runs a bound statement that returns no rows. `bound`: SQLite's code from binding. */
static enum mr_status run_prepared(struct store *store, struct error *error,
                                   sqlite3_stmt *statement, int bound)
{
    enum mr_status status = MR_OK;
    if (bound != SQLITE_OK)
        return store_set_error(store, "use", error);
    if (sqlite3_step(statement) != SQLITE_DONE)
        status = store_set_error(store, "write", error);
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
    return run_prepared(store, error, statement,
                        store_bind_row(statement, store_table_get(which), owners, row,
                                       STORE_WRITTEN_MERGE_RULES, &at));
}

enum mr_status store_update(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, int64_t id)
{
    int at = 1;
    enum mr_status status = prepare_update(store, error, which);
    if (status != MR_OK)
        return status;
    sqlite3_stmt *statement = store->update[which];
    int code = store_bind_row(statement, store_table_get(which), NULL, row,
                              1u << STORE_MERGE_REPLACE, &at);
    return run_prepared(store, error, statement,
                        code == SQLITE_OK ? sqlite3_bind_int64(statement, at, id) : code);
}

/* ---- statements by name ---- */

static enum mr_status bind_statement(struct store *store, struct error *error,
                                     enum store_statement which, const struct store_value *values,
                                     size_t count)
{
    enum mr_status status = prepare_statement(store, error, which);
    if (status != MR_OK)
        return status;
    if (sqlite3_bind_parameter_count(store->statement[which]) != (int)count)
        abort_invalid_statement(statements[which].name,
                                "the statement has a different number of parameters");
    return bind_values(store->statement[which], values, count) == SQLITE_OK
             ? MR_OK
             : store_set_error(store, "use", error);
}

enum mr_status store_run_statement(struct store *store, struct error *error,
                                   enum store_statement which, const struct store_value *values,
                                   size_t count)
{
    enum mr_status status = bind_statement(store, error, which, values, count);
    return status == MR_OK ? run_prepared(store, error, store->statement[which], SQLITE_OK)
                           : status;
}

enum mr_status store_query(struct store *store, struct error *error, enum store_statement which,
                           sqlite3_stmt **statement, const struct store_value *values, size_t count)
{
    enum mr_status status = store_frames_flush(store, error);
    if (status == MR_OK && STORE_TABLE_IS_ON_DEMAND(statements[which].row) &&
        !store_has_on_demand_tables(store->database))
        status = MR_TOO_FEW;
    if (status == MR_OK)
        status = bind_statement(store, error, which, values, count);
    *statement = store->statement[which];
    return status;
}

enum mr_status store_step(struct store *store, sqlite3_stmt *statement, struct error *error)
{
    int code = sqlite3_step(statement);
    if (code == SQLITE_ROW)
        return MR_OK;
    enum mr_status status = code == SQLITE_DONE ? MR_TOO_FEW
                                                : store_set_error(store, "read", error);
    sqlite3_reset(statement);
    return status;
}

enum mr_status store_read_next(struct store *store, struct error *error, enum store_statement which,
                               sqlite3_stmt *statement, void *row)
{
    enum mr_status status = store_step(store, statement, error);
    if (status == MR_OK)
        store_read_row(statement, store_table_get(statements[which].row), row);
    return status;
}

/* Ends the program if the struct has pointers: they would be invalid after the next step. */
static void check_no_pointers(enum store_statement which)
{
    const struct store_table *table = store_table_get(statements[which].row);
    for (unsigned i = 0; i < table->column_count; i++) {
        if (table->columns[i].kind == STORE_TEXT_POINTER || table->columns[i].kind == STORE_BLOB)
            abort_invalid_statement(
                statements[which].name,
                "the rows have pointers, which are valid only until the next row");
    }
}

enum mr_status store_read_one(struct store *store, struct error *error, enum store_statement which,
                              void *row, const struct store_value *values, size_t count)
{
    sqlite3_stmt *statement;
    check_no_pointers(which);
    enum mr_status status = store_query(store, error, which, &statement, values, count);
    if (status == MR_OK)
        status = store_read_next(store, error, which, statement, row);
    if (status == MR_OK)
        sqlite3_reset(statement);
    return status;
}

enum mr_status store_read_number(struct store *store, struct error *error,
                                 enum store_statement which, int64_t *value,
                                 const struct store_value *values, size_t count)
{
    sqlite3_stmt *statement;
    enum mr_status status = store_query(store, error, which, &statement, values, count);
    if (status == MR_OK)
        status = store_step(store, statement, error);
    if (status != MR_OK)
        return status;
    *value = read_integer(statement, 0);
    sqlite3_reset(statement);
    return MR_OK;
}

enum mr_status store_read_all(struct store *store, struct error *error, enum store_statement which,
                              void **rows, size_t *count, const struct store_value *values,
                              size_t values_count)
{
    size_t size = store_table_get(statements[which].row)->row_size;
    sqlite3_stmt *statement;
    check_no_pointers(which);
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, which, &statement, values, values_count);
    while (status == MR_OK) {
        if (!list_grow(rows, *count, size)) {
            sqlite3_reset(statement);
            status = error_set(error, MR_FULL, "out of memory, reading %s; close other programs",
                               store->path);
        } else if ((status = store_read_next(store, error, which, statement,
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

/* ---- creation of the tables ---- */

static void write_column_definitions(sqlite3_str *sql, const struct store_table *table)
{
    bool first = true;
    for (unsigned i = 0; i < table->column_count; i++) {
        const struct store_column *column = &table->columns[i];
        if (!column->name)
            continue;
        sqlite3_str_appendf(sql, "%s%s %s%s%s", first ? "" : ", ", column->name, column->type,
                            column->constraint[0] ? " " : "", column->constraint);
        first = false;
    }
}

static int create_table(sqlite3 *database, enum store_table_number which)
{
    const struct store_table *table = store_table_get(which);
    sqlite3_str *sql = sqlite3_str_new(database);
    sqlite3_str_appendf(sql, "CREATE TABLE %s(", table->name);
    write_column_definitions(sql, table);
    sqlite3_str_appendf(sql, "%s", table->key);
    char *text = sqlite3_str_finish(sql);
    int code = text ? sqlite3_exec(database, text, NULL, NULL, NULL) : SQLITE_NOMEM;
    sqlite3_free(text);
    return code;
}

int store_create_tables(sqlite3 *database, bool on_demand)
{
    int code = SQLITE_OK;
    bool wanted = false; /* `wanted` is kept for the indexes and triggers that follow a table */
#define TABLE(row, table)                                              \
    wanted = STORE_TABLE_IS_ON_DEMAND(STORE_TABLE_##row) == on_demand; \
    if (wanted && code == SQLITE_OK)                                   \
        code = create_table(database, STORE_TABLE_##row);
#define NO_VIEWS
#define INDEX_OR_TRIGGER(sql)        \
    if (wanted && code == SQLITE_OK) \
        code = sqlite3_exec(database, sql, NULL, NULL, NULL);
#include "host/store/tables.def"
    return code;
}

bool store_has_on_demand_tables(sqlite3 *database)
{
    sqlite3_stmt *s = NULL;
    sqlite3_prepare_v2(database, "SELECT 1 FROM main.sqlite_schema WHERE name='records'", -1, &s,
                       NULL);
    bool has = sqlite3_step(s) == SQLITE_ROW;
    sqlite3_finalize(s);
    return has;
}
