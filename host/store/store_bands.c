#include "host/store/store_bands.h"

#include <stdlib.h>

#include "host/store/store_sql.h"

#define ROWS_MAX 256 /* of one query; four bands, some findings, 14 gages */

/* Up to ROWS_MAX rows of a bound query. */
static enum mr_status read_rows(struct store *store, sqlite3_stmt *statement, enum mr_status status, size_t size,
                                void (*read)(sqlite3_stmt *statement, void *row), void **rows, size_t *count,
                                struct error *error)
{
    *count = 0;
    *rows = calloc(ROWS_MAX, size);
    if (!*rows) {
        store_reset(statement);
        return error_set(error, MR_FULL, "no memory: reading %s; close other programs", store->path);
    }
    while (status == MR_OK && *count < ROWS_MAX && (status = store_step(store, statement, error)) == MR_OK)
        read(statement, (char *)*rows + (*count)++ * size);
    if (status == MR_OK) /* there may be more */
        store_reset(statement);
    if (status == MR_OK || status == MR_TOO_FEW)
        return MR_OK;
    free(*rows);
    *rows = NULL;
    *count = 0;
    return status;
}

enum mr_status store_band_put(struct store *store, int64_t run, const struct store_band *b, struct error *error)
{
    return store_run(store, error, STORE_BAND_PUT, run, b->band, b->gages, b->before_lb, b->before_error_lb, b->spread_lb,
                     b->least_lb, b->least_error_lb, b->least_gage, b->least_block, b->most_lb, b->most_error_lb, b->most_gage,
                     b->most_block, b->after_lb, b->change_lb, b->change_error_lb, b->links);
}

static void band_row(sqlite3_stmt *s, void *to)
{
    *(struct store_band *)to = (struct store_band){
        .band = store_integer(s, 0), .gages = store_integer(s, 1), .before_lb = store_real(s, 2),
        .before_error_lb = store_real(s, 3), .spread_lb = store_real(s, 4), .least_lb = store_real(s, 5),
        .least_error_lb = store_real(s, 6), .least_gage = store_integer(s, 7), .least_block = store_integer(s, 8),
        .most_lb = store_real(s, 9), .most_error_lb = store_real(s, 10), .most_gage = store_integer(s, 11),
        .most_block = store_integer(s, 12), .after_lb = store_real(s, 13), .change_lb = store_real(s, 14),
        .change_error_lb = store_real(s, 15), .links = store_integer(s, 16)};
}

enum mr_status store_bands(struct store *store, int64_t run, struct store_band **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status = store_query(store, error, &statement, STORE_BANDS, run);
    status = read_rows(store, statement, status, sizeof **rows, band_row, &made, count, error);
    *rows = made;
    return status;
}

enum mr_status store_band_event_put(struct store *store, int64_t run, const struct store_band_event *event,
                                    struct error *error)
{
    return store_run(store, error, STORE_BAND_EVENT_PUT, run, event->block, event->band, event->gage, event->reason, event->other,
                     event->value_lb, event->links);
}

static void event_row(sqlite3_stmt *s, void *to)
{
    *(struct store_band_event *)to = (struct store_band_event){
        .block = store_integer(s, 0), .band = store_integer(s, 1), .gage = store_integer(s, 2), .reason = store_integer(s, 3),
        .other = store_integer(s, 4), .value_lb = store_real(s, 5), .links = store_integer(s, 6)};
}

enum mr_status store_band_events(struct store *store, int64_t run, struct store_band_event **rows, size_t *count,
                                 struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status = store_query(store, error, &statement, STORE_BAND_EVENTS, run);
    status = read_rows(store, statement, status, sizeof **rows, event_row, &made, count, error);
    *rows = made;
    return status;
}

enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot, const struct store_shunt *shunt,
                               struct error *error)
{
    return store_run(store, error, STORE_SHUNT_PUT, session, boot, shunt->number, shunt->gage, shunt->block, shunt->verdict,
                     shunt->span_lb, shunt->noise_lb, shunt->expected_lb, shunt->change_lb, shunt->zero_change_lb, shunt->links);
}

static void shunt_row(sqlite3_stmt *s, void *to)
{
    *(struct store_shunt *)to = (struct store_shunt){
        .number = store_integer(s, 0), .gage = store_integer(s, 1), .block = store_integer(s, 2), .verdict = store_integer(s, 3),
        .span_lb = store_real(s, 4), .noise_lb = store_real(s, 5), .expected_lb = store_real(s, 6), .change_lb = store_real(s, 7),
        .zero_change_lb = store_real(s, 8), .links = store_integer(s, 9)};
}

enum mr_status store_shunts_before(struct store *store, int64_t session, int64_t boot, int64_t block,
                                   struct store_shunt **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status =
        store_query(store, error, &statement, STORE_SHUNTS_BEFORE, session, boot, session, boot, block);
    status = read_rows(store, statement, status, sizeof **rows, shunt_row, &made, count, error);
    *rows = made;
    return status;
}

enum mr_status store_shunts_after(struct store *store, int64_t session, int64_t boot, int64_t block,
                                  struct store_shunt **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status =
        store_query(store, error, &statement, STORE_SHUNTS_AFTER, session, boot, session, boot, block);
    status = read_rows(store, statement, status, sizeof **rows, shunt_row, &made, count, error);
    *rows = made;
    return status;
}
