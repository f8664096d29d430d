/* Chain reference: the chain model's equations of motion (host/sim/README.md, "Common pieces" and
 * "Chain and landings"), solved a second time. Shares only the scene with host/sim.
 *
 * Between two switches the equations have constant coefficients, so the motion of every mat is its
 * Taylor series in time. A step sums that series to a given order; its length follows from the last
 * terms. A switch (joint, grit, friction, elastic ground) is the first zero of a polynomial, which
 * Bernstein coefficients isolate and halving narrows to 2^-50 of the step: no zero is missed
 * because two fall in one step. What the wheel does (hops, rows of the path, end of thrust) is
 * computed beforehand. README.md, "The chain". Units ft, lb, s, slug. */
#ifndef MATRIG_TESTS_STABILITY_CHAIN_REFERENCE_H
#define MATRIG_TESTS_STABILITY_CHAIN_REFERENCE_H

#include <stdbool.h>
#include <stdint.h>

#include "host/sim/scene/scene.h"

#define CHAIN_REFERENCE_MATS  430
#define CHAIN_REFERENCE_ORDER 24

struct chain_reference {
    int order;           /* 8 to CHAIN_REFERENCE_ORDER */
    double tolerance_ft; /* of the last term of a step's series */
    uint64_t most_steps;
    double *push_lb, *pull_lb; /* by joint 1 to mats + 1: largest compression, tension; or NULL */
    /* the answer */
    uint64_t steps, switches;
    double t_s; /* where it stopped, when it did not answer */
};

/* Run a scene of model chain without modifications and with law stick, tanh or none. u_ft:
 * t_out.count rows of mats + 1 values, by mat from 1. False: the scene is beyond the reference, or
 * it took too many steps, or switches followed each other without end. */
bool chain_reference_run(struct chain_reference *run, const struct sim_scene *scene, double *u_ft);
/* The same in long double, several times slower: for scenes that magnify roundings. */
bool chain_reference_run_long(struct chain_reference *run, const struct sim_scene *scene,
                              double *u_ft);

#endif
