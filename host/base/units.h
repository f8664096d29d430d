/* Units for people: the report's (ft, in, lb) or, with --si, metres, millimetres and newtons.
 * Inside, everything is in the report's units; conversion happens once, where a value is shown. */
#ifndef MATRIG_HOST_BASE_UNITS_H
#define MATRIG_HOST_BASE_UNITS_H

#include <stdbool.h>
#include <stddef.h>

enum unit_kind {
    UNIT_STATION,
    UNIT_DISPLACEMENT,
    UNIT_SPEED,
    UNIT_DECELERATION,
    UNIT_TENSION,
    UNIT_KINDS,               /* those above are a board's */
    UNIT_NUMBER = UNIT_KINDS, /* without a unit, or the unit is in the name */
    UNIT_TIME,
    UNIT_MOVEMENT, /* given in ft, for people in or mm */
    UNIT_STIFFNESS,
    UNIT_ALL
};

struct unit {
    const char *text;   /* "ft/s2" */
    const char *suffix; /* of a name: "ft_s2" */
    double factor;      /* multiply a value in the report's unit by it */
};

const struct unit *unit_of(enum unit_kind kind, bool si);
/* What values are given in. */
const struct unit *unit_given(enum unit_kind kind);
/* A unit that people write beside a value, of a displacement or a tension. */
struct unit_word {
    const char *word; /* "mm", "kN": as printed */
    enum unit_kind kind;
};
/* in, mm, cm, m, ft; lb, N, kN, kg, kgf; their plurals and other spellings, in capitals or not, but
 * for "M" and "Mm", where M is mega. NULL: none of them. Static storage. */
const struct unit_word *unit_read(const char *word, size_t length);
/* All of them, once each: unit_words(0) and on, NULL after the last. Static storage. */
const struct unit_word *unit_words(size_t index);
/* What rounds to 0 at this least digit, without a sign. */
double unit_tidy(double value, double least);
/* Decimals of a value that has `decimals` in the report's unit: in SI as many more or less as keep
 * every digit. */
int unit_decimals(enum unit_kind kind, bool si, int decimals);
/* "93.9 lb" or "417.7 N" of a value in the report's unit, rounded to `decimals` there; "-": it is
 * not known. The second with the sign of what is positive. Both return `out`. */
#define UNIT_TEXT 40
const char *unit_value_text(enum unit_kind kind, bool si, double value, int decimals,
                            char out[UNIT_TEXT]);
const char *unit_signed_text(enum unit_kind kind, bool si, double value, int decimals,
                             char out[UNIT_TEXT]);

#endif
