/* matrig error --predictor, after its options. */
#ifndef MATRIG_HOST_STUDY_ERROR_PREDICTOR_H
#define MATRIG_HOST_STUDY_ERROR_PREDICTOR_H

#include "host/base/cli.h"

/* Runs the study, draws it into `plot` (NULL: not), prints it. Returns the exit code. */
int error_predictor(const char *plot, const struct cli *cli);

#endif
