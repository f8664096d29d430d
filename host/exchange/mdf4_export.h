/* A landing as an MDF4 file: readings at 1 kHz, the gear, and the CAN frames with the DBC
 * attached. */
#ifndef MATRIG_HOST_EXCHANGE_MDF4_EXPORT_H
#define MATRIG_HOST_EXCHANGE_MDF4_EXPORT_H

#include <stdio.h>

#include "host/store/store.h"

/* Second 0 of the file is the first block that was kept, or the first CAN frame when that is
 * earlier. `rows`: readings and frames together. MR_USAGE: neither readings nor frames. */
enum mr_status export_mdf4(struct store *store, int64_t run, FILE *out, bool si, long *rows,
                           struct error *error);

#endif
