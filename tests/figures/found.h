/* What a search has found, kept in a file beside it, so that the table is made again without it. */
#ifndef MATRIG_TESTS_FIGURES_FOUND_H
#define MATRIG_TESTS_FIGURES_FOUND_H

#include <stdio.h>

#include "tests/figures/search.h"

#define FOUND_FILE "tests/figures/readings.json"
#define FOUND_PAGE "host/sim/FIGURES.md"

struct found {
    struct reading best[SEARCH_GROUPS];
    size_t readings;       /* of the ensemble */
    size_t met[FACTS_MAX]; /* of them, that reproduce each fact */
};

struct found found_of(const struct search *search);
enum mr_status found_save(const struct found *found, const char *path, struct error *error);
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

/* What the search says of each input, and pairs of facts that exclude each other; Markdown. */
void say_inputs(FILE *out, const struct search *search);
void say_pairs(FILE *out, const struct search *search);

/* Puts what `write` prints between the marks `<!-- NAME: ... -->` and `<!-- end of NAME -->` of a
 * page. MR_MALFORMED when it has none. */
enum mr_status page_put(const char *path, const char *name,
                        void (*write)(FILE *out, const void *what), const void *what,
                        struct error *error);

#endif
