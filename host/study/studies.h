/* The commands that matrig-study has: their runs (host/base/command.h). Their options stand in
 * host/commands/, for both programs. */
#ifndef MATRIG_HOST_STUDY_STUDIES_H
#define MATRIG_HOST_STUDY_STUDIES_H

#include "host/base/cli.h"

int study_command(int argc, char **argv, const struct cli *cli);
int error_command(int argc, char **argv, const struct cli *cli);
int fit_command(int argc, char **argv, const struct cli *cli);
int sweep_command(int argc, char **argv, const struct cli *cli);

#endif
