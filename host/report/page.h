/* The report page: one self-contained HTML file. */
#ifndef MATRIG_HOST_REPORT_PAGE_H
#define MATRIG_HOST_REPORT_PAGE_H

#include <stdio.h>

#include "host/report/plots.h"

/* A page up to and with <body>: style and colours that every page here has. */
void page_head(FILE *out, const char *title);

/* `name` is the campaign's, for the title; `more`: sections of its own that follow the campaign's, as HTML. */
void page_write(FILE *out, const char *name, const struct report_landing *landings, size_t count,
                const struct store_slow *slow, size_t slow_count, const char *more, bool si);

#endif
