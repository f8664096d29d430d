#include "host/store/store_frames_join.h"

#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

enum mr_status store_frames_join(struct store *store, const struct store_frames_span *span, int64_t from_run, int64_t to_run,
                                 struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    return status == MR_OK ? store_run(store, error, STORE_FRAMES_JOIN, to_run, span->mark, span->session, (int64_t)span->link, from_run,
                                       span->from_us, span->to_us)
                           : status;
}

static bool grow(struct store_kept_frame **frames, size_t *capacity)
{
    size_t more = *capacity ? 2 * *capacity : 256;
    struct store_kept_frame *made = realloc(*frames, more * sizeof *made);
    if (made) {
        *frames = made;
        *capacity = more;
    }
    return made != NULL;
}

enum mr_status store_frames_since(struct store *store, int64_t run, int link, int64_t mark, struct store_kept_frame **frames, size_t *count,
                                  struct error *error)
{
    sqlite3_stmt *s;
    size_t capacity = 0;
    *frames = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &s, STORE_FRAMES_SINCE, mark, run, (int64_t)link);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        const void *data = sqlite3_column_blob(s, 2);
        int length = sqlite3_column_bytes(s, 2);
        if (length > (int)sizeof (*frames)->data)
            continue;
        if (*count == capacity && !grow(frames, &capacity)) {
            store_reset(s);
            return error_set(error, MR_FULL, "no memory: frames of RUN %lld in %s; close other programs", (long long)run, store->path);
        }
        struct store_kept_frame *frame = &(*frames)[(*count)++];
        *frame = (struct store_kept_frame){.id = (uint32_t)store_integer(s, 0), .host_us = (uint64_t)store_integer(s, 1), .length = (uint8_t)length};
        if (length > 0)
            memcpy(frame->data, data, (size_t)length);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}
