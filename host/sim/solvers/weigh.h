/* Weigh: how far an answer can be from the truth, from two passes of its solver and from what joins
 * them. PLANAR.md, "What an answer is worth". */
#ifndef MATRIG_HOST_SIM_SOLVERS_WEIGH_H
#define MATRIG_HOST_SIM_SOLVERS_WEIGH_H

#include "host/sim/models/model.h"
#include "host/sim/scene/options.h"
#include "host/sim/solvers/pass.h"

/* Between the tolerances of two passes. */
#define WEIGH_CHECK_FACTOR   30.0
/* Between two fixed steps. Not 2: the shorter steps would end wherever the longer ones do, and
 * every other switch would be sampled at the same moment in both. */
#define WEIGH_GRID_RATIO     1.9
#define WEIGH_FIRST_PART     0.72 /* the same of steps that are halved and doubled: the first one */
#define WEIGH_LEAST_RTOL     1e-13
/* Where the negative real axis leaves the classical method's stability region, and, about, the
 * order 8 method's. */
#define WEIGH_RK4_REAL       2.785
#define WEIGH_EXPLICIT_REACH 6.0
#define WEIGH_EXPLICIT_STEPS 10000.0 /* more than these for stability alone: implicit */
#define WEIGH_STEP_RATIO     4.0     /* a step of implicit costs as much as so many of event */

/* The runs of one scene with one solver: a coarse one and a fine one, complete, and a third. */
struct weigh_pair {
    struct pass_outcome coarse, fine, third;
    struct pass_request check, request; /* of coarse and fine */
    bool coarse_answers;
};

/* Whether the solver is auto's to choose. */
bool weigh_automatic(const struct sim_options *options);
/* Steps of event that the stability limit alone asks for. */
double weigh_explicit_steps(const struct model *model, const struct sim_result *result);

/* Take what a pass has cost into the result. */
void weigh_cost(struct sim_result *result, const struct pass_outcome *pass);

/* The error estimate of the result, with more runs where it needs them; false when the two passes
 * contradict each other, or for want of memory (error). `where`: their largest difference. */
bool weigh_runs(struct model *model, const struct sim_options *options, struct weigh_pair *runs,
                struct sim_result *result, struct sim_difference *where, struct error *error);

#endif
