/* Commands that run in the separate program matrig-study: for each command, the struct of its
 * option values and the function that runs it (host/study/). matrig only parses the options and
 * does not link the libraries of the studies. */
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
    const char *ground; /* ground of the study; NULL: that in the file */
    int64_t seeds;      /* number of seeds; 0: that in the file */
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
    /* the sweep file and the result files; NULL ends the list */
    const char *words[2 + SWEEP_FILES_MAX];
    const char *cases, *output;
    bool table;
};

int study_command(int argc, char **argv, const struct cli *cli);
int error_command(int argc, char **argv, const struct cli *cli);
int fit_command(int argc, char **argv, const struct cli *cli);
int sweep_command(int argc, char **argv, const struct cli *cli);

/* First argument of matrig-study. The next two are the version and the path of the matrig that
 * starts it. */
#define STUDY_STARTED_BY "--started-by"

/* Runs a command of matrig-study from matrig. matrig-study replaces matrig in the same process,
 * with the same arguments, standard streams, signals and exit code. Returns only if that fails:
 * prints the error and returns the exit code. */
int study_exec(int argc, char **argv, const struct cli *cli);

#endif
