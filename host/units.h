/* Units for people: the report's (ft, in, lb) or, with --si, metres, millimetres and newtons. Inside,
 * everything is in the report's units; conversion happens once, where a value is shown. */
#ifndef MATRIG_HOST_UNITS_H
#define MATRIG_HOST_UNITS_H

#include <stdbool.h>

enum unit_kind { UNIT_STATION, UNIT_DISPLACEMENT, UNIT_SPEED, UNIT_DECELERATION, UNIT_TENSION, UNIT_KINDS };

struct unit {
    const char *text;   /* "ft/s2" */
    const char *suffix; /* of a name: "ft_s2" */
    double factor;      /* multiply a value in the report's unit by it */
};

const struct unit *unit_of(enum unit_kind kind, bool si);
/* What rounds to 0 at this least digit, without a sign. */
double unit_tidy(double value, double least);

#endif
