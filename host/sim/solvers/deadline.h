/* Deadline: options that stop a run after a while on the clock. Solvers ask them as they ask the
 * caller whether to go on (sim_options.go_on), who is asked too. */
#ifndef MATRIG_HOST_SIM_SOLVERS_DEADLINE_H
#define MATRIG_HOST_SIM_SOLVERS_DEADLINE_H

#include "host/sim/scene/options.h"

struct deadline {
    const struct sim_options *asked;
    struct sim_options options; /* for the solver: those asked for, but stopped in time */
    double until_s;             /* on the clock */
    bool late;                  /* it stopped the run */
};

/* From now on for limit_s of asked->clock_s; 0: no limit, the options are those asked for. The
 * deadline is referred to while its options are in use; `asked` stays the caller's. */
void deadline_begin(struct deadline *deadline, const struct sim_options *asked, double limit_s);

#endif
