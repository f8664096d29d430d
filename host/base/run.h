/* RUN on the command line: the number of a landing in its database. */
#ifndef MATRIG_HOST_BASE_RUN_H
#define MATRIG_HOST_BASE_RUN_H

#include <stdint.h>

#include "host/base/error.h"

/* A whole number from 1; else MR_USAGE. */
enum mr_status run_parse(const char *text, int64_t *run, struct error *error);

#endif
