/* A real of the configuration as people may write it: with a unit of its kind, as in `2540 mm` for
 * a field in ft. What is written for people and what a board gets is always in the field's own. */
#ifndef MATRIG_HOST_BOARD_CONFIGUNITS_H
#define MATRIG_HOST_BOARD_CONFIGUNITS_H

#include <stdbool.h>

#include "host/base/quantity.h"

/* Of which kind of channel a unit was that was written. A field of a channel is in in of a
 * transducer, in lb of a gage ("in or lb per h"): which one it is may stand in a later line. */
enum configunits_of { CONFIGUNITS_NONE, CONFIGUNITS_ANY, CONFIGUNITS_LENGTH, CONFIGUNITS_FORCE };

/* The value at *p, and *p behind it: the rest of the line up to a `#`, or with `list` up to the
 * next value. `unit`: the field's, as config.def has it. `missing` is NaN. Without a unit the value
 * is the float that its digits stand for. */
bool configunits_read(const char **p, const char *unit, bool list, float *value,
                      enum configunits_of *of, struct quantity_wrong *wrong);
/* What a channel's field is in, of a transducer or of a gage: "in/h". */
void configunits_own(const char *unit, enum configunits_of of, char out[40]);

#endif
