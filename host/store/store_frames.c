/* Buffering of frames that are written, and reading of a campaign while it is logged. Many frames
 * are written with one statement, which is faster, because SQLite then searches the index only
 * once. Frames are buffered until there are STORE_FRAMES_PER_STATEMENT, or until a commit or any
 * read. */
#include <stdlib.h>
#include <string.h>

#include "host/store/store.h"
#include "host/store/table.h"
#include "common/catalogue.h"
#include "host/base/xmalloc.h"

static struct store_frame_row make_frame_row(int64_t session, const struct store_frame *frame,
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

static enum mr_status prepare_insert_frames(struct store *store, struct error *error)
{
    if (store->insert_frames)
        return MR_OK;
    char *sql = store_make_insert_sql(store_table_get(STORE_TABLE_frame_row),
                                      STORE_FRAMES_PER_STATEMENT);
    int code = sql ? sqlite3_prepare_v3(store->database, sql, -1, SQLITE_PREPARE_PERSISTENT,
                                        &store->insert_frames, NULL)
                   : SQLITE_NOMEM;
    sqlite3_free(sql);
    return code == SQLITE_OK ? MR_OK : store_set_error(store, "use", error);
}

static enum mr_status put_full_buffer(struct store *store, struct error *error)
{
    enum mr_status status = prepare_insert_frames(store, error);
    int at = 1;
    for (unsigned i = 0; i < STORE_FRAMES_PER_STATEMENT && status == MR_OK; i++) {
        if (store_bind_row(store->insert_frames, store_table_get(STORE_TABLE_frame_row), NULL,
                           &store->buffered_frames[i].row, STORE_WRITTEN_MERGE_RULES,
                           &at) != SQLITE_OK)
            status = store_set_error(store, "use", error);
    }
    if (status != MR_OK)
        return status;
    if (sqlite3_step(store->insert_frames) != SQLITE_DONE)
        status = store_set_error(store, "write", error);
    sqlite3_reset(store->insert_frames);
    return status;
}

enum mr_status store_frames_flush(struct store *store, struct error *error)
{
    enum mr_status status = MR_OK;
    unsigned count = store->buffered_frame_count;
    store->buffered_frame_count = 0;
    if (count == STORE_FRAMES_PER_STATEMENT)
        return put_full_buffer(store, error);
    for (unsigned i = 0; i < count && status == MR_OK; i++)
        status = STORE_PUT(store, error, frame_row, &store->buffered_frames[i].row);
    return status;
}

enum mr_status store_frame_put(struct store *store, int64_t session,
                               const struct store_frame *frame, struct error *error)
{
    struct store_buffered_frame *waiting = &store->buffered_frames[store->buffered_frame_count];
    /* rare: only a serial frame can be that long */
    if (frame->length > sizeof waiting->data) {
        const struct store_frame_row row = make_frame_row(session, frame, frame->data);
        enum mr_status status = store_frames_flush(store, error);
        return status == MR_OK ? STORE_PUT(store, error, frame_row, &row) : status;
    }
    if (frame->length)
        memcpy(waiting->data, frame->data, frame->length);
    waiting->row = make_frame_row(session, frame, waiting->data);
    return ++store->buffered_frame_count == STORE_FRAMES_PER_STATEMENT
             ? store_frames_flush(store, error)
             : MR_OK;
}

enum mr_status store_newest_frame_get(struct store *store, int64_t *mark, struct error *error)
{
    *mark = 0;
    return STORE_READ_NUMBER(store, error, FRAMES_NEWEST, mark);
}

enum mr_status store_frames_assign(struct store *store, int64_t session, int64_t run, int64_t mark,
                                   int64_t last, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    return status == MR_OK ? STORE_RUN_STATEMENT(store, error, FRAMES_ASSIGN, STORE_BIND(session),
                                                 STORE_BIND(run), STORE_BIND(mark),
                                                 STORE_BIND(MR_ID_LANDING), STORE_BIND(last))
                           : status;
}

/* ---- following a running log ---- */

#define BLOCKS_PER_CALL_MAX 5000

enum mr_status store_follow_begin(struct store *store, int64_t frames,
                                  struct store_follow_position *position, struct error *error)
{
    int64_t last = 0;
    struct store_frame_reception frame;
    struct store_block_position block = {.boot = -1, .index = -1};
    *position = (struct store_follow_position){.newest_frame_id = 0};
    enum mr_status status = STORE_READ_NUMBER(store, error, FRAMES_NEWEST, &last);
    if (status != MR_OK || last <= frames)
        return status;
    position->newest_frame_id = last - frames;
    status = STORE_READ_ONE(store, error, FRAME_FROM, &frame,
                            STORE_BIND(position->newest_frame_id));
    /* Find the newest block before the frame. Search backwards from the end, because a session can
     * be long. */
    if (status == MR_OK)
        status = STORE_READ_ONE(store, error, BLOCK_BEFORE, &block, STORE_BIND(frame.session),
                                STORE_BIND(frame.host_us));
    if (status != MR_OK && status != MR_TOO_FEW)
        return status;
    position->session = frame.session;
    position->boot = block.boot;
    position->index = block.index;
    return MR_OK;
}

/* Rows of two queries, for frames and for blocks, that are read in parallel. */
struct follow_rows {
    struct store *store;
    sqlite3_stmt *frames_statement, *blocks_statement;
    enum mr_status frame_status,
        block_status; /* MR_OK: the next row is valid; MR_TOO_FEW: no more rows */
    struct store_frame_row frame;
    struct store_block block;
};

static void read_next_frame(struct follow_rows *rows, struct error *error)
{
    rows->frame_status = STORE_READ_NEXT(rows->store, error, FRAMES_AFTER, rows->frames_statement,
                                         &rows->frame);
}

static void read_next_block(struct follow_rows *rows, struct error *error)
{
    rows->block_status = STORE_READ_NEXT(rows->store, error, BLOCKS_AFTER, rows->blocks_statement,
                                         &rows->block);
}

static enum mr_status begin_rows(struct follow_rows *rows,
                                 const struct store_follow_position *position, int64_t frames_max,
                                 struct error *error)
{
    enum mr_status status = STORE_QUERY(rows->store, error, FRAMES_AFTER, &rows->frames_statement,
                                        STORE_BIND(position->newest_frame_id),
                                        STORE_BIND(frames_max));
    if (status == MR_OK)
        status = STORE_QUERY(rows->store, error, BLOCKS_AFTER, &rows->blocks_statement,
                             STORE_BIND(position->session), STORE_BIND(position->boot),
                             STORE_BIND(position->index), STORE_BIND(BLOCKS_PER_CALL_MAX));
    if (status != MR_OK)
        return status;
    read_next_frame(rows, error);
    read_next_block(rows, error);
    return MR_OK;
}

/* Resets both statements. Returns the error that ended one of them, if there was one. */
static enum mr_status end_rows(struct follow_rows *rows)
{
    sqlite3_reset(rows->frames_statement);
    sqlite3_reset(rows->blocks_statement);
    if (rows->frame_status != MR_OK && rows->frame_status != MR_TOO_FEW)
        return rows->frame_status;
    return rows->block_status == MR_TOO_FEW ? MR_OK : rows->block_status;
}

/* Passes the blocks that were received up to `until_us` to the follower. */
static void deliver_blocks(struct follow_rows *rows, struct store_follow_position *position,
                           int64_t until_us, const struct store_follower *follower, int64_t *count,
                           struct error *error)
{
    for (; rows->block_status == MR_OK && rows->block.host_us <= until_us;
         read_next_block(rows, error)) {
        position->session = rows->block.session;
        position->boot = rows->block.boot;
        position->index = rows->block.index;
        follower->record(follower->context, rows->block.record.data, rows->block.record.length,
                         rows->block.host_us);
        ++*count;
    }
}

static void deliver_frame(const struct follow_rows *rows, struct store_follow_position *position,
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
    position->newest_frame_id = row->id;
    if (frame.direction == 0)
        follower->frame(follower->context, &frame);
}

enum mr_status store_follow(struct store *store, struct store_follow_position *position,
                            int64_t frames_max, const struct store_follower *follower, bool *more,
                            struct error *error)
{
    struct follow_rows rows = {.store = store};
    int64_t frames = 0, blocks = 0;
    enum mr_status status = begin_rows(&rows, position, frames_max, error);
    if (status != MR_OK) {
        end_rows(&rows);
        return status;
    }
    for (; rows.frame_status == MR_OK && blocks < BLOCKS_PER_CALL_MAX;
         read_next_frame(&rows, error)) {
        deliver_blocks(&rows, position, rows.frame.host_us, follower, &blocks, error);
        deliver_frame(&rows, position, follower);
        frames++;
    }
    if (rows.frame_status == MR_TOO_FEW && frames < frames_max)
        deliver_blocks(&rows, position, INT64_MAX, follower, &blocks, error);
    *more = frames == frames_max || blocks == BLOCKS_PER_CALL_MAX;
    return end_rows(&rows);
}
