/* Suggests the nearest known word for an unknown word. */
#ifndef MATRIG_HOST_BASE_SPELL_SUGGEST_H
#define MATRIG_HOST_BASE_SPELL_SUGGEST_H

#include <stddef.h>

/* Leading dashes and capitals are ignored. A word is near if one or two letters (in a word of three
 * or four letters: one) are wrong, missing, superfluous or swapped, or if the beginning is the
 * same. */
struct spell_suggest {
    const char *word, *best; /* best NULL: no near word so far */
    size_t distance;         /* distance of `best` */
};

void spell_suggest_begin(struct spell_suggest *suggest, const char *word);
/* Compares a candidate. Among equally near candidates the first is kept. The caller keeps the
 * text. */
void spell_suggest_add(struct spell_suggest *suggest, const char *candidate);

/* Writes "; did you mean BEST?". For some words that matrig handles differently (delete, undo),
 * writes advice between "; " and ";". Writes "" if no word is near. */
#define SPELL_SUGGEST_TEXT 200
void spell_suggest_text(const struct spell_suggest *suggest, char out[static SPELL_SUGGEST_TEXT]);

#endif
