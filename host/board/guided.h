/* Points from a board, one by one: somebody sets a known value and types it, the board's live
 * readings say the code. */
#ifndef MATRIG_HOST_BOARD_GUIDED_H
#define MATRIG_HOST_BOARD_GUIDED_H

#include "host/calibrate/points.h"
#include "host/base/cli.h"

struct calibrate_guided {
    const struct cli *cli;
    const char *serial, *name;    /* link of the board; "d3" */
    unsigned channel;             /* index */
    const struct unit_word *unit; /* of values that are typed without one */
};

/* The configuration in force, and the points, their values in in or lb. MR_USAGE: the channel is
 * not fitted; MR_TIMEOUT; MR_LIMIT: its readings are not valid. */
enum mr_status calibrate_guide(const struct calibrate_guided *guided, struct mr_config *config,
                               struct calibrate_points *points, struct error *error);

#endif
