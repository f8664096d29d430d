/* What a search of the unknown inputs found, kept in a file: the readings that come closest to all
 * that the text says, to its displacements and to its waves. */
#ifndef MATRIG_TESTS_FIGURES_FOUND_H
#define MATRIG_TESTS_FIGURES_FOUND_H

#include <stdio.h>

#include "host/base/error.h"
#include "tests/figures/facts.h"

#define FOUND_FILE "tests/figures/readings.json"

enum search_group { SEARCH_ALL, SEARCH_MOVES, SEARCH_LIFTS, SEARCH_GROUPS };

struct found {
    struct reading best[SEARCH_GROUPS];
    size_t readings;       /* of the ensemble */
    size_t met[FACTS_MAX]; /* of them, that reproduce each fact */
};

enum mr_status found_load(struct found *found, const char *path, struct error *error);

/* The table: each fact, the text, R*, the best readings, whether they reproduce it. Played here by
 * the accurate method. Returns the first fact that R* is held to and misses, or NULL. */
struct sheet {
    struct playing rstar, best, alone[SEARCH_GROUPS]; /* alone: displacements, the rest */
    double score_rstar, score_best;
    struct sheet_row {
        double rstar, best, alone;
    } row[FACTS_MAX];
};
const struct fact *sheet_make(struct sheet *sheet, const struct found *found);
/* As Markdown. */
void sheet_print(FILE *out, const struct sheet *sheet, const struct found *found);

#endif
