#include "host/store/store_sql.h"

#include <math.h>
#include <stdlib.h>

/* ---- the tables, described ---- */

/* What a field is. In an expression an array of characters is a pointer; only its address says what
 * it is. */
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

/* A field that cannot hold what its column has does not compile. */
#define IS_INTEGER(kind) ((kind) == STORE_INT64 || (kind) == STORE_INT || (kind) == STORE_BOOL)
#define IS_REAL(kind)    ((kind) == STORE_DOUBLE)
#define IS_TEXT(kind)    ((kind) == STORE_CHARACTERS || (kind) == STORE_POINTER)
#define IS_BLOB(kind)    ((kind) == STORE_BLOB)
#define COLUMN(row, column, declaration, field, type, constraint, merge, empty, read) \
    _Static_assert(IS_##type(KIND(row, field)),                                       \
                   "the field of column " #column " of struct store_" #row " is no " #type);
#include "host/store/tables.def"

/* What says nothing: all columns of integers are STORE_NONE, but those that count as one or
 * none. */
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

/* ---- in words ---- */

/* What is computed is GIVEN, like the number of a row. */
static bool is_put(const struct store_column *column, unsigned rules)
{
    return (rules >> column->merge & 1u) != 0;
}

static void say_names(sqlite3_str *sql, const struct store_table *table)
{
    bool first = true;
    for (unsigned i = 0; i < table->count; i++) {
        if (!is_put(&table->columns[i], STORE_ALL_RULES))
            continue;
        sqlite3_str_appendf(sql, "%s%s", first ? "" : ", ", table->columns[i].name);
        first = false;
    }
}

static void say_places(sqlite3_str *sql, const struct store_table *table)
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

static void say_merge(sqlite3_str *sql, const struct store_table *table)
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
    say_names(sql, table);
    sqlite3_str_appendall(sql, ") VALUES");
    for (unsigned i = 0; i < rows; i++) {
        sqlite3_str_appendall(sql, i ? "," : "");
        say_places(sql, table);
    }
    if (table->put == STORE_PUT_MERGE)
        say_merge(sql, table);
    return sqlite3_str_finish(sql);
}

char *store_update_text(const struct store_table *table)
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

/* ---- in and out ---- */

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

static int bind_bytes(sqlite3_stmt *statement, int at, const struct store_bytes *bytes)
{
    return sqlite3_bind_blob64(statement, at, bytes->length ? bytes->data : "", bytes->length,
                               SQLITE_STATIC);
}

static int bind_field(sqlite3_stmt *statement, int at, const struct store_column *column,
                      const void *field)
{
    switch ((enum store_kind)column->kind) {
    case STORE_INT: return sqlite3_bind_int(statement, at, *(const int *)field);
    case STORE_BOOL: return sqlite3_bind_int(statement, at, *(const bool *)field);
    case STORE_DOUBLE: return bind_real(statement, at, *(const double *)field);
    case STORE_POINTER:
        return sqlite3_bind_text(statement, at, *(const char *const *)field, -1, SQLITE_STATIC);
    case STORE_BLOB: return bind_bytes(statement, at, field);
    case STORE_CHARACTERS: break;
    case STORE_INT64:
    case STORE_OWNER: abort(); /* store_bind_row binds them */
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
        if (column->kind == STORE_INT64) /* most are */
            code = bind_integer(statement, place++, *(const int64_t *)field);
        else if (column->kind == STORE_OWNER)
            code = bind_integer(statement, place++, *owners++);
        else
            code = bind_field(statement, place++, column, field);
    }
    *at = place;
    return code;
}

int store_bind_values(sqlite3_stmt *statement, const struct store_value *values, size_t count)
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
    case STORE_BLOB: /* the pointer first: SQLite may make it anew, and then the length */
        ((struct store_bytes *)field)->data = sqlite3_column_blob(statement, at);
        ((struct store_bytes *)field)->length = (size_t)sqlite3_column_bytes(statement, at);
        break;
    case STORE_INT64:
    case STORE_OWNER: abort(); /* store_take_row takes them */
    }
}

void store_take_row(sqlite3_stmt *statement, const struct store_table *table, void *row)
{
    const struct store_column *end = table->columns + table->count;
    int at = 0;
    for (const struct store_column *column = table->columns; column < end; column++) {
        void *field = (char *)row + column->offset;
        if (column->kind == STORE_INT64) /* most are */
            *(int64_t *)field = store_integer(statement, at++);
        else if (column->kind != STORE_OWNER)
            take_field(statement, at++, column, field);
    }
}
