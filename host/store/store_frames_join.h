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

/* Of two links that are read one after the other: of the frames of CAN after `mark` those are the
 * landing's that came from the state that serial said first of it to the one that it said last, if
 * it said the end (`ended`). */
enum mr_status store_frames_place(struct store *store, int64_t session, int64_t run, int64_t mark,
                                  bool ended, struct error *error);

struct store_kept_frame {
    uint32_t id;
    uint64_t host_us;
    int64_t board_us; /* STORE_NONE: not known */
    uint8_t length, data[8];
};
/* Those of a landing that the board sent on CAN, later than `mark`, in order; the caller frees
 * them. */
enum mr_status store_frames_since(struct store *store, int64_t run, int link, int64_t mark,
                                  struct store_kept_frame **frames, size_t *count,
                                  struct error *error);

#endif
