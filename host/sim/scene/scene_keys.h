/* The keys of a scene: name in the file, place in struct sim_scene, what is allowed. One table reads and
 * checks them. */
#ifndef MATRIG_HOST_SIM_SCENE_SCENE_KEYS_H
#define MATRIG_HOST_SIM_SCENE_SCENE_KEYS_H

#include "host/sim/scene/scene.h"

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
};

extern const struct sim_key sim_keys[];
extern const size_t sim_key_count;

/* The first key with this name, or NULL. */
const struct sim_key *sim_key_find(const char *name);

#endif
