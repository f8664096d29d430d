/* Confidence: how the true errors of solver `staggered` compare to the errors that it states.
 * README.md, "The landing engine". */
#ifndef MATRIG_TESTS_STABILITY_CONFIDENCE_H
#define MATRIG_TESTS_STABILITY_CONFIDENCE_H

#include <stdio.h>

#include "tests/stability/study.h"

#define CONFIDENCE_GROUPS 17
#define CONFIDENCE_BEYOND 3.0 /* stated errors: such an answer is overconfident */

/* Scenes that have something in common; those with a value that two methods confirm, and how many
 * of them are off by more than one and three stated errors, in u or in lift. */
struct confidence_group {
    size_t scenes, compared, beyond_1, beyond_3;
    double worst;
};

struct confidence {
    struct confidence_group groups[CONFIDENCE_GROUPS]; /* the first: all */
    size_t ends[STUDY_ENDS];
    struct bins u, lift; /* true over stated */
    size_t not_run, verdicts, fold_disputed, alone, crashed;
    size_t reference_only; /* fixed does not answer, another method does */
    double total_s;
};

void confidence_head(FILE *table);

/* Judge one scene from what study_fixed has left, and write its row. */
void confidence_add(struct confidence *c, FILE *table, size_t index, const double *exponents,
                    const struct sim_scene *scene, const struct study_answer *answers);

void confidence_print(const struct confidence *c);

/* Whether the study passes: everything ran, nothing crashed, no fold that others dispute, at most
 * one answer in `one_in` is overconfident. */
bool confidence_good(const struct confidence *c, size_t one_in);

#endif
