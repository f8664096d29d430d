/* Solver `event` of model chain: solves the horizontal equations of a runway and finds the exact
 * time of every switch (change of mode).
 *
 * Between switches (a mat stops, starts or turns; a joint opens, closes or hooks; its grit holds or
 * yields) the equations are linear, and the displacement u of every mat is a power series in time,
 * whose terms are computed from the equations one after another. A step is such a series, truncated
 * where further terms are negligible. A switch condition is a polynomial within the step, and its
 * first root ends the step. Switches are therefore exact in time, and the largest force of a joint
 * is the largest value of its polynomial.
 *
 * A step includes only the mats from the outermost moving ones to one mat beyond. Two runs, at two
 * tolerances, check each other: the stated error is three times their largest difference, but at
 * least a fixed fraction of the movement. If they differ by a thousandth of the movement, a third
 * run is included. If the error exceeds rtol (default: a tenth of the movement), the result is
 * SIM_UNPREDICTABLE: a finer run does not help. */
#ifndef MATRIG_HOST_SIM_SOLVERS_CHAIN_EVENT_H
#define MATRIG_HOST_SIM_SOLVERS_CHAIN_EVENT_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* Returns true if this solver supports the scene: all features except modifications. */
bool chain_event_is_supported(const struct sim_scene *scene);

/* Runs a checked scene for which chain_event_is_supported is true. Result and statuses are those of
 * chain_run (chain.h). */
enum mr_status chain_event_run(const struct sim_scene *scene, const struct sim_options *options,
                               struct sim_result *result, struct error *error);

#endif
