/* Apart: how far two complete passes of a scene differ, and whether they contradict each other. */
#ifndef MATRIG_HOST_SIM_SOLVERS_APART_H
#define MATRIG_HOST_SIM_SOLVERS_APART_H

#include "host/sim/solvers/pass.h"

struct apart {
    struct sim_difference u;
    double lift_ft;
};

struct apart apart_of(const struct pass_outcome *a, const struct pass_outcome *b);

/* False when they contradict each other: by a fifth of the largest movement or lift, or in whether
 * there is a bow wave. */
bool apart_agree(const struct sim_scene *scene, const struct pass_outcome *a,
                 const struct pass_outcome *b, struct apart apart);

#endif
