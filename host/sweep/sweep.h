/* A sweep: what is varied, how, on what, and which results are wanted (README.md here: the file). A
 * case is named by its number, from 1 in files and messages, from 0 in code; the hash of the whole
 * file tells its results from those of another sweep. */
#ifndef MATRIG_HOST_SWEEP_SWEEP_H
#define MATRIG_HOST_SWEEP_SWEEP_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"

/* Values inside JSON by a path of keys and places: "max_lift_ft", "outputs.-1.u_ft.4". In a list a
 * whole number is a place from 0, a negative one counts from the end. Keys that hold a dot cannot
 * be named. */

#define JSONPATH_MAX 100

/* Borrowed; NULL when there is nothing. */
json_t *jsonpath_get(const json_t *root, const char *path);

/* Puts a copy of `value` there. The object keeps sharing what it shared: only what the path goes
 * through is copied. A last key that is not there yet is added to its object. False: the path leads
 * nowhere. */
bool jsonpath_set(json_t *object, const char *path, json_t *value);

/* Designs of a sweep: the levels of a Cartesian product and the samples of a Latin hypercube.
 *
 * Every number is rounded to 12 significant digits, so that a sweep has the same values on
 * computers whose exp and log differ in the last bit. */

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

/* The i-th of them, a new reference. */
json_t *design_level(const struct design_range *range, size_t i);
/* The number at the part u of a range (not of a list). */
double design_number(const struct design_range *range, double u);

/* A column of a design for indices of sensitivity (Saltelli 2010): two Latin hypercubes A and B of
 * n points, and for each of `keys` keys A with that key's column from B. Block by block: u[n (keys
 * + 2)] of key number `key` from 0. */
void design_radial(double *u, size_t n, size_t keys, size_t key, uint64_t seed, const char *name);

#define SWEEP_NAME_MAX  64
#define SWEEP_AXES_MAX  32
#define SWEEP_CASES_MAX 1000000

struct sweep_axis {
    char name[SWEEP_NAME_MAX];
    struct design_range range;
    /* object: keys of the base and the factors that the value is put there with; NULL: the key
     * `name`, the value itself. Borrowed from the sweep's root */
    json_t *set;
    double *u; /* sampled: u[sample]; NULL in the Cartesian part */
};

/* The smallest value of a key for which a field is beyond a level. */
struct sweep_find {
    bool wanted;
    struct sweep_axis key; /* its range, from the low end up; no levels */
    const char *field;     /* path in the result */
    bool below;            /* the field must be below the level, else above it */
    double level;
    /* even parts of the range that are gone through upwards until the field is beyond */
    unsigned scan;
    double tolerance;          /* width of the bracket, as a share of its upper end's size */
    const json_t *beyond_when; /* statuses that count as beyond, such as "folded"; NULL: none */
};

struct sweep {
    json_t *root; /* the file, with its base put in: enough to be read again */
    json_t *base; /* borrowed from root */
    bool study;   /* the base is a study, else a scene */
    struct sweep_axis axis[SWEEP_AXES_MAX];
    size_t axis_count;
    size_t grid;    /* cases of the Cartesian part */
    size_t samples; /* of the Latin hypercube or of the indices' design; 1 without */
    /* indices of sensitivity are wanted: points of the design; samples is that times sampled keys
     * and 2. 0: not */
    size_t points;
    struct sweep_find find;
    size_t cases;
    uint64_t hash; /* of the file with its base */
};

/* Reads FILE; a base that is a file is looked for beside FILE. The first case must be acceptable to
 * the simulation; unknown keys, wrong types: MR_MALFORMED, one line that names the key. On failure
 * there is nothing to free. */
enum mr_status sweep_load(struct sweep *sweep, const char *path, struct error *error);
void sweep_free(struct sweep *sweep);

/* The varied values of a case (from 0), in the file's order: a new object. */
json_t *sweep_values(const struct sweep *sweep, size_t index);
/* The scene (or study) of a case: a new object. NULL: a value cannot be put where `set` says. */
json_t *sweep_input(const struct sweep *sweep, size_t index);
/* The same with the searched key at a value; `input` is not changed. */
json_t *sweep_input_at(const struct sweep *sweep, const json_t *input, double value);
/* Paths of the outputs: an array of text. */
const json_t *sweep_outputs(const struct sweep *sweep);

#endif
