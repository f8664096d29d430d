/* A landing's comparison with its simulation, in the report. */
#ifndef MATRIG_HOST_REPORT_COMPARE_PAGE_H
#define MATRIG_HOST_REPORT_COMPARE_PAGE_H

#include <stdio.h>

#include "host/report/plots.h"

/* Table, zones and picture of the newest comparison that the campaign keeps, from what is measured now (a calibration may have changed
 * since). Nothing where there is none. */
void compare_page(FILE *out, const struct report_landing *landing, bool si);

#endif
