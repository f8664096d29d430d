/* What matrig study is asked for, as its rows (host/commands/study_command.c) put it there;
 * host/study/study_run.c does it. */
#ifndef MATRIG_HOST_STUDY_COMMAND_H
#define MATRIG_HOST_STUDY_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

#define STUDY_JOBS_MAX 256

struct study_request {
    const char *path, *plot;
    const char *ground; /* NULL: as the file says */
    int64_t jobs, seeds; /* 0: one per core; the file's */
};

#endif
