/* Quantities as people write them: the only parser for options, files and keyboard input.
 *
 *     quantity = number [blanks] [unit]                      "5 mm"  "5mm"  "-0.5"  "1.5e3 lb/ft"
 *     unit     = power {blank power} ["/" power]             "ft"  "lb s/ft"  "kg m2"  "1/K"
 *     power    = word ["^"] ["2" to "4"]                     "m"  "m2"  "m^2"
 *
 * Two tables in quantity.c list the words and, for each kind of quantity, its usual units;
 * docs/reference/units.md is generated from them. Words of lengths and forces may be in capitals
 * ("MM", "LB"), except "M" and "Mm", where M is mega. Any product of words with the right dimension
 * is accepted: "kip/in" and "kN/mm" for a stiffness. Where a force is expected, kg means kgf: the
 * mass times 9.80665 m/s2.
 *
 * All factors except that of the degree are exact by definition, and conversion uses long double:
 * the result is within 0.502 units in the last place. A number in the wanted unit gives the same
 * double as the digits without a unit. */
#ifndef MATRIG_HOST_BASE_QUANTITY_H
#define MATRIG_HOST_BASE_QUANTITY_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

/* The reason why a text is not a quantity: "WHAT" and "ADVICE" of a message "WHAT: 'TEXT' for NAME;
 * ADVICE". */
struct quantity_error {
    char what[80];    /* "a force instead of a length" */
    char advice[200]; /* "write ft, in, mm, cm or m behind the number, or no unit for ft" */
};

/* Parses the whole text, which must not have blanks around it. `*value` is in `unit`; if that is ""
 * or NULL, the text is a number without dimension. `bare` is the unit of a text without a unit;
 * NULL: `unit`; "": a unit is required. A unit of another dimension is refused. */
bool quantity_parse(const char *text, const char *unit, const char *bare, double *value,
                    struct quantity_error *wrong);
/* As quantity_parse, but a failure sets `error`: MR_USAGE and the message "WHAT: 'TEXT' for NAME;
 * ADVICE". */
enum mr_status quantity_read(const char *text, const char *name, const char *unit, const char *bare,
                             double *value, struct error *error);
/* Reads a JSON value: either a number in `unit`, or a text that includes its unit. */
bool quantity_read_json(const json_t *json, const char *unit, double *value,
                        struct quantity_error *wrong);
/* Converts a value from unit `from` to unit `to`. Returns NaN if their dimensions differ. */
double quantity_convert(double value, const char *from, const char *to);

/* ---- the tables ---- */

/* A kind of quantity, such as "a length", and its usual units, such as "ft, in, mm, cm, m". */
struct quantity_kind {
    const char *name, *units, *si_unit;
    const char *note; /* note on one of the units; NULL: none */
};
/* Returns the kinds in order: index 0 is the first; NULL after the last. Static storage. */
const struct quantity_kind *quantity_kind_get(size_t index);
/* Finds the kind of quantity that a unit measures. NULL: the table has no such kind, or the text is
 * not a unit. */
const struct quantity_kind *quantity_kind_find(const char *unit);
/* Writes the powers of force, length and time in a unit. All are 0 if the text is not a unit or has
 * no dimension. */
void quantity_find_dimension(const char *unit, int powers[3]);
/* The spelling of a unit in the table of units: "in" for "Inches". "" if the unit is unknown. */
const char *quantity_unit_spelling(const char *text, size_t length);
/* The unit at the end of a name: "ft/s2" for "deceleration_ft_s2". "" if there is no known unit. */
const char *quantity_unit_from_name(const char *name);

#endif
