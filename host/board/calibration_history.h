/* What a campaign knows of how a board's channels were calibrated: by its landings, by the checks
 * of matrig ready, and by what people said of a change. From these the calibration that today's is
 * held against.
 *
 * The past is walked through in order of time. A calibration that follows from the one before
 * (host/calibrate/jump.h) takes its place; one that jumped does not, so a jump is told until
 * somebody says what was changed, or until it is taken back. What people said is a row of table
 * readiness, kind `change`:
 *     {"note": "...", "who": "...", "calibration": [{"channel": "d3", "number": 3, "gain": ...,
 *     "zero_code": ..., "serial": "...",
 *      "calibrated_day": ...}, ...]}
 * and a check of matrig ready has the same list. */
#ifndef MATRIG_HOST_BOARD_CALIBRATION_HISTORY_H
#define MATRIG_HOST_BOARD_CALIBRATION_HISTORY_H

#include <jansson.h>

#include "common/block.h"
#include "common/config.h"
#include "host/store/store.h"

struct calibration_history {
    /* kind, number, gain as unit_per_code, zero_code (NaN: not known), serial, day */
    struct mr_channel_config channel[MR_CHANNELS];
    /* the landing that it comes from; 0: no landing */
    int64_t run[MR_CHANNELS];
};

/* Kind MR_KIND_NONE: the campaign knows nothing of that channel. */
enum mr_status calibration_history_read(struct store *store, const char *board_uid,
                                        struct calibration_history *past, struct error *error);
/* The list for a row; `only`: bit per channel, from 0. The caller owns it. */
json_t *calibration_history_json(const struct mr_config *config, uint32_t only);
/* Keeps what was said of a change, in a transaction of its own. */
enum mr_status calibration_history_say(struct store *store, const char *board_uid,
                                       const struct mr_config *config, uint32_t channels,
                                       const char *note, int64_t made_us, struct error *error);

#endif
