#include "common/similitude.h"

#include <math.h>
#include <string.h>

const struct mr_quantity mr_quantities[] = {
    {"length", "l", "ft", {0, 1, 0}},
    {"area", "A", "ft2", {0, 2, 0}},
    {"time", "t", "s", {0, 0, 1}},
    {"velocity", "v", "ft/s", {0, 1, -1}},
    {"acceleration", "a", "ft/s2", {0, 1, -2}},
    {"gravity", "g", "ft/s2", {0, 1, -2}},
    {"angle", "theta", "deg", {0, 0, 0}},
    {"friction", "f", "1", {0, 0, 0}},
    {"landings", "N", "1", {0, 0, 0}},
    {"weight", "W", "lb", {1, 0, 0}},
    {"force", "F", "lb", {1, 0, 0}},
    {"moment", "M", "ft lb", {1, 1, 0}},
    {"mass", "m", "slug", {1, -1, 2}},
    {"density", "rho", "slug/ft3", {1, -4, 2}},
    {"modulus", "E", "lb/ft2", {1, -2, 0}},
    {"pressure", "p", "lb/ft2", {1, -2, 0}},
    {"soil_modulus", "k", "lb/ft3", {1, -3, 0}},
    {"inertia", "I", "slug ft2", {1, 1, 2}},
    {"stiffness", "KL", "lb/ft", {1, -1, 0}},
    {"soil_stiffness", "KV", "lb/ft", {1, -1, 0}},
    {"torsional_stiffness", "KT", "ft lb/rad", {1, 1, 0}},
    {"damping", "CL", "lb s/ft", {1, -1, 1}},
    {"soil_damping", "CV", "lb s/ft", {1, -1, 1}},
    {"torsional_damping", "CT", "ft lb s/rad", {1, 1, 1}},
    {"line_force", "q", "lb/ft", {1, -1, 0}},
};
const size_t mr_quantity_count = sizeof mr_quantities / sizeof mr_quantities[0];

const struct mr_quantity *mr_quantity_find(const char *name)
{
    for (size_t i = 0; i < mr_quantity_count; i++) {
        if (strcmp(mr_quantities[i].name, name) == 0 || strcmp(mr_quantities[i].symbol, name) == 0)
            return &mr_quantities[i];
    }
    return NULL;
}

int mr_similitude_half_powers(enum mr_similitude_rule rule, struct mr_dimension dimension)
{
    int force = rule == MR_KEEP_DENSITY ? 6 : 4;
    return force * dimension.force + 2 * dimension.length + dimension.time;
}

double mr_similitude_ratio(enum mr_similitude_rule rule, double n, struct mr_dimension dimension)
{
    return pow(n, 0.5 * mr_similitude_half_powers(rule, dimension));
}
