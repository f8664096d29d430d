/* An ensemble of runways: each member is a possible runway, given all readings. Unmeasured
 * properties of the mats are drawn by member: the share of the thrust that the strip bears,
 * friction, resistance of closing joints, stiffness and damping of joints, and the opening and
 * resistance of each joint. A survey gives ten joints their sum; a measured landing informs the
 * rest (the smoother below). Members are computed eight side by side (host/sim/models/chains.h), on
 * several threads: seed and inputs fix the result, not the threads.
 *
 * Feet, pounds, seconds; openings of surveys and movements in inches, as they are read. */
#ifndef MATRIG_HOST_ADVISE_MEMBERS_H
#define MATRIG_HOST_ADVISE_MEMBERS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/closure.h"
#include "common/matchain.h"
#include "common/splitmix.h"

#define ADVISE_LEAST     64u /* members; of less, chances are too rough to act on */
#define ADVISE_USUAL     256u
#define ADVISE_MOST      4096u
#define ADVISE_ZONE_MATS 50u /* as the board's warning: MR_PREDICTOR_WARNING_MATS */
#define ADVISE_ZONE_FT   2.0 /* the wheel so near to the zone's start is at it */
#define ADVISE_SLOW_FT_S 2.0 /* a slower wheel pushes nothing together */
#define ADVISE_PROFILE   24u
#define ADVISE_JOINTS    (MR_CHAIN_MATS + 1u)
#define ADVISE_G_FT_S2   32.174

/* Random numbers: a seed and a stream make the same ones everywhere. */
struct chance {
    uint64_t state;
};

/* Streams of a seed have nothing in common. */
static inline struct chance chance_from(uint64_t seed, uint64_t stream)
{
    struct chance chance = {seed};
    chance.state = mr_splitmix64(&chance.state) ^ (stream + 1u) * 0xd1342543de82ef95u;
    (void)mr_splitmix64(&chance.state);
    return chance;
}

/* In [0, 1). */
static inline double chance_uniform(struct chance *chance)
{
    return mr_splitmix64_uniform(&chance->state);
}

/* Standard normal (Box and Muller). */
static inline double chance_normal(struct chance *chance)
{
    double u = 1.0 - chance_uniform(chance);
    return sqrt(-2.0 * log(u)) * cos(6.283185307179586 * chance_uniform(chance));
}

/* Logarithms, but for nothing: all are positive. */
enum advise_unknown {
    ADVISE_SHARE, /* of W/axles that the strip bears */
    ADVISE_FRICTION,
    ADVISE_RESISTANCE, /* mean of closing joints, lb */
    ADVISE_STIFFNESS,  /* KL, lb/ft */
    ADVISE_DAMPING,    /* CL, lb s/ft */
    ADVISE_UNKNOWNS
};

/* Given properties of the runway. */
struct advise_runway {
    struct mr_chain_params chain;     /* friction as given; its step is not used */
    double grit_lb;                   /* mean closing resistance, as configured */
    double thrust_lb_per_g;           /* of the lead axle on the strip */
    double share;                     /* of that, measured within 3 %; 0: not measured */
    double bump_ft;                   /* the ground's irregularity; 0: unknown */
    float station_ft[MR_TRANSDUCERS]; /* NaN: not fitted */
};

struct advise_member {
    double unknown[ADVISE_UNKNOWNS];
    float gap_ft[ADVISE_JOINTS]; /* of joint 1 at [0] */
    float grit[ADVISE_JOINTS];   /* closing resistance over the mean */
};

struct advise_members {
    struct advise_runway runway;
    struct advise_member *member;
    size_t count; /* a multiple of 8 */
    unsigned threads;
    unsigned learned; /* landings */
    bool surveyed;    /* since the mats were laid, ten joints at least */
    struct chance chance;
};

/* Braking over time, relative to its mean: joined by straight lines, constant before the first and
 * behind the last. count 0: even. */
struct advise_profile {
    size_t count;
    double t_s[ADVISE_PROFILE], factor[ADVISE_PROFILE];
};

double advise_factor(const struct advise_profile *profile, double t_s);

/* A landing of one member. Braking begins with an onset of 60 ms. */
struct advise_braking {
    double speed_ft_s, touchdown_ft;
    double mean_ft_s2;                    /* times the profile's factor */
    const struct advise_profile *profile; /* NULL: even */
};

double advise_braking_ft_s2(const struct advise_braking *braking, double t_s);

/* The outcome. */
struct advise_met {
    float zone_ft; /* station of the wheel when it first is at a zone of 50 mats; NaN: it is not */
    float stop_ft; /* of the wheel; beyond the runway: it rolls off */
    uint16_t most_mats;             /* longest zone that it was at */
    bool ran_away;                  /* the chain did: nothing else holds */
    float moved_in[MR_TRANSDUCERS]; /* at the end; NaN: not fitted */
    float sum_in[MR_SEGMENTS];      /* openings at the end */
};

/* Draws `count` members, rounded up to eight, of a runway without readings. MR_USAGE: the runway's
 * parameters make no sense. advise_members_free in every case. */
enum mr_status advise_members_draw(struct advise_members *members,
                                   const struct advise_runway *runway, size_t count, uint64_t seed);
void advise_members_free(struct advise_members *members);

/* The mats were laid anew: all openings are drawn again, what was learned of the rest stays. */
void advise_relay(struct advise_members *members);
/* Openings get the surveyed sums, NaN: not read. Each member is off by an error of its own. */
void advise_survey(struct advise_members *members, const double sum_in[MR_SEGMENTS],
                   double error_in);
/* Plays a landing on each member. `keeps`: their joints are left as it left them. False: no
 * memory. */
bool advise_play(struct advise_members *members, const struct advise_braking *braking, bool keeps,
                 struct advise_met *met);

/* A landing that was measured. */
struct advise_seen {
    struct advise_braking braking;
    double moved_in[MR_TRANSDUCERS], moved_error_in; /* at the end; NaN: not read */
    double before_in[MR_SEGMENTS];                   /* surveyed; NaN: not read */
    double after_in[MR_SEGMENTS];
    double survey_error_in;
};
/* Takes in what a landing shows: the survey before it, then its readings, in two passes of the
 * smoother, then the landing itself. False: a chain ran away. */
bool advise_learn(struct advise_members *members, const struct advise_seen *seen);

/* Spreads what was learned about its mean again, `times` above 1: for a landing unlike those. */
void advise_widen(struct advise_members *members, double times);

/* Longest zone ahead of the wheel: from a closed joint (0.001 in) to a closed one in which no ten
 * joints in a row have more than one open. Joints are counted from 0; 0 mats: none. */
struct advise_zone {
    unsigned first, mats;
};
struct advise_zone advise_longest(const float *opening_ft, unsigned joints, unsigned from);

/* Geometric mean and relative spread of an unknown over the members. */
void advise_unknown(const struct advise_members *members, enum advise_unknown unknown, double *mean,
                    double *spread);

/* Ensemble smoother: updates the unknowns of an ensemble from readings, by the correlation of both
 * among its members (Evensen 1994; several passes with larger errors: ES-MDA, Emerick and Reynolds
 * 2013; gain taken down by distance: Chen and Oliver 2017; spread given back: Whitaker and Hamill
 * 2012). For a linear model with Gaussian unknowns and many members it approaches the Kalman filter
 * (tests/host/test_advise.c). Pure but for its memory and the draws. */

/* Unknowns and readings are in any units; each reading's error is in the reading's. */
struct smoother {
    size_t members, states, data;
    double *state;           /* [members][states]; smoother_take changes it */
    const double *predicted; /* [members][data]: each member's prediction of the readings */
    const double *read;      /* [data]; NaN: not read */
    const double *error;     /* [data]: standard errors, of the model too; above 0 */
    /* the errors' variance counts so many times; n passes with n each come to one with 1 */
    double passes;
    /* 0..1: weight of a datum for a state; NULL: 1. Suppresses chance correlations */
    double (*nearness)(const void *context, size_t state, size_t datum);
    const void *context;
};

/* One pass. Readings are perturbed member by member, their mean is not. Without a reading nothing
 * changes. */
void smoother_take(const struct smoother *smoother, struct chance *chance);

/* Mean and standard deviation of column `column` of [members][states]. */
void smoother_spread(const double *state, size_t members, size_t states, size_t column,
                     double *mean, double *deviation);
/* Gives back to the column the share `kept` of the deviation that it has lost since it was `was`,
 * and all of it up to `least`. */
void smoother_widen(double *state, size_t members, size_t states, size_t column, double was,
                    double kept, double least);

/* 1 at 0, 0 from twice `half` on, smooth between (Gaspari and Cohn 1999, equation 4.10). */
double smoother_taper(double distance, double half);

/* An ensemble's prediction for a planned landing: the probability that the wheel reaches a zone of
 * 50 mats, and where, against the deceleration; the hardest braking that stays below a limit.
 *
 * Probabilities are shares of the members, calibrated on series that are not scored
 * (advise_calibrated). Their intervals (95 %, Wilson 1927) cover the number of members alone, not
 * the errors of model and inputs. All decelerations are played with the same draws, so that rows
 * differ by the braking alone. */

#define ADVISE_STATIONS 6u /* the runway in so many parts */
#define ADVISE_ROWS     9u
#define ADVISE_PLAN_MET 0.10 /* spread of mean decelerations about their plan, before any landing */

struct advise_plan {
    double speed_ft_s, speed_spread; /* spreads: relative standard deviations */
    double mean_ft_s2, spread, bias; /* bias: braking turns out exp(bias) times the plan */
    double touchdown_ft, touchdown_spread_ft;
    struct advise_profile profile; /* count 0: even */
    uint64_t seed;
};

struct advise_chance {
    double p, low, high;
};

struct advise_row {
    double speed_ft_s, mean_ft_s2; /* as planned */
    double share;                  /* of the members that come to a zone, as counted */
    struct advise_chance zone;
    struct advise_chance by_station[ADVISE_STATIONS]; /* come to by the end of each part */
    double off_runway;                                /* share of the members that roll off */
    double half_ft; /* where half of those that come to a zone have come to it; NaN: none does */
};

/* How a planned mean deceleration was met: natural logarithms of (measured / planned), `count` of
 * them. Predictive mean and standard deviation of the next one, from a normal-inverse-gamma prior
 * that without landings gives 0 +- ADVISE_PLAN_MET and counts as four landings. */
void advise_plan_met(const double *log_ratio, size_t count, double *bias, double *spread);

/* The landing of each member, `mean_ft_s2` planned. */
void advise_draw_braking(const struct advise_members *members, const struct advise_plan *plan,
                         double mean_ft_s2, struct advise_braking *braking);

/* One row. `braking` and `met` have room for all members and hold what was played. False: the
 * chains cannot be played. */
bool advise_row(struct advise_members *members, const struct advise_plan *plan, double mean_ft_s2,
                struct advise_braking *braking, struct advise_met *met, struct advise_row *row);

/* Of `events` in `count` members: share, Wilson's interval, each calibrated. */
struct advise_chance advise_chance_of(size_t events, size_t count, bool surveyed);
/* What a share of the members is worth as a probability: none is certain, and the log odds of
 * advise_odds by what series that are not scored have shown. */
double advise_calibrated(double share, bool surveyed);
/* Log odds of a share, half a member of 64 on either side of 0 and 1. */
double advise_odds(double share);

/* Mean deceleration that stops the gear at the runway's end. */
double advise_least_ft_s2(const struct advise_members *members, const struct advise_plan *plan);

/* Where mats are closed already far from touchdown, harder braking stops before them: the least
 * braking of the rows (ascending) from which on the probability of a zone is below `limit` again.
 * NaN: there is none, or all rows are below. */
double advise_short_ft_s2(const struct advise_row *row, size_t rows, double limit);

/* Up to where the probability of a zone, and the share that rolls off, stay below a limit. Its 95 %
 * interval comes from the number of members alone. */
struct advise_reach {
    double at;        /* NaN: the first row is not below the limit */
    double low, high; /* NaN: the interval is open on that side */
    bool beyond;      /* all rows are below: `at` is the last row's */
};
/* `x` ascending: what the rows vary, such as the touchdown speed. Between rows in proportion. */
struct advise_reach advise_reach(const double *x, const struct advise_row *row, size_t rows,
                                 double limit);
/* The row of the first pair that the limit, or an end of its interval, lies between, and that is
 * further apart than `width`; `rows`: there is none. */
size_t advise_reach_gap(const double *x, const struct advise_row *row, size_t rows, double limit,
                        double width);

#endif
