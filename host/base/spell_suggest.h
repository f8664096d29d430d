/* Suggests the nearest known word for an unknown word. */
#ifndef MATRIG_HOST_BASE_SPELL_SUGGEST_H
#define MATRIG_HOST_BASE_SPELL_SUGGEST_H

#include <stdbool.h>
#include <stddef.h>

/* State of the search for the known word nearest to `word`. Leading dashes and capitals are
 * ignored. A known word is near if its beginning is the same, or if one or two letters (one in a
 * word of three or four letters) are wrong, missing, superfluous or swapped. */
struct spell_suggest {
    const char *word, *best; /* best: the nearest word so far; NULL: none */
    size_t distance;         /* number of edits from `word` to `best` */
    char choices[200];       /* see spell_suggest_add_choices */
};

void spell_suggest_begin(struct spell_suggest *suggest, const char *word);
/* Compares a candidate with the word. Of equally near candidates the first is kept. The text must
 * outlive the search. Returns true if the candidate equals the word. */
bool spell_suggest_add(struct spell_suggest *suggest, const char *candidate);
/* Starts the search for `word` and compares choices such as "left|right". Returns true if the word
 * is one of them. */
bool spell_suggest_add_choices(struct spell_suggest *suggest, const char *word,
                               const char *choices);

/* Writes "; did you mean BEST?". For some words of other programs (delete, undo), writes advice
 * between "; " and ";". Writes "" if no word is near. */
#define SPELL_SUGGEST_TEXT_SIZE 200
void spell_suggest_text(const struct spell_suggest *suggest,
                        char out[static SPELL_SUGGEST_TEXT_SIZE]);

#endif
