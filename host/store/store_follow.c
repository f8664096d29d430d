#include "host/store/store_follow.h"

#include "host/store/store_sql.h"

#define BLOCKS_A_TURN 5000

enum mr_status store_newest_session(struct store *store, int64_t base, int64_t *session,
                                    struct error *error)
{
    return STORE_NUMBER(store, error, SESSION_NEWEST, session, BIND(base));
}

enum mr_status store_newest_base(struct store *store, int64_t *base, int64_t *boards,
                                 struct error *error)
{
    enum mr_status status = STORE_NUMBER(store, error, BASE_NEWEST, base);
    return status == MR_OK && boards ? STORE_NUMBER(store, error, BASES_NEWEST, boards) : status;
}

enum mr_status store_follow_from(struct store *store, int64_t base, int64_t frames,
                                 struct store_place *place, struct error *error)
{
    int64_t last = 0;
    struct store_frame_moment frame;
    struct store_block_place block = {.boot = -1, .index = -1};
    *place = (struct store_place){.base = base};
    enum mr_status status = STORE_NUMBER(store, error, FRAMES_NEWEST, &last);
    if (status != MR_OK || last <= frames)
        return status;
    place->frame = last - frames;
    status = STORE_ONE(store, error, FRAME_FROM, &frame, BIND(base), BIND(place->frame));
    if (status == MR_TOO_FEW) /* the others' alone */
        return MR_OK;
    /* The newest block before then: backwards from the session's end, so that a long session is not
     * gone through. */
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

/* The two tables side by side, each at its next row. */
struct rows {
    struct store *store;
    sqlite3_stmt *frames, *blocks;
    enum mr_status frame_status, block_status; /* MR_OK: there is one; MR_TOO_FEW: no more */
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

static enum mr_status open_rows(struct rows *rows, const struct store_place *place, int64_t most,
                                struct error *error)
{
    enum mr_status status = STORE_QUERY(rows->store, error, FRAMES_AFTER, &rows->frames,
                                        BIND(place->base), BIND(place->frame), BIND(most));
    if (status == MR_OK)
        status = STORE_QUERY(rows->store, error, BLOCKS_AFTER, &rows->blocks, BIND(place->base),
                             BIND(place->session), BIND(place->boot), BIND(place->index),
                             BIND(BLOCKS_A_TURN));
    if (status != MR_OK)
        return status;
    next_frame(rows, error);
    next_block(rows, error);
    return MR_OK;
}

/* What ended one of the two, when that was not its last row. */
static enum mr_status close_rows(struct rows *rows)
{
    sqlite3_reset(rows->frames);
    sqlite3_reset(rows->blocks);
    if (rows->frame_status != MR_OK && rows->frame_status != MR_TOO_FEW)
        return rows->frame_status;
    return rows->block_status == MR_TOO_FEW ? MR_OK : rows->block_status;
}

/* Gives the blocks that were received until then. */
static void give_blocks(struct rows *rows, struct store_place *place, int64_t until_us,
                        const struct store_follower *follower, int64_t *count, struct error *error)
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

static void give_frame(const struct rows *rows, struct store_place *place,
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

enum mr_status store_follow(struct store *store, struct store_place *place, int64_t most,
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
        give_blocks(&rows, place, rows.frame.host_us, follower, &blocks, error);
        give_frame(&rows, place, follower);
        frames++;
    }
    if (rows.frame_status == MR_TOO_FEW && frames < most)
        give_blocks(&rows, place, INT64_MAX, follower, &blocks, error);
    *more = frames == most || blocks == BLOCKS_A_TURN;
    return close_rows(&rows);
}
