/* A sweep's results as a page: what is done, plots, tables, failures with their reasons. */
#ifndef MATRIG_HOST_SWEEP_PAGE_H
#define MATRIG_HOST_SWEEP_PAGE_H

#include <stdio.h>

#include "host/sweep/sweep_table.h"

/* One self-contained HTML file. `name` is the results file's, for the title. */
void sweep_page_write(FILE *out, const char *name, const struct sweep_table *table);

/* The same for a program: rows in the study's order, without their run times. A new object. */
json_t *sweep_table_json(const struct sweep_table *table);

#endif
