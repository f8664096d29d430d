/* The keys of a scene: name in the file, place in struct sim_scene, unit, what is allowed. One
 * table reads and checks them, and explains them to people and programs. An
 * element that is a file of its own brings its key along (elements/element.h); elements/element.c
 * puts those at the end. */
#ifndef MATRIG_HOST_SIM_SCENE_SCENE_KEYS_H
#define MATRIG_HOST_SIM_SCENE_SCENE_KEYS_H

#include "host/sim/scene/scene.h"
#include <stdbool.h>
#include "host/base/quantity.h"
#include <stdio.h>

enum sim_key_kind {
    SIM_KEY_TEXT,
    SIM_KEY_REAL,
    SIM_KEY_INTEGER,
    SIM_KEY_CHOICE, /* an int-sized enum; `choices` in its order */
    SIM_KEY_LIST,   /* of reals */
    SIM_KEY_MATS,   /* list of mat numbers */
    SIM_KEY_JOINTS, /* one real, or a list of N+1 */
    SIM_KEY_PARTS,  /* one real, or a list with one per part of a modification (mods_check) */
    SIM_KEY_PATH    /* rows of three reals */
};

struct sim_key {
    const char *name;
    enum sim_key_kind kind;
    size_t offset;
    double low; /* of the value, or of each value of a list */
    double high;
    bool above;                 /* low itself is not allowed */
    const char *const *choices; /* ends with NULL */
    const char *unit;           /* "lb s/ft"; "" for a pure number or a name */
    const char *meaning;        /* one line for people */
    /* of an element's key: power of cos with joints laid diagonally (landing_series/scale.c) */
    int lay;
};

#define SIM_LARGEST 1e15 /* of no physical meaning: keeps products of values finite */

extern const char *const sim_models[];

/* Keys of elements; elements/element.c. */
extern const struct sim_key *const sim_element_keys[];
extern const size_t sim_element_key_count;

/* All keys, in order; NULL beyond the last. */
const struct sim_key *sim_key_at(size_t i);

/* The key with this name, or NULL. */
const struct sim_key *sim_key_find(const char *name);

/* Units of a scene's numbers: each key has its own in ft, lb, s, slug; a value may be written as
 * text with any unit of its kind (host/base/quantity.h): "ground_damping": "175 N s/m". */

/* The keys of a scene, told to programs (JSON Schema) and to people: from the table that reads and
 * checks them. */

struct json_t;

/* JSON Schema (2020-12) of a scene file; the caller's. */
struct json_t *sim_scene_schema(void);

/* One line per key: name, default, unit, meaning. */
void sim_scene_print_keys(FILE *to);

#endif
