/* The page of a report: a self-contained HTML file. */
#ifndef MATRIG_HOST_REPORT_PAGE_H
#define MATRIG_HOST_REPORT_PAGE_H

#include <stdio.h>

#include "host/report/report.h"

/* A page up to and with <body>: style and colours that every page here has. */
void page_head(FILE *out, const char *title);

/* All of a report that report_begin has begun, in memory: the caller frees *text. Reads one landing
 * after the other. Fails with a section's error. */
enum mr_status page_write(struct report *report, char **text, size_t *length, struct error *error);

#endif
