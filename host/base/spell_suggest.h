/* Suggests the nearest known word for a word that is not known. */
#ifndef MATRIG_HOST_BASE_SPELL_SUGGEST_H
#define MATRIG_HOST_BASE_SPELL_SUGGEST_H

#include <stddef.h>

/* Dashes at the beginning and capitals do not count. Near: a letter or two (in a word of three or
 * four letters: one) that are wrong, missing, too many or swapped; or the same beginning. */
struct spell_suggest {
    const char *word, *best; /* best NULL: none so far */
    size_t distance;         /* of the best */
};

void spell_suggest_begin(struct spell_suggest *near, const char *word);
/* Of equally near ones the first is kept; the text stays the caller's. */
void spell_suggest_try(struct spell_suggest *near, const char *candidate);

/* "; did you mean BEST?"; of a word for what is done otherwise here (delete, undo) how, behind it
 * ";"; "" when nothing is near. */
#define SPELL_SUGGEST_TEXT 200
void spell_suggest_text(const struct spell_suggest *near, char out[static SPELL_SUGGEST_TEXT]);

#endif
