/* The part of a landing's summary that is about its links: frames received, lost and doubted,
 * troubles, gaps, CAN against serial. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_LINKS_H
#define MATRIG_HOST_ANALYSE_SUMMARY_LINKS_H

#include "host/analyse/summary.h"

enum mr_status summary_links_load(struct store *store, struct summary *summary,
                                  struct error *error);
/* Adds up what the gaps say: lost, dropped, silent. */
void summary_count_gaps(const struct store_gap *gaps, size_t count,
                        struct summary_link link[LINK_KINDS]);
void summary_links_answer(const struct summary *summary, struct answer *answer);

#endif
