/* Truth of the score: series of landings on runways that are not the predictor's model. host/sim's
 * chain in double precision and a fine step, with gaps, closing resistances, friction, stiffness,
 * thrust and braking drawn from the series' number. Or, for another kind of truth, host/sim's
 * planar landing (host/sim/solvers/landing.h): another engine and scheme, mats that heave and turn,
 * on ground that is uneven under the joints, by up to 0.043 in, the same in all landings of a
 * series. A bow wave ends the series. Or the chain again under a gear that has its weight, on four
 * axle lines, and ground that gives way under it and springs back (elements/gear.h): what the mats
 * are pushed by is then no thrust of one axle. Or the chain again, braked lightly for the first
 * part of its way, then hard; with other openings, other resistances, or braked in pulses. */
#ifndef MATRIG_TESTS_SCORE_TRUTH_H
#define MATRIG_TESTS_SCORE_TRUTH_H

#include <stdbool.h>
#include <stdint.h>

enum score_kind {
    SCORE_CHAIN,
    SCORE_PLANAR,
    SCORE_ELASTIC,
    SCORE_LATE,
    SCORE_SHUT,   /* a runway nearly closed: four joints of five are open by 0.004 in at most */
    SCORE_PATCHY, /* 5 to 40 mats nearly closed, then as many open */
    SCORE_HEAVY,  /* closing resistances with a heavy tail */
    SCORE_PULSED, /* anti-skid: the brake lets go 3 to 8 times a second */
    SCORE_KINDS
};

#define SCORE_MATS      420
#define SCORE_JOINTS    (SCORE_MATS + 1)
#define SCORE_STATIONS  11 /* 10, 20 .. 110 ft */
#define SCORE_LANDINGS  5  /* of a series, at most */
#define SCORE_ROW_MS    4  /* between displacements */
#define SCORE_LOOK_MS   50 /* between looks at the gaps */
#define SCORE_ROWS_MAX  4000
#define SCORE_LOOKS_MAX 320
#define SCORE_SWITCHES  24
#define SCORE_KNOTS     3 /* of the braking's profile, straight lines between */
#define SCORE_MAT_FT    (2.0 / 7.0)

/* What the series is, and what of it is told to the predictor. */
struct score_series {
    uint32_t number;
    uint32_t landings;
    double friction, told_friction; /* measured by pulling: 10 % rms */
    double kl_lb_ft, cl_lb_s_ft;
    double thrust_share; /* 1: all of W/12 on the strip; not told */
    double grit_mean_lb; /* not told */
    /* 0 uniform, 1 exponential, 2 triangular, 3 uniform with a quarter of the joints clean */
    uint32_t grit_shape;
    double touchdown_ft; /* told as 3 ft */
};

struct score_landing {
    uint32_t number; /* from 1 */
    uint32_t rows, looks, edges;
    double speed_ft_s, stop_s, stop_ft, touchdown_s;               /* time 0: the first row */
    float edge_s[SCORE_SWITCHES + 8], edge_ft[SCORE_SWITCHES + 8]; /* nominal stations */
    float gap_in[SCORE_JOINTS];                                    /* before */
    /* braking as it is meant, without onset and ripple: time from touchdown */
    float plan_time_s[SCORE_KNOTS], plan_deceleration_ft_s2[SCORE_KNOTS];
    float u_in[SCORE_ROWS_MAX][SCORE_STATIONS];
    float wheel_ft[SCORE_LOOKS_MAX], speed_at_ft_s[SCORE_LOOKS_MAX];
    /* hundredths of a mil, 1e-5 in; 0: pressed together */
    uint16_t gap_counts[SCORE_LOOKS_MAX][SCORE_JOINTS];
    float wave_s; /* planar: a bow wave begins; NaN: none. Looks end there */
};

struct score_truth {
    struct score_series series;
    struct score_landing landing[SCORE_LANDINGS];
};

const char *score_kind_name(enum score_kind kind);
/* SCORE_KINDS: there is none of that name. */
enum score_kind score_kind_find(const char *name);

/* Series `number`, from the cache in `folder` or computed and put there. False: told on stderr. */
bool score_truth_get(struct score_truth *truth, uint32_t number, enum score_kind kind,
                     const char *folder);

/* Uniform in 0..1 and standard normal from a state. */
double score_uniform(uint64_t *state);
double score_normal(uint64_t *state);

#endif
