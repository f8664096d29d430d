#include "host/sim/scene/scene_units.h"

#include <string.h>

#include "common/decimal.h"

#define M_PER_FT 0.3048
#define N_PER_LB 4.4482216152605 /* both exact */

static const struct {
    const char *unit, *si;
    double factor;
} units[] = {
    {"ft", "m", M_PER_FT},
    {"ft2", "m2", M_PER_FT *M_PER_FT},
    {"lb", "N", N_PER_LB},
    {"lb/ft", "N/m", N_PER_LB / M_PER_FT},
    {"lb/ft2", "N/m2", N_PER_LB / (M_PER_FT * M_PER_FT)},
    {"lb s/ft", "N s/m", N_PER_LB / M_PER_FT},
    {"ft lb", "N m", N_PER_LB *M_PER_FT},
    {"ft lb/rad", "N m/rad", N_PER_LB *M_PER_FT},
    {"ft lb s/rad", "N m s/rad", N_PER_LB *M_PER_FT},
    {"ft/s", "m/s", M_PER_FT},
    {"ft/s2", "m/s2", M_PER_FT},
    {"slug ft2", "kg m2", N_PER_LB *M_PER_FT}, /* lb s2/ft times ft2 */
};

const char *sim_unit_si(const char *unit, double *factor)
{
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
        if (strcmp(units[i].unit, unit) == 0) {
            *factor = units[i].factor;
            return units[i].si;
        }
    }
    return NULL;
}

bool sim_unit_read(const struct sim_key *key, const char *text, double *value)
{
    const char *end;
    double factor = 1.0;
    *value = mr_decimal_read(text, &end);
    if (end == text)
        return false;
    end += strspn(end, " ");
    if (strcmp(end, key->unit) == 0)
        return true;
    const char *si = sim_unit_si(key->unit, &factor);
    *value /= factor;
    return si && strcmp(end, si) == 0;
}
