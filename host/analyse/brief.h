/* The short summary that `matrig log` prints when a landing ends. `matrig show DB RUN` prints the
 * full summary. */
#ifndef MATRIG_HOST_ANALYSE_BRIEF_H
#define MATRIG_HOST_ANALYSE_BRIEF_H

#include "host/analyse/summary.h"

/* Prints the short summary as text; with `all`, the full summary. Prints nothing if the outcome of
 * the landing cannot be read. Returns false if `out` cannot be written. */
bool brief_print(struct store *store, const struct summary *summary, bool all, bool si, FILE *out);

/* Writes the outcome of the landing, with its lead time and evidence; "" if it cannot be read. */
#define BRIEF_OUTCOME_SIZE 600
const char *brief_format_outcome(struct store *store, const struct summary *summary,
                                 char out[BRIEF_OUTCOME_SIZE]);
/* Adds this text for people. */
void brief_add_outcome(struct store *store, const struct summary *summary, struct answer *answer);

#endif
