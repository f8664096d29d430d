/* Planar: running a scene of the report model or the consistent model with any solver, and checking
 * the answer.
 *
 * Every scene is run twice. A solver that chooses its step runs at its tolerance and at 30 times
 * that; the answer is the finer run. A fixed step runs at dt and at dt/1.9; the answer is the run
 * at dt if dt was given, otherwise the finer one. (Not dt/2: then steps of both runs end at the
 * same times and sample the switches in the same way.) The error estimate is the largest difference
 * between the two runs: for u over all mats, at 64 equally spaced times and at t_out; for lift over
 * the same times and the maximum of each run. It is at least the tolerance times L for anything
 * that moves. Two runs can agree by chance, and they share errors of their solver: planar.c
 * describes the additional checks.
 *
 * The first two runs must agree within a fifth (of the largest movement, of the lift) and on
 * whether there is a bow wave. Otherwise an automatic tolerance is reduced by a factor of 100, at
 * most twice, and then the result is `unpredictable`; it is `unstable` if the step or tolerance was
 * given. A fixed step beyond the stability limit of the equations with every node on the ground is
 * refused before the run, because its result can look right.
 *
 * Solver auto: if its first solver makes no progress, the other one is tried, then hamming, which
 * samples switches that accumulate, then moreau, which solves them in one step. These later solvers
 * have one minute together; if none succeeds, the run is refused for the reason of the first one. A
 * landing for which no step of staggered gives a result is run with event and implicit, if they
 * support its laws. */
#ifndef MATRIG_HOST_SIM_SOLVERS_PLANAR_H
#define MATRIG_HOST_SIM_SOLVERS_PLANAR_H

#include "host/sim/models/model.h"
#include "host/sim/scene/result.h"
#include "host/sim/solvers/pass.h"

/* Wall-clock time, s, of all solvers together that auto tries after its first one. */
#define PLANAR_OTHER_SOLVERS_S 60.0

/* Returns true if sim_run has a solver of this name for planar models ("auto" included). */
bool planar_has_solver(const char *name);

/* Runs a checked scene. MR_OK: the run ended, see result->status. The caller frees the result in
 * every case. */
enum mr_status planar_run(const struct sim_scene *scene, const struct sim_options *options,
                          struct sim_result *result, struct error *error);

/* A deadline stops a run after a wall-clock time. Solvers call its options.may_continue, which also
 * calls the caller's. */
struct deadline {
    const struct sim_options *requested_options;
    /* Options for the solver: those of the caller, with the time limit. */
    struct sim_options options;
    double until_s;   /* time at which the limit ends, on the clock of the options */
    bool is_exceeded; /* true: the deadline has stopped the run */
};

/* Starts a limit of limit_s seconds on asked->clock_s. 0: no limit, and the options are those of
 * the caller. The deadline must exist while its options are in use. The caller owns `asked`. */
void deadline_begin(struct deadline *deadline, const struct sim_options *asked, double limit_s);

#endif
