/* What the report's text says of figures 3.6 to 3.12, one row each, with the bounds within which a
 * reading reproduces it. The bounds were fixed before any search. */
#ifndef MATRIG_TESTS_FIGURES_FACTS_H
#define MATRIG_TESTS_FIGURES_FACTS_H

#include <stdbool.h>
#include <stddef.h>

#include "tests/figures/play.h"

#define FACTS_MAX 48

/* What a fact is about: a number of run `a`, or of runs `a` and `b`. Times count the run's own. */
enum fact_kind {
    FACT_U,    /* displacement of `mat` (0: of the reading's input `mat_of`) at time `at`, ft */
    FACT_LAST, /* largest displacement of the last mat, runs a to b, ft */
    FACT_FALLS_BACK, /* most that u of mat 4 falls from one time to the next, runs 3.6, 3.7, 3.12 */
    FACT_BOW,        /* largest lift over the lift that is called a bow wave */
    FACT_LIFT,       /* lift at time `at`, ft */
    FACT_PEAK,       /* largest lift, ft */
    FACT_STANDS,     /* lift at the last time over the largest */
    FACT_LIFTS,      /* lift of a over that of b at time `at` */
    FACT_PEAKS,      /* largest lifts, a over b */
    FACT_MOVES,      /* displacement of mat 4 at time `at`, a over b */
    FACT_RISES,      /* time to a lift of 0.05 ft, a over b */
    FACT_SPREAD      /* least over most of the largest lifts of runs a to b */
};

struct fact {
    const char *figure, *section, *text;
    enum fact_kind kind;
    enum run_id a, b;
    int mat, at;
    enum input_id mat_of; /* where mat is 0 */
    double stated;        /* a number that is printed; 0: none, words */
    double low, high;     /* reproduced: low <= value <= high; high 0: none */
    bool held;            /* R* is held to it by `make figures` */
    const char *why;      /* why it is open, where something is to be said */
};
extern const struct fact facts[];
extern const size_t fact_count;

/* Beyond the bounds a miss is counted in these: ratios of a number, of words. */
#define UNIT_NUMBER 1.02
#define UNIT_WORDS  1.25

/* What comes out; NaN when a run that it needs did not end well, or the ratio has no meaning. */
double fact_value(const struct fact *fact, struct playing *playing);
bool fact_met(const struct fact *fact, double value);
/* How far off, in units: at most 1 for a number that is met, 0 for words that are. */
double fact_miss(const struct fact *fact, double value);
/* Whether the fact is about displacements, which no lift changes in the low profile (A.1). */
bool fact_moves(const struct fact *fact);

#endif
