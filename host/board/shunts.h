/* The results of a shunt calibration, as a board tells them: each gage's, and behind it what
 * changed since the last one. */
#ifndef MATRIG_HOST_BOARD_SHUNTS_H
#define MATRIG_HOST_BOARD_SHUNTS_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"

struct shunts {
    bool begun; /* one began while somebody listened; results of an earlier one do not count */
    unsigned count;
    struct mr_shunt_result result[MR_GAGES];
    struct mr_shunt_check check[MR_GAGES]; /* NaN: not told */
};

/* All zero: none. Takes a message in; those of other kinds change nothing. */
void shunts_take(struct shunts *shunts, uint32_t id, const uint8_t *bytes, size_t length);

/* What a shunt calibration came to; a number that is none (STORE_NONE): "not calibrated". Static
 * storage. */
const char *shunts_verdict_text(int64_t verdict);

#endif
