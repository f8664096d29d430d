/* Options of the commands that matrig-study runs. host/study/NAME_run.c contains each command. */
#include "host/commands/studies.h"
#include "host/base/xmalloc.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/version.h"
#include "host/base/command.h"
#include "host/base/data_dir.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/landing_series/series.h"

#define STUDY_PROGRAM "matrig-study"

static bool find_executable(char *path, size_t size, const char *folder, size_t length,
                            const char *below)
{
    struct stat file;
    int need = snprintf(path, size, "%.*s%s" STUDY_PROGRAM, (int)length, folder, below);
    return need > 0 && (size_t)need < size && stat(path, &file) == 0 && S_ISREG(file.st_mode) &&
           access(path, X_OK) == 0;
}

/* Finds matrig-study: in the folder of the program with the path `matrig`, in ../libexec/matrig
 * relative to that folder, or in the folders listed in `search`, which has the form of PATH (empty
 * entries are skipped; NULL: no list). Returns false if it is not found. */
static bool study_find_program(const char *matrig, const char *search, char *path, size_t size)
{
    const char *slash = strrchr(matrig, '/');
    size_t length = slash ? (size_t)(slash - matrig) : 0;
    if (slash && (find_executable(path, size, matrig, length, "/") ||
                  find_executable(path, size, matrig, length, "/../libexec/matrig/")))
        return true;
    while (search && *search) {
        length = strcspn(search, ":");
        if (length > 0 && find_executable(path, size, search, length, "/"))
            return true;
        search += length + (search[length] == ':');
    }
    return false;
}

static int print_start_error(const char *command, const char *why)
{
    struct error error = {0};
    error_set(&error, MR_IO,
              "cannot start " STUDY_PROGRAM
              ", which runs matrig %s: %s; build it with make all, or install "
              "it with make install or the package matrig-study",
              command, why);
    return cli_fail(&error);
}

int study_exec(int argc, char **argv, const struct cli *cli)
{
    char matrig[PATH_MAX], path[PATH_MAX], why[PATH_MAX + 100];
    char **words = xcalloc(4 + command_matrig.part_count + (size_t)argc + 1, sizeof *words);
    size_t count = 0;
    data_dir_program_path(matrig, sizeof matrig);
    if (!study_find_program(matrig, getenv("PATH"), path, sizeof path)) {
        free(words);
        snprintf(why, sizeof why,
                 "not found next to %s, in ../libexec/matrig relative to that folder, or on PATH",
                 matrig);
        return print_start_error(argv[0], why);
    }
    words[count++] = STUDY_PROGRAM;
    words[count++] = STUDY_STARTED_BY;
    words[count++] = (char *)VERSION_TEXT;
    words[count++] = matrig;
    count += program_global_options((const char **)words + count, cli);
    memcpy(words + count, argv, (size_t)argc * sizeof *argv);
    fflush(NULL);
    execv(path, words);
    snprintf(why, sizeof why, "%s (%s)", path, strerror(errno));
    free(words);
    return print_start_error(argv[0], why);
}

/* ---- error ---- */

#define OPTION_VALUES struct error_request
static const struct command_part error_parts[] = {
    HELP_ITEM("SCENE", "scene file, JSON"),
    OPTION_TEXT("--plot", "F", plot,
                "plot error against run time (.svg, .png, .pdf). Errors are in ft, even with --si"),
    HELP_NOTE("Every solver of the scene's model runs at several tolerances or steps. The "
              "reference is a solution on which two different methods agree. If no two methods "
              "agree, there is no table (exit 5)."),
    HELP_EXAMPLE("matrig error host/scenes/consistent_fig3_7.json --plot error.svg"),
};

const struct command command_error = {
    "error",
    study_exec,
    "SCENE [--plot F]",
    "compare the error and the run time of every solver on a scene",
    COMMAND_PARTS(error_parts),
    {1, 1, "SCENE"},
};
#undef OPTION_VALUES

/* ---- study ---- */

#define OPTION_VALUES struct study_request
static const struct command_part study_parts[] = {
    HELP_ITEM(
        "FILE",
        "study file, JSON (host/landing_series/README.md): runway, landings, modifications, seeds"),
    OPTION_INTEGER(
        "--seeds", "N", seeds, 1.0, SERIES_SEEDS_MAX, 0.0,
        "number of seeds, starting with the first seed of the file; default: number in the file"),
    OPTION_CHOICE("--ground", "G", ground, "ground", "weightless|elastic",
                  "weightless: the gear exerts thrust only. elastic: axle lines have weight, and "
                  "the ground deflects (key elastic); default: as in the file"),
    OPTION_TEXT("--plot", "F", plot,
                "plot movement and buckles along the runway (.svg, .png, .pdf)"),
    HELP_NOTE("Results are distributions over the seeds: median and 5th to 95th percentile."),
    HELP_EXAMPLE(
        "matrig study host/landing_series/series/friction.json --ground elastic --seeds 4"),
    HELP_EXAMPLE("matrig study host/landing_series/series/standard.json --plot standard.svg"),
};

const struct command command_study = {
    "study",
    study_exec,
    "FILE [--seeds N] [--ground weightless|elastic] [--plot F]",
    "simulate a series of landings on an ensemble of runways, to find when each runway buckles",
    COMMAND_PARTS(study_parts),
    {1, 1, "FILE"},
};
#undef OPTION_VALUES

/* ---- sweep ---- */

#define OPTION_VALUES struct sweep_request
static const struct command_part sweep_parts[] = {
    HELP_ITEM("FILE",
              "sweep file, JSON (host/sweep/README.md): base scene or study file, inputs to vary, "
              "outputs. Without an option, the cases are listed, each as a line of JSON"),
    OPTION_TEXT("--cases", "N..M", cases,
                "run cases N to M in turn; N..: case N to the last; N: only case N. Each result is "
                "a line of JSON. For parallel runs see docs/howto/sweep-on-a-cluster.md"),
    OPTION_FLAG("--table", table,
                "summarize the result files R.jsonl...: counts, reasons for failures, sensitivity "
                "indices, all cases. Exit 1 when cases are missing"),
    OPTION_TEXT("-o", "F", output,
                "output file: with --cases the results, with --table the cases as CSV"),
    HELP_NOTE("A failed case also has a result line, which gives the reason."),
    HELP_EXAMPLE("matrig sweep host/sweep/examples/threshold.json --cases 1..35 -o r.jsonl\n"
                 "matrig sweep host/sweep/examples/threshold.json --table r.jsonl -o table.csv"),
};

const struct command command_sweep = {
    "sweep",
    study_exec,
    "FILE\nFILE --cases N..M [-o R.jsonl]\nFILE --table R.jsonl... [-o T.csv]",
    "run many cases of a scene or study: grid, Latin hypercube, threshold search, sensitivity "
    "indices",
    COMMAND_PARTS(sweep_parts),
    {1, 1 + SWEEP_FILES_MAX, "FILE"},
};
#undef OPTION_VALUES

/* ---- fit ---- */

#define OPTION_VALUES struct fit_request
static const struct command_part fit_parts[] = {
    HELP_ITEM("DB [RUN...]", "campaign database and landings; default: all landings with known "
                             "motion. Exit 1 when the model does not fit the data"),
    OPTION_TEXT(
        "--scene", "S", scene,
        "scene file with the runway (model chain) and the prior values; default: the model runway"),
    OPTION_TEXT("--fit", "NAMES", fitted,
                "parameters to fit, from gap,grit,f,share,KL; the others stay fixed; default: all"),
    OPTION_TEXT("--prior", "NAME=V:E,...", prior,
                "prior value and standard error (lb, in, lb/ft); default: values of the scene, "
                "with errors of 50 % for grit, KL and an unsurveyed gap, 3 % for a surveyed gap, "
                "and 20 % for f; share: 1/12, error 15 %"),
    OPTION_INTEGER("--draws", "N", draws, FIT_DRAWS_MIN, 1e5, 300.0,
                   "simulated data sets per round, at least {low}; default: {standard}"),
    OPTION_INTEGER("--seed", "N", seed, 0.0, 1e9, 1.0,
                   "seed of all random draws; default: {standard}"),
    OPTION_TEXT("--plot", "F", plot, "plot the residuals (.svg, .png, .pdf)"),
    OPTION_TEXT("-o", "F.json", out_scene, "write a scene with the fitted values"),
    OPTION_FORCE(force),
    HELP_EXAMPLE("matrig fit campaign.db 1 --fit grit,f --prior f=0.5:0.05 --plot fit.svg"),
};

const struct command command_fit = {
    "fit",
    study_exec,
    "DB [RUN...] [--scene S] [--fit NAMES] [--prior NAME=V:E,...] [--draws N] [--seed N] "
    "[--plot F] [-o F] [--force]",
    "fit gap, resistance, friction, thrust share and stiffness to landings, with errors",
    COMMAND_PARTS(fit_parts),
    {1, 1 + FIT_RUNS_MAX, "DB [RUN...]"},
};
#undef OPTION_VALUES
