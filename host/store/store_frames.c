/* Frames waiting for the database. A statement per frame costs half as much as all other work on a
 * frame in matrig, mostly to find the place in the index. A statement with many rows finds it once.
 * So frames wait until there are STORE_FRAMES_A_STATEMENT, or until a commit or any read. */
#include <stdlib.h>
#include <string.h>

#include "host/store/store.h"
#include "host/store/table.h"
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
        if (store_bind_row(store->frames_put, store_table(STORE_TABLE_frame_row), NULL,
                           &store->waiting[i].row, STORE_ALL_RULES, &at) != SQLITE_OK)
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
    for (unsigned i = 0; i < count && status == MR_OK; i++)
        status = STORE_PUT(store, error, frame_row, &store->waiting[i].row);
    return status;
}

enum mr_status store_frame_put(struct store *store, int64_t session,
                               const struct store_frame *frame, struct error *error)
{
    struct store_waiting *waiting = &store->waiting[store->waiting_count];
    if (frame->length > sizeof waiting->data) { /* rare: only serial has such frames */
        const struct store_frame_row row = row_of(session, frame, frame->data);
        enum mr_status status = store_frames_flush(store, error);
        return status == MR_OK ? STORE_PUT(store, error, frame_row, &row) : status;
    }
    if (frame->length)
        memcpy(waiting->data, frame->data, frame->length);
    waiting->row = row_of(session, frame, waiting->data);
    return ++store->waiting_count == STORE_FRAMES_A_STATEMENT ? store_frames_flush(store, error)
                                                              : MR_OK;
}

enum mr_status store_frames_mark(struct store *store, int64_t *mark, struct error *error)
{
    *mark = 0;
    return STORE_NUMBER(store, error, FRAMES_NEWEST, mark);
}

enum mr_status store_frames_place(struct store *store, int64_t session, int64_t run, int64_t mark,
                                  int64_t last, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    return status == MR_OK ? STORE_RUN(store, error, FRAMES_PLACE, BIND(session), BIND(run),
                                       BIND(mark), BIND(MR_ID_LANDING), BIND(last))
                           : status;
}

/* ---- following a running log ---- */

#define BLOCKS_A_TURN 5000

enum mr_status store_follow_from(struct store *store, int64_t frames,
                                 struct store_follow_place *place, struct error *error)
{
    int64_t last = 0;
    struct store_frame_moment frame;
    struct store_block_place block = {.boot = -1, .index = -1};
    *place = (struct store_follow_place){.frame = 0};
    enum mr_status status = STORE_NUMBER(store, error, FRAMES_NEWEST, &last);
    if (status != MR_OK || last <= frames)
        return status;
    place->frame = last - frames;
    status = STORE_ONE(store, error, FRAME_FROM, &frame, BIND(place->frame));
    /* The newest block before the frame. The query searches backwards from the session's end, so a
     * long session is not read in full. */
    if (status == MR_OK)
        status = STORE_ONE(store, error, BLOCK_BEFORE, &block, BIND(frame.session),
                           BIND(frame.host_us));
    if (status != MR_OK && status != MR_TOO_FEW)
        return status;
    place->session = frame.session;
    place->boot = block.boot;
    place->index = block.index;
    return MR_OK;
}

/* Both tables in parallel, each at its next row. */
struct rows {
    struct store *store;
    sqlite3_stmt *frames, *blocks;
    enum mr_status frame_status, block_status; /* MR_OK: a row is there; MR_TOO_FEW: no more rows */
    struct store_frame_row frame;
    struct store_block block;
};

static void next_frame(struct rows *rows, struct error *error)
{
    rows->frame_status = STORE_NEXT(rows->store, error, FRAMES_AFTER, rows->frames, &rows->frame);
}

static void next_block(struct rows *rows, struct error *error)
{
    rows->block_status = STORE_NEXT(rows->store, error, BLOCKS_AFTER, rows->blocks, &rows->block);
}

static enum mr_status open_rows(struct rows *rows, const struct store_follow_place *place,
                                int64_t most, struct error *error)
{
    enum mr_status status = STORE_QUERY(rows->store, error, FRAMES_AFTER, &rows->frames,
                                        BIND(place->frame), BIND(most));
    if (status == MR_OK)
        status = STORE_QUERY(rows->store, error, BLOCKS_AFTER, &rows->blocks, BIND(place->session),
                             BIND(place->boot), BIND(place->index), BIND(BLOCKS_A_TURN));
    if (status != MR_OK)
        return status;
    next_frame(rows, error);
    next_block(rows, error);
    return MR_OK;
}

/* Reset both statements; returns an error that ended one of them early. */
static enum mr_status close_rows(struct rows *rows)
{
    sqlite3_reset(rows->frames);
    sqlite3_reset(rows->blocks);
    if (rows->frame_status != MR_OK && rows->frame_status != MR_TOO_FEW)
        return rows->frame_status;
    return rows->block_status == MR_TOO_FEW ? MR_OK : rows->block_status;
}

/* Deliver the blocks that were received up to until_us. */
static void deliver_blocks(struct rows *rows, struct store_follow_place *place, int64_t until_us,
                           const struct store_follower *follower, int64_t *count,
                           struct error *error)
{
    for (; rows->block_status == MR_OK && rows->block.host_us <= until_us;
         next_block(rows, error)) {
        place->session = rows->block.session;
        place->boot = rows->block.boot;
        place->index = rows->block.index;
        follower->record(follower->context, rows->block.record.data, rows->block.record.length,
                         rows->block.host_us);
        ++*count;
    }
}

static void deliver_frame(const struct rows *rows, struct store_follow_place *place,
                          const struct store_follower *follower)
{
    const struct store_frame_row *row = &rows->frame;
    const struct store_frame frame = {.link = (int)row->link,
                                      .direction = (int)row->direction,
                                      .host_us = row->host_us,
                                      .id = (uint32_t)row->can_id,
                                      .data = row->data.data,
                                      .length = row->data.length,
                                      .board_us = row->board_us};
    place->frame = row->id;
    if (frame.direction == 0)
        follower->frame(follower->context, &frame);
}

enum mr_status store_follow(struct store *store, struct store_follow_place *place, int64_t most,
                            const struct store_follower *follower, bool *more, struct error *error)
{
    struct rows rows = {.store = store};
    int64_t frames = 0, blocks = 0;
    enum mr_status status = open_rows(&rows, place, most, error);
    if (status != MR_OK) {
        close_rows(&rows);
        return status;
    }
    for (; rows.frame_status == MR_OK && blocks < BLOCKS_A_TURN; next_frame(&rows, error)) {
        deliver_blocks(&rows, place, rows.frame.host_us, follower, &blocks, error);
        deliver_frame(&rows, place, follower);
        frames++;
    }
    if (rows.frame_status == MR_TOO_FEW && frames < most)
        deliver_blocks(&rows, place, INT64_MAX, follower, &blocks, error);
    *more = frames == most || blocks == BLOCKS_A_TURN;
    return close_rows(&rows);
}
