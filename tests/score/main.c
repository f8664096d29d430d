/* score: how good the predictor's zones and warnings are on landings that are not its own model.
 * See README.md.
 *
 *   score FOLDER FROM COUNT [LEVEL [calibrate|KIND]]
 *                         series FROM .. FROM + COUNT - 1; truth is kept in FOLDER; the tables on
 *                         stdout. LEVEL of the predictor: 0 full, 1 two mats in one, 2 four, 3
 *                         plough. KIND of truth: truth.h
 *
 * Exit: 0; 2 usage; 3 files; 5 a series failed. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/score/score.h"

#define JOBS 2

struct files {
    FILE *looks, *outcomes;
};

static void put_look(void *ctx, const struct score_look *look)
{
    fwrite(look, sizeof *look, 1, ((struct files *)ctx)->looks);
}

static void put_outcome(void *ctx, const struct score_outcome *outcome)
{
    fwrite(outcome, sizeof *outcome, 1, ((struct files *)ctx)->outcomes);
}

/* Every JOBS-th series; views in turn, so that a series' outcomes of a view follow each other. */
static int work(const struct files *files, const char *folder, unsigned from, unsigned count,
                unsigned level, enum score_kind kind, unsigned job)
{
    static struct score_truth truth;
    const struct score_sink sink = {
        .look = put_look, .outcome = put_outcome, .ctx = (void *)(uintptr_t)files};
    int code = 0;
    for (unsigned n = from + job; n < from + count; n += JOBS) {
        if (!score_truth_get(&truth, n, kind, folder)) {
            code = 5;
            continue;
        }
        for (unsigned view = 0; view < SCORE_VIEWS; view++)
            score_play(&truth, view, level, &sink);
    }
    return fflush(files->looks) || fflush(files->outcomes) ? 3 : code;
}

static void *read_all(FILE *file[JOBS], size_t size, size_t *count)
{
    size_t bytes = 0, at = 0;
    for (unsigned j = 0; j < JOBS; j++) {
        fseek(file[j], 0, SEEK_END);
        bytes += (size_t)ftell(file[j]);
        rewind(file[j]);
    }
    char *all = malloc(bytes + 1);
    for (unsigned j = 0; all && j < JOBS; j++)
        at += fread(all + at, 1, bytes - at, file[j]);
    *count = at / size;
    return all;
}

int main(int argc, char **argv)
{
    struct files files[JOBS];
    FILE *looks[JOBS], *outcomes[JOBS];
    pid_t child[JOBS];
    int code = 0;
    bool calibrates = argc == 6 && strcmp(argv[5], "calibrate") == 0;
    enum score_kind kind = argc == 6 && !calibrates ? score_kind_find(argv[5]) : SCORE_CHAIN;
    unsigned level = argc > 4 ? (unsigned)atoi(argv[4]) : 0;
    if (argc < 4 || argc > 6 || kind == SCORE_KINDS || level > 3 || atoi(argv[2]) < 0 ||
        atoi(argv[3]) < 1 || atoi(argv[2]) + atoi(argv[3]) > 65535) {
        fprintf(
            stderr,
            "score: usage: score FOLDER FROM COUNT [LEVEL [calibrate|KIND]] (series FROM and on, "
            "below 65535; LEVEL 0 to 3; KIND: chain, planar, elastic, late, shut, patchy, heavy, "
            "pulsed)\n");
        return 2;
    }
    for (unsigned j = 0; j < JOBS; j++) {
        looks[j] = files[j].looks = tmpfile();
        outcomes[j] = files[j].outcomes = tmpfile();
        if (!looks[j] || !outcomes[j]) {
            fprintf(stderr, "score: temporary file: %s; make room in /tmp\n", strerror(errno));
            return 3;
        }
        child[j] = fork();
        if (child[j] == 0)
            _exit(work(&files[j], argv[1], (unsigned)atoi(argv[2]), (unsigned)atoi(argv[3]), level,
                       kind, j));
    }
    for (unsigned j = 0; j < JOBS; j++) {
        int status;
        if (child[j] < 0 || waitpid(child[j], &status, 0) < 0 || !WIFEXITED(status)) {
            fprintf(stderr, "score: a worker died; run again\n");
            return 5;
        }
        code = WEXITSTATUS(status) > code ? WEXITSTATUS(status) : code;
    }
    size_t look_count, outcome_count;
    struct score_look *all_looks = read_all(looks, sizeof *all_looks, &look_count);
    struct score_outcome *all_outcomes = read_all(outcomes, sizeof *all_outcomes, &outcome_count);
    if (!all_looks || !all_outcomes || !outcome_count) {
        fprintf(stderr, "score: nothing was scored\n");
        return 5;
    }
    score_print(all_looks, look_count, all_outcomes, outcome_count);
    if (calibrates)
        score_calibrate(all_looks, look_count);
    free(all_looks);
    free(all_outcomes);
    return code;
}
