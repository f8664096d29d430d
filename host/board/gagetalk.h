/* Asking a board for the zeros of its channels, or for a shunt calibration of its gages. */
#ifndef MATRIG_HOST_BOARD_GAGETALK_H
#define MATRIG_HOST_BOARD_GAGETALK_H

#include "common/block.h"
#include "host/board/dialogue.h"
#include "host/board/shunts.h"

struct gagetalk {
    struct mr_ack ack; /* MR_OK: all good; MR_LIMIT: the results say which is not */
    struct shunts shunts;
    struct mr_zero_result zero[MR_CHANNELS];
    unsigned zeros;
};

/* MR_COMMAND_ZERO or MR_COMMAND_SHUNT (common/command.h has their arguments), once the board has
 * said hello; fills `talk`, which subscribes to the caller's dialogue. MR_NOT_NOW: the board is
 * armed, in a landing, or calibrating; MR_TIMEOUT; else as dialogue_hello. */
enum mr_status gagetalk_order(struct gagetalk *talk, struct dialogue *dialogue, unsigned code,
                              int32_t argument, struct error *error);

#endif
