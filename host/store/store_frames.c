/* Frames on their way into the database. A row of its own costs half as much as the rest of a frame's way through matrig, most of it
 * to find again where the index goes on; rows of one statement do that once. So frames wait until STORE_FRAMES_A_STATEMENT of them
 * are there, or the transaction is committed, or anything is read. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_guard.h"
#include "host/store/store_sql.h"

#define COLUMNS 10
#define HEAD "INSERT INTO frames(session, landing, link, direction, seq, board_us, host_us, can_id, dlc, data) VALUES"
#define ROW "(?,?,?,?,?,?,?,?,?,?)"

static enum mr_status put_one(struct store *store, int64_t session, const struct store_frame *frame, struct error *error)
{
    return store_run(store, error, STORE_FRAME_PUT, session, frame->run, (int64_t)frame->link, (int64_t)frame->direction, frame->seq,
                     frame->board_us, frame->host_us, (int64_t)frame->id, (int64_t)frame->length, (const void *)frame->data,
                     frame->length);
}

static int bind_integer(sqlite3_stmt *statement, int column, int64_t value)
{
    return value == STORE_NONE ? sqlite3_bind_null(statement, column) : sqlite3_bind_int64(statement, column, value);
}

/* The bytes stay where they are until the statement has run. */
static int bind_row(sqlite3_stmt *s, int before, const struct store_waiting *row)
{
    const struct store_frame *frame = &row->frame;
    const int64_t integer[COLUMNS - 1] = {row->session,    frame->run,     frame->link, frame->direction,
                                          frame->seq,      frame->board_us, frame->host_us, frame->id,
                                          (int64_t)frame->length};
    int code = SQLITE_OK;
    for (int c = 0; c < COLUMNS - 1 && code == SQLITE_OK; c++)
        code = bind_integer(s, before + c + 1, integer[c]);
    return code == SQLITE_OK ? sqlite3_bind_blob64(s, before + COLUMNS, row->data, frame->length, SQLITE_STATIC) : code;
}

static enum mr_status prepare(struct store *store, struct error *error)
{
    char sql[sizeof HEAD + STORE_FRAMES_A_STATEMENT * sizeof ROW];
    size_t at = (size_t)snprintf(sql, sizeof sql, "%s", HEAD);
    if (store->frames_put)
        return MR_OK;
    for (unsigned i = 0; i < STORE_FRAMES_A_STATEMENT; i++)
        at += (size_t)snprintf(sql + at, sizeof sql - at, "%s" ROW, i ? "," : "");
    return sqlite3_prepare_v3(store->database, sql, -1, SQLITE_PREPARE_PERSISTENT, &store->frames_put, NULL) == SQLITE_OK
               ? MR_OK
               : store_failed(store, "use", error);
}

static enum mr_status put_all(struct store *store, struct error *error)
{
    enum mr_status status = prepare(store, error);
    for (int i = 0; i < (int)STORE_FRAMES_A_STATEMENT && status == MR_OK; i++) {
        if (bind_row(store->frames_put, i * COLUMNS, &store->waiting[i]) != SQLITE_OK)
            status = store_failed(store, "use", error);
    }
    if (status != MR_OK)
        return status;
    store_guard_renew(store);
    if (sqlite3_step(store->frames_put) != SQLITE_DONE)
        status = store_failed(store, "write", error);
    sqlite3_reset(store->frames_put);
    return status;
}

enum mr_status store_frames_flush(struct store *store, struct error *error)
{
    enum mr_status status = MR_OK;
    unsigned count = store->waiting_count;
    store->waiting_count = 0;
    if (count == STORE_FRAMES_A_STATEMENT)
        return put_all(store, error);
    for (unsigned i = 0; i < count && status == MR_OK; i++) {
        const struct store_waiting *row = &store->waiting[i];
        struct store_frame frame = row->frame;
        frame.data = row->data;
        status = put_one(store, row->session, &frame, error);
    }
    return status;
}

enum mr_status store_frame_put(struct store *store, int64_t session, const struct store_frame *frame, struct error *error)
{
    if (frame->length > sizeof store->waiting[0].data) { /* only serial has such frames, few */
        enum mr_status status = store_frames_flush(store, error);
        return status == MR_OK ? put_one(store, session, frame, error) : status;
    }
    struct store_waiting *row = &store->waiting[store->waiting_count++];
    row->session = session;
    row->frame = *frame;
    row->frame.data = NULL;
    if (frame->length)
        memcpy(row->data, frame->data, frame->length);
    return store->waiting_count == STORE_FRAMES_A_STATEMENT ? store_frames_flush(store, error) : MR_OK;
}

enum mr_status store_frames_mark(struct store *store, int64_t *mark, struct error *error)
{
    sqlite3_stmt *statement = NULL;
    *mark = 0;
    enum mr_status status = store_frames_flush(store, error);
    if (status == MR_OK)
        status = store_query(store, error, &statement, STORE_FRAMES_NEWEST);
    return store_take_integer(store, statement, status, mark, error);
}

enum mr_status store_frames_move(struct store *store, int64_t session, int link, int64_t mark, int64_t from_run, int64_t to_run,
                                 struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    return status == MR_OK
               ? store_run(store, error, STORE_FRAMES_MOVE, to_run, mark, session, (int64_t)link, from_run)
               : status;
}
