/* Calibration of all channels in one walk: those that are due first, then whichever the person
 * wants. The board holds a channel's calibration before the next one begins, so a walk that was
 * broken off goes on behind it. */
#ifndef MATRIG_HOST_DAY_WALK_H
#define MATRIG_HOST_DAY_WALK_H

#include <stdbool.h>

#include "host/base/error.h"
#include "host/board/configtext.h"

struct day_walk {
    const char *db, *serial, *folder; /* files of the walk go there */
    bool ended;                       /* out: no channel was left that is due */
};

/* Whether channel 0.. is due on a day (since 1970-01-01): it was never calibrated, or expires. */
bool day_walk_is_due(const struct mr_config *config, unsigned channel, uint32_t today);

/* At this terminal. MR_IO, MR_MALFORMED: of the configuration that the board told. */
enum mr_status day_walk(struct day_walk *walk, struct error *error);

#endif
