/* What of a study is done, and which part of it is this process's: results files and shards.
 *
 * R.jsonl holds the whole study's results; shard i of n writes R.i-of-n.jsonl, and what is in any
 * of them is done. A case belongs to shard 1 + (its number modulo n). */
#ifndef MATRIG_HOST_SWEEP_SHARE_H
#define MATRIG_HOST_SWEEP_SHARE_H

#include "host/sweep/sweep_results.h"
#include "host/sweep/sweep_study.h"

#define SWEEP_SHARDS_MAX 100000
#define SWEEP_PATH_MAX   1000

struct sweep_shard {
    unsigned i, n; /* 1..n of n; n 0: no shards */
};

/* From "i/n"; "/n" takes i from SLURM_ARRAY_TASK_ID; NULL: both from Slurm's environment when a job
 * array runs this, else none. MR_USAGE: what cannot be meant, such as an array that leaves numbers
 * out. */
enum mr_status sweep_shard_read(struct sweep_shard *shard, const char *text, struct error *error);

static inline bool sweep_shard_has(const struct sweep_shard *shard, size_t index)
{
    return shard->n == 0 || index % shard->n == shard->i - 1;
}

/* "dir/r.jsonl", shard 2 of 5: "dir/r.2-of-5.jsonl". `out` has SWEEP_PATH_MAX + 40 bytes. */
void sweep_shard_path(const char *results, const struct sweep_shard *shard, char *out);
/* "dir/r.jsonl": "dir/r.study.json", beside the results: the study with its base put in. */
void sweep_study_path(const char *results, char *out);

struct sweep_done {
    const struct sweep_study *study;
    bool *done; /* [cases] */
    size_t count, failed, twice;
    bool retry; /* in: what failed, in other files than the one being written, is not done */
};

/* What the lines of the file being written, of R and of the other shards' files say; begin with
 * {.retry =} alone. A line whose case the study does not have: MR_MALFORMED, so that results of two
 * studies are never mixed. The caller frees done->done. */
enum mr_status sweep_done_load(struct sweep_done *done, const struct sweep_study *study,
                               const struct sweep_results *own, const char *results,
                               struct error *error);

/* Puts the lines of the shards' files that R lacks into R, in the study's order; a failure in R
 * gives way to a result of a later try. parts NULL: all files named as shards of R. */
struct sweep_gathered {
    /* differ: cases whose results in two files are not the same (cpu_ms apart) */
    size_t parts, added, differ;
    char differs[SWEEP_ID_SIZE]; /* one of them */
};
enum mr_status sweep_gather(struct sweep_results *into, struct sweep_done *done,
                            const char *results, const char *const *parts, size_t part_count,
                            struct sweep_gathered *gathered, struct error *error);

#endif
