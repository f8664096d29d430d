/* Export of a landing, and of the message catalogue, for other programs. `*rows` is set to the
 * number of frames or readings written. */
#ifndef MATRIG_HOST_EXCHANGE_EXPORT_H
#define MATRIG_HOST_EXCHANGE_EXPORT_H

#include <stdio.h>

#include "host/base/cli.h"
#include "host/store/store.h"

/* Writes a landing's CAN frames as a candump -L log. The time stamps are the times of day at which
 * the board took the data, from the landing's time map (host/link/timemap.h). Without a usable time
 * map they are board times after a date in 2001, and a note is printed. MR_USAGE: the landing was
 * logged without a CAN link. */
enum mr_status export_candump(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                              long *rows, struct error *error);
/* Writes an MDF4 file: readings at 1 kHz, the gear, and the CAN frames with the DBC attached;
 * remote and error frames are in separate tables. Second 0 is the first stored block, or the first
 * CAN frame if it is earlier. Without a usable time map the file has no date, and a note is
 * printed. MR_USAGE: there are neither readings nor frames. */
enum mr_status export_mdf4(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                           long *rows, struct error *error);
/* Writes the message catalogue as a Vector DBC file for a board with this base on its bus
 * (common/canbase.h). The caller checks the stream for errors. Returns the number of messages. */
unsigned dbc_write(FILE *out, uint16_t base);

#endif
