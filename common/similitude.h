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

/* The pi terms of section 2.1 (or B.1): products of quantities that are the same in prototype and
 * model. Powers are those of mr_pi_inputs, in that order: weight, density, gravity, length,
 * acceleration, modulus, velocity, pressure, friction, landings. */
#define MR_PI_INPUTS 10
struct mr_pi_term {
    const char *name; /* as the report writes it: "W/(rho g l^3)" */
    signed char power[MR_PI_INPUTS];
};
extern const char *const mr_pi_inputs[MR_PI_INPUTS];
extern const struct mr_pi_term mr_pi_terms[];
extern const size_t mr_pi_term_count;

/* Value of a term from the ten inputs; NaN when one that it needs is NaN. */
double mr_pi_value(const struct mr_pi_term *term, const double inputs[MR_PI_INPUTS]);

#endif
