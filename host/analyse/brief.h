/* The lines of a landing that matter when it ends: what `matrig log` prints. `matrig show DB RUN`
 * has all of its summary. */
#ifndef MATRIG_HOST_ANALYSE_BRIEF_H
#define MATRIG_HOST_ANALYSE_BRIEF_H

#include "host/analyse/summary.h"

/* Text, for people; with `all` the whole summary. A landing whose outcome cannot be read has none
 * here. False: `out` cannot be written. */
bool brief_print(struct store *store, const struct summary *summary, bool all, bool si, FILE *out);

#endif
