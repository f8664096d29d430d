/* Warnings before the board is armed: earlier results that the operator may have overlooked. */
#ifndef MATRIG_HOST_ADVISE_ARMING_H
#define MATRIG_HOST_ADVISE_ARMING_H

#include "host/store/store.h"

#define ARMING_TEXT_SIZE 900
/* Writes one line per warning: advice against this landing; a survey that is unfinished, or not
 * loaded into the board; a check by matrig ready that was no-go, or predates the last landing or
 * the loading of the survey. Steps that the campaign never used are not reported. "": no warning,
 * or the campaign cannot be read. */
void arming_write_warnings(struct store *store, int64_t now_us, char out[ARMING_TEXT_SIZE]);

#endif
