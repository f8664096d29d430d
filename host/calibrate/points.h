/* A file of points: what is known to be true, and what the converter read there.
 *
 *     displacement (mm),codes
 *     0,62.1
 *     12.7,372.4
 *     1 in,682.6
 *
 * The first line names the columns, in either order: `codes`, and the unit of the values, alone or
 * in brackets behind a name: mm, load (lb), displacement [in]. Values are converted to in or lb. A
 * value may have a unit of its own behind it; the column is then called `value`. Lines that are
 * empty or begin with # are passed over. */
#ifndef MATRIG_HOST_CALIBRATE_POINTS_H
#define MATRIG_HOST_CALIBRATE_POINTS_H

#include "host/calibrate/fit.h"
#include "host/base/quantity.h"
#include "host/base/units.h"

struct calibrate_points {
    struct calibrate_point point[CALIBRATE_POINTS_MAX]; /* values in in or lb */
    size_t count;
    const struct unit_word *unit; /* of values without one of their own; NULL: all had their own */
    bool codes_first;
};

/* What the name of a column says. A name is understood wholly or not at all: what could change a
 * unit would make every value another one. */
struct calibrate_column {
    bool known, codes;
    const struct unit_word *unit; /* NULL: none */
};
struct calibrate_column calibrate_column(const char *name);

/* MR_IO; MR_MALFORMED: a line, or what the first line says; MR_TOO_LONG. */
enum mr_status calibrate_points_read(const char *path, enum unit_kind kind,
                                     struct calibrate_points *points, struct error *error);
/* A number, with a unit of that kind behind it or without; `plain`: the unit of one without, NULL:
 * it needs one. False: none of it, and `wrong` says why. */
bool calibrate_value(const char *text, enum unit_kind kind, const struct unit_word *plain,
                     double *value, struct quantity_wrong *wrong);

#endif
