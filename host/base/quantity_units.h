/* Units as products of words: what quantity.c computes with. */
#ifndef MATRIG_HOST_BASE_QUANTITY_UNITS_H
#define MATRIG_HOST_BASE_QUANTITY_UNITS_H

#include <stdbool.h>
#include <stddef.h>

/* What units are made of. A mass is force time2 / length. */
enum quantity_base {
    QUANTITY_LENGTH,
    QUANTITY_FORCE,
    QUANTITY_TIME,
    QUANTITY_ANGLE,
    QUANTITY_VOLTAGE,
    QUANTITY_RESISTANCE,
    QUANTITY_TEMPERATURE,
    QUANTITY_BASES
};

/* 1 of this word is times / over * 10^ten of the SI units of its bases. Both are whole numbers that
 * a double holds exactly, but for pi. */
struct quantity_word {
    const char *word;
    signed char base[QUANTITY_BASES]; /* its powers */
    double times, over;
    int ten;
    bool any_case; /* also in other capitals */
};

#define QUANTITY_WORDS_MAX 48
struct quantity_unit {
    int power[QUANTITY_WORDS_MAX]; /* of each word of the table */
};

extern const struct quantity_word quantity_words[];
extern const size_t quantity_word_count;

/* The word's place in the table, by its spelling ("inches" is in); quantity_word_count: none. */
size_t quantity_word_find(const char *text, size_t length);
/* False: not a unit. "": no unit, all powers 0. */
bool quantity_unit_parse(const char *text, struct quantity_unit *unit);
bool quantity_unit_alike(const struct quantity_unit *a, const struct quantity_unit *b);
/* kg alone becomes kgf where `wanted` is a force. */
void quantity_unit_weigh(struct quantity_unit *unit, const struct quantity_unit *wanted);

#endif
