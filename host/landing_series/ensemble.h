/* An ensemble: the runways of a series, each simulated from its seed through all its landings, and
 * their combined results. */
#ifndef MATRIG_HOST_LANDING_SERIES_ENSEMBLE_H
#define MATRIG_HOST_LANDING_SERIES_ENSEMBLE_H

#include <stddef.h>

#include "host/base/answer.h"
#include "host/landing_series/series.h"
#include "host/sim/scene/result.h"

/* time step of the second simulation of a runway divided by that of the first; not an integer */
#define SERIES_CHECK_STEP_RATIO 1.37
#define SERIES_CHECK_EVERY      6 /* one in this many runways is simulated a second time */

/* Results of one landing. Movements and stations are those of this landing, except
 * total_movement_in, which is the movement since the runway was laid. */
struct series_outcome {
    double stop_ft, deceleration_ft_s2; /* deceleration_ft_s2: mean over the landing */
    bool has_planar_run;
    /* largest lift force on a joint due to compression, divided by the weight of a mat */
    double lift_ratio;
    double peak_movement_in;
    double movement_in[SERIES_STATIONS_MAX], total_movement_in[SERIES_STATIONS_MAX];
    /* distance from the stop to the farthest joint downfield of it that moved by at least 0.001
     * in */
    double moved_length_beyond_stop_ft;
    int zone_mats;
    /* Start and end of the longest stretch in which any ten consecutive joints have lost two thirds
     * of their opening. */
    double zone_start_ft, zone_end_ft;
    double compression_lb,
        tension_lb; /* largest forces in any joint, in compression and in tension */
    /* Standard errors, due to the time step, of those values that are maxima over time; NaN: not
     * known. */
    double lift_error, compression_error_lb, tension_error_lb;
    bool is_planar; /* movement and forces are from the planar engine; false: from the chain */
    /* time steps of the second simulation, s: of the chain, of the planar engine */
    double check_step_s[2];
    int torn_joint_count; /* number of joints that were torn by tension */
    int wave_count;
    double wave_station_ft; /* station of the highest wave; 0: no wave */
    double wave_rise_in;    /* rise of the highest wave */
    double crest_angle_deg, sag_angle_deg;
    bool is_unhinged, is_buckled;
    /* Station at which the wheel first reached the wave, or of its crest if the wheel stopped
     * before it. */
    double buckle_station_ft;
    int wave_encounter_count;
    /* All stations at which the wheel reached the wave again after leaving it, and the first
     * one. */
    double wave_encounter_station_ft[SIM_WAVE_ENCOUNTERS_MAX];
    /* number of failures (stretches of mats that rose by at least the buckle limit); at least 1 if
     * the runway buckled */
    int failure_count;
    /* Station of each failure, in downfield order: where the wheel first reached it, or its crest
     * if the wheel did not. */
    double failure_station_ft[SERIES_FAILURES_MAX];
    /* Distance from the wheel's mat to the mat that first rose by buckle_in; valid only if
     * first_buckle_station_ft > 0. */
    int first_buckle_ahead_mats;
    /* station of the mat that first rose by buckle_in; 0: no mat rose that far while the wheel was
     * on the runway */
    double first_buckle_station_ft;
    int slack_band_segment_count; /* number of segments of bands that became slack */
};

struct series_run {
    uint64_t seed;
    /* number of simulated landings; a buckled runway has no further landings */
    size_t simulated_landing_count;
    int buckled_landing; /* landing in which the runway buckled, from 1; 0: it did not buckle */
    double buckle_station_ft;        /* station at which it buckled */
    struct series_outcome *outcomes; /* array of landing_count entries */
    struct error error;              /* reason why this runway could not be simulated to its end */
    /* Results of the second simulation of the same landings with other time steps; NULL: this
     * runway has none. */
    struct series_outcome *check_outcomes;
    size_t check_landing_count;
};

/* Simulates the runway of a seed; every sixth runway is simulated a second time with other steps.
 * The result depends only on series and seed. */
void series_simulate(const struct landing_series *series, uint64_t seed, struct series_run *run);
void series_run_free(struct series_run *run);

/* Computes the errors in all outcomes, from the runways that were simulated twice: README.md,
 * "Errors of peaks". */
void series_compute_errors(const struct landing_series *series, struct series_run *runs);

/* Simulates all seeds on `jobs` threads, and computes the errors. One of the threads calls
 * `progress` at intervals; NULL: no calls. A runway that fails stores its error; the others are
 * still simulated. */
void series_simulate_all(const struct landing_series *series, unsigned jobs,
                         void (*progress)(void *ctx, size_t done, size_t total), void *ctx,
                         struct series_run *runs);

/* Random draws: the values of a seed for the ranges of a series, and the path of a landing. Streams
 * are independent, so an additional landing or range does not change other draws. */

enum draw_stream { DRAW_GAPS, DRAW_CLOSING, DRAW_GROUND, DRAW_LANDING };

struct draw_generator {
    uint64_t state;
};

struct draw_generator draw_generator_init(uint64_t seed, unsigned stream);

double draw_from_range(struct draw_generator *draw, struct series_range range);

/* The aircraft's path from touchdown to the stop or to the end of the runway. */
struct draw_path {
    struct sim_path_row *rows;
    size_t count;
    double touchdown_ft, stop_ft, mean_ft_s2;
};

/* Computes the path of landing `index` (from 0) on the runway of a seed. The aircraft brakes from
 * touchdown: the deceleration a rises within onset_s, and the thrust is W/axles a/g. A towed model
 * runs to the end of the runway instead. `path` must be zeroed or the result of an earlier call.
 * MR_USAGE: the aircraft does not stop within 600 s. */
enum mr_status draw_landing_path(const struct landing_series *series,
                                 const struct series_landing *landing, uint64_t seed, size_t index,
                                 struct draw_path *path, struct error *error);
void draw_path_free(struct draw_path *path);

/* Finds failures. A failure is a stretch of nodes that rose by `limit_ft` or more, separated by
 * nodes that did not. A two-panel wave, which the aircraft presses flat, counts as a failure if it
 * rose so far; mats between failures count as pressed flat. `rise_ft` is as in sim_result, for
 * nodes 1..nodes, with [0] unused; the runway's ends are ignored. The station of a failure is
 * where the wheel first reached it (`reached_ft`, in order of time); otherwise it is that of the
 * highest node. Returns the number of failures, at most SERIES_FAILURES_MAX, in downfield order in
 * `failure_ft`. */
int series_find_failures(const double *rise_ft, size_t nodes, double length_ft, double limit_ft,
                         const double *reached_ft, int reached_count,
                         double failure_ft[SERIES_FAILURES_MAX]);

/* Flattening of a wave that remains after a landing: the aircraft presses it flat when it is pushed
 * back. */

struct runway_flattening {
    /* mats + 1; the first and the last are the runway's ends, which are fixed */
    size_t joint_count;
    /* opening of each joint; negative: the mats are too long by this amount to lie flat */
    double *gap_ft;
    /* movement of mats 1 to joint_count - 1 ([0] unused), updated by flatten_waves */
    double *u_ft;
    const double *closing_resistance_lb; /* closing resistance of each joint */
    double friction_force_lb;            /* friction of a mat: coefficient times weight */
    double kl_lb_ft;                     /* stiffness of a joint in compression */
};

/* Flattens the runway. Each joint with a negative gap pushes the neighbouring mats outward, step by
 * step, towards the side with less resistance. Mats that touch move together until the next opening
 * closes. Each joint keeps the compression that friction on both sides can hold. The sum of the
 * openings does not change. */
void flatten_waves(const struct runway_flattening *runway);

/* 5th, 50th and 95th percentile (linear between order statistics); all NaN if count is 0. */
struct series_spread {
    double low, median, high;
    size_t count;
};

struct series_spread series_compute_spread(double *values, size_t count); /* also sorts `values` */

/* Distribution over the runways of a value that is a maximum over time. */
struct series_peak {
    struct series_spread spread;
    /* mean_error: standard error of the mean; run_error: standard error for a single runway */
    double mean, mean_error, run_error;
};

/* Results of all runways on which this landing was simulated. */
struct series_landing_summary {
    size_t runway_count;
    size_t buckled_count;
    size_t planar_count, wave_count, unhinged_count, torn_count;
    struct series_spread stop_ft, peak_movement_in, moved_length_beyond_stop_ft, zone_mats;
    struct series_peak lift_ratio, compression_lb, tension_lb;
    struct series_spread movement_in[SERIES_STATIONS_MAX], total_movement_in[SERIES_STATIONS_MAX];
};

struct series_summary {
    size_t runway_count;   /* number of runways simulated to their end */
    size_t failed_count;   /* number of runways whose simulation failed */
    size_t survived_count; /* number of runways that did not buckle */
    /* distributions over the runways that buckled */
    struct series_spread buckle_station_ft, buckle_landing;
    /* distributions over the same runways, for the landing before the one with the buckle */
    struct series_spread zone_mats_before_buckle, peak_before_buckle_in;
    struct series_landing_summary *landing; /* array of landing_count entries */
};

/* Computes the summary; the caller frees it. */
void series_summarise(struct series_summary *summary, const struct landing_series *series,
                      const struct series_run *runs);
void series_summary_free(struct series_summary *summary);

/* Makes a new answer, which the caller owns. JSON values have the units in their keys' names, even
 * if `si` is set. */
struct answer *series_to_answer(const struct landing_series *series, const struct series_run *runs,
                                const struct series_summary *summary, bool si);

#endif
