/* What somebody may have meant who typed a word that is not there: the nearest that is. */
#ifndef MATRIG_HOST_BASE_NEAR_H
#define MATRIG_HOST_BASE_NEAR_H

#include <stddef.h>

/* Dashes at the beginning and capitals do not count. Near: a letter or two (in a word of three or
 * four letters: one) that are wrong, missing, too many or swapped; or the same beginning. */
struct near {
    const char *word, *best; /* best NULL: none so far */
    size_t distance;         /* of the best */
};

void near_begin(struct near *near, const char *word);
/* Of equally near ones the first is kept; the text stays the caller's. */
void near_try(struct near *near, const char *candidate);

/* "; did you mean BEST?", or "" when nothing is near. */
#define NEAR_TEXT 120
void near_text(const struct near *near, char out[static NEAR_TEXT]);

#endif
