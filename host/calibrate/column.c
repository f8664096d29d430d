#include "host/calibrate/column.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define WORDS_MAX   24u
#define COUNT(list) (sizeof(list) / sizeof(list)[0])

static const char *const code_words[] = {"code", "codes", "count", "counts", "adc", "raw", "lsb"};
static const char *const volt_words[] = {"v", "mv", "volt", "volts", "millivolt", "millivolts"};
static const char *const descriptions[] = {
    "actual",     "applied",   "average",      "block",    "caliper",   "cell",    "channel",
    "deflection", "dial",      "displacement", "distance", "extension", "force",   "forces",
    "gage",       "gap",       "gauge",        "height",   "indicated", "input",   "known",
    "length",     "level",     "load",         "loads",    "mass",      "mean",    "measured",
    "nominal",    "of",        "output",       "pos",      "position",  "reading", "readings",
    "ref",        "reference", "sensor",       "set",      "standard",  "stroke",  "target",
    "tension",    "the",       "transducer",   "travel",   "true",      "unit",    "units",
    "value",      "values",    "weight",       "weights"};
/* Words that make another number of a value, and units that matrig does not convert. */
static const char *const refused_words[] = {
    "half",        "halves",     "third",       "thirds",      "quarter",     "quarters",
    "eighth",      "eighths",    "sixteenth",   "sixteenths",  "tenth",       "tenths",
    "hundredth",   "hundredths", "thousandth",  "thousandths", "zehntel",     "hundertstel",
    "tausendstel", "halbe",      "double",      "twice",       "triple",      "ten",
    "tens",        "hundred",    "hundreds",    "thousand",    "thousands",   "dozen",
    "million",     "per",        "times",       "percent",     "pct",         "ppm",
    "minus",       "negative",   "inverse",     "deci",        "centi",       "milli",
    "micro",       "nano",       "deca",        "deka",        "hecto",       "kilo",
    "mega",        "giga",       "da",          "h",           "k",           "u",
    "x",           "sq",         "square",      "squared",     "cu",          "cubic",
    "scale",       "scaled",     "factor",      "thou",        "thous",       "mil",
    "mils",        "um",         "nm",          "dm",          "km",          "micron",
    "microns",     "micrometre", "micrometres", "micrometer",  "micrometers", "yd",
    "yard",        "yards",      "g",           "gram",        "grams",       "gf",
    "t",           "ton",        "tons",        "tonne",       "tonnes",      "oz",
    "ounce",       "ounces",     "kip",         "kips",        "klb",         "klbf",
    "dan",         "mn",         "un",          "cn",          "hn",          "dyn",
    "st",          "stone",      "psi",         "pa",          "kpa",         "mpa",
    "bar",         "mbar"};

enum meaning { UNIT, CODE, VOLT, DESCRIPTION, PREPOSITION, REFUSED, UNKNOWN };

struct word {
    const char *text;
    size_t length;
    enum meaning meaning;
    const struct unit_word *unit;
    bool in_brackets;
};

struct name {
    struct word word[WORDS_MAX];
    size_t words;
    struct column *column;
};

static bool is(const struct word *word, const char *known)
{
    return strlen(known) == word->length && strncasecmp(known, word->text, word->length) == 0;
}

static bool is_one_of(const struct word *word, const char *const *list, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (is(word, list[i]))
            return true;
    }
    return false;
}

static bool is_letter(char c)
{
    return isalpha((unsigned char)c) || (unsigned char)c >= 0x80;
}

/* Signs beyond ASCII, in UTF-8 or Latin-1: of the first block (one half, micro, squared,
 * plus-minus), times and divided by, general punctuation and fractions, and the Greek micro.
 * Letters are none of them. */
static bool has_sign(const struct word *word)
{
    const unsigned char *p = (const unsigned char *)word->text, *end = p + word->length;
    while (p < end) {
        size_t more = p[0] >= 0xf0 ? 3 : p[0] >= 0xe0 ? 2 : p[0] >= 0xc0 ? 1 : 0;
        bool whole = (size_t)(end - p) > more;
        for (size_t i = 1; whole && i <= more; i++)
            whole = (p[i] & 0xc0) == 0x80;
        if (whole && more > 0) {
            if (p[0] == 0xc2 || p[0] == 0xe2 || (p[0] == 0xc3 && (p[1] == 0x97 || p[1] == 0xb7)) ||
                (p[0] == 0xce && p[1] == 0xbc))
                return true;
            p += more + 1;
            continue;
        }
        if ((p[0] >= 0x80 && p[0] < 0xc0) || p[0] == 0xd7 || p[0] == 0xf7)
            return true;
        p++;
    }
    return false;
}

static void odd(struct column *column, const char *text, size_t length)
{
    if (!column->odd[0])
        snprintf(column->odd, sizeof column->odd, "%.*s", (int)length, text);
}

/* d1 to d8 and t1 to t14 as the board numbers them, ch1 and adc1 to 99 as others do. */
static bool is_channel(const struct word *letters, size_t digits)
{
    unsigned long number = digits <= 2 ? strtoul(letters->text + letters->length, NULL, 10) : 0;
    unsigned long last = is(letters, "d")                        ? 8
                       : is(letters, "t")                        ? 14
                       : is(letters, "ch") || is(letters, "adc") ? 99
                                                                 : 0;
    return number >= 1 && number <= last;
}

static enum meaning meaning_of(struct word *word)
{
    word->unit = unit_read(word->text, word->length);
    return word->unit                                                             ? UNIT
         : is_one_of(word, code_words, COUNT(code_words))                         ? CODE
         : is_one_of(word, volt_words, COUNT(volt_words))                         ? VOLT
         : is_one_of(word, descriptions, COUNT(descriptions))                     ? DESCRIPTION
         : is_one_of(word, refused_words, COUNT(refused_words)) || has_sign(word) ? REFUSED
                                                                                  : UNKNOWN;
}

/* A word, with the digits that are glued to its end. Returns its bytes. */
static size_t take_word(struct name *name, const char *text, size_t length, bool in_brackets)
{
    struct word word = {.text = text, .in_brackets = in_brackets};
    size_t digits = 0;
    while (word.length < length && is_letter(text[word.length]))
        word.length++;
    while (word.length + digits < length && isdigit((unsigned char)text[word.length + digits]))
        digits++;
    size_t taken = word.length + digits;
    bool glued = taken < length && digits > 0 && is_letter(text[taken]);
    word.meaning = digits == 0 ? meaning_of(&word) : DESCRIPTION;
    if (digits == 0 && name->words == 0 && is(&word, "x")) /* a place; a factor would have digits */
        word.meaning = DESCRIPTION;
    if ((digits > 0 && (glued || !is_channel(&word, digits))) || name->words == WORDS_MAX)
        odd(name->column, text, taken);
    else
        name->word[name->words++] = word;
    return taken;
}

/* Between words: blanks and _; a dash between letters or blanks, not one that could be a minus; a
 * dot or colon behind a letter. */
static bool is_separator(const char *text, size_t i, size_t length)
{
    char before = i > 0 ? text[i - 1] : '(', after = i + 1 < length ? text[i + 1] : ')';
    switch (text[i]) {
    case ' ':
    case '\t':
    case '\r':
    case '\n':
    case '_': return true;
    case '-': return (is_letter(before) && is_letter(after)) || (before == ' ' && after == ' ');
    case '.':
    case ':': return is_letter(before);
    default: return false;
    }
}

static void take_words(struct name *name, const char *text, size_t length)
{
    char open = '\0';
    for (size_t i = 0; i < length;) {
        bool opens = text[i] == '(' || text[i] == '[';
        if (is_letter(text[i])) {
            i += take_word(name, text + i, length - i, open != '\0');
            continue;
        }
        size_t digits = strspn(text + i, "0123456789");
        digits = digits < length - i ? digits : length - i;
        if (opens && !open)
            open = text[i];
        else if ((text[i] == ')' && open == '(') || (text[i] == ']' && open == '['))
            open = '\0';
        else if (digits > 0 || !is_separator(text, i, length))
            odd(name->column, text + i, digits > 0 ? digits : 1);
        i += digits > 0 ? digits : 1;
    }
    if (open)
        odd(name->column, &open, 1);
}

/* `in` before a unit, codes or a word that nobody knows is no inch: "value in mm". As the first
 * word it may be either: inch-pounds. */
static void find_prepositions(struct name *name)
{
    for (size_t i = 0; i + 1 < name->words; i++) {
        enum meaning next = name->word[i + 1].meaning;
        if (is(&name->word[i], "in") && next != DESCRIPTION && (i > 0 || next != UNIT))
            name->word[i].meaning = PREPOSITION;
    }
}

static void place_words(struct name *name)
{
    struct column *column = name->column;
    bool told = false; /* the unit stands where units stand */
    for (size_t i = 0; i < name->words; i++) {
        const struct word *word = &name->word[i];
        column->codes |= word->meaning == CODE;
        column->volts |= word->meaning == VOLT;
        if (word->meaning != UNIT)
            continue;
        column->units |= column->unit && column->unit != word->unit;
        column->unit = word->unit;
        told |= word->in_brackets || (i > 0 && name->word[i - 1].meaning == PREPOSITION);
    }
    column->units |= column->unit && column->codes;
    for (size_t i = 0; i < name->words; i++) {
        const struct word *word = &name->word[i];
        bool described = (told || column->codes) && !word->in_brackets;
        if (word->meaning == REFUSED || (word->meaning == UNKNOWN && !described))
            odd(column, word->text, word->length);
    }
}

void column_read(const char *text, size_t length, struct column *column)
{
    struct name name = {.column = column};
    *column = (struct column){0};
    while (length > 0 && isspace((unsigned char)text[0]))
        text++, length--;
    while (length > 0 && isspace((unsigned char)text[length - 1]))
        length--;
    if (length > 1 && (text[0] == '"' || text[0] == '\'') && text[length - 1] == text[0])
        text++, length -= 2;
    take_words(&name, text, length);
    find_prepositions(&name);
    place_words(&name);
}
