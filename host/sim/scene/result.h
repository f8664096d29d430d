/* Options and result of a simulation: the input of sim_run apart from the scene, and its output,
 * for all models and solvers.
 *
 * sim_run allocates the arrays, sim_result_free releases them. A result that is not SIM_OK has no
 * usable numbers: status, mat, t_s and the costs are set, and the arrays are NULL. There are two
 * exceptions. An interrupted result has the values computed so far. A result that is
 * SIM_UNPREDICTABLE has one of several runs that diverge at t_s: from then on its numbers are valid
 * only within the error estimates, which are the spread of those runs. Units are ft and s. Arrays
 * never contain NaN. */
#ifndef MATRIG_HOST_SIM_SCENE_RESULT_H
#define MATRIG_HOST_SIM_SCENE_RESULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/sim/scene/scene.h"

/* Options of a run. All zero: every choice is automatic. */
struct sim_options {
    /* NULL or "auto": chosen automatically, with the reason in the result. Chain: "event",
     * "staggered"; planar models: the names in stepper.h. */
    const char *solver;
    /* Fixed step. 0: half the stability limit, halved if the check (chain.h) requires it. */
    double dt_s;
    /* Planar models: tolerance of the step control. Chain: permitted error estimate as a share of
     * the largest |u|; the step is halved until it is met. */
    double rtol;
    bool no_prune; /* integrate every mat all the time */
    /* Solver staggered: one pass, without error estimate (0) and without checks except that of
     * stability. For ensembles whose spread is far larger than the error of a pass; the step is dt,
     * or half the stability limit. Solver event of the chain: one pass at tolerance rtol. */
    bool single;
    /* Solver staggered: runs its first two passes on two threads, for a caller without other work.
     * The result is identical bit for bit. */
    bool in_parallel;
    /* Landings with heights: record where the wheel meets nodes that have risen by this height; 0:
     * do not record. */
    double overrun_ft;
    /* Called at intervals with the completed share of the pass, 0 to 1. Returning false stops the
     * run: SIM_INTERRUPTED. NULL: not called. */
    bool (*may_continue)(void *ctx, int pass_from_1, double part);
    void *may_continue_ctx;
    /* Time limit by the clock, after which the run is stopped: SIM_INTERRUPTED. 0: no limit.
     * Solvers that auto tries after the first one have a separate limit (planar.h). */
    double time_limit_s;
    /* seconds, never decreasing; NULL: the clock of host/base/monotonic_clock.h */
    double (*clock_s)(void *ctx);
    void *clock_ctx;
    double sample_dt_s; /* time between samples; 0: no samples */
    /* Stations to sample: the mat that begins at the station or covers it. */
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

/* The state at one of the scene's t_out (or at the end if it has none). */
struct sim_output {
    double t_s;
    double *u_ft;   /* mats + 1 values; u_ft[n] is mat n, [0] is unused */
    double lift_ft; /* largest lift, -min Y; 0 in a model without vertical motion */
    int lift_node;
};

struct sim_result {
    enum sim_status status;
    int mat;            /* mat at which the run failed, if not SIM_OK */
    double t_s;         /* time of the failure */
    const char *reason; /* reason if a stepper made no progress, static text; otherwise NULL */
    int passes;         /* number of passes begun, for may_continue */
    const char *solver; /* static text */
    int mats;
    /* start of the run (sim_scene_start_s); all times of the result are on the scene's clock */
    double start_s;
    double t_end_s;
    double run_ms;        /* duration of all passes, wall clock */
    double pass_ms;       /* duration of the pass that gave the numbers */
    double dt_s;          /* time step of that pass */
    double dt_limit_s;    /* a larger step is unstable */
    double checked_dt_s;  /* step of the check pass */
    uint64_t evaluations; /* number of force evaluations in all passes */
    uint64_t steps;       /* number of steps in the pass that gave the numbers */
    uint64_t rejected;    /* number of steps in all other passes */
    uint64_t events;      /* number of mats brought to rest within a step, in that pass */
    /* error estimate: largest over all mats at 64 equally spaced times, t_out and samples */
    double error_u_ft;
    double error_lift_ft;
    /* SIM_UNPREDICTABLE: number of diverging runs, whose differences are the estimates, and number
     * of those with a bow wave. */
    int divergence_runs, divergence_waves;
    double peak_u_ft; /* largest |u| at the same times */
    int peak_mat;
    double speed_end_ft_s; /* speed of the fastest mat at the end; 0 if all are at rest */
    double max_lift_ft;
    bool bow_wave;
    /* Solver staggered and the chain's event, over the whole run; joints 1..N+1, [0] unused. NULL
     * for other solvers. */
    double *push_lb; /* largest compression of each joint */
    double *pull_lb; /* largest tension of each joint */
    double *rise_ft; /* planar: largest lift of each node off its ground */
    /* Planar: largest turn of a joint upward (^) and downward (v); both positive. */
    double crest_deg, sag_deg;
    int crest_joint, sag_joint;
    /* Nodes at which the wheel met a wave (sim_options.overrun_ft), in order. Between two entries
     * the wheel was on mats lower than half of overrun_ft. */
    int overrun[SIM_OVERRUNS_MAX];
    int overruns; /* number of entries in `overrun` */
    /* Node that first rose by overrun_ft, and the mat under the wheel at that time (0: none). */
    int first_crest, first_crest_wheel;

    struct sim_output *outputs;
    size_t output_count;
    double *u_ft; /* movement at the end: mats + 1 values, by mat */
    /* At the end: mats + 2 values, by joint 1..N+1; [0] unused. Negative: compressed. */
    double *gap_ft;

    /* final state of the modifications (mods.h); NULL without modifications */
    struct mods_state *mods;

    size_t sample_count;  /* rows, at start_s + k * sample_dt_s, k = 0, 1, ... */
    size_t station_count; /* columns */
    double sample_dt_s;
    double *sample_u_ft; /* sample_u_ft[k * station_count + s] */
    double *sample_y_ft; /* same index: height of the mat's left end, up; NULL in model chain */

    int mats_max;                           /* largest number of mats integrated at the same time */
    double mats_mean;                       /* mean over time */
    const char *left_out[SIM_LEFT_OUT_MAX]; /* static texts; NULL ends the list */
    char notes[SIM_NOTES_MAX][160];         /* an empty text ends the list */
};

/* "ok", "unstable", "folded", "step_underflow", "interrupted", "unpredictable". */
const char *sim_status_name(enum sim_status status);

/* Records the end of a run that did not complete, with mat and time. */
void sim_result_set_status(struct sim_result *result, enum sim_status status, int mat, double t_s);

/* Significant digits for a time on a clock that starts at start_s: `digits` plus the number of
 * digits of start_s before its decimal point, at most 15. */
int sim_time_digits(double start_s, int digits);

/* These functions add an entry to a list unless the list has it. The lists have room for all
 * entries that the code can make. */
void sim_result_add_left_out(struct sim_result *result, const char *what);
void sim_result_add_note(struct sim_result *result, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void sim_result_free(struct sim_result *result);

/* Record: the output of one pass of a solver: u of every mat at set times, and samples at stations.
 *
 * The set times are 64 equally spaced times up to the end (for comparing passes) and the scene's
 * t_out. The solver reports the end of each step; between, u is interpolated linearly, as in the
 * motion of a fixed step. Units are ft and s. */
struct sim_snapshot {
    double t_s;
    int output;   /* index in the scene's t_out, or -1 */
    double *u_ft; /* movements: mats + 1 values by mat */
    double lift_ft;
    int lift_node;
};

struct sim_record {
    int mats;
    double end_s;
    struct sim_snapshot *snapshots; /* snapshots in order of time */
    size_t snapshot_count;
    double *storage;
    int *station_mat;
    size_t station_count;
    double *sample_u_ft;
    double *sample_y_ft; /* heights of the samples; NULL in model chain */
    size_t sample_count;
    double sample_dt_s;
    size_t next_snapshot;
    size_t next_sample;
    double next_s; /* next time to be recorded; INFINITY: none */
    /* By mat: height of its left end, up; set by the solver of a planar model, like the lift. */
    const double *height_ft;
    double lift_ft; /* set by the solver before it calls sim_record_add; default: 0 and node 1 */
    int lift_node;
};

void sim_record_make(struct sim_record *record, const struct sim_scene *scene,
                     const struct sim_options *options);

/* Records all times up to t_s, at which the mats have displacements u and had speeds v. Most calls
 * can be avoided by testing next_s. */
void sim_record_add(struct sim_record *record, double t_s, const double *u_ft,
                    const double *v_ft_s);

/* Largest difference between two complete records of the same scene, with mat and time. */
struct sim_difference {
    double u_ft;
    int mat;
    double t_s;
};
struct sim_difference sim_record_difference(const struct sim_record *a, const struct sim_record *b);

/* Largest difference of the lift between two complete records of the same scene. */
double sim_record_lift_difference(const struct sim_record *a, const struct sim_record *b);

/* Largest |u| of a complete record, with mat and time. */
struct sim_difference sim_record_peak(const struct sim_record *record);

/* Moves outputs and samples to a result, which then owns them. */
void sim_record_to_result(struct sim_record *record, struct sim_result *result);
/* Like sim_record_to_result, for a chain. Also sets the peak, and copies the lists by mat and
 * joint; gap_ft is 0. */
void sim_record_chain_to_result(struct sim_record *record, const double *u_ft,
                                const double *push_lb, const double *pull_lb,
                                struct sim_result *result);

void sim_record_free(struct sim_record *record);

#endif
