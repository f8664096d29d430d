/* moreau's runs and its stated error. The method: moreau.c.
 *
 * A scene is run with steps 1.9 times shorter each time, until the stated error is below a
 * ten-thousandth of what moves and of what lifts, or the work is done that MOREAU_WORK allows. The
 * answer is the run with the shortest steps. Its method is of order 1 where anything switches, so
 * the shortest steps' error is 1.1 times the last difference, 2.6 times for order 1/2: stated is
 * three times the larger of the last difference and of the one before divided by 1.9, so that runs
 * that are close by chance are not believed. Runs that contradict each other with the shortest
 * steps are `unpredictable` (spread.h). With a given step: that, 1.9 and 3.6 times it. */
#ifndef MATRIG_HOST_SIM_SOLVERS_MOREAU_H
#define MATRIG_HOST_SIM_SOLVERS_MOREAU_H

#include "host/sim/models/model.h"
#include "host/sim/scene/options.h"

#define MOREAU_WORK 1.5e7 /* evaluations times mats: some 10 s */

/* MR_OK: look at result->status. Friction `sign` is solved as its exact form, `stick`. */
enum mr_status moreau_run(const struct model *model, const struct sim_options *options,
                          struct sim_result *result, struct error *error);

#endif
