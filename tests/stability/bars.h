/* Bars: every solver's true errors over the errors that it states. README.md, "The error bars". */
#ifndef MATRIG_TESTS_STABILITY_BARS_H
#define MATRIG_TESTS_STABILITY_BARS_H

#include <stdio.h>

#include "tests/stability/study.h"

#define BARS_SEED   81947u
#define BARS_SCENES 5000u

/* Who answered: `auto`, and each solver by its name, `auto`'s choices among them. */
#define BARS_ROWS 9

/* One solver's answers. Ratio: true error over the stated one, in u or in lift, whichever is
 * larger. */
struct bars_row {
    size_t scenes, ends[STUDY_ENDS];
    size_t compared, beyond_1, beyond_3, verdicts, alone, contested;
    size_t by_itself; /* compared with the same method at a finer tolerance only */
    size_t unsure;    /* said themselves that their end is not predictable */
    double worst, slowest_s;
    float *ratios; /* of those compared */
};

struct bars {
    struct bars_row rows[BARS_ROWS];
    size_t scenes, not_run, crashed, fold_disputed, late;
    double total_s;
};

/* Room for so many scenes. */
bool bars_make(struct bars *bars, size_t scenes);
void bars_free(struct bars *bars);

void bars_head(FILE *table);
/* Judge one scene from what study_bars has left, and write its rows. */
void bars_add(struct bars *bars, FILE *table, size_t index, const double *exponents,
              const struct sim_scene *scene, const struct study_answer *answers);
void bars_print(const struct bars *bars);

/* Whether auto keeps to its word: at most one answer in `one_in` (and one of fewer) beyond 1, none
 * beyond 3, no crash, no disputed fold, nothing above STUDY_LATE_S, everything ran. */
bool bars_good(const struct bars *bars, size_t one_in);

#endif
