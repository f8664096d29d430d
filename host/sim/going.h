/* Going: a run that takes long says so, how far it is, and what would be quicker. For
 * sim_options.go_on of whoever runs scenes for people. */
#ifndef MATRIG_HOST_SIM_GOING_H
#define MATRIG_HOST_SIM_GOING_H

#include <stdio.h>

#include "host/sim/scene/options.h"
#include "host/sim/scene/scene.h"

#define SIM_GOING_S 30.0 /* between two lines; a minute without one is too long */

struct sim_going {
    const char *who;                   /* the command: "sim" */
    const char *quicker;               /* what else there is to do: "--limit S ends it"; "" */
    FILE *to;                          /* NULL: nothing is said */
    const struct sim_options *options; /* whose clock it is; borrowed */
    double begin_s, next_s, end_s;     /* on the clock; of the scene */
};

/* Counting begins now, on options->clock_s. */
void sim_going_begin(struct sim_going *going, const struct sim_options *options,
                     const struct sim_scene *scene);
/* As sim_options.go_on with a struct sim_going: always goes on. */
bool sim_going_on(void *going, int pass_from_1, double part);

#endif
