/* What matrig fit is asked for, as its rows (host/commands/fit_command.c) put it there;
 * host/study/fit_run.c does it. */
#ifndef MATRIG_HOST_FIT_COMMAND_H
#define MATRIG_HOST_FIT_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

#include "host/study/fit/fit.h"

#define FIT_RUNS_MAX 20

struct fit_request {
    const char *words[1 + FIT_RUNS_MAX];
    const char *scene, *fitted, *prior, *plot, *out_scene;
    bool force;
    struct fit_options options;
    int64_t draws, seed, threads; /* threads 0: as many as processors */
    char model_runway[500];
};

#endif
