/* The report page: one self-contained HTML file. */
#ifndef MATRIG_HOST_REPORT_PAGE_H
#define MATRIG_HOST_REPORT_PAGE_H

#include <stdio.h>

#include "host/report/report.h"

/* A page up to and with <body>: style and colours that every page here has. */
void page_head(FILE *out, const char *title);

/* All of it, in memory: the caller frees *text. Fails with a section's error. */
enum mr_status page_write(const struct report *report, char **text, size_t *length,
                          struct error *error);

#endif
