/* Units of printed values: the report's units (ft, in, lb) or, with --si, metres, millimetres and
 * newtons. Internally all values are in the report's units; they are converted once, for output. */
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
    UNIT_MEASURED_KIND_COUNT, /* number of the kinds above, which a board measures */
    UNIT_NUMBER =
        /* a number without a unit, or a value whose name contains the unit */
    UNIT_MEASURED_KIND_COUNT,
    UNIT_TIME,
    UNIT_MOVEMENT, /* passed in ft; shown in inches or mm */
    UNIT_STIFFNESS,
    UNIT_KIND_COUNT
};

struct unit {
    const char *text;   /* printed unit: "ft/s2" */
    const char *suffix; /* the unit as the end of a name: "ft_s2" */
    double factor;      /* factor from the report's unit to this unit */
};

const struct unit *unit_get(enum unit_kind kind, bool si);
/* Returns the unit in which callers pass values of this kind. */
const struct unit *unit_get_json(enum unit_kind kind);
/* A unit that users may write after a displacement or a tension. */
struct unit_word {
    const char *word; /* spelling for output: "mm", "kN" */
    enum unit_kind kind;
};
/* Finds a unit: in, mm, cm, m, ft; lb, N, kN, kg, kgf; their plurals and other spellings, in any
 * case except "M" and "Mm", where M is mega. NULL: unknown. Static storage. */
const struct unit_word *unit_word_find(const char *word, size_t length);
/* Returns each unit once, in order: index 0 is the first; NULL after the last. Static storage. */
const struct unit_word *unit_word_get(size_t index);
/* Returns 0 (never -0) if the value rounds to 0 when its last digit has the value `resolution`;
 * otherwise returns the value. */
double unit_round_to_zero(double value, double resolution);
/* Number of decimals to print for a value that has `decimals` decimals in the report's unit. In SI
 * the number is adapted so that no digit is lost. */
int unit_decimals(enum unit_kind kind, bool si, int decimals);
/* Formats a value in the report's unit, rounded to `decimals` decimals in that unit: "93.9 lb" or
 * "417.7 N"; "-" if it is not known. unit_signed_text also prints the sign of a positive value.
 * Both return `out`. */
#define UNIT_TEXT_SIZE 40
const char *unit_value_text(enum unit_kind kind, bool si, double value, int decimals,
                            char out[UNIT_TEXT_SIZE]);
const char *unit_signed_text(enum unit_kind kind, bool si, double value, int decimals,
                             char out[UNIT_TEXT_SIZE]);

#endif
