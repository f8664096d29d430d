/* An ensemble: runways of a series, each from its seed through all its landings, and what they did
 * together. */
#ifndef MATRIG_HOST_LANDING_SERIES_ENSEMBLE_H
#define MATRIG_HOST_LANDING_SERIES_ENSEMBLE_H

#include <stddef.h>

#include "host/base/answer.h"
#include "host/landing_series/series.h"
#include "host/sim/scene/result.h"

/* of the first play's step, where a runway is played again: no whole multiple */
#define SERIES_OTHER_STEP 1.37
#define SERIES_EVERY      6 /* of so many runways one is */

/* What one landing did. Movements and stations: of this landing; total: since the runway was
 * laid. */
struct series_outcome {
    double stop_ft, deceleration_ft_s2; /* mean */
    bool asked_planar;                  /* the planar engine ran */
    /* largest lift of a joint by the chain's compression, in weights of a mat */
    double skip_ratio;
    double peak_in;
    double movement_in[SERIES_STATIONS_MAX], total_in[SERIES_STATIONS_MAX];
    double reach_ft; /* farthest joint beyond the stop that moved by 0.001 in */
    int zone_mats;
    /* longest stretch where any ten joints have closed by two thirds; the last landing's wave is in
     * it */
    double zone_from_ft, zone_to_ft;
    double push_lb, pull_lb; /* largest in a joint */
    /* standard errors of what is largest in time, by the steps; NaN: not known */
    double skip_error, push_error_lb, pull_error_lb;
    bool by_planar;    /* movement and forces are the planar engine's, else the chain's */
    double other_s[2]; /* the step of another play: of the chain, of the planar engine */
    int tears;         /* joints pulled beyond their strength */
    int waves;
    double wave_ft; /* station of the highest; 0: none */
    double rise_in; /* highest */
    double crest_deg, sag_deg;
    bool unhinged, buckled;
    /* station: where the wheel first met the wave; else, when it stopped before it, its crest */
    double buckle_ft;
    int overruns;
    /* all such stations, the wheel having left the wave in between */
    double overrun_ft[SIM_OVERRUNS_MAX];
    /* stretches of mats that rose so far, between mats that did not; at least 1 when buckled */
    int failures;
    /* stations, downfield: where the wheel first met it, else its crest */
    double failure_ft[SERIES_FAILURES_MAX];
    /* of the wheel's mat: where a rise of buckle_in came first; only when crest_ft > 0 */
    int crest_ahead_mats;
    /* station of it; 0: nothing rose so far while the wheel was on the runway */
    double crest_ft;
    int band_slack; /* segments of bands that went slack */
};

struct series_run {
    uint64_t seed;
    size_t played;                   /* landings; a buckled runway takes no more */
    int buckled;                     /* landing, from 1; 0: none */
    double buckle_ft;                /* station */
    struct series_outcome *outcomes; /* landing_count */
    struct error error;              /* why this runway could not be played to its end */
    /* of some runways the same landings, from the first on, at other steps; NULL: of this not */
    struct series_outcome *other;
    size_t other_played;
};

/* Play the runway of a seed, and each sixth once more at other steps. The result depends on series
 * and seed alone. */
void series_play(const struct landing_series *series, uint64_t seed, struct series_run *run);
void series_run_free(struct series_run *run);

/* Set the errors in all outcomes, from the runways that were played twice: README.md, "What a peak
 * is worth". */
void series_errors(const struct landing_series *series, struct series_run *runs);

/* Play all seeds on `jobs` threads, and their errors. `progress` is called now and then, by one of
 * them; NULL: not. A runway that fails keeps its error; the others are played. */
void series_ensemble(const struct landing_series *series, unsigned jobs,
                     void (*progress)(void *ctx, size_t done, size_t of), void *ctx,
                     struct series_run *runs);

/* Draw: what a seed makes of a series' ranges, and the path of a landing. Streams are
 * independent: another landing or another range does not change what else is drawn. */

enum draw_stream { DRAW_GAPS, DRAW_CLOSING, DRAW_GROUND, DRAW_LANDING };

struct draw {
    uint64_t state;
};

struct draw draw_from(uint64_t seed, unsigned stream);

double draw_between(struct draw *draw, struct series_range range);

/* The aircraft's way from touchdown to its stop, or off the runway. */
struct draw_path {
    struct sim_path_row *rows;
    size_t count;
    double touchdown_ft, stop_ft, mean_ft_s2;
};

/* Path of landing `index` (from 0) on the runway of a seed: brakes from touchdown, with an onset of
 * onset_s; thrust W/axles a/g; or is towed to the runway's end. `path` is all zero or of an earlier
 * call. MR_USAGE when it does not stop within 600 s. */
enum mr_status draw_landing(const struct landing_series *series,
                            const struct series_landing *landing, uint64_t seed, size_t index,
                            struct draw_path *path, struct error *error);
void draw_path_free(struct draw_path *path);

/* Failures: the stations at which mats rose in one landing: a two-panel wave, which the aircraft
 * presses flat, or more. */

/* Each stretch of nodes that rose by `limit_ft` or more, between nodes that did not, is a failure:
 * the aircraft presses flat what lies between. `rise_ft` as sim_result has it, by node 1..nodes,
 * [0] unused; the runway's ends do not count. Its station: where the wheel first met it (`met_ft`,
 * in order of time), else its highest node. Returns how many, at most SERIES_FAILURES_MAX,
 * downfield in `failure_ft`. */
int failures_find(const double *rise_ft, size_t nodes, double length_ft, double limit_ft,
                  const double *met_ft, int met, double failure_ft[SERIES_FAILURES_MAX]);

/* Flatten: a wave that a landing left, pressed flat when the aircraft is pushed back over it. */

struct flat_runway {
    size_t joints;  /* mats + 1; the first and the last are the runway's ends, which hold */
    double *gap_ft; /* per joint; negative: its mats are that much too long to lie flat */
    double *u_ft;   /* per mat 1..joints - 1, [0] unused: movement, added to */
    const double *closing_lb; /* per joint: what it resists closing with */
    double rub_lb;            /* what holds a mat: friction times its weight */
    double kl_lb_ft;          /* of a joint, pressed */
};

/* Joints that are too short push what lies against them away, step by step to the side that resists
 * less: mats that touch each other go together, until the next opening has closed. Each joint stops
 * at the compression that both sides hold by friction. Openings only pass along: their sum
 * stays. */
void flatten(const struct flat_runway *runway);

/* Summary: distributions of what an ensemble's runways did. */

/* 5th, 50th and 95th percentile (linear between order statistics); count 0: NaN. */
struct series_spread {
    double low, middle, high;
    size_t count;
};

struct series_spread series_spread_of(double *values, size_t count); /* sorts them */

/* Largest in time of one runway; over runways. */
struct series_peak {
    struct series_spread spread;
    double mean, mean_error, error; /* of the mean, of one runway */
};

/* Of the runways that took this landing. */
struct series_landing_summary {
    size_t played;
    size_t buckled;
    size_t planar, waved, unhinged, torn;
    struct series_spread stop_ft, peak_in, reach_ft, zone_mats;
    struct series_peak skip_ratio, push_lb, pull_lb;
    struct series_spread movement_in[SERIES_STATIONS_MAX], total_in[SERIES_STATIONS_MAX];
};

struct series_summary {
    size_t runways;                                   /* that were played to their end */
    size_t failed;                                    /* that could not be */
    size_t survived;                                  /* did not buckle */
    struct series_spread station_ft, buckle_landing;  /* of those that buckled */
    struct series_spread zone_before, peak_before_in; /* of them, in the landing before */
    struct series_landing_summary *landing;           /* landing_count */
};

/* The caller frees. */
void series_summarise(struct series_summary *summary, const struct landing_series *series,
                      const struct series_run *runs);
void series_summary_free(struct series_summary *summary);

/* What matrig study answers: an ensemble's outcome, in words and tables, and for programs every
 * landing of every runway. */

/* Both. A new answer, the caller's; for programs in the units of the keys' names, also with `si`.
 */
struct answer *series_answer(const struct landing_series *series, const struct series_run *runs,
                             const struct series_summary *summary, bool si);

#endif
