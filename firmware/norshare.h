/* Who has the memory: the black box, and when it has nothing to do, the predictor's runway, one
 * operation at a time.
 *
 * An operation of the runway that is under way when a landing begins is over after a page's time (3
 * ms at most); an erase, which is begun only while nothing is armed, after 400 ms: the box is told
 * of it and keeps as much of its ring free as for one of its own. */
#ifndef MATRIG_FIRMWARE_NORSHARE_H
#define MATRIG_FIRMWARE_NORSHARE_H

#include "firmware/blackbox.h"
#include "firmware/runwaystore.h"

struct norshare {
    struct blackbox *box;
    struct runwaystore *store;
    struct predict *predict;
    const float *slack_in; /* the survey, MR_SEGMENTS */
};

/* `quiet`: neither armed nor in a landing. */
void norshare_poll(struct norshare *share, uint32_t now_ms, bool quiet);

#endif
