/* Options and result of a simulation: how sim_run is asked, and what it answers, whatever the model
 * and the solver.
 *
 * sim_run allocates the arrays, sim_result_free releases them. A result that is not SIM_OK holds no
 * numbers to use: status, mat, t_s and the costs are filled, the arrays are NULL; but one that was
 * interrupted holds what there was by then. One that is SIM_UNPREDICTABLE holds one run of several
 * that part at t_s: from then on its numbers hold within the error estimates only, which are the
 * spread of those runs. Units ft, s. No array ever holds a NaN. */
#ifndef MATRIG_HOST_SIM_SCENE_RESULT_H
#define MATRIG_HOST_SIM_SCENE_RESULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/sim/scene/scene.h"

/* How a scene is to be run. All zero: choose everything. */
struct sim_options {
    /* NULL or "auto": chosen, the result says why. Chain: "event", "staggered"; else stepper.h has
     * names */
    const char *solver;
    /* of a fixed step. 0: half the stability limit, halved when the check (chain.h) asks */
    double dt_s;
    /* planar models: tolerance of the step control. Chain: error estimate allowed, as a share of
     * the largest |u|; halves the step until met */
    double rtol;
    bool no_prune; /* integrate every mat all the time */
    /* solver staggered: one pass, no error estimate (0) and no check but that of stability. For
     * ensembles whose spread is far larger than a pass's error; the step is dt, or half the
     * stability limit. The chain's event, when asked for: one pass at tolerance rtol */
    bool single;
    /* solver staggered: its first two passes on two threads, for a caller that runs nothing else.
     * The result is the same to the bit */
    bool side_by_side;
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

enum sim_status {
    SIM_OK,
    SIM_UNSTABLE,
    SIM_FOLDED,
    SIM_STEP_UNDERFLOW,
    SIM_INTERRUPTED,
    SIM_UNPREDICTABLE
};

#define SIM_LEFT_OUT_MAX 12
#define SIM_NOTES_MAX    16
#define SIM_OVERRUNS_MAX 8

/* The state at one of the scene's t_out (or at the end when it names none). */
struct sim_output {
    double t_s;
    double *u_ft;   /* mats + 1 values; u_ft[n] is mat n, [0] is unused */
    double lift_ft; /* -min Y; 0 in a model without vertical motion */
    int lift_node;
};

struct sim_result {
    enum sim_status status;
    int mat;            /* where it failed, when not SIM_OK */
    double t_s;         /* when it failed */
    const char *why;    /* a stepper made no progress: static text; NULL else */
    int passes;         /* begun; for go_on */
    const char *solver; /* static text */
    int mats;
    double start_s; /* of the run (sim_scene_start_s); all times of the result are the scene's */
    double t_end_s;
    double run_ms;       /* all passes, wall clock */
    double pass_ms;      /* the pass whose numbers these are */
    double dt_s;         /* its step */
    double dt_limit_s;   /* beyond this a step is unstable */
    double checked_dt_s; /* step of the pass it was checked against */
    uint64_t rhs;        /* force evaluations, all passes */
    uint64_t steps;      /* of the pass whose numbers these are */
    uint64_t rejected;   /* steps of all other passes */
    uint64_t events;     /* mats brought to rest within a step, in that pass */
    double error_u_ft;   /* estimate: largest over all mats at 64 even times, t_out and samples */
    double error_lift_ft;
    /* SIM_UNPREDICTABLE: runs that the estimates are the spread of, and those with a bow wave */
    int spread_runs, spread_waves;
    double peak_u_ft; /* largest |u| at the same times */
    int peak_mat;
    double speed_end_ft_s; /* fastest mat at the end; 0 when all are at rest */
    double max_lift_ft;
    bool bow_wave;
    /* Solver fixed, whole run; joints 1..N+1, [0] unused. NULL elsewhere. */
    double *push_lb; /* largest compression of each joint */
    double *pull_lb; /* largest tension */
    double *rise_ft; /* planar: largest lift of each node off its ground */
    /* planar: most that a joint was turned upwards (^) and downwards (v); both positive */
    double crest_deg, sag_deg;
    int crest_joint, sag_joint;
    /* nodes where the wheel met a wave (sim_options.overrun_ft), in order; between two */
    int overrun[SIM_OVERRUNS_MAX];
    int overruns; /* of them it was on mats that lay lower than half of that */
    /* node that first rose so far, and the mat the wheel was on then (0: on none) */
    int first_crest, first_crest_wheel;

    struct sim_output *outputs;
    size_t output_count;
    double *u_ft; /* at the end: mats + 1 values, by mat */
    /* at the end: mats + 2 values, by joint 1..N+1; [0] unused. Negative: pressed together */
    double *gap_ft;

    struct mods_state *mods; /* what the modifications have come to (mods.h); NULL without any */

    size_t sample_count;  /* rows, at start_s + k * sample_dt_s, k = 0.. */
    size_t station_count; /* columns */
    double sample_dt_s;
    double *sample_u_ft; /* sample_u_ft[k * station_count + s] */
    double *sample_y_ft; /* likewise: height of the mat's left end, up; NULL in model chain */

    int mats_max;                           /* most mats integrated at once */
    double mats_mean;                       /* time mean */
    const char *left_out[SIM_LEFT_OUT_MAX]; /* static texts, NULL at the end of the list */
    char notes[SIM_NOTES_MAX][160];         /* empty text at the end of the list */
};

/* "ok", "unstable", "folded", "step_underflow", "interrupted", "unpredictable". */
const char *sim_status_name(enum sim_status status);

/* How a run ended that did not come to its end, at which mat and when. */
void sim_result_end(struct sim_result *result, enum sim_status status, int mat, double t_s);

/* Significant digits of a time on a clock that shows start_s: as many more than `digits` as that
 * has before its point, 15 at most. */
int sim_time_digits(double start_s, int digits);

/* Adds to a list what it does not have yet; what does not fit is dropped (the lists hold all that
 * the code can say). */
void sim_result_leave_out(struct sim_result *result, const char *what);
void sim_result_note(struct sim_result *result, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void sim_result_free(struct sim_result *result);

/* Record: what one pass of a solver leaves behind: u of every mat at set times, and samples at
 * stations.
 *
 * The set times are 64 even ones to the end (for comparing passes) and the scene's t_out. The
 * solver reports each step as it ends; between steps u is taken as linear, which is how the fixed
 * step moves. Units ft, s. */
struct sim_snapshot {
    double t_s;
    int output;   /* index among the scene's t_out, or -1 */
    double *u_ft; /* mats + 1 values by mat */
    double lift_ft;
    int lift_node;
};

struct sim_record {
    int mats;
    double end_s;
    struct sim_snapshot *snapshots; /* in order of time */
    size_t snapshot_count;
    double *storage;
    int *station_mat;
    size_t station_count;
    double *sample_u_ft;
    double *sample_y_ft; /* NULL in model chain */
    size_t sample_count;
    double sample_dt_s;
    size_t next_snapshot;
    size_t next_sample;
    double next_s; /* the earliest time still wanted; INFINITY when none is */
    /* by mat: of its left end, up; set by the solver of a planar model like the lift */
    const double *height_ft;
    double lift_ft; /* set by the solver before it calls sim_record_take; 0 and node 1 else */
    int lift_node;
};

void sim_record_make(struct sim_record *record, const struct sim_scene *scene,
                     const struct sim_options *options);

/* Take everything wanted up to t_s, where the mats are at u, having moved at v. Cheap when next_s
 * is later: test it first. */
void sim_record_take(struct sim_record *record, double t_s, const double *u_ft,
                     const double *v_ft_s);

/* Largest difference between two complete records of the same scene, and where. */
struct sim_difference {
    double u_ft;
    int mat;
    double t_s;
};
struct sim_difference sim_record_difference(const struct sim_record *a, const struct sim_record *b);

/* Largest difference of the lift between the same. */
double sim_record_lift_difference(const struct sim_record *a, const struct sim_record *b);

/* Largest |u| of a complete record, and where. */
struct sim_difference sim_record_peak(const struct sim_record *record);

/* Hand outputs and samples over to a result, which owns them from then on. */
void sim_record_deliver(struct sim_record *record, struct sim_result *result);
/* Likewise for a chain, with its peak and copies of the lists by mat and joint; gap_ft is 0. */
void sim_record_deliver_chain(struct sim_record *record, const double *u_ft, const double *push_lb,
                              const double *pull_lb, struct sim_result *result);

void sim_record_free(struct sim_record *record);

#endif
