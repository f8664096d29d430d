/* Reasons against arming now: findings from before the landing that may be forgotten when the board
 * is armed. */
#ifndef MATRIG_HOST_ADVISE_ARMING_H
#define MATRIG_HOST_ADVISE_ARMING_H

#include "host/store/store.h"

#define ARMING_TEXT 900
/* Lines: advice against this landing, a survey that goes on or that the board does not have, a
 * check by matrig ready that was no-go or predates the last landing or the survey's loading. What
 * was never done in the campaign is not missed. "": nothing, or it cannot be read. */
void arming_doubts(struct store *store, int64_t now_us, char out[ARMING_TEXT]);

#endif
