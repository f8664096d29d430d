#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_readiness.h"
#include "host/store/table.h"
#include "host/base/monotonic_clock.h"

/* number of SQLite's virtual machine instructions between two checks of the time */
#define SQL_STEPS_PER_TIME_CHECK 20000

enum mr_status store_readiness_put(struct store *store, const char *board_uid, const char *kind,
                                   const struct store_readiness *row, struct error *error)
{
    struct store_readiness_row stored = {
        .made_us = row->made_us, .board_uid = board_uid, .kind = kind, .checks = row->checks};
    memcpy(stored.verdict, row->verdict, sizeof stored.verdict);
    return STORE_PUT(store, error, readiness_row, &stored);
}

enum mr_status store_readiness_get(struct store *store, const char *board_uid, const char *kind,
                                   int64_t until_us, bool only_valid, struct store_readiness *row,
                                   bool *found, struct error *error)
{
    sqlite3_stmt *s;
    struct store_readiness_row stored;
    int64_t from_us = only_valid ? until_us - STORE_READINESS_VALID_US : 0;
    *row = (struct store_readiness){0};
    *found = false;
    enum mr_status status = STORE_QUERY(store, error, READINESS_GET, &s, STORE_BIND(board_uid),
                                        STORE_BIND(kind), STORE_BIND(from_us),
                                        STORE_BIND(until_us));
    if (status == MR_OK)
        status = STORE_READ_NEXT(store, error, READINESS_GET, s, &stored);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    row->made_us = stored.made_us;
    memcpy(row->verdict, stored.verdict, sizeof row->verdict);
    row->checks = strdup(stored.checks ? stored.checks : "");
    sqlite3_reset(s);
    if (!row->checks)
        abort();
    *found = true;
    return MR_OK;
}

enum mr_status store_certificate_add(struct store *store, const struct store_certificate *row,
                                     struct error *error)
{
    enum mr_status status = store_begin(store, error);
    if (status == MR_OK)
        status = STORE_PUT(store, error, certificate, row);
    return status == MR_OK ? store_commit(store, error) : status;
}

enum mr_status store_certificates_get(struct store *store, const char *board_uid,
                                      struct store_certificate **rows, size_t *count,
                                      struct error *error)
{
    STORE_RETURN_ROWS(CERTIFICATES, STORE_BIND(board_uid));
}

enum mr_status store_newest_board_get(struct store *store, char board_uid[25], struct error *error)
{
    struct store_newest_board row = {.board_uid = ""};
    enum mr_status status = STORE_READ_ONE(store, error, READINESS_BOARD, &row);
    memcpy(board_uid, row.board_uid, sizeof row.board_uid);
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_newest_shunt_spans_get(struct store *store, const char *board_uid,
                                            float span_lb[MR_GAGES], int64_t *started_us,
                                            struct error *error)
{
    sqlite3_stmt *s;
    struct store_board_span row;
    *started_us = STORE_NONE;
    for (unsigned i = 0; i < MR_GAGES; i++)
        span_lb[i] = NAN;
    enum mr_status status = STORE_QUERY(store, error, BOARD_SHUNTS, &s, STORE_BIND(board_uid));
    while (status == MR_OK &&
           (status = STORE_READ_NEXT(store, error, BOARD_SHUNTS, s, &row)) == MR_OK) {
        if (row.gage >= 1 && row.gage <= (int64_t)MR_GAGES)
            span_lb[row.gage - 1] = (float)row.span_lb;
        *started_us = row.started_us;
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_size_get(struct store *store, int64_t *bytes, int64_t *landings,
                              struct error *error)
{
    enum mr_status status = STORE_READ_NUMBER(store, error, DATABASE_BYTES, bytes);
    return status == MR_OK ? STORE_READ_NUMBER(store, error, LANDINGS_COUNT, landings) : status;
}

void store_set_wait_s(struct store *store, double wait_s)
{
    sqlite3_busy_timeout(store->database, (int)(1000.0 * wait_s));
}

static int is_time_over(void *until_s)
{
    return monotonic_s() > *(double *)until_s;
}

enum mr_status store_check_integrity(struct store *store, double duration_max_s, bool *complete,
                                     struct error *error)
{
    double until_s = monotonic_s() + duration_max_s;
    sqlite3_stmt *s = NULL;
    enum mr_status status = MR_OK;
    *complete = false;
    if (sqlite3_prepare_v2(store->database, "PRAGMA quick_check(1)", -1, &s, NULL) != SQLITE_OK)
        return store_set_error(store, "check", error);
    sqlite3_progress_handler(store->database, SQL_STEPS_PER_TIME_CHECK, is_time_over, &until_s);
    int step = sqlite3_step(s);
    store_limit_sql_steps(store); /* restores the progress handler that was active before */
    const char *text = step == SQLITE_ROW ? (const char *)sqlite3_column_text(s, 0) : NULL;
    *complete = text && strcmp(text, "ok") == 0;
    if (text && !*complete)
        status = error_set(error, MR_MALFORMED,
                           "the campaign is damaged (%s): %s; begin a new campaign", text,
                           store->path);
    else if (step != SQLITE_ROW && step != SQLITE_INTERRUPT)
        status = store_set_error(store, "check", error);
    sqlite3_finalize(s);
    return status;
}
