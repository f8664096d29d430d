/* Error estimate: how far an answer can be from the truth, from two passes of its solver and from
 * the runs that join them. PLANAR.md, "What an answer is worth". */
#ifndef MATRIG_HOST_SIM_SOLVERS_ERROR_ESTIMATE_H
#define MATRIG_HOST_SIM_SOLVERS_ERROR_ESTIMATE_H

#include "host/sim/models/model.h"
#include "host/sim/scene/result.h"
#include "host/sim/solvers/pass.h"

/* How far two complete passes of a scene differ, and whether they contradict each other. */
struct pass_difference {
    struct sim_difference u;
    double lift_ft;
};

struct pass_difference pass_difference(const struct pass_outcome *a, const struct pass_outcome *b);

/* False when they contradict each other: by a fifth of the largest movement or lift, or in whether
 * there is a bow wave. */
bool passes_agree(const struct sim_scene *scene, const struct pass_outcome *a,
                  const struct pass_outcome *b, struct pass_difference apart);

/* Divergence: a scene that no finer step or tolerance decides.
 *
 * Runs that should be alike part: each switch that falls otherwise makes their difference larger,
 * and from some time on it is as large as what is computed. Then runs whose stiffnesses differ by
 * less than anybody knows them, DIVERGENCE_PART, say how far apart the scene's answers can be. The
 * result is SIM_UNPREDICTABLE: t_s and mat are where the first two of all runs part (by more than a
 * fifth of the largest movement or lift), the error estimates the largest difference of any of
 * them to the one whose numbers are given. */
#define DIVERGENCE_PART 1e-9
#define DIVERGENCE_RUNS 4 /* besides those that part */

/* Take two records apart at the first time they differ by more than these: widens the estimates,
 * and t_s and mat when that is earlier than what the result has. */
void divergence_find(struct sim_result *result, const struct sim_record *given,
                     const struct sim_record *other, double most_u_ft, double most_lift_ft);

/* Passes that contradict each other, both complete: `given` is the one whose numbers are taken. */
void divergence_state(const struct model *model, const struct pass_request *request,
                      const struct sim_options *options, const struct pass_outcome *given,
                      const struct pass_outcome *other, struct sim_result *result);

/* Between the tolerances of two passes. */
#define ESTIMATE_CHECK_FACTOR   30.0
/* Between two fixed steps. Not 2: the shorter steps would end wherever the longer ones do, and
 * every other switch would be sampled at the same moment in both. */
#define ESTIMATE_GRID_RATIO     1.9
#define ESTIMATE_FIRST_PART     0.72 /* the first of steps that are halved and doubled */
#define ESTIMATE_LEAST_RTOL     1e-13
/* Where the negative real axis leaves the classical method's stability region, and, about, the
 * order 8 method's. */
#define ESTIMATE_RK4_REAL       2.785
#define ESTIMATE_EXPLICIT_REACH 6.0
#define ESTIMATE_EXPLICIT_STEPS 10000.0 /* more than these for stability alone: implicit */
#define ESTIMATE_STEP_RATIO     4.0     /* a step of implicit costs as much as so many of event */

/* The runs of one scene with one solver: a coarse one and a fine one, complete, and a third. */
struct error_pair {
    struct pass_outcome coarse, fine, third;
    struct pass_request check, request; /* of coarse and fine */
    bool coarse_answers;
};

/* Whether the solver is auto's to choose. */
bool solver_is_automatic(const struct sim_options *options);
/* Steps of event that the stability limit alone asks for. */
double explicit_steps(const struct model *model, const struct sim_result *result);

/* Take what a pass has cost into the result. */
void cost_add(struct sim_result *result, const struct pass_outcome *pass);

/* The error estimate of the result, with more runs where it needs them; false when the two passes
 * contradict each other. `where`: their largest difference. */
bool error_estimate(struct model *model, const struct sim_options *options, struct error_pair *runs,
                    struct sim_result *result, struct sim_difference *where);

#endif
