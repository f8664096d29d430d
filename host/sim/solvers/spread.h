/* Spread: what is left to say of a scene that no finer step or tolerance decides.
 *
 * Runs that should be alike part: each switch that falls otherwise makes their difference larger,
 * and from some time on it is as large as what is computed. Then runs whose stiffnesses differ by
 * less than anybody knows them, SPREAD_PART, say how far apart the scene's answers can be. The
 * result is SIM_UNPREDICTABLE: t_s and mat are where the first two of all runs part (by more than a
 * fifth of the largest movement or lift), the error estimates the largest difference of any of
 * them to the one whose numbers are given. */
#ifndef MATRIG_HOST_SIM_SOLVERS_SPREAD_H
#define MATRIG_HOST_SIM_SOLVERS_SPREAD_H

#include "host/sim/solvers/pass.h"

#define SPREAD_PART 1e-9
#define SPREAD_RUNS 4 /* besides those that part */

/* Take two records apart at the first time they differ by more than these: widens the estimates,
 * and t_s and mat when that is earlier than what the result has. */
void spread_part(struct sim_result *result, const struct sim_record *given,
                 const struct sim_record *other, double most_u_ft, double most_lift_ft);

/* One pass of the scene, known a little otherwise: run 0 to SPREAD_RUNS - 1. */
enum mr_status spread_nudged(const struct model *model, const struct pass_request *request,
                             const struct sim_options *options, int run, struct pass_outcome *pass,
                             struct sim_result *result, struct error *error);

/* Passes that contradict each other, both complete: `given` is the one whose numbers are taken.
 * MR_FULL. */
enum mr_status spread_run(const struct model *model, const struct pass_request *request,
                          const struct sim_options *options, const struct pass_outcome *given,
                          const struct pass_outcome *other, struct sim_result *result,
                          struct error *error);

#endif
