/* The slow log on the host: rows of a board into the campaign database or a CSV file. */
#ifndef MATRIG_HOST_SLOW_H
#define MATRIG_HOST_SLOW_H

#include "common/slowrow.h"
#include "host/base/cli.h"
#include "host/store/store.h"

struct box_client;

/* A row as the database keeps it. `time_us` STORE_NONE: not known when it was made. */
void slow_row(const struct mr_slowrow *row, const char *board_uid, int64_t time_us,
              struct store_slow *out);
/* `matrig board slow`: what is missing in `db`, or all rows, to `csv`; either may be NULL. Returns
 * the exit code. */
int slow_fetch(const struct cli *cli, struct box_client *talk, const char *db, const char *csv,
               struct error *error);

#endif
