/* Running a scene. */
#ifndef MATRIG_HOST_SIM_SIM_H
#define MATRIG_HOST_SIM_SIM_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* All zero: choose everything. */
struct sim_options {
    const char *solver; /* NULL or "auto": chosen, the result says why. Chain: "fixed"; else stepper.h has the names */
    double dt_s;        /* of a fixed step. 0: half the stability limit, halved when the check (fixed.h) asks for it */
    double rtol;        /* planar models: tolerance of the step control. Chain: error estimate allowed, as a share of the largest |u|; halves the step until met */
    bool no_prune;      /* integrate every mat all the time */
    bool single;        /* solver fixed: one pass, no error estimate (0) and no check but that of stability. For ensembles
                           whose spread is far larger than a pass's error; the step is dt, or half the stability limit */
    double overrun_ft;  /* landings with heights: note where the wheel meets nodes that have risen so far; 0: not */
    /* Called now and then: how much of the pass is done, 0 to 1. False stops the run: SIM_INTERRUPTED. NULL: never. */
    bool (*go_on)(void *ctx, int pass_from_1, double part);
    void *go_on_ctx;
    double sample_dt_s; /* 0: no samples */
    const double *station_ft; /* where to sample: the mat that begins at the station or lies over it */
    size_t station_count;
};

/* Run a scene. MR_OK: the result is SIM_OK. MR_NUMERICS: the numerics were refused or failed, or the run was
 * interrupted; the result says how and the error names mat and time. An interrupted result holds what was computed:
 * outputs and samples up to t_s, from the pass under way, without an error estimate. MR_USAGE: the model, the solver or an option is not
 * available. MR_MALFORMED: the scene is wrong. The result is written in every case; the caller frees it.
 * Scene and options are only read. */
enum mr_status sim_run(const struct sim_scene *scene, const struct sim_options *options,
                       struct sim_result *result, struct error *error);

#endif
