/* Frames on their way into the database. A row of its own costs half as much as the rest of a
 * frame's way through matrig, most of it to find again where the index goes on; rows of one
 * statement do that once. So frames wait until STORE_FRAMES_A_STATEMENT of them are there, or the
 * transaction is committed, or anything is read. */
#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"
#include "host/store/store.h"
#include "common/catalogue.h"
#include "host/base/xmalloc.h"

static struct store_frame_row row_of(int64_t session, const struct store_frame *frame,
                                     const uint8_t *data)
{
    return (struct store_frame_row){.session = session,
                                    .run = frame->run,
                                    .link = frame->link,
                                    .direction = frame->direction,
                                    .seq = frame->seq,
                                    .board_us = frame->board_us,
                                    .host_us = frame->host_us,
                                    .can_id = frame->id,
                                    .dlc = (int64_t)frame->length,
                                    .data = {data, frame->length}};
}

static enum mr_status put_one(struct store *store, int64_t session, const struct store_frame *frame,
                              const uint8_t *data, struct error *error)
{
    const struct store_frame_row row = row_of(session, frame, data);
    return STORE_PUT(store, error, frame_row, &row);
}

static enum mr_status prepare(struct store *store, struct error *error)
{
    if (store->frames_put)
        return MR_OK;
    char *sql = store_insert_text(store_table(STORE_TABLE_frame_row), STORE_FRAMES_A_STATEMENT);
    int code = sql ? sqlite3_prepare_v3(store->database, sql, -1, SQLITE_PREPARE_PERSISTENT,
                                        &store->frames_put, NULL)
                   : SQLITE_NOMEM;
    sqlite3_free(sql);
    return code == SQLITE_OK ? MR_OK : store_failed(store, "use", error);
}

static enum mr_status put_all(struct store *store, struct error *error)
{
    enum mr_status status = prepare(store, error);
    int at = 1;
    for (unsigned i = 0; i < STORE_FRAMES_A_STATEMENT && status == MR_OK; i++) {
        const struct store_waiting *waiting = &store->waiting[i];
        const struct store_frame_row row = row_of(waiting->session, &waiting->frame, waiting->data);
        if (store_bind_row(store->frames_put, store_table(STORE_TABLE_frame_row), NULL, &row,
                           STORE_ALL_RULES, &at) != SQLITE_OK)
            status = store_failed(store, "use", error);
    }
    if (status != MR_OK)
        return status;
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
        status = put_one(store, row->session, &row->frame, row->data, error);
    }
    return status;
}

enum mr_status store_frame_put(struct store *store, int64_t session,
                               const struct store_frame *frame, struct error *error)
{
    if (frame->length > sizeof store->waiting[0].data) { /* only serial has such frames, few */
        enum mr_status status = store_frames_flush(store, error);
        return status == MR_OK ? put_one(store, session, frame, frame->data, error) : status;
    }
    struct store_waiting *row = &store->waiting[store->waiting_count++];
    row->session = session;
    row->frame = *frame;
    row->frame.data = NULL;
    if (frame->length)
        memcpy(row->data, frame->data, frame->length);
    return store->waiting_count == STORE_FRAMES_A_STATEMENT ? store_frames_flush(store, error)
                                                            : MR_OK;
}

enum mr_status store_frames_mark(struct store *store, int64_t *mark, struct error *error)
{
    *mark = 0;
    return STORE_NUMBER(store, error, FRAMES_NEWEST, mark);
}

enum mr_status store_frames_place(struct store *store, int64_t session, int64_t run, int64_t mark,
                                  bool ended, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    return status == MR_OK ? STORE_RUN(store, error, FRAMES_PLACE, BIND(session), BIND(run),
                                       BIND(mark), BIND(MR_ID_LANDING), BIND((int64_t)ended))
                           : status;
}
