/* A study's shards through Slurm or GNU parallel. */
#ifndef MATRIG_HOST_SWEEP_SUBMIT_H
#define MATRIG_HOST_SWEEP_SUBMIT_H

#include <stdbool.h>

#include "host/base/error.h"

enum sweep_engine { SWEEP_SLURM, SWEEP_PARALLEL };

struct sweep_submission {
    enum sweep_engine engine;
    const char *study;   /* file */
    const char *results; /* R.jsonl */
    unsigned shards;
    unsigned jobs;       /* GNU parallel: shards at a time */
    const char *with;    /* further options of sbatch or parallel; NULL: none */
    const char *timeout; /* --timeout of the shards; NULL: the study's */
    bool force;          /* the script takes any file's place */
    bool no_wait;        /* Slurm: gather in a job of its own after the array */
    char script[1100];   /* out: what was written */
    char job[40];        /* out: Slurm's number of the array */
    int exit_code;       /* out: of sbatch or parallel */
};

/* Writes the script beside the results and runs it: R.slurm with sbatch, R.parallel with bash.
 * Returns when all shards have ended, or with no_wait when they are submitted. A shard that failed
 * is no error here: what is missing shows when gathering. MR_IO: the program is not there or
 * refused. */
enum mr_status sweep_submit(struct sweep_submission *submission, struct error *error);

#endif
