/* An open campaign, for host/store/ alone. */
#ifndef MATRIG_HOST_STORE_STORE_SQL_H
#define MATRIG_HOST_STORE_STORE_SQL_H

#include <sqlite3.h>
#include <time.h>

#include "host/store/store.h"
#include "host/store/table.h"

/* A frame that waits to be written with others (store_frames.c). */
#define STORE_FRAMES_A_STATEMENT 64u
struct store_waiting {
    int64_t session;
    struct store_frame frame; /* its data NULL: they are in */
    uint8_t data[8];
};

/* What matrig log knows of the file itself (store_log.c): of its header, and its size. */
struct store_header {
    uint32_t counter, pages, cookie;
    int64_t bytes;
};

struct store {
    sqlite3 *database;
    char *path;
    sqlite3_stmt *statement[STORE_STATEMENT_COUNT]; /* prepared at first use, as the next two */
    sqlite3_stmt *insert[STORE_TABLE_COUNT], *update[STORE_TABLE_COUNT];
    int alone; /* descriptor that keeps others who log out; 0: none */
    sqlite3_stmt *frames_put;
    struct store_waiting waiting[STORE_FRAMES_A_STATEMENT];
    unsigned waiting_count;
    int64_t steps;              /* since the last statement that began while no other was running */
    struct store_header header; /* as it was last looked at; bytes 0: never */
    bool overwritten;
    int64_t session;                     /* that is logged; 0: none */
    struct store_logged committed, next; /* of it; to be committed */
    int64_t version;                     /* of the content, when the session was last looked for */
    int refused;                         /* enum store_refusal, of the last call that failed */
};

/* Sets the error from SQLite's last one. Returns its status. */
enum mr_status store_failed(struct store *store, const char *doing, struct error *error);
/* Statements of which no row is wanted. `doing` as above. */
enum mr_status store_execute(struct store *store, const char *sql, const char *doing,
                             struct error *error);

/* Settings of every connection to a campaign: its schema is data, and cannot be written as a table.
 * NULL: none. */
void store_guard_settings(sqlite3 *database);
/* From now on SQLite interrupts a statement that takes too many steps. */
void store_limit_steps(struct store *store);

/* Writes the frames that wait; before anything is read, and before a commit. */
enum mr_status store_frames_flush(struct store *store, struct error *error);

/* Calls `each` with every statement that is prepared. */
void store_each_statement(struct store *store, int (*each)(sqlite3_stmt *statement));

/* Columns with NULL as STORE_NONE and NaN; text is copied, cut to `size`. */
int64_t store_integer(sqlite3_stmt *statement, int column);
double store_real(sqlite3_stmt *statement, int column);
void store_text(sqlite3_stmt *statement, int column, char *out, size_t size);

#endif
