/* The commands that matrig-study runs: the request of each command, as filled from its rows
 * (host/commands/), and the function that runs it (host/study/). matrig has only the rows and links
 * none of the libraries. */
#ifndef MATRIG_HOST_COMMANDS_STUDIES_H
#define MATRIG_HOST_COMMANDS_STUDIES_H

#include <stdbool.h>
#include <stdint.h>

#include "host/base/cli.h"

#define FIT_RUNS_MAX    20
#define FIT_DRAWS_MIN   60
#define SWEEP_FILES_MAX 4000

struct study_request {
    const char *path, *plot;
    const char *ground; /* NULL: as in the file */
    int64_t seeds;      /* 0: as in the file */
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
    const char *words[2 + SWEEP_FILES_MAX]; /* the sweep and result files; NULL at the end */
    const char *cases, *output;
    bool table;
};

int study_command(int argc, char **argv, const struct cli *cli);
int error_command(int argc, char **argv, const struct cli *cli);
int fit_command(int argc, char **argv, const struct cli *cli);
int sweep_command(int argc, char **argv, const struct cli *cli);

/* First argument of matrig-study: followed by the version and the path of the matrig that starts
 * it. */
#define STUDY_STARTED_BY "--started-by"

/* Runs a command (host/base/command.h) from matrig: matrig-study replaces matrig in this process,
 * with the same arguments, standard streams, signals and exit code. Returns only if that fails:
 * prints the error and returns the exit code. */
int study_exec(int argc, char **argv, const struct cli *cli);

#endif
