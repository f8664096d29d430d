/* A sweep's indices of sensitivity (sweep_indices.h), for its page and for programs: for each
 * quantity and each combination of the keys in `vary`. */
#ifndef MATRIG_HOST_SWEEP_INFLUENCES_H
#define MATRIG_HOST_SWEEP_INFLUENCES_H

#include "host/sweep/sweep_plot.h"

/* Tables of one quantity. */
void sweep_influences_write(FILE *out, const struct sweep_table *table,
                            const struct sweep_quantity *quantity);

/* All of them: {QUANTITY: [{"at": {KEY: VALUE}, "points":, "keys": {KEY: {"first": [value, low,
 * high], "total": [..]}}}]}. A new object. */
json_t *sweep_influences_json(const struct sweep_table *table);

#endif
