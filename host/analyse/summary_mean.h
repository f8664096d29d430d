/* Means over a landing of what the board tells again and again: the quantities of the catalogue
 * that the campaign keeps. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_MEAN_H
#define MATRIG_HOST_ANALYSE_SUMMARY_MEAN_H

#include "common/quantity.h"
#include "host/base/answer.h"
#include "host/store/store.h"

/* `mean` has MR_QUANTITIES. */
enum mr_status summary_mean_load(struct store *store, int64_t run, struct store_mean *mean,
                                 struct error *error);
void summary_mean_answer(const struct store_mean *mean, struct answer *answer);

#endif
