#include "host/store/store_frames_join.h"

#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "host/store/store_sql.h"
#include "host/base/xmalloc.h"

enum mr_status store_frames_join(struct store *store, const struct store_frames_span *span,
                                 int64_t from_run, int64_t to_run, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    return status == MR_OK ? STORE_RUN(store, error, FRAMES_JOIN, BIND(to_run), BIND(span->mark),
                                       BIND(span->session), BIND(span->link), BIND(from_run),
                                       BIND(span->from_us), BIND(span->to_us))
                           : status;
}

enum mr_status store_frames_place(struct store *store, int64_t session, int64_t run, int64_t mark,
                                  bool ended, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    return status == MR_OK ? STORE_RUN(store, error, FRAMES_PLACE, BIND(session), BIND(run),
                                       BIND(mark), BIND(MR_ID_LANDING), BIND((int64_t)ended))
                           : status;
}

enum mr_status store_frames_since(struct store *store, int64_t run, int link, int64_t mark,
                                  struct store_kept_frame **frames, size_t *count,
                                  struct error *error)
{
    sqlite3_stmt *s;
    struct store_received_frame row;
    *frames = NULL;
    *count = 0;
    enum mr_status status = STORE_QUERY(store, error, FRAMES_SINCE, &s, BIND(mark), BIND(run),
                                        BIND(link));
    while (status == MR_OK && (status = STORE_NEXT(store, error, FRAMES_SINCE, s, &row)) == MR_OK) {
        if (row.data.length > sizeof(*frames)->data)
            continue;
        if (!list_grow(frames, *count, sizeof **frames)) {
            sqlite3_reset(s);
            return error_set(error, MR_FULL,
                             "no memory: frames of RUN %lld in %s; close other programs",
                             (long long)run, store->path);
        }
        struct store_kept_frame *frame = &(*frames)[(*count)++];
        *frame = (struct store_kept_frame){.id = (uint32_t)row.can_id,
                                           .host_us = (uint64_t)row.host_us,
                                           .board_us = row.board_us,
                                           .length = (uint8_t)row.data.length};
        if (row.data.length > 0)
            memcpy(frame->data, row.data.data, row.data.length);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}
