/* A search of the unknown inputs against everything that the text says at once.
 *
 * First an ensemble: a Latin hypercube over the ranges of inputs.c. Then walks (Metropolis: a
 * reading weighs exp(-score), every value of a range alike) from the best of it and from R*, and a
 * descent from the best that was met. Once for all facts, once each for displacements and for the
 * rest alone: what they ask for apart from each other. Fixed seeds: the same search each time. */
#ifndef MATRIG_TESTS_FIGURES_SEARCH_H
#define MATRIG_TESTS_FIGURES_SEARCH_H

#include "host/base/error.h"
#include "tests/figures/facts.h"

enum search_group { SEARCH_ALL, SEARCH_MOVES, SEARCH_LIFTS, SEARCH_GROUPS };

#define SEARCH_TOP 12 /* of these the accurate method chooses */

struct trial {
    double part[INPUTS]; /* of each range (inputs.h) */
    double score;        /* of the facts of a group */
    double value[FACTS_MAX];
};

struct search {
    struct trial *ensemble; /* facts of all groups */
    struct trial *walked;   /* SEARCH_ALL: where the walks were, without their first third */
    size_t count, walked_count, walked_room;
    struct trial best[SEARCH_GROUPS];
    struct trial top[SEARCH_TOP]; /* SEARCH_ALL: the best met, best first; score HUGE_VAL: none */
    size_t played;                /* readings, those included that were given up half-way */
};

/* `count` readings of the ensemble, and as many steps of the walks. The caller frees it. */
enum mr_status search_run(struct search *search, size_t count, struct error *error);
void search_free(struct search *search);

bool search_has(enum search_group group, const struct fact *fact);
struct reading trial_reading(const struct trial *trial);
/* The score of a playing; stops, at more than `most`, without playing the rest. `value`: of each
 * fact, NaN where it was not asked. */
double search_score(struct playing *playing, enum search_group group, double most, double *value);

#endif
