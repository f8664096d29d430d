/* The page that `matrig report` makes, for others that pass it on. */
#ifndef MATRIG_HOST_REPORT_COMMAND_H
#define MATRIG_HOST_REPORT_COMMAND_H

#include <stdio.h>

#include "host/store/store.h"

/* Of every landing of the campaign, also of voided ones; `name` is the title's. */
enum mr_status report_page(struct store *store, const char *name, bool si, FILE *out, struct error *error);

#endif
