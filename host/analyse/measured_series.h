/* The series of a measured landing: from block records where there are any, the rest from CAN messages. Only
 * measured.c. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_SERIES_H
#define MATRIG_HOST_ANALYSE_MEASURED_SERIES_H

#include "host/analyse/measured.h"

/* Fills source, first_block, samples, the raw series and validities, and, with both links, the check of one
 * against the other. Needs landing and channel configuration. */
enum mr_status measured_load_series(struct store *store, struct measured *measured, struct error *error);

#endif
