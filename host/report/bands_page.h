/* Bands of a landing in the report: figures, findings, shunt calibrations. */
#ifndef MATRIG_HOST_REPORT_BANDS_PAGE_H
#define MATRIG_HOST_REPORT_BANDS_PAGE_H

#include "host/analyse/bands.h"

/* Nothing where the board told nothing. */
void bands_page(const struct bands_summary *bands, const struct measured *measured, bool si, FILE *out);

#endif
