/* Quantities as people write them: the one reader for options, files and what is typed.
 *
 *     quantity = number [blanks] [unit]             "5 mm"  "5mm"  "-0.5"  "1.5e3 lb/ft"
 *     unit     = power {blank power} ["/" power]    "ft"  "lb s/ft"  "kg m2"  "1/K"
 *     power    = word ["^"] ["2" to "4"]            "m"  "m2"  "m^2"
 *
 * The words, and for each kind of quantity the units that people know of it, are the two tables of
 * quantity.c; docs/reference/units.md is made from them. Words of lengths and forces may be
 * written in capitals ("MM", "LB"), but for "M" and "Mm", where M is mega. Any product of words
 * that has the right dimension is taken: "kip/in" and "kN/mm" for a stiffness. kg alone, where a
 * force is wanted, is the weight of that mass: times 9.80665 m/s2, which is kgf.
 *
 * All factors are exact by definition, but for the degree, and a conversion is computed in long
 * double: its result is within 0.502 units in the last place. A number in the wanted unit is the
 * double that its digits stand for, as without a unit. */
#ifndef MATRIG_HOST_BASE_QUANTITY_H
#define MATRIG_HOST_BASE_QUANTITY_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

/* Why a text is none, for "WHAT: where it stands; ADVICE". */
struct quantity_wrong {
    char what[80];    /* "a force instead of a length" */
    char advice[200]; /* "write ft, in, mm, cm or m behind the number, or no unit for ft" */
};

/* The whole text, without blanks around it. `*value` is in `unit`; "" or NULL: a plain number. A
 * number without a unit is in `bare`; NULL: in `unit`; "": it needs one. Never another unit. */
bool quantity_parse(const char *text, const char *unit, const char *bare, double *value,
                    struct quantity_wrong *wrong);
/* The same; MR_USAGE, and "WHAT: 'TEXT' for NAME; ADVICE". */
enum mr_status quantity_read(const char *text, const char *name, const char *unit, const char *bare,
                             double *value, struct error *error);
/* A JSON value: a number in `unit`, or text with a unit of its own. */
bool quantity_json(const json_t *json, const char *unit, double *value,
                   struct quantity_wrong *wrong);
/* A value in `from`, in `to`. NaN: they are of different kinds. */
double quantity_convert(double value, const char *from, const char *to);

/* ---- the tables ---- */

/* What is measured: "a length", and the units that people know, "ft, in, mm, cm, m". */
struct quantity_kind {
    const char *name, *units, *si;
    const char *note; /* what is to be known of one of them; NULL: nothing */
};
/* quantity_kind_at(0) and on, NULL after the last. Static storage. */
const struct quantity_kind *quantity_kind_at(size_t index);
/* Of a unit; NULL: the table has no such kind, or the text is no unit. */
const struct quantity_kind *quantity_kind_of(const char *unit);
/* Powers of force, length and time in a unit; all 0: not a unit, or a pure number. */
void quantity_dimension(const char *unit, int powers[3]);
/* The word that the units' table has for a spelling: "in" for "Inches"; "": none. */
const char *quantity_word(const char *text, size_t length);
/* The unit that a name ends with: "ft/s2" of "deceleration_ft_s2"; "": none that is known. */
const char *quantity_unit_of_name(const char *name);

#endif
