/* The error report: several scenes' error studies on one page. */
#ifndef MATRIG_TESTS_ERROR_REPORT_REPORT_H
#define MATRIG_TESTS_ERROR_REPORT_REPORT_H

#include <stdio.h>

#include "host/sim/check/error_study.h"

/* What the figures of a study say, as one <p>: every number and every verdict in it is taken from
 * the study. */
void write_conclusion(FILE *out, const struct error_study *study);

/* The engines of campaigns on the first landing of a series, as a section. */
enum mr_status write_engines(FILE *out, const char *series, struct error *error);

/* The onboard predictor beside the chain's solver, as a section. */
enum mr_status write_predictor(FILE *out, struct error *error);

/* Runs, slopes and cheapest solvers as tables. */
void write_tables(FILE *out, const struct error_study *study);

#endif
