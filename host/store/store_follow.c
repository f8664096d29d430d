#include "host/store/store_follow.h"

#include "host/store/store_guard.h"
#include "host/store/store_sql.h"

#define BLOCKS_A_TURN 5000

static enum mr_status prepare(struct store *store, const char *sql, sqlite3_stmt **statement, struct error *error)
{
    store_guard_renew(store);
    return sqlite3_prepare_v2(store->database, sql, -1, statement, NULL) == SQLITE_OK ? MR_OK : store_failed(store, "read", error);
}

/* The end of a statement that was stepped through. */
static enum mr_status finish(struct store *store, sqlite3_stmt *statement, int code, struct error *error)
{
    enum mr_status status = code == SQLITE_ROW || code == SQLITE_DONE ? MR_OK : store_failed(store, "read", error);
    sqlite3_finalize(statement);
    return status;
}

static enum mr_status one_number(struct store *store, const char *sql, int64_t parameter, int64_t *value, struct error *error)
{
    sqlite3_stmt *statement;
    enum mr_status status = prepare(store, sql, &statement, error);
    if (status != MR_OK)
        return status;
    if (sqlite3_bind_parameter_count(statement) > 0)
        sqlite3_bind_int64(statement, 1, parameter);
    int code = sqlite3_step(statement);
    *value = code == SQLITE_ROW ? sqlite3_column_int64(statement, 0) : 0;
    return finish(store, statement, code, error);
}

/* 6 is DOUBT_EXCESS; those below it are recognised and not obeyed. */
enum mr_status store_doubted(struct store *store, int64_t session, int64_t *count, struct error *error)
{
    return one_number(store,
                      "SELECT max(coalesce(sum(detail) FILTER (WHERE code % 256 = 6), 0),"
                      " coalesce(sum(detail) FILTER (WHERE code % 256 < 6), 0)) FROM events WHERE session=? AND kind='doubt'",
                      session, count, error);
}

enum mr_status store_newest_session(struct store *store, int64_t *session, struct error *error)
{
    return one_number(store, "SELECT max(id) FROM sessions", 0, session, error);
}

enum mr_status store_follow_from(struct store *store, int64_t frames, struct store_place *place, struct error *error)
{
    sqlite3_stmt *statement;
    int64_t last, host_us, session;
    *place = (struct store_place){0};
    enum mr_status status = one_number(store, "SELECT max(id) FROM frames", 0, &last, error);
    if (status != MR_OK || last <= frames)
        return status;
    place->frame = last - frames;
    status = one_number(store, "SELECT host_us FROM frames WHERE id>=? ORDER BY id LIMIT 1", place->frame, &host_us, error);
    if (status == MR_OK)
        status = one_number(store, "SELECT session FROM frames WHERE id>=? ORDER BY id LIMIT 1", place->frame, &session, error);
    /* The newest block before then: backwards from the session's end, so that a long session is not gone through. */
    if (status == MR_OK)
        status = prepare(store, "SELECT boot, idx FROM blocks WHERE session=? AND host_us<? ORDER BY boot DESC, idx DESC LIMIT 1", &statement,
                         error);
    if (status != MR_OK)
        return status;
    sqlite3_bind_int64(statement, 1, session);
    sqlite3_bind_int64(statement, 2, host_us);
    int code = sqlite3_step(statement);
    place->session = session;
    place->boot = code == SQLITE_ROW ? sqlite3_column_int64(statement, 0) : -1;
    place->index = code == SQLITE_ROW ? sqlite3_column_int64(statement, 1) : -1;
    return finish(store, statement, code, error);
}

/* The two tables side by side, each at its next row. */
struct rows {
    sqlite3_stmt *frames, *blocks;
    int frame, block; /* what the last step said */
};

static enum mr_status open_rows(struct store *store, const struct store_place *place, int64_t most, struct rows *rows, struct error *error)
{
    enum mr_status status = prepare(store, "SELECT id, link, direction, host_us, can_id, dlc, data, board_us FROM frames WHERE id>? ORDER BY id LIMIT ?",
                                    &rows->frames, error);
    if (status == MR_OK)
        status = prepare(store, "SELECT session, boot, idx, host_us, record FROM blocks WHERE (session, boot, idx) > (?, ?, ?)"
                                " ORDER BY session, boot, idx LIMIT ?", &rows->blocks, error);
    if (status != MR_OK)
        return status;
    sqlite3_bind_int64(rows->frames, 1, place->frame);
    sqlite3_bind_int64(rows->frames, 2, most);
    sqlite3_bind_int64(rows->blocks, 1, place->session);
    sqlite3_bind_int64(rows->blocks, 2, place->boot);
    sqlite3_bind_int64(rows->blocks, 3, place->index);
    sqlite3_bind_int64(rows->blocks, 4, BLOCKS_A_TURN);
    rows->frame = sqlite3_step(rows->frames);
    rows->block = sqlite3_step(rows->blocks);
    return MR_OK;
}

/* Gives the blocks that were received until then. */
static void give_blocks(struct rows *rows, struct store_place *place, int64_t until_us, const struct store_follower *follower,
                        int64_t *count)
{
    sqlite3_stmt *s = rows->blocks;
    for (; rows->block == SQLITE_ROW && sqlite3_column_int64(s, 3) <= until_us; rows->block = sqlite3_step(s)) {
        place->session = sqlite3_column_int64(s, 0);
        place->boot = sqlite3_column_int64(s, 1);
        place->index = sqlite3_column_int64(s, 2);
        follower->record(follower->context, sqlite3_column_blob(s, 4), (size_t)sqlite3_column_bytes(s, 4), sqlite3_column_int64(s, 3));
        ++*count;
    }
}

static void give_frame(struct rows *rows, struct store_place *place, const struct store_follower *follower)
{
    sqlite3_stmt *s = rows->frames;
    struct store_frame frame = {.link = sqlite3_column_int(s, 1), .direction = sqlite3_column_int(s, 2),
                                .host_us = sqlite3_column_int64(s, 3), .id = (uint32_t)sqlite3_column_int64(s, 4),
                                .data = sqlite3_column_blob(s, 6), .length = (size_t)sqlite3_column_bytes(s, 6),
                                .board_us = sqlite3_column_type(s, 7) == SQLITE_NULL ? STORE_NONE : sqlite3_column_int64(s, 7)};
    place->frame = sqlite3_column_int64(s, 0);
    if (frame.direction == 0)
        follower->frame(follower->context, &frame);
}

enum mr_status store_follow(struct store *store, struct store_place *place, int64_t most, const struct store_follower *follower,
                            bool *more, struct error *error)
{
    struct rows rows = {.frame = SQLITE_DONE, .block = SQLITE_DONE};
    int64_t frames = 0, blocks = 0;
    struct error late = {0};
    enum mr_status status = open_rows(store, place, most, &rows, error);
    for (; status == MR_OK && rows.frame == SQLITE_ROW && blocks < BLOCKS_A_TURN; rows.frame = sqlite3_step(rows.frames)) {
        give_blocks(&rows, place, sqlite3_column_int64(rows.frames, 3), follower, &blocks);
        give_frame(&rows, place, follower);
        frames++;
    }
    if (status == MR_OK && rows.frame == SQLITE_DONE && frames < most)
        give_blocks(&rows, place, INT64_MAX, follower, &blocks);
    *more = frames == most || blocks == BLOCKS_A_TURN;
    if (finish(store, rows.frames, rows.frame, &late) != MR_OK || finish(store, rows.blocks, rows.block, &late) != MR_OK)
        status = status == MR_OK ? error_set(error, late.status, "%s", late.text) : status;
    return status;
}
