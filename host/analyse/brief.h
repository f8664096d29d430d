/* The short summary that `matrig log` prints when a landing ends. `matrig show DB RUN` prints the
 * full summary. */
#ifndef MATRIG_HOST_ANALYSE_BRIEF_H
#define MATRIG_HOST_ANALYSE_BRIEF_H

#include "host/analyse/summary.h"

/* Prints the short summary as text; with `all`, the full summary. The outcome must be loaded. `db`:
 * path of the campaign. Returns false if `out` cannot be written. */
bool brief_print(const char *db, const struct summary *summary, bool all, bool si, FILE *out);

#endif
