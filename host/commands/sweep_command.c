/* matrig sweep: its options. What runs it is host/study/sweep_run.c, in matrig-study. */
#include "host/commands/studies.h"

#include "host/commands/commands.h"

#define VALUES struct sweep_request
static const struct command_part parts[] = {
    HELP_ITEM("FILE", "the sweep, JSON (host/sweep/README.md): base scene or study file, what is "
                      "varied, which results are wanted.\n"
                      "Alone: its cases, a line of JSON each"),
    OPTION_TEXT(
        "--cases", "N..M", cases,
        "run cases N to M (or the last one), or N alone, one after the other; a result is a "
        "line of JSON.\n"
        "GNU parallel or a Slurm job array runs many: docs/howto/sweep-on-a-cluster.md"),
    OPTION_FLAG("--table", table,
                "gather the results in the files after FILE: counts, reasons of failures, indices "
                "of sensitivity, all cases.\n"
                "Exit 1 when cases are missing"),
    OPTION_TEXT("-o", "F", output,
                "write the results of --cases, or the cases of --table as CSV, to F"),
    HELP_NOTE("A case that fails is a result: its line has the reason.\n"
              ""),
    HELP_EXAMPLE("matrig sweep host/sweep/examples/threshold.json --cases 1..35 -o r.jsonl\n"
                 "matrig sweep host/sweep/examples/threshold.json --table r.jsonl -o table.csv"),
};

const struct command command_sweep = {
    "sweep",
    study_start,
    "FILE | FILE --cases N..M [-o R.jsonl] | FILE --table R.jsonl... [-o T.csv]",
    "many cases of one scene or study: Cartesian, Latin hypercube, thresholds, indices",
    COMMAND_PARTS(parts),
    {1, 1 + SWEEP_FILES_MAX, "FILE"},
};
