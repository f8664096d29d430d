/* March: the chain, grit included, by a second method to hold `staggered` to: classical Runge-Kutta
 * with every switch located.
 *
 * Independent of solvers/staggered.c, models/chain.c and elements/: the same equations (README.md,
 * "Chain and landings"; elements/joint.h on grit), another method, and no code of theirs for
 * joints, grit and friction; only the thrust (elements/wheel.h) is the planar models'. What is a
 * row of elements/element.h is refused, as nothing here has such a force a second time. Joints
 * have modes (hooked, open, held by grit, grit giving way, pressed together) and mats have modes
 * (stuck, sliding either way), within which the right-hand side is smooth but for the clamp on
 * what grit holds. A step whose end does not fit a mode is shortened to the earliest such moment,
 * to 1e-9 s, and the mode changed there. Stuck mats outside the outermost moving ones are left
 * alone; the force on the first on either side is watched.
 *
 * Friction stick or none. Units ft, s, lb. */
#ifndef MATRIG_HOST_SIM_CHECK_ERROR_MARCH_H
#define MATRIG_HOST_SIM_CHECK_ERROR_MARCH_H

#include "host/sim/solvers/record.h"

struct march_cost {
    uint64_t steps, rhs, events;
    double ms;
    bool stalled; /* switches without progress: the record is not complete */
    double t_s;
};

/* Run a checked scene of model chain with steps of at most dt_s. MR_USAGE for another friction.
 * Whoever asked frees the record in every case. */
enum mr_status march_run(struct sim_record *record, struct march_cost *cost,
                         const struct sim_scene *scene, double dt_s, struct error *error);

#endif
