/* Writing and reading rows of the campaign: the tables of tables.def, the statements of
 * queries.def. Only files in host/store/ include this file and use SQLite.
 *
 * The compiler checks that a row has the struct of its table or query, that the number of owner
 * columns is right, and that each parameter of a statement is an integer, a real or a text. Two
 * more mistakes end the program at the first use of the statement: a wrong number of parameters,
 * and columns that differ from the fields of the struct. tests/host/test_tables.c uses each
 * statement. */
#ifndef MATRIG_HOST_STORE_TABLE_H
#define MATRIG_HOST_STORE_TABLE_H

#include <sqlite3.h>

#include "common/catalogue.h"
#include "common/quantity.h"
#include "host/base/error.h"
#include "host/store/rows.h"

struct store;

/* ---- definitions from tables.def ---- */

#define TABLE(row, table) STORE_TABLE_##row,
enum store_table_number {
#include "host/store/tables.def"
    STORE_TABLE_COUNT
};

/* Number of owner columns of a table: integers that identify the session or landing of a row. */
/* clang-format off */
#define TABLE(row, table) enum { STORE_OWNERS_##row = 0
#define OWNER(row, column, constraint) +1
#define TABLE_END(row, key, put) };
/* clang-format on */
#include "host/store/tables.def"

enum store_merge {
    STORE_MERGE_KEEP,
    STORE_MERGE_FILL,
    STORE_MERGE_PRESENT,
    STORE_MERGE_REPLACE,
    STORE_MERGE_BITS,
    STORE_MERGE_READ_ONLY
};
enum store_put { STORE_PUT_ADD, STORE_PUT_FIRST, STORE_PUT_LAST, STORE_PUT_MERGE };
enum store_field_kind {
    STORE_OWNER,
    STORE_INT64,
    STORE_INT,
    STORE_BOOL,
    STORE_DOUBLE,
    STORE_TEXT_ARRAY,
    STORE_TEXT_POINTER,
    STORE_BLOB
};

struct store_column {
    const char *name; /* name of the column; NULL: SQL computes the field, which has no column */
    const char *type, *constraint;
    const char *field, *read_sql; /* SQL expression that is read instead of the column; "": none */
    size_t field_offset, field_size; /* position and size of the field in the struct, bytes */
    uint8_t kind, merge;
    bool empty_is_null;
};

struct store_table {
    const char *name; /* name of the table; NULL: the rows exist only as results of a query */
    const struct store_column *columns;
    unsigned column_count;
    size_t row_size;
    const char *key;
    enum store_put put;
};

const struct store_table *store_table_get(enum store_table_number which);

/* True for a table that is created when its first row is written. Until then, a query of it returns
 * no rows. */
#define STORE_TABLE_IS_ON_DEMAND(which) ((which) == STORE_TABLE_record)
/* Creates the tables, indexes and triggers that are created on demand (STORE_TABLE_IS_ON_DEMAND),
 * or all others. Returns SQLite's code. */
int store_create_tables(sqlite3 *database, bool on_demand);
bool store_has_on_demand_tables(sqlite3 *database);

/* store_make_insert_sql returns an INSERT statement for `rows` rows, store_make_column_list the
 * columns that a SELECT reads. The caller frees the text with sqlite3_free. */
char *store_make_insert_sql(const struct store_table *table, unsigned rows);
char *store_make_column_list(const struct store_table *table);

/* Binds the columns of a row whose merge rule is in the set `rules` (bits 1 << enum store_merge).
 * *at is the number of the first parameter; on return, that of the parameter after the last one.
 * Data behind pointers must stay valid until the statement has run. Returns SQLite's code. */
int store_bind_row(sqlite3_stmt *statement, const struct store_table *table, const int64_t *owners,
                   const void *row, unsigned rules, int *at);
#define STORE_WRITTEN_MERGE_RULES (~(1u << STORE_MERGE_READ_ONLY))
/* Reads the current row of a SELECT whose columns are those of store_make_column_list. */
void store_read_row(sqlite3_stmt *statement, const struct store_table *table, void *row);

/* ---- writing rows ---- */

/* STORE_PUT(store, error, edge, &edge, run) writes a row of the table `edges`. tables.def defines
 * how this changes an existing row. */
#define STORE_PUT(store, error, row, value, ...)                                            \
    store_insert(                                                                           \
        (store), (error), STORE_TABLE_##row, (1 ? (value) : (const struct store_##row *)0), \
        (const int64_t[]){0, __VA_ARGS__} + 1 +                                             \
            0 * sizeof(char[sizeof((const int64_t[]){0, __VA_ARGS__}) / sizeof(int64_t) ==  \
                                    1 + STORE_OWNERS_##row                                  \
                                ? 1                                                         \
                                : -1]))
/* Replaces the columns with the merge rule REPLACE in the row with this id. */
#define STORE_UPDATE(store, error, row, value, id)    \
    store_update((store), (error), STORE_TABLE_##row, \
                 (1 ? (value) : (const struct store_##row *)0), (id))

enum mr_status store_insert(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, const int64_t *owners);
enum mr_status store_update(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, int64_t id);

/* ---- reading rows ---- */

#define ROW_QUERY(NAME, row, sql) STORE_##NAME,
#define STATEMENT(NAME, sql)      STORE_##NAME,
enum store_statement {
#include "host/store/queries.def"
    STORE_STATEMENT_COUNT
};

#define ROW_QUERY(NAME, row, sql) typedef struct store_##row store_row_of_##NAME;
#include "host/store/queries.def"

/* A parameter of a statement. */
struct store_value {
    enum store_field_kind kind;
    int64_t integer;
    double real;
    const char *text;
};
static inline struct store_value store_value_integer(int64_t value)
{
    return (struct store_value){.kind = STORE_INT64, .integer = value};
}
static inline struct store_value store_value_real(double value)
{
    return (struct store_value){.kind = STORE_DOUBLE, .real = value};
}
static inline struct store_value store_value_text(const char *value)
{
    return (struct store_value){.kind = STORE_TEXT_POINTER, .text = value};
}
/* Makes a parameter from a value of any type. STORE_NONE, NaN and NULL become SQL NULL. */
/* clang-format off */
#define STORE_BIND(value)                         \
    _Generic((value),                       \
             int64_t: store_value_integer,  \
             int: store_value_integer,      \
             uint32_t: store_value_integer, \
             double: store_value_real,      \
             const char *: store_value_text, \
             char *: store_value_text)(value)
/* clang-format on */
#define STORE_VALUES(...)                                                   \
    (const struct store_value[]){{.integer = 0}, __VA_ARGS__} + 1,          \
        sizeof((const struct store_value[]){{.integer = 0}, __VA_ARGS__}) / \
                sizeof(struct store_value) -                                \
            1

/* Runs a statement that returns no rows. */
#define STORE_RUN_STATEMENT(store, error, NAME, ...) \
    store_run_statement((store), (error), STORE_##NAME, STORE_VALUES(__VA_ARGS__))
/* Starts a query. Then call STORE_READ_NEXT (or store_step, which reads no struct) until it returns
 * MR_TOO_FEW (no more rows) or an error. To stop earlier, call sqlite3_reset. */
#define STORE_QUERY(store, error, NAME, statement, ...) \
    store_query((store), (error), STORE_##NAME, (statement), STORE_VALUES(__VA_ARGS__))
#define STORE_READ_NEXT(store, error, NAME, statement, row)      \
    store_read_next((store), (error), STORE_##NAME, (statement), \
                    (1 ? (row) : (store_row_of_##NAME *)0))
/* Reads the first row into a struct without pointers. Returns MR_TOO_FEW if there is no row. */
#define STORE_READ_ONE(store, error, NAME, row, ...)                                       \
    store_read_one((store), (error), STORE_##NAME, (1 ? (row) : (store_row_of_##NAME *)0), \
                   STORE_VALUES(__VA_ARGS__))
/* Reads the integer in the only row of a query. Returns MR_TOO_FEW if there is no row. */
#define STORE_READ_NUMBER(store, error, NAME, value, ...) \
    store_read_number((store), (error), STORE_##NAME, (value), STORE_VALUES(__VA_ARGS__))

enum mr_status store_run_statement(struct store *store, struct error *error,
                                   enum store_statement which, const struct store_value *values,
                                   size_t count);
enum mr_status store_query(struct store *store, struct error *error, enum store_statement which,
                           sqlite3_stmt **statement, const struct store_value *values,
                           size_t count);
enum mr_status store_step(struct store *store, sqlite3_stmt *statement, struct error *error);
enum mr_status store_read_next(struct store *store, struct error *error, enum store_statement which,
                               sqlite3_stmt *statement, void *row);
enum mr_status store_read_one(struct store *store, struct error *error, enum store_statement which,
                              void *row, const struct store_value *values, size_t count);
enum mr_status store_read_number(struct store *store, struct error *error,
                                 enum store_statement which, int64_t *value,
                                 const struct store_value *values, size_t count);
/* Reads all rows into an array that the caller frees. The struct must have no pointers. Used by
 * STORE_RETURN_ROWS. */
enum mr_status store_read_all(struct store *store, struct error *error, enum store_statement which,
                              void **rows, size_t *count, const struct store_value *values,
                              size_t values_count);

/* Body of a function with the parameters `store`, `rows`, `count` and `error` that returns all rows
 * of a query. */
#define STORE_RETURN_ROWS(NAME, ...)                                                     \
    do {                                                                                 \
        void *made;                                                                      \
        enum mr_status status = store_read_all(store, error, STORE_##NAME, &made, count, \
                                               STORE_VALUES(__VA_ARGS__));               \
        *rows = (store_row_of_##NAME *)made;                                             \
        return status;                                                                   \
    } while (0)

/* Prepares all statements. Ends the program if one does not match its struct. */
enum mr_status store_prepare_all(struct store *store, struct error *error);

/* ---- an open campaign ---- */

/* A frame that will be written together with others (store_frames.c). */
#define STORE_FRAMES_PER_STATEMENT 64u
struct store_buffered_frame {
    struct store_frame_row row; /* the row without its data, which is in `data` */
    uint8_t data[8];
};

/* Fields of the database file's header, and the size of the file. matrig log compares them to
 * detect that another program overwrote the file. */
struct store_file_header {
    uint32_t change_counter, page_count, schema_cookie;
    int64_t file_bytes;
};

/* SQLite's methods for a file. The writing methods are replaced by functions that first check
 * whether another program overwrote the file. */
struct store_write_guard {
    /* must be the first field: SQLite's pointer to the methods is cast to this struct */
    sqlite3_io_methods methods;
    const sqlite3_io_methods *original_methods;
    struct store *store;
};

struct store {
    sqlite3 *database;
    char *path;
    /* the statements of these arrays are prepared at their first use */
    sqlite3_stmt *statement[STORE_STATEMENT_COUNT];
    sqlite3_stmt *insert[STORE_TABLE_COUNT], *update[STORE_TABLE_COUNT];
    int lock_fd;              /* descriptor whose lock excludes other logs; 0: none */
    bool is_checkpointed;     /* the journal was written back since the last commit */
    bool size_limit_reached;  /* the last failed call reached the size limit of the file */
    bool is_retry;            /* the campaign is being opened a second time, with a longer wait */
    bool checkpoint_at_close; /* store_close writes the journal back */
    char copy_folder[STORE_TEXT_SIZE]; /* folder with the copy that is read instead; "": none */
    sqlite3_stmt *insert_frames;
    struct store_buffered_frame buffered_frames[STORE_FRAMES_PER_STATEMENT];
    unsigned buffered_frame_count;
    /* number of steps since a statement was started while none was running */
    int64_t sql_step_count;
    struct store_file_header header; /* header at the last check; file_bytes 0: not checked yet */
    bool is_overwritten;
    struct store_write_guard guard;
    int64_t session; /* session being logged; 0: none */
    /* newest data of the session: committed, and in the open transaction */
    struct store_session_progress committed_progress, pending_progress;
    int64_t data_version; /* PRAGMA data_version when the data of the session was last checked */
    int last_failed_code; /* SQLite's code of the last call that failed; 0: none */
};

/* Sets `error` from SQLite's last error and returns its status. `action` is the verb after "cannot"
 * in the message. */
enum mr_status store_set_error(struct store *store, const char *action, struct error *error);
/* Runs SQL statements and ignores their rows. `action`: as for store_set_error. */
enum mr_status store_execute(struct store *store, const char *sql, const char *action,
                             struct error *error);

/* Makes SQLite interrupt a statement that needs more steps than an undamaged file of the same size
 * can. */
void store_limit_sql_steps(struct store *store);

/* Writes the buffered frames. Call it before any read and before a commit. */
enum mr_status store_frames_flush(struct store *store, struct error *error);

/* Calls `each` with every prepared statement. */
void store_for_each_statement(struct store *store, int (*each)(sqlite3_stmt *statement));

/* Copies a text column, truncated to `size` and without control characters. NULL gives "". */
void store_copy_text(sqlite3_stmt *statement, int column, char *out, size_t size);

/* ---- the file system of a campaign (store_place.c) ---- */

#define STORE_URI_SIZE 12400u /* large enough: each byte of a path may need three characters */

/* Describes the file system of a path: "nfs4 at /home". */
void store_describe_file_system(const char *path, char out[STORE_TEXT_SIZE]);
/* Describes the process that has locked a campaign, as far as the kernel reports it: "process 4711,
 * sqlite3 has locked the campaign". */
void store_describe_lock_holder(const char *path, char out[STORE_TEXT_SIZE]);
/* True if the file system supports locks. Call it only while this process does not have the
 * campaign open: the function closes a descriptor of the file, which releases all of SQLite's
 * locks. */
bool store_has_file_locks(const char *path);
/* Makes a URI with which SQLite can read a campaign that it cannot open normally. The URI names the
 * file itself or, if the file has a journal, a copy in the new folder `folder`, which
 * store_remove_read_copy removes. */
enum mr_status store_make_read_uri(const char *path, char uri[STORE_URI_SIZE],
                                   char folder[STORE_TEXT_SIZE], struct error *error);
void store_remove_read_copy(const char folder[STORE_TEXT_SIZE]);

#endif
