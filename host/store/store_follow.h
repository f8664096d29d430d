/* Reading a campaign database while another process writes it: what has come since the last look,
 * in order of reception. */
#ifndef MATRIG_HOST_STORE_STORE_FOLLOW_H
#define MATRIG_HOST_STORE_STORE_FOLLOW_H

#include "host/store/store.h"

/* Where one has read to, of the sessions of one board. */
struct store_place {
    int64_t base;                 /* of the board on CAN (common/canbase.h) */
    int64_t frame;                /* id of the newest frame read */
    int64_t session, boot, index; /* of the newest block read */
};

/* The lowest base of the boards that the newest log is of, and how many there are (NULL: it is not
 * asked for). */
enum mr_status store_newest_base(struct store *store, int64_t *base, int64_t *boards,
                                 struct error *error);

/* The place some `frames` before the end, or the beginning, of the board at `base`. */
enum mr_status store_follow_from(struct store *store, int64_t base, int64_t frames,
                                 struct store_place *place, struct error *error);

/* Gives up to `most` frames that the board sent after the place, and the blocks received until
 * then, to `frame` and `record`, and moves the place. `*more`: there are more. */
struct store_follower {
    void (*frame)(void *context, const struct store_frame *frame);
    void (*record)(void *context, const uint8_t *record, size_t length, int64_t host_us);
    void *context;
};
enum mr_status store_follow(struct store *store, struct store_place *place, int64_t most,
                            const struct store_follower *follower, bool *more, struct error *error);

/* The newest session of the board at `base`; 0: none. */
enum mr_status store_newest_session(struct store *store, int64_t base, int64_t *session,
                                    struct error *error);

#endif
