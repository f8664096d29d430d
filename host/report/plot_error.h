/* The picture of an error study: error against run time, log-log, a line of marks for each
 * solver. */
#ifndef MATRIG_HOST_REPORT_PLOT_ERROR_H
#define MATRIG_HOST_REPORT_PLOT_ERROR_H

#include <stdio.h>

#include "host/sim/check/error_study.h"

/* One <svg> for a page: two panels, lift and u (a chain: u and its rms). Brings its own style. */
void plot_error(FILE *out, const char *name, const struct error_study *study);

/* The same as a file of its own. */
void plot_error_file(FILE *out, const char *name, const struct error_study *study);

#endif
