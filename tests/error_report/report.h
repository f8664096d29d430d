/* Error against run time of what `matrig error` does not study, as Markdown and a plot each. */
#ifndef MATRIG_TESTS_ERROR_REPORT_REPORT_H
#define MATRIG_TESTS_ERROR_REPORT_REPORT_H

#include "host/base/error.h"

/* The two landing engines of series on the first landing of a series; FOLDER/engines.svg. */
enum mr_status write_engines(const char *folder, const char *series, struct error *error);
/* The onboard predictor beside the chain's solver; FOLDER/predictor.svg. */
enum mr_status write_predictor(const char *folder, struct error *error);

#endif
