/* A file of calibration points: known values and the converter's readings.
 *
 *     displacement (mm),codes
 *     0,62.1
 *     12.7,372.4
 *     1 in,682.6
 *
 * The first line names the columns, in either order: `codes`, and the unit of the values. The unit
 * is the column name or follows a name in brackets: mm, load (lb), displacement [in]. Values are
 * converted to in or lb. A unit may follow each value; the column may then be named `value`. Empty
 * lines and lines that begin with # are skipped. */
#ifndef MATRIG_HOST_CALIBRATE_POINTS_H
#define MATRIG_HOST_CALIBRATE_POINTS_H

#include "host/calibrate/fit.h"
#include "host/base/quantity.h"
#include "host/base/units.h"

struct calibrate_points {
    /* points in order, with values in in or lb */
    struct calibrate_point point[CALIBRATE_POINTS_MAX];
    size_t count;
    const struct unit_word *unit; /* unit of values without a unit; NULL: every value has a unit */
    bool are_codes_first;
};

/* Meaning of a column name. An unknown name is refused, because a wrong unit would change every
 * value. */
struct calibrate_column {
    bool is_known, is_codes;
    const struct unit_word *unit; /* NULL: no unit */
};
struct calibrate_column calibrate_column_parse(const char *name);

/* Reads a file of points. MR_IO: it cannot be read. MR_MALFORMED: invalid line or column names.
 * MR_TOO_LONG: too many points. */
enum mr_status calibrate_points_read(const char *path, enum unit_kind kind,
                                     struct calibrate_points *points, struct error *error);
/* Reads a number, with or without a unit of that kind. `plain`: unit of a number without a unit;
 * NULL: a unit is required. Returns false if the text is invalid; `wrong` has the reason. */
bool calibrate_value_parse(const char *text, enum unit_kind kind, const struct unit_word *plain,
                           double *value, struct quantity_error *wrong);

#endif
