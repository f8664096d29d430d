/* Measurement of a board's channel zeros, and shunt calibration of its gages. */
#ifndef MATRIG_HOST_BOARD_GAGE_CLIENT_H
#define MATRIG_HOST_BOARD_GAGE_CLIENT_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "host/board/dialogue.h"

/* Results of a shunt calibration as a board sends them: the result of each gage, followed by its
 * change since the last calibration. */
struct shunts {
    /* a calibration has begun in this dialogue; results that arrive earlier are ignored */
    bool has_begun;
    unsigned count;
    struct mr_shunt_result result[MR_GAGES];
    /* change since the previous calibration; NaN: not reported */
    struct mr_shunt_check check[MR_GAGES];
};

/* Updates the results from a message; messages of other kinds change nothing. A zeroed struct
 * contains no results. */
void shunts_receive(struct shunts *shunts, uint32_t id, const uint8_t *bytes, size_t length);

/* Returns the verdict of a shunt calibration as text; STORE_NONE: "not calibrated". Static
 * storage. */
const char *shunts_verdict_text(int64_t verdict);

/* A client that makes a board measure the zeros of its channels or calibrate its gages with the
 * shunt. */
struct gage_client {
    /* MR_OK: all channels are good; MR_LIMIT: the results show which channel is outside its
     * limit */
    struct mr_ack ack;
    struct shunts shunts;
    struct mr_zero_result zero[MR_CHANNELS];
    unsigned zero_count;
};

/* Waits for the board's hello and sends MR_COMMAND_ZERO or MR_COMMAND_SHUNT (common/command.h has
 * their arguments). Fills `client`, which subscribes to the caller's dialogue. MR_NOT_NOW: the
 * board is armed, in a landing, or calibrating. MR_TIMEOUT: no answer. Other statuses as
 * dialogue_wait_for_hello. */
enum mr_status gage_client_send(struct gage_client *client, struct dialogue *dialogue,
                                unsigned code, int32_t argument, struct error *error);

#endif
