/* Starting matrig-study, the program that has the studies: fit, sweep, campaign, error, and sim
 * with --solver cvode. They are what needs GSL and SUNDIALS, which matrig is not linked with. */
#ifndef MATRIG_HOST_COMMANDS_STUDY_START_H
#define MATRIG_HOST_COMMANDS_STUDY_START_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/cli.h"

/* Before all other words: the version and the path of the matrig that starts it. */
#define STUDY_STARTED_BY "--started-by"

/* A command's run (host/base/command.h). matrig-study takes matrig's place in this process, with
 * the same words, standard streams, signals and exit code: from there on it is as if matrig had the
 * command itself. Returns only when that fails: told, and the exit code. */
int study_start(int argc, char **argv, const struct cli *cli);

/* Where matrig-study is: beside the matrig of this path, else in ../libexec/matrig from there, else
 * in the first folder of `search` that has it (as PATH; empty ones are left out; NULL: none).
 * False: nowhere. */
bool study_find(const char *matrig, const char *search, char *path, size_t size);

#endif
