/* One landing, and the message catalogue, for other tools. `*rows`: frames or readings written. */
#ifndef MATRIG_HOST_EXCHANGE_EXPORT_H
#define MATRIG_HOST_EXCHANGE_EXPORT_H

#include <stdio.h>

#include "host/base/cli.h"
#include "host/store/store.h"

/* A landing's CAN frames as a candump -L log, stamped with the time of day at which the board sent
 * what they tell, by the time map of the landing (host/link/timemap.h); without a good one, with
 * board time after a date in 2001, and that is told. MR_USAGE: logged without a CAN link. */
enum mr_status export_candump(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                              long *rows, struct error *error);
/* As an MDF4 file: readings at 1 kHz, the gear, and the CAN frames with the DBC attached, remote
 * and error frames in tables of their own. Second 0 is the first block that was kept, or the first
 * CAN frame when that is earlier; without a good time map it has no date, and that is told.
 * MR_USAGE: neither readings nor frames. */
enum mr_status export_mdf4(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                           long *rows, struct error *error);
/* The message catalogue as a Vector DBC file, of a board with this base on its bus
 * (common/canbase.h); the caller checks the stream. Returns the number of messages. */
unsigned dbc_write(FILE *out, uint16_t base);

#endif
