/* What people said of the landings, in the report: series, notes, corrections, voided landings, waves and breaks. */
#ifndef MATRIG_HOST_REPORT_JOURNAL_PAGE_H
#define MATRIG_HOST_REPORT_JOURNAL_PAGE_H

#include <stdio.h>

#include "host/store/store.h"

/* A section of the page; nothing when nobody said anything. */
enum mr_status journal_page(struct store *store, bool si, FILE *out, struct error *error);

#endif
