/* Page: an ensemble as one HTML page, or its picture as an SVG file. */
#ifndef MATRIG_HOST_CAMPAIGN_PAGE_H
#define MATRIG_HOST_CAMPAIGN_PAGE_H

#include <stdio.h>

#include "host/campaign/summary.h"

/* Movement along the runway after each landing (median, 5 to 95 %), and where and when runways
 * buckled. */
void campaign_picture(FILE *out, const struct campaign *campaign, const struct campaign_run *runs,
                      const struct campaign_summary *summary, bool alone);
void campaign_page(FILE *out, const struct campaign *campaign, const struct campaign_run *runs,
                   const struct campaign_summary *summary);

#endif
