#include "host/base/spell_suggest.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#define WORD_LETTERS_MAX 32u /* longest word that is compared */
#define COMMON_PREFIX_LETTERS_MIN \
    5u /* Words with this many equal first letters count as forms of the same word. */

static const char *skip_dashes(const char *word)
{
    return word + strspn(word, "-");
}

static int lowercase_letter_at(const char *word, size_t i)
{
    return tolower((unsigned char)word[i]);
}

static size_t smaller_size(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Number of edits from word a to word b. An edit changes, inserts or deletes a letter, or swaps two
 * adjacent letters. */
static size_t compute_edit_distance(const char *a, size_t a_length, const char *b, size_t b_length)
{
    size_t row[WORD_LETTERS_MAX + 1][WORD_LETTERS_MAX + 1];
    for (size_t i = 0; i <= a_length; i++)
        row[i][0] = i;
    for (size_t k = 0; k <= b_length; k++)
        row[0][k] = k;
    for (size_t i = 1; i <= a_length; i++) {
        for (size_t k = 1; k <= b_length; k++) {
            bool same = lowercase_letter_at(a, i - 1) == lowercase_letter_at(b, k - 1);
            row[i][k] = smaller_size(row[i - 1][k - 1] + !same,
                                     smaller_size(row[i - 1][k], row[i][k - 1]) + 1);
            if (i > 1 && k > 1 && lowercase_letter_at(a, i - 1) == lowercase_letter_at(b, k - 2) &&
                lowercase_letter_at(a, i - 2) == lowercase_letter_at(b, k - 1))
                row[i][k] = smaller_size(row[i][k], row[i - 2][k - 2] + 1);
        }
    }
    return row[a_length][b_length];
}

static size_t count_common_prefix(const char *a, const char *b)
{
    size_t n = 0;
    while (a[n] && lowercase_letter_at(a, n) == lowercase_letter_at(b, n))
        n++;
    return n;
}

void spell_suggest_begin(struct spell_suggest *suggest, const char *word)
{
    *suggest = (struct spell_suggest){.word = word};
}

bool spell_suggest_add(struct spell_suggest *suggest, const char *candidate)
{
    const char *a = skip_dashes(suggest->word), *b = skip_dashes(candidate);
    size_t a_length = strlen(a), b_length = strlen(b), shorter = smaller_size(a_length, b_length);
    bool is_word = strcmp(suggest->word, candidate) == 0;
    if (a_length > WORD_LETTERS_MAX || b_length > WORD_LETTERS_MAX || shorter == 0)
        return is_word;
    size_t allowed = shorter < 3 ? 0 : shorter < 5 ? 1 : 2;
    size_t distance = compute_edit_distance(a, a_length, b, b_length),
           beginning = count_common_prefix(a, b);
    if (distance > allowed) {
        if (beginning < COMMON_PREFIX_LETTERS_MIN && !(beginning == shorter && shorter >= 3))
            return is_word;
        distance = 3; /* a word that only begins the same ranks below a misspelling */
    }
    if (!suggest->best || distance < suggest->distance) {
        suggest->best = candidate;
        suggest->distance = distance;
    }
    return is_word;
}

bool spell_suggest_add_choices(struct spell_suggest *suggest, const char *word, const char *choices)
{
    bool found = false;
    spell_suggest_begin(suggest, word);
    snprintf(suggest->choices, sizeof suggest->choices, "%s", choices);
    for (char *choice, *rest = suggest->choices; (choice = strsep(&rest, "|"));)
        found |= spell_suggest_add(suggest, choice);
    return found;
}

void spell_suggest_text(const struct spell_suggest *suggest,
                        char out[static SPELL_SUGGEST_TEXT_SIZE])
{
    static const struct {
        const char *words, *answer;
    } otherwise[] = {
        {" delete remove rm undo revert ",
         "matrig deletes no data; to undo a mistake use landing --void, --withdraw or "
         "--withdraw-series, or survey --withdraw"},
        {" arm disarm zero shunt reset gages gauges ",
         "to send a command to the board use matrig board --serial LINK arm, disarm, zero [1|2], "
         "shunt or reset"},
        {" output out ", "name the output file with -o F"},
        {" list ls view open summary ", "to list the landings use matrig show DB"},
        {" plot graph chart draw ", "to plot a campaign use matrig report DB"},
        {" start begin run ", "to record landings use matrig log"},
        {" stop quit exit end ", "to end matrig log, press Ctrl-C in its terminal"},
        {" version ", "write matrig --version"},
        {" format pdf print ", "the extension of the file for -o sets the format; to print a "
                               "report, open its page in a browser"},
    };
    char word[40];
    out[0] = '\0';
    snprintf(word, sizeof word, " %.30s ", skip_dashes(suggest->word));
    if (suggest->best)
        snprintf(out, SPELL_SUGGEST_TEXT_SIZE, "; did you mean %.90s?", suggest->best);
    for (size_t i = 0; i < sizeof otherwise / sizeof otherwise[0] && !suggest->best; i++)
        if (strstr(otherwise[i].words, word))
            snprintf(out, SPELL_SUGGEST_TEXT_SIZE, "; %s;", otherwise[i].answer);
}
