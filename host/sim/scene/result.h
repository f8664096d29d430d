/* Options and result of a simulation, for all models and solvers: the inputs of sim_run besides the
 * scene, and its output.
 *
 * sim_run allocates the arrays, sim_result_free releases them. A result that is not SIM_OK has no
 * usable numbers: status, mat, t_s and the costs are set, and the arrays are NULL. There are two
 * exceptions. An interrupted result has the values computed so far. A SIM_UNPREDICTABLE result is
 * one of several runs that diverge at t_s. From t_s on, its numbers are valid only within the error
 * estimates, which are the differences between those runs. Units are ft and s. Arrays never contain
 * NaN. */
#ifndef MATRIG_HOST_SIM_SCENE_RESULT_H
#define MATRIG_HOST_SIM_SCENE_RESULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/sim/scene/scene.h"

/* Options of a run. If all are zero, every choice is automatic. */
struct sim_options {
    /* NULL or "auto": chosen automatically, with the reason in the result. Chain: "event",
     * "staggered"; planar models: the names in stepper.h. */
    const char *solver;
    /* Time step. 0: half of the stability limit, and shorter if the check (chain.h) requires it. */
    double dt_s;
    /* Planar models: tolerance of the step control. Chain: permitted error estimate as a fraction
     * of the largest |u|. The step is halved until the estimate is below it. */
    double rtol;
    bool integrates_all_mats; /* true: all mats are integrated at all times, also mats at rest */
    /* Solver staggered: one pass with dt or half the stability limit, without an error estimate
     * (0). Only stability is checked. For ensembles whose spread is far larger than the error of a
     * pass. Solver event of the chain: one pass at tolerance rtol. */
    bool is_single_pass;
    /* Solver staggered: run the first two passes on two threads, for a caller that does not use the
     * second thread itself. The result is identical bit for bit. */
    bool in_parallel;
    /* Landings with heights: record where the wheel reaches a node that has risen by at least this
     * height. 0: do not record. */
    double wave_encounter_height_ft;
    /* Called from time to time with the completed fraction of the pass, 0 to 1. If it returns
     * false, the run stops: SIM_INTERRUPTED. NULL: not called. */
    bool (*may_continue)(void *ctx, int pass_from_1, double part);
    void *may_continue_ctx;
    /* Wall-clock time after which the run is stopped: SIM_INTERRUPTED. 0: no limit. If `auto` tries
     * further solvers, they have a separate limit (planar.h). */
    double time_limit_s;
    /* returns seconds that never decrease; NULL: the clock of host/base/monotonic_clock.h */
    double (*clock_s)(void *ctx);
    void *clock_ctx;
    double sample_dt_s; /* interval between samples; 0: no samples */
    /* Stations at which u is sampled, each on the mat that begins there or covers it. */
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

#define SIM_LEFT_OUT_MAX        12
#define SIM_NOTES_MAX           16
#define SIM_WAVE_ENCOUNTERS_MAX 8

/* The state at one of the scene's output times t_out (or at the end if it has none). */
struct sim_output {
    double t_s;
    double *u_ft;   /* mats + 1 values; u_ft[n] is mat n, [0] is unused */
    double lift_ft; /* largest lift, -min Y; 0 in a model without vertical motion */
    int highest_node;
};

struct sim_result {
    enum sim_status status;
    int mat;            /* mat at which the run failed, if not SIM_OK */
    double t_s;         /* time of the failure, if the run failed */
    const char *reason; /* reason why a solver made no progress, static text; NULL: none */
    int pass_count;     /* number of the passes that were begun */
    const char *solver; /* name of the solver, static text */
    int mats;
    /* start of the run (sim_scene_start_s), as a time in the scene; all times of the result are
     * times in the scene */
    double start_s;
    double t_end_s;
    double run_ms;        /* wall-clock duration of all passes */
    double pass_ms;       /* duration of the pass whose numbers are the result */
    double dt_s;          /* time step of that pass */
    double dt_limit_s;    /* largest stable time step */
    double checked_dt_s;  /* time step of the second pass, with which the result was checked */
    uint64_t evaluations; /* number of force evaluations in all passes */
    uint64_t steps;       /* number of steps in the pass whose numbers are the result */
    uint64_t other_steps; /* number of steps in all other passes */
    /* number of times that a mat came to rest within a step, in the pass whose numbers are the
     * result */
    uint64_t events;
    /* error estimate: largest error of u over all mats at 64 equally spaced times, t_out and
     * samples */
    double error_u_ft;
    double error_lift_ft;
    /* If SIM_UNPREDICTABLE: number of runs that diverge, and number of those with a bow wave. The
     * error estimates are the differences between these runs. */
    int diverging_run_count, diverging_wave_count;
    double peak_u_ft; /* largest |u| over the times of error_u_ft */
    int peak_mat;
    double speed_end_ft_s; /* speed of the fastest mat at the end; 0 if all mats are at rest */
    double max_lift_ft;
    bool bow_wave;
    /* Arrays over joints 1..N+1 ([0] unused), maxima over the whole run. Only for solver staggered
     * and for the chain's event; otherwise NULL. */
    double *max_compression_lb; /* largest compression of each joint in the run */
    double *max_tension_lb;     /* largest tension of each joint in the run */
    double *max_rise_ft;        /* planar models: largest lift of each node above its ground */
    /* Planar models: largest angle by which a joint turns upward (^) and downward (v). Both are
     * positive. */
    double crest_deg, sag_deg;
    int crest_joint, sag_joint;
    /* Nodes at which the wheel reached a wave (sim_options.wave_encounter_height_ft), in order of
     * time. Between two entries the wheel passed mats with less than half of that rise. */
    int wave_encounter_nodes[SIM_WAVE_ENCOUNTERS_MAX];
    int wave_encounter_count; /* number of entries in `wave_encounter_nodes` */
    /* First node that rose by wave_encounter_height_ft, and the mat under the wheel at that time
     * (0: none). */
    int first_crest_node, first_crest_wheel_mat;

    struct sim_output *outputs;
    size_t output_count;
    double *u_ft; /* movement at the end: mats + 1 values, by mat */
    /* Opening of each joint at the end: mats + 2 values, by joint 1..N+1; [0] unused. Negative: the
     * joint is compressed. */
    double *gap_ft;

    /* final state of the modifications (mods.h); NULL without modifications */
    struct mods_state *mods;

    size_t sample_count;  /* number of rows of samples; row k is at start_s + k * sample_dt_s */
    size_t station_count; /* number of columns of samples */
    double sample_dt_s;
    double *sample_u_ft; /* sample_u_ft[k * station_count + s] */
    /* same index: height of the left end of the mat, positive up; NULL in model chain */
    double *sample_y_ft;

    int integrated_mats_max;     /* largest number of mats integrated in one step */
    double integrated_mats_mean; /* number of integrated mats, mean over time */
    /* effects that the model omits, as static texts; NULL ends the list */
    const char *omitted_effects[SIM_LEFT_OUT_MAX];
    char notes[SIM_NOTES_MAX][200]; /* an empty text ends the list */
};

/* Name of a status: "ok", "unstable", "folded", "step_underflow", "interrupted",
 * "unpredictable". */
const char *sim_status_name(enum sim_status status);

/* Sets the status of a run that did not complete, and the mat and time of the failure. */
void sim_result_set_status(struct sim_result *result, enum sim_status status, int mat, double t_s);

/* Returns the number of significant digits for a time of a run that starts at start_s: `digits`
 * plus the number of digits of start_s before the decimal point, at most 15. */
int sim_time_digits(double start_s, int digits);

/* These functions add a text to a list unless the list already has it. The lists have room for all
 * texts that the code can add. */
void sim_result_add_omitted_effect(struct sim_result *result, const char *what);
void sim_result_add_note(struct sim_result *result, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void sim_result_free(struct sim_result *result);

/* Record: the output of one pass of a solver: u of every mat at set times, and samples at stations.
 *
 * The set times are 64 equally spaced times up to the end (for comparing passes) and the scene's
 * t_out. The solver reports the state at the end of each step; in between, u is interpolated
 * linearly, as in the motion of a fixed step. Units are ft and s. */
struct sim_snapshot {
    double t_s;
    int output_index; /* index in the scene's t_out; -1: one of the 64 times */
    double *u_ft;     /* displacements: mats + 1 values by mat */
    double lift_ft;
    int lift_node;
};

struct sim_record {
    int mats;
    double end_s;
    struct sim_snapshot *snapshots; /* snapshots in ascending order of time */
    size_t snapshot_count;
    double *storage;
    int *station_mat;
    size_t station_count;
    double *sample_u_ft;
    double *sample_y_ft; /* height at each sample; NULL in model chain */
    size_t sample_count;
    double sample_dt_s;
    size_t next_snapshot;
    size_t next_sample;
    double next_record_s; /* next time that must be recorded; INFINITY: none */
    /* Height of the left end of each mat, positive up. A planar model's solver sets it. */
    const double *height_ft;
    /* largest lift and its node; a planar model's solver sets them before it calls sim_record_add,
     * otherwise 0 and node 1 */
    double lift_ft;
    int lift_node;
};

void sim_record_make(struct sim_record *record, const struct sim_scene *scene,
                     const struct sim_options *options);

/* Records all times up to t_s, at which the mats have displacements u and speeds v. A call is
 * necessary only if t_s has reached next_record_s. */
void sim_record_add(struct sim_record *record, double t_s, const double *u_ft,
                    const double *v_ft_s);

/* Largest difference in u between two complete records of the same scene, with its mat and time. */
struct sim_difference {
    double u_ft;
    int mat;
    double t_s;
};
struct sim_difference sim_record_difference(const struct sim_record *a, const struct sim_record *b);

/* Largest difference in lift between two complete records of the same scene. */
double sim_record_lift_difference(const struct sim_record *a, const struct sim_record *b);

/* Largest |u| of a complete record, with its mat and time. */
struct sim_difference sim_record_peak(const struct sim_record *record);

/* Moves outputs and samples from a record to a result, which then owns them. */
void sim_record_move_to_result(struct sim_record *record, struct sim_result *result);
/* As sim_record_move_to_result, for the chain. Also sets the peak, and copies the lists by mat and
 * by joint; gap_ft is 0. */
void sim_record_move_chain_to_result(struct sim_record *record, const double *u_ft,
                                     const double *push_lb, const double *pull_lb,
                                     struct sim_result *result);

void sim_record_free(struct sim_record *record);

#endif
