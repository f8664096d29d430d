/* matrig sweep: its options. What runs it is host/study/sweep_run.c, in matrig-study. */
#include "host/commands/sweep_command.h"

#include "host/commands/commands.h"
#include "host/commands/study_start.h"

#define JOBS_MAX 1024.0

#define VALUES struct sweep_request
static const struct command_part parts[] = {
    HELP_ITEM("FILE", "the sweep, JSON (host/sweep/README.md): base scene or study file, what is "
                      "varied, what is wanted"),
    OPTION_TEXT("-o", "R.jsonl", output,
                "results, one JSON line a case; else FILE's name with .jsonl. The same command "
                "goes on where it was, after\n"
                "any kill; R.study.json is a copy of FILE"),
    OPTION_WHOLE("-j", "N", jobs, 1.0, JOBS_MAX, 0.0,
                 "cases at a time, each a process on one core; else as many as there are cores"),
    OPTION_TEXT("--shard", "i/n", shard_text,
                "only every n-th case, from the i-th on, into R.i-of-n.jsonl. In a Slurm job array "
                "(SLURM_ARRAY_TASK_ID) that\n"
                "is done by itself; --shard /n takes i from there"),
    OPTION_NUMBER("--timeout", "S", timeout_s, "s", 1e-3, 1e7, 0.0,
                  "give a case S seconds; else the timeout_s of FILE"),
    OPTION_FLAG("--retry", retry, "do those again that failed"),
    HELP_ITEM("--gather [PART...]",
              "put the shards' results together in R.jsonl; exit 1 when cases are missing"),
    OPTION_FLAG("--slurm", slurm,
                "write and submit a job array (R.jsonl.slurm), wait for it, gather; --no-wait "
                "gathers in a job after it"),
    OPTION_FLAG("--parallel", parallel,
                "the same with GNU parallel (R.jsonl.parallel), -j shards at a time"),
    OPTION_WHOLE("--shards", "N", shards, 1.0, SWEEP_SHARDS_MAX, 0.0,
                 "of them (16; four a core); --with 'OPTIONS' adds options for sbatch or parallel"),
    OPTION_FLAG("--list", list, "print ids and values of all cases, run nothing"),
    OPTION_FORCE(force),
    HELP_NOTE("Exit 1 when cases are missing (stopped); cases that failed are recorded with their "
              "reason.\n"
              ""),
    HELP_EXAMPLE(
        "matrig sweep host/sweep/examples/threshold.json -o t.jsonl && matrig report t.jsonl"),
    OPTION_TEXT("--with", "'OPTIONS'", with, NULL),
    OPTION_FLAG("--gather", gather, NULL),
    OPTION_FLAG("--no-wait", no_wait, NULL),
};

const struct command command_sweep = {
    "sweep",
    study_start,
    "FILE [-j N] [--shard i/n] [-o R.jsonl] [--timeout S] [--retry] [--force] | FILE --gather | "
    "FILE --slurm|--parallel [--shards N]",
    "many cases of one scene or study: Cartesian, Latin hypercube, thresholds, indices",
    COMMAND_PARTS(parts),
    {1, 1 + SWEEP_PARTS_MAX, "FILE"},
};
