/* Designs of a sweep: the levels of a Cartesian product and the samples of a Latin hypercube.
 *
 * Every number is rounded to 12 significant digits, so that a sweep has the same values on
 * computers whose exp and log differ in the last bit. */
#ifndef MATRIG_HOST_SWEEP_DESIGN_H
#define MATRIG_HOST_SWEEP_DESIGN_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"

/* FNV-1a of `size` bytes (Fowler, Noll, Vo), going on from `hash`; FNV_BASIS to begin. */
#define FNV_BASIS 0xcbf29ce484222325u
uint64_t fnv1a(uint64_t hash, const void *bytes, size_t size);

/* A range of numbers, or a list of any values. */
struct design_range {
    double from, to;
    bool log;       /* even steps of the logarithm; from and to above 0 */
    bool whole;     /* whole numbers, both ends among them */
    size_t count;   /* of a range that is stepped through; 0: not given */
    json_t *levels; /* NULL: a range. Owned */
};

/* From [..] or {"from":, "to":, ["count":,] ["scale": "linear"|"log"|"whole"]}; `unit`: of the
 * ends, which may be text with another; "": numbers alone. `where` begins the error: "sweep.json:
 * vary KL". The object may have other keys, which are the caller's. */
enum mr_status design_range_read(struct design_range *range, const json_t *value, const char *unit,
                                 const char *where, struct error *error);
void design_range_free(struct design_range *range);

/* How many levels it has: those of the list, or count. */
size_t design_levels(const struct design_range *range);
/* The i-th of them, a new reference. */
json_t *design_level(const struct design_range *range, size_t i);
/* At the part u of the range, 0 to 1; of a list the level that u falls on. A new reference. */
json_t *design_at(const struct design_range *range, double u);
/* The number at the part u of a range (not of a list). */
double design_number(const struct design_range *range, double u);
/* A number as JSON: whole ones as integers. */
json_t *design_json(double value);

/* Latin hypercube: n parts of [0, 1), one from each of n even strata, in random order. Depends on
 * seed and name alone, so another key more, or another order of the keys, changes nothing. */
void design_latin(double *u, size_t n, uint64_t seed, const char *name);

/* A column of a design for indices of sensitivity (Saltelli 2010): two Latin hypercubes A and B of
 * n points, and for each of `keys` keys A with that key's column from B. Block by block: u[n (keys
 * + 2)] of key number `key` from 0. */
void design_radial(double *u, size_t n, size_t keys, size_t key, uint64_t seed, const char *name);

#endif
