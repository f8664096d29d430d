/* Warnings shown before the board is armed: results of earlier commands that the operator may have
 * overlooked. */
#ifndef MATRIG_HOST_ADVISE_ARMING_H
#define MATRIG_HOST_ADVISE_ARMING_H

#include "host/store/store.h"

#define ARMING_TEXT_SIZE 900
/* Writes one line per warning. Reasons for a warning: advice against this landing; a survey that is
 * unfinished or not loaded into the board; a NO-GO of matrig ready, or a check older than the last
 * landing or the last loading of a survey. A command that the campaign never used causes no
 * warning. Writes "" if there is no warning or the campaign cannot be read. */
void arming_write_warnings(struct store *store, int64_t now_us, char out[ARMING_TEXT_SIZE]);

#endif
