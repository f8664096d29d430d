/* The picture of a predictor study: error of u against cycles on the board, log-log; a shape for
 * each variant, a colour and a line for each landing. */
#ifndef MATRIG_HOST_REPORT_PLOT_PREDICTOR_H
#define MATRIG_HOST_REPORT_PLOT_PREDICTOR_H

#include <stdio.h>

#include "host/sim/check/predictor_study.h"

/* An <svg> file of its own: two panels, the predictor's own runway and another one. */
void plot_predictor_file(FILE *out, const struct predictor_study *study);

#endif
