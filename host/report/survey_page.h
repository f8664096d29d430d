/* Surveys in the report: opening and closing per ten mats, movement and in-plane bow against station. */
#ifndef MATRIG_HOST_REPORT_SURVEY_PAGE_H
#define MATRIG_HOST_REPORT_SURVEY_PAGE_H

#include <stdio.h>

#include "host/store/store.h"

/* A section of the page; nothing when the campaign has no survey. */
enum mr_status survey_page(struct store *store, bool si, FILE *out, struct error *error);

#endif
