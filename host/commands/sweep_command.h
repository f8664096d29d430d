/* What matrig sweep is asked for, as its rows (host/commands/sweep_command.c) put it there;
 * host/study/sweep_run.c does it. */
#ifndef MATRIG_HOST_SWEEP_COMMAND_H
#define MATRIG_HOST_SWEEP_COMMAND_H

#include <stdbool.h>

#define SWEEP_FILES_MAX 4000

struct sweep_request {
    const char *words[2 + SWEEP_FILES_MAX]; /* the sweep, result files; NULL at the end */
    const char *cases, *output;
    bool table;
};

#endif
