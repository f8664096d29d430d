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
#include "host/sweep/sweep_design.h"

#define SWEEP_NAME_MAX  64
#define SWEEP_AXES_MAX  32
#define SWEEP_CASES_MAX 1000000

/* What a case is a run of. Another kind is added here, in sweep.c's table of kinds, and in
 * sweep_case.c. */
enum sweep_kind { SWEEP_SCENE, SWEEP_STUDY };
#define SWEEP_KINDS 2
extern const char *const sweep_kind_names[SWEEP_KINDS];

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
    enum sweep_kind kind;
    struct sweep_axis axis[SWEEP_AXES_MAX];
    size_t axis_count;
    size_t grid;    /* cases of the Cartesian part */
    size_t samples; /* of the Latin hypercube or of the indices' design; 1 without */
    /* indices of sensitivity are wanted: points of the design; samples is that times sampled keys
     * and 2. 0: not */
    size_t points;
    struct sweep_find find;
    const char *solver; /* NULL: chosen */
    double rtol;        /* 0: the solver's */
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
