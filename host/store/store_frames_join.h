/* Frames that were put to the wrong landing. Conventions as in store.h. */
#ifndef MATRIG_HOST_STORE_STORE_FRAMES_JOIN_H
#define MATRIG_HOST_STORE_STORE_FRAMES_JOIN_H

#include "host/store/store.h"

/* Of a link in a session, later than the row `mark` (store_frames_mark), of this board time. */
struct store_frames_span {
    int64_t session;
    int link;
    int64_t mark, from_us, to_us;
};
/* Those of `from_run` (STORE_NONE: of none) become those of `to_run`. */
enum mr_status store_frames_join(struct store *store, const struct store_frames_span *span,
                                 int64_t from_run, int64_t to_run, struct error *error);

struct store_kept_frame {
    uint32_t id;
    uint64_t host_us;
    uint8_t length, data[8];
};
/* Those of a landing that the board sent on CAN, later than `mark`, in order; the caller frees
 * them. */
enum mr_status store_frames_since(struct store *store, int64_t run, int link, int64_t mark,
                                  struct store_kept_frame **frames, size_t *count,
                                  struct error *error);

#endif
