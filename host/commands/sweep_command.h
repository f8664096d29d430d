/* What matrig sweep is asked for, as its rows (host/commands/sweep_command.c) put it there;
 * host/study/sweep_run.c does it. */
#ifndef MATRIG_HOST_SWEEP_COMMAND_H
#define MATRIG_HOST_SWEEP_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

#include "host/sweep/sweep_share.h"

#define SWEEP_PARTS_MAX 1000

struct sweep_request {
    const char *study, *with, *output, *shard_text;
    const char *words[2 + SWEEP_PARTS_MAX]; /* NULL at the end */
    size_t parts;
    char results[SWEEP_PATH_MAX];
    struct sweep_shard shard;
    int64_t jobs, shards; /* while the command line is read 0: not given */
    double timeout_s;     /* 0: the study's */
    bool list, gather, retry, slurm, parallel, no_wait, force;
};

#endif
