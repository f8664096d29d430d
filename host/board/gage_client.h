/* Zeros and shunt calibration of a board. */
#ifndef MATRIG_HOST_BOARD_GAGE_CLIENT_H
#define MATRIG_HOST_BOARD_GAGE_CLIENT_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "host/board/dialogue.h"

/* The results of a shunt calibration, as a board sends them: each gage's, followed by its change
 * since the last one. */
struct shunts {
    bool begun; /* one began during this dialogue; results of an earlier one do not count */
    unsigned count;
    struct mr_shunt_result result[MR_GAGES];
    struct mr_shunt_check check[MR_GAGES]; /* NaN: not reported */
};

/* All zero: none. Takes a message in; those of other kinds change nothing. */
void shunts_take(struct shunts *shunts, uint32_t id, const uint8_t *bytes, size_t length);

/* Result of a shunt calibration in words; for none (STORE_NONE): "not calibrated". Static
 * storage. */
const char *shunts_verdict_text(int64_t verdict);

/* Asking a board for the zeros of its channels, or for a shunt calibration of its gages. */
struct gage_client {
    struct mr_ack ack; /* MR_OK: all good; MR_LIMIT: the results show which one is not */
    struct shunts shunts;
    struct mr_zero_result zero[MR_CHANNELS];
    unsigned zeros;
};

/* MR_COMMAND_ZERO or MR_COMMAND_SHUNT (common/command.h has their arguments), after the board's
 * hello; fills `talk`, which subscribes to the caller's dialogue. MR_NOT_NOW: the board is armed,
 * in a landing, or calibrating; MR_TIMEOUT; else as dialogue_hello. */
enum mr_status gage_client_order(struct gage_client *talk, struct dialogue *dialogue, unsigned code,
                                 int32_t argument, struct error *error);

#endif
