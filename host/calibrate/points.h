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

/* Meaning of a column's name. A name is understood completely or refused: a misread unit would
 * change every value. */
struct calibrate_column {
    bool known, codes;
    const struct unit_word *unit; /* NULL: none */
};
struct calibrate_column calibrate_column(const char *name);

/* MR_IO; MR_MALFORMED: a line, or the first line's names; MR_TOO_LONG. */
enum mr_status calibrate_points_read(const char *path, enum unit_kind kind,
                                     struct calibrate_points *points, struct error *error);
/* A number, with or without a unit of that kind; `plain`: the unit of one without, NULL: it needs
 * one. False: invalid, and `wrong` has the reason. */
bool calibrate_value(const char *text, enum unit_kind kind, const struct unit_word *plain,
                     double *value, struct quantity_wrong *wrong);

#endif
