/* A file of points: what is known to be true, and what the converter read there.
 *
 *     displacement (mm),codes
 *     0,62.1
 *     12.7,372.4
 *     1 in,682.6
 *
 * The first line names the columns: the unit of the values, and `codes` (or counts, adc, raw, lsb).
 * So the columns may stand in either order, and values are converted to in or lb. A name that is
 * not understood wholly is refused (column.h). A value may have a unit of its own behind it. A file
 * that names no unit needs one from the caller: inches and millimetres look alike. Lines that are
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
    bool codes_first;             /* the first line names the columns in this order */
};

/* `given`: the unit that the caller was told; NULL: none. MR_IO; MR_MALFORMED: a line, or what the
 * first line says; MR_USAGE: no unit, or another one than given, or one of another kind than
 * UNIT_DISPLACEMENT or UNIT_TENSION; MR_TOO_LONG. */
enum mr_status calibrate_points_read(const char *path, enum unit_kind kind,
                                     const struct unit_word *given, struct calibrate_points *points,
                                     struct error *error);
/* A number, with a unit of that kind behind it or without; `plain`: the unit of one without, NULL:
 * it needs one. False: none of it, and `wrong` says why. */
bool calibrate_value(const char *text, enum unit_kind kind, const struct unit_word *plain,
                     double *value, struct quantity_wrong *wrong);

#endif
