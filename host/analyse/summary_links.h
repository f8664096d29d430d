/* The part of a landing's summary that is about its links: frames received, lost and doubted, troubles, gaps, CAN against serial. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_LINKS_H
#define MATRIG_HOST_ANALYSE_SUMMARY_LINKS_H

#include "host/analyse/summary.h"

enum mr_status summary_links_load(struct store *store, struct summary *summary, struct error *error);
/* What makes the landing's numbers doubtful, and strangers that did not. */
void summary_doubts_print(const struct summary *summary, FILE *out);
void summary_links_print(const struct summary *summary, FILE *out);
void summary_links_json(const struct summary *summary, json_t *object);

#endif
