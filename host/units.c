#include "host/units.h"

#include <math.h>

/* 1 ft = 0.3048 m, 1 in = 25.4 mm, 1 lb = 4.4482216152605 N: exact by definition. */
static const struct unit units[2][UNIT_KINDS] = {
    {{"ft", "ft", 1.0}, {"in", "in", 1.0}, {"ft/s", "ft_s", 1.0}, {"ft/s2", "ft_s2", 1.0}, {"lb", "lb", 1.0}},
    {{"m", "m", 0.3048},
     {"mm", "mm", 25.4},
     {"m/s", "m_s", 0.3048},
     {"m/s2", "m_s2", 0.3048},
     {"N", "N", 4.4482216152605}},
};

const struct unit *unit_of(enum unit_kind kind, bool si)
{
    return &units[si][kind];
}

double unit_tidy(double value, double least)
{
    return fabs(value) < 0.5 * least ? 0.0 : value;
}
