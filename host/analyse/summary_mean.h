/* Means over a landing of what the board tells again and again: the quantities of the catalogue that the campaign keeps. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_MEAN_H
#define MATRIG_HOST_ANALYSE_SUMMARY_MEAN_H

#include <jansson.h>
#include <stdio.h>

#include "common/quantity.h"
#include "host/store/store.h"

#define SUMMARY_MEAN_TEXT 60

/* `mean` has MR_QUANTITIES. */
enum mr_status summary_mean_load(struct store *store, int64_t run, struct store_mean *mean, struct error *error);
void summary_mean_print(const struct store_mean *mean, FILE *out);
void summary_mean_json(const struct store_mean *mean, json_t *object);
/* "20.00 ± 0.29 °C", or `plain` "20.00 +- 0.29 C"; of a quantity without an error "3.301 V". */
void summary_mean_text(unsigned quantity, const struct store_mean *mean, bool plain, char out[SUMMARY_MEAN_TEXT]);

#endif
