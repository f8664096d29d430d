/* Options: how a scene is to be run. */
#ifndef MATRIG_HOST_SIM_SCENE_OPTIONS_H
#define MATRIG_HOST_SIM_SCENE_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

/* All zero: choose everything. */
struct sim_options {
    /* NULL or "auto": chosen, the result says why. Chain: "staggered"; else stepper.h has names */
    const char *solver;
    /* of a fixed step. 0: half the stability limit, halved when the check (staggered.h) asks */
    double dt_s;
    /* planar models: tolerance of the step control. Chain: error estimate allowed, as a share of
     * the largest |u|; halves the step until met */
    double rtol;
    bool no_prune; /* integrate every mat all the time */
    /* solver staggered: one pass, no error estimate (0) and no check but that of stability. For
     * ensembles whose spread is far larger than a pass's error; the step is dt, or half the
     * stability limit */
    bool single;
    /* landings with heights: note where the wheel meets nodes that have risen so far; 0: not */
    double overrun_ft;
    /* Called now and then: how much of the pass is done, 0 to 1. False stops the run:
     * SIM_INTERRUPTED. NULL: never. */
    bool (*go_on)(void *ctx, int pass_from_1, double part);
    void *go_on_ctx;
    /* After so much time on the clock the run is stopped: SIM_INTERRUPTED. 0: never. What auto
     * tries after its first solver has a limit of its own (planar.h) */
    double limit_s;
    double (*clock_s)(void *ctx); /* seconds that only grow; NULL: host/base/monotonic_clock.h's */
    void *clock_ctx;
    double sample_dt_s; /* 0: no samples */
    /* where to sample: the mat that begins at the station or lies over it */
    const double *station_ft;
    size_t station_count;
};

#endif
