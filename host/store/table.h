/* Rows in and out of the campaign, by the tables of tables.def and the queries of queries.def. Only
 * host/store/ includes this, and only host/store/ knows SQLite.
 *
 * The compiler checks that a row is of its table's or query's struct, how many integers say whose
 * it is, and that each value which a statement takes is an integer, a real or a text. That a
 * statement takes so many, and that a query's columns are the fields of its struct, is checked when
 * it is prepared: a mistake ends the program at its first use (tests/host/test_tables.c uses
 * each). */
#ifndef MATRIG_HOST_STORE_TABLE_H
#define MATRIG_HOST_STORE_TABLE_H

#include <sqlite3.h>

#include "common/catalogue.h"
#include "common/quantity.h"
#include "host/base/error.h"
#include "host/store/rows.h"

struct store;

/* ---- what tables.def says ---- */

#define TABLE(row, table) STORE_TABLE_##row,
enum store_table_number {
#include "host/store/tables.def"
    STORE_TABLE_COUNT
};

/* How many integers say whose a row is. */
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
    const char *name; /* NULL: computed, of no column */
    const char *type, *constraint;
    const char *field, *read; /* SQL that is read instead of the column; "": none */
    size_t offset, size;      /* of the field in the row */
    uint8_t kind, merge;
    bool empty_is_null;
};

struct store_table {
    const char *name; /* NULL: rows of a query alone */
    const struct store_column *columns;
    unsigned count;
    size_t row_size;
    const char *key;
    enum store_put put;
};

const struct store_table *store_table(enum store_table_number which);

/* Makes all tables, indexes and triggers in an empty database. Returns SQLite's code. */
int store_tables_make(sqlite3 *database);

/* "INSERT ... VALUES(?,...),(?,...)" of so many rows, "UPDATE ...", and the names of what is read;
 * the caller frees them with sqlite3_free. */
char *store_insert_text(const struct store_table *table, unsigned rows);
char *store_read_text(const struct store_table *table);

/* Binds a row from parameter `*at` on, which moves behind it: the columns whose merge rule is in
 * `rules` (1 << enum store_merge). What pointers point to must stay until the statement has run.
 * Returns SQLite's code. */
int store_bind_row(sqlite3_stmt *statement, const struct store_table *table, const int64_t *owners,
                   const void *row, unsigned rules, int *at);
#define STORE_ALL_RULES (~(1u << STORE_GIVEN))
/* The row that a statement made of store_read_text stands at. */
void store_take_row(sqlite3_stmt *statement, const struct store_table *table, void *row);

/* ---- rows in ---- */

/* STORE_PUT(store, error, edge, &edge, run): a row of the table `edges`; what becomes of one that
 * is there: tables.def. */
#define STORE_PUT(store, error, row, value, ...)                                            \
    store_insert(                                                                           \
        (store), (error), STORE_TABLE_##row, (1 ? (value) : (const struct store_##row *)0), \
        (const int64_t[]){0, __VA_ARGS__} + 1 +                                             \
            0 * sizeof(char[sizeof((const int64_t[]){0, __VA_ARGS__}) / sizeof(int64_t) ==  \
                                    1 + STORE_OWNERS_##row                                  \
                                ? 1                                                         \
                                : -1]))
/* Writes the columns that can change of the row with the number `id`. */
#define STORE_CHANGE(store, error, row, value, id)    \
    store_update((store), (error), STORE_TABLE_##row, \
                 (1 ? (value) : (const struct store_##row *)0), (id))

enum mr_status store_insert(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, const int64_t *owners);
enum mr_status store_update(struct store *store, struct error *error, enum store_table_number which,
                            const void *row, int64_t id);

/* ---- rows out ---- */

#define LISTED(NAME, row, sql) STORE_##NAME,
#define STATEMENT(NAME, sql)   STORE_##NAME,
enum store_statement {
#include "host/store/queries.def"
    STORE_STATEMENT_COUNT
};

#define LISTED(NAME, row, sql) typedef struct store_##row store_row_of_##NAME;
#include "host/store/queries.def"

/* What a statement takes. */
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
/* STORE_NONE, NaN and NULL are NULL. */
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

/* A statement that returns no rows. */
#define STORE_RUN(store, error, NAME, ...) \
    store_run((store), (error), STORE_##NAME, STORE_VALUES(__VA_ARGS__))
/* A query; then store_step, or STORE_NEXT into a row, until it returns MR_TOO_FEW (no more rows) or
 * an error. A query that is not stepped to its end is released with sqlite3_reset. */
#define STORE_QUERY(store, error, NAME, statement, ...) \
    store_query((store), (error), STORE_##NAME, (statement), STORE_VALUES(__VA_ARGS__))
#define STORE_NEXT(store, error, NAME, statement, row) \
    store_next((store), (error), STORE_##NAME, (statement), (1 ? (row) : (store_row_of_##NAME *)0))
/* The only or first row, of a struct without pointers; MR_TOO_FEW: none. */
#define STORE_ONE(store, error, NAME, row, ...)                                       \
    store_one((store), (error), STORE_##NAME, (1 ? (row) : (store_row_of_##NAME *)0), \
              STORE_VALUES(__VA_ARGS__))
/* The integer of a query's only row; MR_TOO_FEW: none. */
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
/* All rows, of a struct without pointers, in an array that the caller frees; STORE_ROWS calls
 * this. */
enum mr_status store_all(struct store *store, struct error *error, enum store_statement which,
                         void **rows, size_t *count, const struct store_value *values,
                         size_t values_count);

/* Ends a function that has `store`, `rows`, `count` and `error` with all rows of a query. */
#define STORE_ROWS(NAME, ...)                                                       \
    do {                                                                            \
        void *made;                                                                 \
        enum mr_status status = store_all(store, error, STORE_##NAME, &made, count, \
                                          STORE_VALUES(__VA_ARGS__));               \
        *rows = (store_row_of_##NAME *)made;                                        \
        return status;                                                              \
    } while (0)

/* Prepares all of them: MR_OK, or the program ends. */
enum mr_status store_prepare_all(struct store *store, struct error *error);

/* ---- an open campaign ---- */

/* A frame that waits to be written with others (store_frames.c). */
#define STORE_FRAMES_A_STATEMENT 64u
struct store_waiting {
    struct store_frame_row row; /* its data: */
    uint8_t data[8];
};

/* What matrig log knows of the file itself: of its header, and its size. */
struct store_header {
    uint32_t counter, pages, cookie;
    int64_t bytes;
};

/* SQLite's methods of the file, of which those that write look first whose it is. */
struct store_guard {
    sqlite3_io_methods methods; /* first: SQLite points to them */
    const sqlite3_io_methods *plain;
    struct store *store;
};

struct store {
    sqlite3 *database;
    char *path;
    sqlite3_stmt *statement[STORE_STATEMENT_COUNT]; /* prepared at first use, as the next two */
    sqlite3_stmt *insert[STORE_TABLE_COUNT], *update[STORE_TABLE_COUNT];
    int alone;               /* descriptor that keeps others who log out; 0: none */
    bool made_room;          /* since the last commit */
    bool grown;              /* its file may not become larger */
    bool waits;              /* it has locks, and another program holds them */
    bool writes;             /* its journal is written back when it is closed */
    char folder[STORE_TEXT]; /* holds a copy that is read; "": none */
    sqlite3_stmt *frames_put;
    struct store_waiting waiting[STORE_FRAMES_A_STATEMENT];
    unsigned waiting_count;
    int64_t steps;              /* since the last statement that began while no other was running */
    struct store_header header; /* as it was last looked at; bytes 0: never */
    bool overwritten;
    struct store_guard guard;
    int64_t session;                     /* that is logged; 0: none */
    struct store_logged committed, next; /* of it; to be committed */
    int64_t version;                     /* of the content, when the session was last looked for */
    int refused;                         /* SQLite's code of the last call that failed; 0: none */
};

/* Sets the error from SQLite's last one. Returns its status. */
enum mr_status store_failed(struct store *store, const char *doing, struct error *error);
/* Statements of which no row is wanted. `doing` as above. */
enum mr_status store_execute(struct store *store, const char *sql, const char *doing,
                             struct error *error);

/* From now on SQLite interrupts a statement that takes too many steps. */
void store_limit_steps(struct store *store);

/* Writes the frames that wait; before anything is read, and before a commit. */
enum mr_status store_frames_flush(struct store *store, struct error *error);

/* Calls `each` with every statement that is prepared. */
void store_each_statement(struct store *store, int (*each)(sqlite3_stmt *statement));

/* Columns with NULL as STORE_NONE and NaN; text is copied, cut to `size`. */
void store_text(sqlite3_stmt *statement, int column, char *out, size_t size);

/* ---- where a campaign lies (store_place.c) ---- */

#define STORE_PLACE_URI 12400u /* each byte of a path as three */

/* "nfs4 at /home". */
void store_file_system(const char *path, char out[STORE_TEXT]);
/* "process 4711, sqlite3 holds its lock", by the kernel; where it does not say, that somebody
 * does. */
void store_holder(const char *path, char out[STORE_TEXT]);
/* MR_IO: a campaign cannot be written there; the error says why. */
enum mr_status store_place_to_write(const char *path, struct error *error);
/* While no connection of this process is open to it: closing a descriptor takes SQLite's locks. */
bool store_place_has_locks(const char *path);
/* A name by which SQLite reads it all the same: in place when no journal waits to be written back,
 * else a copy in `folder`, for store_place_forget. */
enum mr_status store_place_to_read(const char *path, char uri[STORE_PLACE_URI],
                                   char folder[STORE_TEXT], struct error *error);
void store_place_forget(const char folder[STORE_TEXT]);

#endif
