/* Runs a scene of the report model or the consistent model with any solver, and checks the result.
 *
 * Every scene is run twice. A solver that chooses its step runs with its tolerance and with 30
 * times its tolerance; the result is the first of these runs. A solver with a fixed step runs with
 * dt and with dt/1.9; the result is the run with dt if dt was given, otherwise the other one. (With
 * dt/2, steps of both runs would end at the same times, and both runs would sample the switches in
 * the same way.) The error estimate is the largest difference between the two runs: for u over all
 * mats, at 64 equally spaced times and at t_out; for lift over the same times and the maximum of
 * each run. It is at least the tolerance times L for anything that moves. Two runs can agree by
 * chance, and they share errors of their solver: planar.c describes the additional checks.
 *
 * The first two runs must agree within a fifth of the largest movement or lift, and on whether
 * there is a bow wave. Otherwise an automatic tolerance is reduced by a factor of 100, at most
 * twice, and then the result is `unpredictable`; it is `unstable` if the step or tolerance was
 * given. A fixed step beyond the stability limit of the equations with every node on the ground is
 * refused before the run, because its result can look right.
 *
 * Solver auto begins with event or implicit. If this solver makes no progress, it tries the other
 * one, then hamming, which samples switches, then moreau, which solves any number of switches in
 * one step. These later solvers have one minute in all; if none succeeds, the error of the first
 * solver is reported. A landing for which no step of staggered gives a result is run with event and
 * implicit, if they support its laws. */
#ifndef MATRIG_HOST_SIM_SOLVERS_PLANAR_H
#define MATRIG_HOST_SIM_SOLVERS_PLANAR_H

#include "host/sim/models/model.h"
#include "host/sim/scene/result.h"
#include "host/sim/solvers/pass.h"

/* Time limit, in s of real time, for all solvers together that `auto` tries after its first one. */
#define PLANAR_OTHER_SOLVERS_S 60.0

/* Returns true if sim_run has a solver of this name for planar models ("auto" included). */
bool planar_has_solver(const char *name);

/* Runs a checked scene. MR_OK: the run ended, see result->status. The caller frees the result in
 * every case. */
enum mr_status planar_run(const struct sim_scene *scene, const struct sim_options *options,
                          struct sim_result *result, struct error *error);

/* A deadline stops a run after a given real time. Solvers call its options.may_continue, which
 * calls the caller's function too. */
struct deadline {
    const struct sim_options *caller_options;
    /* options for the solver: the caller's options with the time limit added */
    struct sim_options options;
    double until_s;   /* time at which the limit ends, on the clock of the options */
    bool is_exceeded; /* true: the deadline has stopped the run */
};

/* Starts a time limit of limit_s seconds, measured with caller_options->clock_s. With 0 there is no
 * limit, and `options` is a copy of the caller's options. The deadline must exist while its options
 * are in use. The caller owns `caller_options`. */
void deadline_begin(struct deadline *deadline, const struct sim_options *caller_options,
                    double limit_s);

#endif
