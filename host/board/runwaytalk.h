/* Talking to a board about what its predictor knows of the runway: reading it, giving it one,
 * making it forget. */
#ifndef MATRIG_HOST_BOARD_RUNWAYTALK_H
#define MATRIG_HOST_BOARD_RUNWAYTALK_H

#include "common/runway.h"
#include "host/board/dialogue.h"

struct runwaytalk {
    struct dialogue *dialogue;
    bool said_hello, stored_known, looked, whole;
    struct mr_runway_store stored;   /* where it comes from */
    struct mr_predictor_state state; /* the runway, once read */
    unsigned parts;
};

/* The dialogue is the caller's; `talk` subscribes to it. Waits until the board has said hello and
 * looked through its memory. Statuses as dialogue_hello. */
enum mr_status runwaytalk_begin(struct runwaytalk *talk, struct dialogue *dialogue,
                                struct error *error);
/* Fills state and stored; whole, and of the CRC that the board says it has. MR_CRC: it came damaged
 * each time. */
enum mr_status runwaytalk_read(struct runwaytalk *talk, struct error *error);
/* The board has taken it, and kept it, when this says MR_OK. MR_LIMIT: the board has another number
 * of mats; MR_MALFORMED: it is refused; MR_NOT_NOW. */
enum mr_status runwaytalk_give(struct runwaytalk *talk, const struct mr_predictor_state *state,
                               struct error *error);
/* The runway is one that nobody has measured, and kept so, when this says MR_OK. MR_NOT_NOW. */
enum mr_status runwaytalk_forget(struct runwaytalk *talk, struct error *error);

#endif
