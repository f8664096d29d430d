/* Facts: what a report says of a series besides where the runway buckled, and how a runway of the
 * series compares. */
#ifndef MATRIG_HOST_LANDING_SERIES_FACTS_H
#define MATRIG_HOST_LANDING_SERIES_FACTS_H

#include "host/landing_series/keys.h"
#include "host/landing_series/play.h"
#include "host/landing_series/summary.h"

/* The key `facts` of a series whose landings and stations have been read. */
void facts_read(const struct keys *keys, const json_t *root, struct landing_series *series);

/* The fact's quantity on one runway; NaN where it has none, as its landings were not reached. A
 * landing in which the runway buckled counts for SERIES_AT_BUCKLING alone. */
double facts_value(const struct landing_series *series, const struct series_fact *fact,
                   const struct series_run *run);

/* `values` is room for a number per seed. */
struct series_fact_summary facts_summarise(const struct landing_series *series,
                                           const struct series_fact *fact,
                                           const struct series_run *runs, double *values);

/* "0.25 to 0.33 in", "at least 3 times", "35 mats or more": the range that agrees. */
void facts_range_text(const struct series_fact *fact, char *text, size_t size);
const char *facts_unit(const struct series_fact *fact);

#endif
