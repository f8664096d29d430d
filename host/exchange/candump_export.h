/* A landing's CAN frames as a candump -L log, stamped with the time of day at which the board sent
 * what they tell, by the time map of the landing (host/link/timemap.h); without a good one, with
 * board time after a date in 2001, and that is told. */
#ifndef MATRIG_HOST_EXCHANGE_CANDUMP_EXPORT_H
#define MATRIG_HOST_EXCHANGE_CANDUMP_EXPORT_H

#include <stdio.h>

#include "host/base/cli.h"
#include "host/store/store.h"

/* `*rows`: frames written. MR_USAGE: the landing was logged without a CAN link. */
enum mr_status export_candump(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                              long *rows, struct error *error);

#endif
