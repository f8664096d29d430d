/* Chain by events: the horizontal equations of a runway, in which every switch is a moment of its
 * own (solver `event` of model chain).
 *
 * Between switches (a mat stops, starts or turns; a joint opens, closes, hooks; its dirt holds,
 * yields) the equations are linear, and u of every mat is a power series in time whose terms follow
 * from the equations one by one. A step is such a series, cut off where a term no longer counts;
 * what switches is a polynomial within it, and its first root ends the step. So no switch is
 * sampled, and the largest force of a joint is that of its polynomial.
 *
 * Only mats from the outermost moving ones to one beyond are in a step. Two runs, at two
 * tolerances, check each other: three times their largest difference is stated, and never less than
 * a share of the movement. Where they part by a thousandth of it, a third run counts too. More than
 * rtol allows (a tenth of the movement when none is given) is SIM_UNPREDICTABLE: no finer run
 * helps. */
#ifndef MATRIG_HOST_SIM_SOLVERS_CHAIN_EVENT_H
#define MATRIG_HOST_SIM_SOLVERS_CHAIN_EVENT_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* Whether this solver has all that the scene has: all but modifications. */
bool chain_event_can(const struct sim_scene *scene);

/* Runs a checked scene that it can. As chain_run (chain.h). */
enum mr_status chain_event_run(const struct sim_scene *scene, const struct sim_options *options,
                               struct sim_result *result, struct error *error);

#endif
