/* Pages: self-contained HTML files, and the page of a report. */
#ifndef MATRIG_HOST_REPORT_PAGE_H
#define MATRIG_HOST_REPORT_PAGE_H

#include "host/report/report.h"

/* A page up to and with <body>: style and colours that every page here has. */
void page_head(FILE *out, const char *title);
/* Its end; `plots`: with the script that draws them (chart.h). */
void page_foot(FILE *out, bool plots);

/* All of a report that report_begin has begun. Reads one landing after the other; nothing is
 * written when one cannot be read. Fails with a section's error. */
enum mr_status page_write(struct report *report, FILE *out, struct error *error);

#endif
