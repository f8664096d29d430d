/* Listening to a CAN bus for a while: what comes goes to a busscan. Nothing is sent. */
#ifndef MATRIG_HOST_BUSLISTEN_H
#define MATRIG_HOST_BUSLISTEN_H

#include "host/board/busscan.h"

/* Listens for `for_s`, in the log's own time to one that was recorded; ends earlier at the end of a
 * file. `*heard_s`: how long it was. A log that is cut off or no log is an error, and so is a
 * device that stays away. */
enum mr_status buslisten(struct link *link, double for_s, struct busscan *scan, double *heard_s,
                         struct error *error);
/* When not a frame came. MR_OK: the bus was silent; else `error` says why nothing could be heard:
 * errors on the bus alone, or no device. */
enum mr_status buslisten_silent(const struct link *link, struct error *error);

#endif
