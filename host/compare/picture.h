/* A landing's comparison as a picture or as a table of numbers. */
#ifndef MATRIG_HOST_COMPARE_PICTURE_H
#define MATRIG_HOST_COMPARE_PICTURE_H

#include <stdio.h>

#include "host/compare/figures.h"

/* A small plot for each transducer, measured and simulated against time, each with its 95 % band.
 * `alone`: a file of its own, else part of a page. MR_FULL. */
enum mr_status compare_draw(FILE *out, const struct measured *measured,
                            const struct store_simulation_head *head,
                            const struct store_simulation *rows, size_t count, bool alone, bool si,
                            struct error *error);
/* CSV, a row a millisecond: t_s, then of each transducer measured, its error, simulated, its error,
 * alignment's part; units in the head. */
enum mr_status compare_csv(FILE *out, const struct measured *measured,
                           const struct store_simulation_head *head,
                           const struct store_simulation *rows, size_t count, bool si,
                           struct error *error);

#endif
