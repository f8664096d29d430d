/* A landing of the campaign from another instrument's samples. */
#ifndef MATRIG_HOST_EXCHANGE_LANDING_IMPORT_H
#define MATRIG_HOST_EXCHANGE_LANDING_IMPORT_H

#include "host/exchange/import.h"
#include "host/exchange/mapping.h"

/* The series of the mapping as one landing of a session of its own, in the transaction that is
 * open. By 1 ms blocks: faster samples as their mean over a block, slower ones by straight lines
 * between them; a gap stays one. With request->like the gear, switches, survey and configuration
 * are that landing's, and time is its time. MR_MALFORMED: nothing to put in a landing, or more than
 * an hour; MR_USAGE. */
enum mr_status import_landing(struct store *store, struct mapping *mapping,
                              const struct import_request *request, struct import_result *result,
                              struct error *error);

/* One channel by blocks, its time in us of the board: reading[i] is that of block first + i; NaN:
 * missing. `usual_us`: between samples. Pure, for tests. */
void import_resample(const struct series *series, double base_us, double usual_us, double gap_us,
                     int64_t first, size_t blocks, float *reading);

#endif
