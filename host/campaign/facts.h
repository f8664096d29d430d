/* Facts: what a report says of a series besides where the runway buckled, and how a runway of the
 * campaign compares. */
#ifndef MATRIG_HOST_CAMPAIGN_FACTS_H
#define MATRIG_HOST_CAMPAIGN_FACTS_H

#include "host/campaign/keys.h"
#include "host/campaign/play.h"
#include "host/campaign/summary.h"

/* The key `facts` of a campaign whose landings and stations have been read. */
void facts_read(const struct keys *keys, const json_t *root, struct campaign *campaign);

/* The fact's quantity on one runway; NaN where it has none, as its landings were not reached. A
 * landing in which the runway buckled counts for CAMPAIGN_AT_BUCKLING alone. */
double facts_value(const struct campaign *campaign, const struct campaign_fact *fact,
                   const struct campaign_run *run);

/* `values` is room for a number per seed. */
struct campaign_fact_summary facts_summarise(const struct campaign *campaign,
                                             const struct campaign_fact *fact,
                                             const struct campaign_run *runs, double *values);

/* "0.25 to 0.33 in", "at least 3 times", "35 mats or more": the range that agrees. */
void facts_range_text(const struct campaign_fact *fact, char *text, size_t size);
const char *facts_unit(const struct campaign_fact *fact);

#endif
