/* Chain draw: scenes of the chain's part of the stability study. README.md, "The chain". */
#ifndef MATRIG_TESTS_STABILITY_CHAIN_DRAW_H
#define MATRIG_TESTS_STABILITY_CHAIN_DRAW_H

#include <stdint.h>

#include "host/sim/scene/scene.h"

#define CHAIN_MATS    60
#define CHAIN_OUTPUTS 64

enum chain_kind {
    CHAIN_ROW,   /* thrown or pushed mats in a row, with and without slack */
    CHAIN_RIG,   /* rows of the rig under a braking aircraft: slack, gaps and grit of each joint */
    CHAIN_BOX,   /* between walls, with play, without losses */
    CHAIN_PULSE, /* a short pulse in a long run */
    CHAIN_LATE,  /* a push after a long wait, a throw in a long run */
    CHAIN_LIMIT, /* thrust at the limit of friction */
    CHAIN_GEAR,  /* gear on elastic ground */
    CHAIN_OTHER, /* friction tanh or none, ground damping */
    CHAIN_KINDS
};
extern const char *const chain_kind_names[CHAIN_KINDS];

/* Scene `index`; the caller frees it. Returns its kind. */
enum chain_kind chain_draw(struct sim_scene *scene, size_t index, uint64_t seed);

#endif
