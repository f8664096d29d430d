/* The commands that matrig-study runs: what each is asked for, as its rows (host/commands/) put it
 * there, and its run (host/study/). matrig has the rows alone and links none of their libraries. */
#ifndef MATRIG_HOST_COMMANDS_STUDIES_H
#define MATRIG_HOST_COMMANDS_STUDIES_H

#include <stdbool.h>
#include <stdint.h>

#include "host/base/cli.h"

#define FIT_RUNS_MAX    20
#define FIT_LEAST_DRAWS 60
#define SWEEP_FILES_MAX 4000

struct study_request {
    const char *path, *plot;
    const char *ground; /* NULL: as the file says */
    int64_t seeds;      /* 0: the file's */
};

struct error_request {
    const char *plot;
};

struct fit_request {
    const char *words[1 + FIT_RUNS_MAX];
    const char *scene, *fitted, *prior, *plot, *out_scene;
    bool force;
    int64_t draws, seed;
    char model_runway[500];
};

struct sweep_request {
    const char *words[2 + SWEEP_FILES_MAX]; /* the sweep, result files; NULL at the end */
    const char *cases, *output;
    bool table;
};

int study_command(int argc, char **argv, const struct cli *cli);
int error_command(int argc, char **argv, const struct cli *cli);
int fit_command(int argc, char **argv, const struct cli *cli);
int sweep_command(int argc, char **argv, const struct cli *cli);

/* Before all other words: the version and the path of the matrig that starts matrig-study. */
#define STUDY_STARTED_BY "--started-by"

/* A command's run (host/base/command.h) in matrig: matrig-study takes its place in this process,
 * with the same words, standard streams, signals and exit code. Returns only when that fails:
 * printed, and the exit code. */
int study_start(int argc, char **argv, const struct cli *cli);

#endif
