/* Writing and reading rows of the campaign, by the tables of tables.def and the queries of
 * queries.def. Only files in host/store/ include this file and use SQLite.
 *
 * The compiler checks that a row has the struct of its table or query, that the number of owner
 * columns is right, and that each parameter of a statement is an integer, a real or a text. The
 * number of parameters of a statement, and the match of a query's columns with its struct, are
 * checked when the statement is prepared: a mistake ends the program at its first use
 * (tests/host/test_tables.c uses each statement). */
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

/* Number of owner columns of a table: integers that state to which session or landing a row
 * belongs. */
/* clang-format off */
#define TABLE(row, table) enum { STORE_OWNERS_##row = 0
#define OWNER(row, column, constraint) +1
#define END(row, key, put) };
/* clang-format on */
#include "host/store/tables.def"

enum store_merge { STORE_KEEP, STORE_FILL, STORE_NEWER, STORE_TAKE, STORE_JOIN, STORE_GIVEN };
enum store_put { STORE_PUT_ADD, STORE_PUT_FIRST, STORE_PUT_LAST, STORE_PUT_MERGE };
enum store_kind {
    STORE_OWNER,
    STORE_INT64,
    STORE_INT,
    STORE_BOOL,
    STORE_DOUBLE,
    STORE_CHARACTERS,
    STORE_POINTER,
    STORE_BLOB
};

struct store_column {
    const char *name; /* NULL: computed, not a column */
    const char *type, *constraint;
    const char *field, *read; /* SQL expression that is read instead of the column; "": none */
    size_t offset, size;      /* position and size of the field in the struct */
    uint8_t kind, merge;
    bool empty_is_null;
};

struct store_table {
    const char *name; /* NULL: only for rows of a query */
    const struct store_column *columns;
    unsigned count;
    size_t row_size;
    const char *key;
    enum store_put put;
};

const struct store_table *store_table(enum store_table_number which);

/* A late table is made with its first row; reading it before gives no rows. */
#define STORE_IS_LATE(which) ((which) == STORE_TABLE_record)
/* Makes all tables, indexes and triggers in an empty database, or the late ones. Returns SQLite's
 * code. */
int store_tables_make(sqlite3 *database, bool late);
bool store_has_late(sqlite3 *database);

/* SQL text: "INSERT ... VALUES(?,...),(?,...)" for `rows` rows, and the list of columns to read.
 * The caller frees it with sqlite3_free. */
char *store_insert_text(const struct store_table *table, unsigned rows);
char *store_read_text(const struct store_table *table);

/* Binds a row to the parameters from `*at` on, and moves `*at` past them: the columns whose merge
 * rule is in `rules` (1 << enum store_merge). Data behind pointers must stay valid until the
 * statement has run. Returns SQLite's code. */
int store_bind_row(sqlite3_stmt *statement, const struct store_table *table, const int64_t *owners,
                   const void *row, unsigned rules, int *at);
#define STORE_ALL_RULES (~(1u << STORE_GIVEN))
/* Reads the current row of a statement made with store_read_text. */
void store_take_row(sqlite3_stmt *statement, const struct store_table *table, void *row);

/* ---- writing rows ---- */

/* STORE_PUT(store, error, edge, &edge, run) writes a row of the table `edges`; tables.def defines
 * what happens to an existing row. */
#define STORE_PUT(store, error, row, value, ...)                                            \
    store_insert(                                                                           \
        (store), (error), STORE_TABLE_##row, (1 ? (value) : (const struct store_##row *)0), \
        (const int64_t[]){0, __VA_ARGS__} + 1 +                                             \
            0 * sizeof(char[sizeof((const int64_t[]){0, __VA_ARGS__}) / sizeof(int64_t) ==  \
                                    1 + STORE_OWNERS_##row                                  \
                                ? 1                                                         \
                                : -1]))
/* Writes the columns that may change of the row with number `id`. */
#define STORE_CHANGE(store, error, row, value, id)    \
    store_update((store), (error), STORE_TABLE_##row, \
                 (1 ? (value) : (const struct store_##row *)0), (id))

enum mr_status store_insert(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, const int64_t *owners);
enum mr_status store_update(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, int64_t id);

/* ---- reading rows ---- */

#define LISTED(NAME, row, sql) STORE_##NAME,
#define STATEMENT(NAME, sql)   STORE_##NAME,
enum store_statement {
#include "host/store/queries.def"
    STORE_STATEMENT_COUNT
};

#define LISTED(NAME, row, sql) typedef struct store_##row store_row_of_##NAME;
#include "host/store/queries.def"

/* A parameter of a statement. */
struct store_value {
    enum store_kind kind;
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
    return (struct store_value){.kind = STORE_POINTER, .text = value};
}
/* STORE_NONE, NaN and NULL are bound as SQL NULL. */
/* clang-format off */
#define BIND(value)                         \
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
#define STORE_RUN(store, error, NAME, ...) \
    store_run((store), (error), STORE_##NAME, STORE_VALUES(__VA_ARGS__))
/* Starts a query. Then call store_step, or STORE_NEXT to read into a struct, until it returns
 * MR_TOO_FEW (no more rows) or an error. A query that is not stepped to its end must be released
 * with sqlite3_reset. */
#define STORE_QUERY(store, error, NAME, statement, ...) \
    store_query((store), (error), STORE_##NAME, (statement), STORE_VALUES(__VA_ARGS__))
#define STORE_NEXT(store, error, NAME, statement, row) \
    store_next((store), (error), STORE_##NAME, (statement), (1 ? (row) : (store_row_of_##NAME *)0))
/* Reads the only or first row into a struct without pointers; MR_TOO_FEW: there is none. */
#define STORE_ONE(store, error, NAME, row, ...)                                       \
    store_one((store), (error), STORE_##NAME, (1 ? (row) : (store_row_of_##NAME *)0), \
              STORE_VALUES(__VA_ARGS__))
/* Reads the integer in the only row of a query; MR_TOO_FEW: there is none. */
#define STORE_NUMBER(store, error, NAME, value, ...) \
    store_number((store), (error), STORE_##NAME, (value), STORE_VALUES(__VA_ARGS__))

enum mr_status store_run(struct store *store, struct error *error, enum store_statement which,
                         const struct store_value *values, size_t count);
enum mr_status store_query(struct store *store, struct error *error, enum store_statement which,
                           sqlite3_stmt **statement, const struct store_value *values,
                           size_t count);
enum mr_status store_step(struct store *store, sqlite3_stmt *statement, struct error *error);
enum mr_status store_next(struct store *store, struct error *error, enum store_statement which,
                          sqlite3_stmt *statement, void *row);
enum mr_status store_one(struct store *store, struct error *error, enum store_statement which,
                         void *row, const struct store_value *values, size_t count);
enum mr_status store_number(struct store *store, struct error *error, enum store_statement which,
                            int64_t *value, const struct store_value *values, size_t count);
/* Reads all rows, of a struct without pointers, into an array that the caller frees; used by
 * STORE_ROWS. */
enum mr_status store_all(struct store *store, struct error *error, enum store_statement which,
                         void **rows, size_t *count, const struct store_value *values,
                         size_t values_count);

/* Body of a function with the parameters `store`, `rows`, `count` and `error` that returns all rows
 * of a query. */
#define STORE_ROWS(NAME, ...)                                                       \
    do {                                                                            \
        void *made;                                                                 \
        enum mr_status status = store_all(store, error, STORE_##NAME, &made, count, \
                                          STORE_VALUES(__VA_ARGS__));               \
        *rows = (store_row_of_##NAME *)made;                                        \
        return status;                                                              \
    } while (0)

/* Prepares all statements. Returns MR_OK, or the program ends. */
enum mr_status store_prepare_all(struct store *store, struct error *error);

/* ---- an open campaign ---- */

/* A frame waiting to be written with others (store_frames.c). */
#define STORE_FRAMES_A_STATEMENT 64u
struct store_waiting {
    struct store_frame_row row; /* its data is in `data` */
    uint8_t data[8];
};

/* State of the file as known to matrig log: fields of its header, and its size. */
struct store_header {
    uint32_t counter, pages, cookie;
    int64_t bytes;
};

/* SQLite's methods of the file. Writing methods are replaced by functions that first check whether
 * the file was overwritten. */
struct store_guard {
    /* must be the first field: SQLite's pointer to the methods is used as one to this struct */
    sqlite3_io_methods methods;
    const sqlite3_io_methods *plain;
    struct store *store;
};

struct store {
    sqlite3 *database;
    char *path;
    /* prepared at first use, like `insert` and `update` */
    sqlite3_stmt *statement[STORE_STATEMENT_COUNT];
    sqlite3_stmt *insert[STORE_TABLE_COUNT], *update[STORE_TABLE_COUNT];
    int alone;               /* descriptor whose lock keeps other logs out; 0: none */
    bool made_room;          /* the journal was written back since the last commit */
    bool grown;              /* the file has reached its size limit */
    bool waits;              /* the file system has locks, and another program holds one */
    bool writes;             /* the journal is written back at closing */
    char folder[STORE_TEXT]; /* folder with a copy for reading; "": none */
    sqlite3_stmt *frames_put;
    struct store_waiting waiting[STORE_FRAMES_A_STATEMENT];
    unsigned waiting_count;
    int64_t steps; /* steps since the last statement that started while no other one was running */
    struct store_header header; /* header at the last check; bytes 0: not checked yet */
    bool overwritten;
    struct store_guard guard;
    int64_t session; /* session being logged; 0: none */
    /* newest data of the session: committed, and to be committed */
    struct store_logged committed, next;
    int64_t version; /* data version at the last check for the session */
    int refused;     /* SQLite's code of the last failed call; 0: none */
};

/* Sets the error from SQLite's last error. Returns its status. */
enum mr_status store_failed(struct store *store, const char *doing, struct error *error);
/* Runs statements and ignores their rows. `doing`: as for store_failed. */
enum mr_status store_execute(struct store *store, const char *sql, const char *doing,
                             struct error *error);

/* Makes SQLite interrupt statements that take too many steps. */
void store_limit_steps(struct store *store);

/* Writes the buffered frames; call it before any read and before a commit. */
enum mr_status store_frames_flush(struct store *store, struct error *error);

/* Calls `each` with every prepared statement. */
void store_each_statement(struct store *store, int (*each)(sqlite3_stmt *statement));

/* Copies a text column, cut to `size`; NULL is copied as "". */
void store_text(sqlite3_stmt *statement, int column, char *out, size_t size);

/* ---- the location of a campaign (store_place.c) ---- */

#define STORE_PLACE_URI 12400u /* each byte of a path may take three characters */

/* File system of a path as text: "nfs4 at /home". */
void store_file_system(const char *path, char out[STORE_TEXT]);
/* Process that holds the lock of a file, from the kernel, as text: "process 4711, sqlite3 holds its
 * lock". If the kernel does not know it, a text without a process. */
void store_holder(const char *path, char out[STORE_TEXT]);
/* True if the file system supports locks. Call it only while this process has no connection to the
 * file: closing a descriptor releases SQLite's locks. */
bool store_place_has_locks(const char *path);
/* Makes a URI by which SQLite can read a campaign that it cannot open normally: the file itself if
 * there is no journal to write back, otherwise a copy in `folder`, which store_place_release
 * removes. */
enum mr_status store_place_to_read(const char *path, char uri[STORE_PLACE_URI],
                                   char folder[STORE_TEXT], struct error *error);
void store_place_release(const char folder[STORE_TEXT]);

#endif
