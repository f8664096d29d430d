/* A sweep: the varied keys and their values, the design, the base, and the wanted results
 * (README.md in this folder describes the file). A case is identified by its number, from 1 in
 * files and messages, from 0 in code. The hash of the whole file identifies the sweep to which a
 * result belongs. */
#ifndef MATRIG_HOST_SWEEP_SWEEP_H
#define MATRIG_HOST_SWEEP_SWEEP_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"

/* Access to values in JSON by a path of keys and indices, such as "max_lift_ft" or
 * "outputs.-1.u_ft.4". In a list a whole number is an index from 0; a negative number counts from
 * the end. A key that contains a dot cannot be used in a path. */

#define JSONPATH_MAX 100

/* Returns the value at the path as a borrowed reference; NULL if there is none. */
json_t *jsonpath_get(const json_t *root, const char *path);

/* Sets a copy of `value` at the path. Copies only the objects along the path; other parts remain
 * shared. If the last key does not exist yet, it is added to its object. Returns false if the path
 * does not exist. */
bool jsonpath_set(json_t *object, const char *path, json_t *value);

/* Designs of a sweep: the levels of a Cartesian product and the samples of a Latin hypercube.
 *
 * Every number is rounded to 12 significant digits, so that a sweep has the same values on
 * computers whose exp and log differ in the last bit. */

/* FNV-1a hash of `size` bytes (Fowler, Noll, Vo), continued from `hash`; start with FNV_BASIS. */
#define FNV_BASIS 0xcbf29ce484222325u
uint64_t fnv1a_hash(uint64_t hash, const void *bytes, size_t size);

/* A range of numbers, or a list of any values. */
struct design_range {
    double from, to;
    bool is_logarithmic; /* equal steps of the logarithm; from and to are above 0 */
    bool is_integer;     /* the numbers of the range are whole numbers, including both ends */
    size_t count;        /* number of steps in a range; 0: not given */
    json_t *levels;      /* list of values, which the range owns; NULL: a range */
};

/* Reads [..] or {"from":, "to":, ["count":,] ["scale": "linear"|"log"|"whole"]}. `unit`: unit of
 * the ends, which may be texts with another unit; "": only numbers are allowed. `where` begins the
 * error message: "sweep.json: vary KL". The object may have other keys, which this function
 * ignores. */
enum mr_status design_range_read(struct design_range *range, const json_t *value, const char *unit,
                                 const char *where, struct error *error);

/* Returns the i-th value as a new reference. */
json_t *design_level(const struct design_range *range, size_t i);
/* Returns the number at the fraction u of a range (not of a list). */
double design_number(const struct design_range *range, double u);

/* Fills u with one column of a design for sensitivity indices (Saltelli 2010): two Latin hypercubes
 * A and B of n points, and for each of `keys` keys a copy of A with that key's column taken from B.
 * u has n (keys + 2) values, one block after the other, for the key with index `key`. */
void design_fill_radial(double *u, size_t n, size_t keys, size_t key, uint64_t seed,
                        const char *name);

#define SWEEP_NAME_MAX  64
#define SWEEP_AXES_MAX  32
#define SWEEP_CASES_MAX 1000000

struct sweep_axis {
    char name[SWEEP_NAME_MAX];
    struct design_range range;
    /* the base's keys that are set and their factors, as an object; NULL: the key `name` is set.
     * Borrowed from the sweep's root */
    json_t *factors;
    /* values of the samples for this axis, as fractions of the range; NULL in the Cartesian part */
    double *sample_fractions;
};

/* A search for the smallest value of a key at which a field passes a level. */
struct sweep_search {
    bool is_present;
    /* the key and its range, which is searched from the low end and has no levels */
    struct sweep_axis key;
    const char *field; /* path of the field in the result */
    /* the field passes its level when it falls below it; false: when it rises above it */
    bool is_passed_downward;
    double level;
    /* Number of equal parts of the range, which are tried in ascending order until the field has
     * passed the level. */
    unsigned part_count;
    /* width at which the bisection ends, relative to the magnitude of the upper end */
    double tolerance;
    /* statuses of a run, such as "folded", that count as passing the level; NULL: none */
    const json_t *passing_statuses;
};

struct sweep {
    /* content of the file with its base inserted, so that it can be read again without other
     * files */
    json_t *root;
    json_t *base;  /* base of the sweep, borrowed from root */
    bool is_study; /* the base is a study; false: a scene */
    struct sweep_axis axis[SWEEP_AXES_MAX];
    size_t axis_count;
    size_t grid_case_count; /* number of cases in the Cartesian part */
    /* number of samples of the Latin hypercube, or of the design for the indices; otherwise 1 */
    size_t sample_count;
    /* Points of the design for sensitivity indices; `sample_count` is then points times (number of
     * sampled keys + 2). 0: no indices. */
    size_t sensitivity_point_count;
    struct sweep_search search;
    size_t case_count;
    uint64_t hash; /* hash of the sweep file and its base scene */
};

/* Reads FILE; a base given as a file is read from the folder of FILE. The first case must be valid
 * for the simulation. MR_MALFORMED: unknown key or wrong type; the message is one line that names
 * the key. After a failure there is nothing to free. */
enum mr_status sweep_load(struct sweep *sweep, const char *path, struct error *error);
void sweep_free(struct sweep *sweep);

/* Returns the varied values of a case (from 0), in the order of the file, as a new object. */
json_t *sweep_case_values(const struct sweep *sweep, size_t index);
/* Returns the scene or study of a case as a new object. NULL: a value cannot be set at the path in
 * `set`. */
json_t *sweep_case_input(const struct sweep *sweep, size_t index);
/* Returns a copy of `input` in which the searched key has a value. */
json_t *sweep_input_with_value(const struct sweep *sweep, const json_t *input, double value);
/* Returns the paths of the outputs, as an array of texts. */
const json_t *sweep_outputs(const struct sweep *sweep);

#endif
