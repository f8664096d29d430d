/* A landing's CAN frames as a candump -L log. */
#ifndef MATRIG_HOST_EXPORT_CANDUMP_H
#define MATRIG_HOST_EXPORT_CANDUMP_H

#include <stdio.h>

#include "host/cli.h"
#include "host/store/store.h"

/* `*rows`: frames written. MR_USAGE: the landing was logged without a CAN link. */
enum mr_status export_candump(struct store *store, int64_t run, FILE *out, const struct cli *cli, long *rows, struct error *error);

#endif
