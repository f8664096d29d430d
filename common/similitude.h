/* Similitude between prototype and model: by what factor a quantity changes with the length scale
 * n.
 *
 * A ratio is prototype / model. Lengths change by n, times by sqrt(n) (gravity is the same), forces
 * by n^3 when the materials' density is kept (the 1/7 model: 1973 report, Table 2.2) or by n^2 when
 * their stiffness is kept (the pilot model: Table B.2). Everything else follows from its dimensions
 * in F, L, T, so both tables come out of these two lines, and so do the entries they leave out
 * (stiffnesses, dampings). Pure functions. */
#ifndef MATRIG_COMMON_SIMILITUDE_H
#define MATRIG_COMMON_SIMILITUDE_H

#include <stddef.h>

enum mr_similitude_rule { MR_KEEP_DENSITY, MR_KEEP_MODULUS };

/* Powers of force, length and time in a quantity's unit. */
struct mr_dimension {
    signed char force, length, time;
};

/* A quantity by name ("soil_modulus"), its usual symbol in the report, its dimension and the unit
 * shown. */
struct mr_quantity {
    const char *name;
    const char *symbol;
    const char *unit;
    struct mr_dimension dimension;
};

extern const struct mr_quantity mr_quantities[];
extern const size_t mr_quantity_count;

/* The quantity with this name or symbol; NULL when there is none. */
const struct mr_quantity *mr_quantity_find(const char *name);

/* Power of n by which a quantity changes, in halves: 5 means n^2.5. */
int mr_similitude_half_powers(enum mr_similitude_rule rule, struct mr_dimension dimension);

/* Prototype / model, n > 0. */
double mr_similitude_ratio(enum mr_similitude_rule rule, double n, struct mr_dimension dimension);

#endif
