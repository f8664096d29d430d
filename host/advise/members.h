/* An ensemble of runways. Each member is a runway that is consistent with all readings. Unmeasured
 * properties of the mats are drawn for each member: the share of the thrust that the strip carries,
 * friction, resistance of closing joints, stiffness and damping of joints, and the opening and
 * resistance of each joint. A survey gives sums of ten openings. A measured landing updates the
 * other properties (see the smoother in this file). Eight members at a time are computed together
 * (host/sim/models/chains.h), on several threads. The result depends on the seed and the inputs,
 * not on the number of threads.
 *
 * Units are feet, pounds and seconds; surveyed openings and movements are in inches, as read. */
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

/* minimum number of members; with fewer, probabilities are too rough to act on */
#define ADVISE_MEMBERS_MIN       64u
#define ADVISE_MEMBERS_DEFAULT   256u
#define ADVISE_MEMBERS_MAX       4096u
/* least number of mats in a zone; the board's warning uses the same number,
 * MR_PREDICTOR_WARNING_MATS */
#define ADVISE_ZONE_MATS         50u
/* the wheel has reached a zone if it is this near to the zone's start */
#define ADVISE_ZONE_TOLERANCE_FT 2.0
#define ADVISE_SLOW_FT_S         2.0 /* a slower wheel does not push mats together */
#define ADVISE_PROFILE_MAX       24u
#define ADVISE_JOINTS            (MR_CHAIN_MATS + 1u)
#define ADVISE_G_FT_S2           32.174

/* Random number generator. The same seed and stream give the same numbers on every computer. */
struct rng {
    uint64_t state;
};

/* Different streams of a seed are independent. */
static inline struct rng rng_init(uint64_t seed, uint64_t stream)
{
    struct rng rng = {seed};
    rng.state = mr_splitmix64(&rng.state) ^ (stream + 1u) * 0xd1342543de82ef95u;
    (void)mr_splitmix64(&rng.state);
    return rng;
}

/* Uniform in [0, 1). */
static inline double rng_uniform(struct rng *rng)
{
    return mr_splitmix64_uniform(&rng->state);
}

/* Standard normal (Box and Muller). */
static inline double rng_normal(struct rng *rng)
{
    double u = 1.0 - rng_uniform(rng);
    return sqrt(-2.0 * log(u)) * cos(6.283185307179586 * rng_uniform(rng));
}

/* Unknowns are stored as logarithms, because all are positive. */
enum advise_parameter {
    ADVISE_SHARE, /* share of the weight per axle that the strip carries */
    ADVISE_FRICTION,
    ADVISE_RESISTANCE, /* mean resistance of closing joints, lb */
    ADVISE_STIFFNESS,  /* joint stiffness KL, lb/ft */
    ADVISE_DAMPING,    /* joint damping CL, lb s/ft */
    ADVISE_UNKNOWNS
};

/* Properties of the runway that are not drawn: they are the same for all members. */
struct advise_runway {
    struct mr_chain_params chain; /* friction_lb as configured; step_s is not used */
    double grit_lb;               /* mean closing resistance of the joints, as configured */
    double thrust_lb_per_g;       /* thrust of the lead axle on the strip */
    /* share of the thrust that the strip carries, measured within 3 %; 0: not measured */
    double thrust_share;
    double bump_ft;                   /* irregularity of the ground; 0: unknown */
    float station_ft[MR_TRANSDUCERS]; /* NaN: no transducer is fitted */
};

struct advise_member {
    double unknown[ADVISE_UNKNOWNS];
    float gap_ft[ADVISE_JOINTS]; /* opening of each joint; joint 1 is at [0] */
    float grit[ADVISE_JOINTS];   /* closing resistance of each joint divided by the mean */
};

struct advise_members {
    struct advise_runway runway;
    struct advise_member *member;
    size_t count; /* number of members, a multiple of 8 */
    unsigned threads;
    unsigned updates; /* number of landings from which the ensemble was updated */
    bool is_surveyed; /* at least one segment (ten joints) was surveyed since the mats were laid */
    struct rng rng;
};

/* Braking over time, relative to its mean. Points are joined by straight lines; braking is constant
 * before the first and after the last point. count 0: uniform braking. */
struct advise_profile {
    size_t count;
    double t_s[ADVISE_PROFILE_MAX], factor[ADVISE_PROFILE_MAX];
};

double advise_braking_factor(const struct advise_profile *profile, double t_s);

/* Speed, touchdown and braking of one member's landing. Braking begins with an onset of 60 ms. */
struct advise_braking {
    double speed_ft_s, touchdown_ft;
    double mean_ft_s2;                    /* the profile's factor applies to it */
    const struct advise_profile *profile; /* NULL: uniform braking */
};

double advise_braking_ft_s2(const struct advise_braking *braking, double t_s);

/* Outcome of a simulated landing. */
struct advise_outcome {
    float zone_ft; /* wheel station at which it first reaches a zone of 50 mats; NaN: never */
    float stop_ft; /* stop station of the wheel; beyond the runway: it rolls off */
    uint16_t longest_mats;             /* longest zone that the wheel reached */
    bool diverged;                     /* the other fields are not valid */
    float movement_in[MR_TRANSDUCERS]; /* movement at the end; NaN: no transducer is fitted */
    float segment_sum_in[MR_SEGMENTS]; /* sums of openings at the end */
};

/* Draws `count` members, rounded up to a multiple of eight, for a runway without readings.
 * MR_USAGE: the runway's parameters are invalid. Call advise_members_free in every case. */
enum mr_status advise_members_draw(struct advise_members *members,
                                   const struct advise_runway *runway, size_t count, uint64_t seed);
void advise_members_free(struct advise_members *members);

/* Draws all openings again, because the mats were laid anew. The other unknowns keep their updated
 * values. */
void advise_relay_mats(struct advise_members *members);
/* Draws the openings and closing resistances of the joints `first` to `last` (from 0) again,
 * because their mats were replaced or relaid. */
void advise_redraw_joints(struct advise_members *members, unsigned first, unsigned last);
/* Sets the openings to the surveyed sums (NaN: not read), with an independent survey error for each
 * member. */
void advise_apply_survey(struct advise_members *members, const double sum_in[MR_SEGMENTS],
                         double error_in);
/* Simulates a landing on each member. `keeps`: the members' openings are set to those at the end of
 * the landing. Returns false if memory is insufficient. */
bool advise_simulate(struct advise_members *members, const struct advise_braking *braking,
                     bool keeps, struct advise_outcome *outcome);

/* A measured landing. */
struct advise_observation {
    struct advise_braking braking;
    double movement_in[MR_TRANSDUCERS], movement_error_in; /* movement at the end; NaN: not read */
    double survey_before_in[MR_SEGMENTS]; /* surveyed before the landing; NaN: not read */
    double survey_after_in[MR_SEGMENTS];  /* surveyed after the landing; NaN: not read */
    double survey_error_in;
};
/* Updates the ensemble from a landing: applies the survey before it, applies its readings in two
 * passes of the smoother, and then simulates the landing. Returns false if a chain diverged. */
bool advise_update(struct advise_members *members, const struct advise_observation *observation);

/* Widens the spread of the updated unknowns about their means by the factor `times` above 1, for a
 * landing unlike the previous ones. */
void advise_widen_spread(struct advise_members *members, double times);

/* Longest zone ahead of the wheel. A zone begins and ends with a closed joint (open by less than
 * 0.001 in), and any ten consecutive joints in it contain at most one open joint. Joints are
 * counted from 0. 0 mats: there is no zone. */
struct advise_zone {
    unsigned first, mats;
};
struct advise_zone advise_longest_zone(const float *opening_ft, unsigned joints, unsigned from);

/* Geometric mean and relative spread of an unknown over the members. */
void advise_parameter_moments(const struct advise_members *members, enum advise_parameter unknown,
                              double *mean, double *spread);

/* Ensemble smoother: updates the unknowns of an ensemble from readings, by the correlation between
 * unknowns and predicted readings among the members (Evensen 1994; several passes with larger
 * errors: ES-MDA, Emerick and Reynolds 2013; gain reduced with distance: Chen and Oliver 2017;
 * spread restored: Whitaker and Hamill 2012). For a linear model with Gaussian unknowns and many
 * members it approaches the Kalman filter (tests/host/test_advise.c). Pure functions, except for
 * memory and random numbers. */

/* Unknowns and readings may have any units; the error of a reading has the unit of the reading. */
struct smoother {
    size_t members, states, readings;
    double *state; /* [members][states]: unknowns of each member; smoother_update changes them */
    const double *predicted; /* [members][data]: readings as predicted by each member */
    const double *reading;   /* [data]: the readings; NaN: not read */
    const double
        *reading_error; /* [data]: standard errors, which include the model's error; above 0 */
    /* Factor on the variance of the errors. n passes with the factor n are equivalent to one pass
     * with the factor 1. */
    double error_factor;
    /* Returns the weight of a reading for a state, 0..1, which suppresses spurious correlations.
     * NULL: 1. */
    double (*taper_weight)(const void *context, size_t state, size_t datum);
    const void *context;
};

/* Runs one pass. Readings are perturbed for each member; the mean of the perturbations is 0.
 * Without a reading nothing changes. */
void smoother_update(const struct smoother *smoother, struct rng *rng);

/* Computes mean and standard deviation of column `column` of [members][states]. */
void smoother_moments(const double *state, size_t members, size_t states, size_t column,
                      double *mean, double *deviation);
/* Restores part of the spread of a column: the share `kept` of the decrease of its standard
 * deviation from `was`. The result is at least `least`. */
void smoother_restore_spread(double *state, size_t members, size_t states, size_t column,
                             double was, double kept, double least);

/* Smooth weight that falls from 1 at distance 0 to 0 at twice `half` (Gaspari and Cohn 1999,
 * equation 4.10). */
double smoother_taper(double distance, double half);

/* Prediction of an ensemble for a planned landing: the probability that the wheel reaches a zone of
 * 50 mats, and the station of that zone, as functions of deceleration; also the hardest braking at
 * which the probability stays below a limit.
 *
 * Probabilities are shares of the members, calibrated on series that are not scored
 * (advise_calibrate). Their 95 % intervals (Wilson 1927) cover only the finite number of members,
 * not the errors of model and inputs. All decelerations use the same random numbers, so rows differ
 * only by the braking. */

#define ADVISE_RUNWAY_PARTS 6u /* number of equal parts of the runway */
#define ADVISE_ROWS         9u
/* relative spread of mean decelerations about the plan, before any landing */
#define ADVISE_PLAN_SPREAD  0.10

struct advise_plan {
    double speed_ft_s, speed_spread; /* spreads are relative standard deviations */
    /* bias: actual braking is exp(bias) times the planned braking */
    double mean_ft_s2, spread, bias;
    double touchdown_ft, touchdown_spread_ft;
    struct advise_profile profile; /* count 0: uniform */
    uint64_t seed;
};

struct advise_probability {
    double p, low, high;
};

struct advise_row {
    double speed_ft_s, mean_ft_s2; /* planned values */
    double zone_share;             /* share of the members that reach a zone, not calibrated */
    struct advise_probability zone;
    /* probability that a zone is reached before the end of each part */
    struct advise_probability by_station[ADVISE_RUNWAY_PARTS];
    double off_runway_share; /* share of the members that roll off */
    /* median station at which members reach a zone; NaN: no member reaches one */
    double median_zone_ft;
};

/* Deviation of braking from plan: `count` natural logarithms of (measured / planned). Returns the
 * predictive mean and standard deviation of the next one. The prior is normal-inverse-gamma:
 * without landings it gives 0 +- ADVISE_PLAN_SPREAD, and it counts as four landings. */
void advise_plan_deviation(const double *log_ratio, size_t count, double *bias, double *spread);

/* Draws the landing of each member for a planned mean deceleration of `mean_ft_s2`. */
void advise_draw_braking(const struct advise_members *members, const struct advise_plan *plan,
                         double mean_ft_s2, struct advise_braking *braking);

/* Computes one row. `braking` and `outcome` have room for all members and receive the simulated
 * landings. Returns false if the chains cannot be simulated. */
bool advise_compute_row(struct advise_members *members, const struct advise_plan *plan,
                        double mean_ft_s2, struct advise_braking *braking,
                        struct advise_outcome *outcome, struct advise_row *row);

/* Probability from `events` in `count` members: share and Wilson's interval, all calibrated. */
struct advise_probability advise_probability_of(size_t events, size_t count, bool surveyed);
/* Calibrated probability for a share of the members. The share is never taken as 0 or 1: its log
 * odds (advise_log_odds) are corrected by a fit to series that are not scored. */
double advise_calibrate(double share, bool surveyed);
/* Log odds of a share; the share is limited to half a member of 64 from 0 and 1. */
double advise_log_odds(double share);

/* Mean deceleration that stops the gear at the end of the runway. */
double advise_least_braking_ft_s2(const struct advise_members *members,
                                  const struct advise_plan *plan);

/* Where mats far from touchdown are closed from the start, harder braking stops the gear short of
 * them. Returns the lowest braking of the rows (ascending) above which the probability of a zone
 * stays below `limit`. NaN: there is none, or all rows are below the limit. */
double advise_stop_short_ft_s2(const struct advise_row *row, size_t rows, double limit);

/* Largest value up to which both the probability of a zone and the share that rolls off stay below
 * a limit. Its 95 % interval covers only the finite number of members. */
struct advise_bound {
    double value;      /* largest value; NaN: the first row is not below the limit */
    double low, high;  /* 95 % interval; NaN: open on that side */
    bool is_unbounded; /* all rows are below the limit: `at` is the last row's */
};
/* `x`: ascending values of the quantity that varies between rows, such as the touchdown speed. The
 * bound is interpolated linearly between rows. */
struct advise_bound advise_find_bound(const double *x, const struct advise_row *row, size_t rows,
                                      double limit);
/* Finds the first pair of adjacent rows that are further apart than `width` and enclose the limit
 * or an end of its interval. Returns the index of the first of them; `rows`: there is no such
 * pair. */
size_t advise_find_gap(const double *x, const struct advise_row *row, size_t rows, double limit,
                       double width);

#endif
