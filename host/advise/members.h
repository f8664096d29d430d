/* An ensemble of runways. Each member is a runway that is consistent with all measurements.
 * Unmeasured properties of the mats are drawn for each member: the fraction of the braking thrust
 * that the mat strip carries, friction, resistance of closing joints, stiffness and damping of
 * joints, and the opening and resistance of each joint. A survey sets the sum of the openings of
 * each segment of ten joints. A measured landing updates the other properties (see struct
 * smoother). Eight members at a time are computed together (host/sim/models/chains.h), on several
 * threads. The result depends on the seed and the inputs, not on the number of threads.
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

/* Smallest number of members. With fewer members, probabilities are too inexact. */
#define ADVISE_MEMBERS_MIN              64u
#define ADVISE_MEMBERS_DEFAULT          256u
#define ADVISE_MEMBERS_MAX              4096u
/* Smallest number of mats in a zone. The board's warning uses the same number,
 * MR_PREDICTOR_WARNING_MATS. */
#define ADVISE_ZONE_MATS                50u
/* The wheel has reached a zone if it is at most this far from the start of the zone. */
#define ADVISE_ZONE_REACHED_DISTANCE_FT 2.0
/* a wheel slower than this does not push mats together */
#define ADVISE_SLOW_SPEED_FT_S          2.0
#define ADVISE_PROFILE_MAX              24u
#define ADVISE_JOINTS                   (MR_CHAIN_MATS + 1u)
#define ADVISE_G_FT_S2                  32.174

/* A random number generator. The same seed and stream give the same numbers on every computer. */
struct rng {
    uint64_t state;
};

/* Starts a stream of random numbers. Different streams of a seed are independent. */
static inline struct rng rng_init(uint64_t seed, uint64_t stream)
{
    struct rng rng = {seed};
    rng.state = mr_splitmix64(&rng.state) ^ (stream + 1u) * 0xd1342543de82ef95u;
    (void)mr_splitmix64(&rng.state);
    return rng;
}

/* Uniform number in [0, 1). */
static inline double rng_uniform(struct rng *rng)
{
    return mr_splitmix64_uniform(&rng->state);
}

/* Standard normal number (Box and Muller). */
static inline double rng_normal(struct rng *rng)
{
    double u = 1.0 - rng_uniform(rng);
    return sqrt(-2.0 * log(u)) * cos(6.283185307179586 * rng_uniform(rng));
}

/* Properties that are drawn for each member. They are stored as logarithms, because all are
 * positive. */
enum advise_unknown {
    ADVISE_UNKNOWN_THRUST_SHARE, /* share of the thrust that the mat strip carries */
    ADVISE_UNKNOWN_FRICTION,
    ADVISE_UNKNOWN_RESISTANCE, /* mean resistance of closing joints, lb */
    ADVISE_UNKNOWN_STIFFNESS,  /* joint stiffness KL, lb/ft */
    ADVISE_UNKNOWN_DAMPING,    /* joint damping CL, lb s/ft */
    ADVISE_UNKNOWN_COUNT
};

/* Properties of the runway that are the same for all members. */
struct advise_runway {
    struct mr_chain_params chain; /* friction_lb is the configured value; step_s is not used */
    double grit_lb;               /* configured mean closing resistance of the joints */
    /* thrust of the lead axle on the mat strip per g of deceleration */
    double thrust_lb_per_g;
    /* share of the thrust that the strip carries, measured to within 3 %; 0: not measured */
    double thrust_share;
    double ground_irregularity_ft; /* irregularity of the ground; 0: unknown */
    float transducer_station_ft
        [MR_TRANSDUCERS]; /* stations of the transducers; NaN: none is fitted */
};

struct advise_member {
    double unknown[ADVISE_UNKNOWN_COUNT];
    float gap_ft[ADVISE_JOINTS];     /* opening of each joint; joint 1 is at [0] */
    float grit_ratio[ADVISE_JOINTS]; /* closing resistance of each joint divided by the mean */
};

struct advise_members {
    struct advise_runway runway;
    struct advise_member *member;
    size_t member_count; /* number of members, a multiple of 8 */
    unsigned thread_count;
    unsigned update_count; /* number of landings from which the ensemble was updated */
    bool is_surveyed; /* at least one segment of ten joints was surveyed since the mats were laid */
    struct rng rng;
};

/* Braking over time, relative to its mean: straight lines between points. Braking is constant
 * before the first point and after the last. count 0: uniform braking. */
struct advise_profile {
    size_t point_count;
    double t_s[ADVISE_PROFILE_MAX], factor[ADVISE_PROFILE_MAX];
};

double advise_braking_factor(const struct advise_profile *profile, double t_s);

/* Speed, touchdown and braking of the landing of one member. Braking increases from 0 within 60
 * ms. */
struct advise_braking {
    double speed_ft_s, touchdown_ft;
    /* mean deceleration, by which the factors of the profile are multiplied */
    double mean_braking_ft_s2;
    const struct advise_profile *profile; /* NULL: uniform braking */
};

double advise_braking_ft_s2(const struct advise_braking *braking, double t_s);

/* Outcome of the simulated landing of one member. */
struct advise_outcome {
    float zone_station_ft; /* where the wheel first reaches a zone of 50 mats; NaN: never */
    /* station at which the wheel stops; beyond the runway if the aircraft rolls off */
    float stop_station_ft;
    uint16_t longest_zone_mats; /* mats of the longest zone that the wheel reached */
    bool has_diverged;          /* the simulation diverged, so the other fields are not valid */
    float movement_in[MR_TRANSDUCERS]; /* movement at the end; NaN: no transducer is fitted */
    float segment_sum_in[MR_SEGMENTS]; /* sums of the openings of each segment at the end */
};

/* Draws the properties of `count` members (rounded up to a multiple of eight) from their prior
 * distributions. MR_USAGE: the parameters of the runway are invalid. Call advise_members_free in
 * every case. */
enum mr_status advise_members_draw(struct advise_members *members,
                                   const struct advise_runway *runway, size_t count, uint64_t seed);
void advise_members_free(struct advise_members *members);

/* Draws all openings again, because the mats were relaid. The other properties keep their updated
 * values. */
void advise_redraw_all_joints(struct advise_members *members);
/* Draws openings and closing resistances of joints `first` to `last` (counted from 0) again,
 * because their mats were replaced or relaid. */
void advise_redraw_joints(struct advise_members *members, unsigned first, unsigned last);
/* Sets the openings to the surveyed sums (NaN: not read), with an independent survey error for each
 * member. */
void advise_apply_survey(struct advise_members *members, const double sum_in[MR_SEGMENTS],
                         double error_in);
/* Simulates a landing on each member. With `updates_joint_state`, each member keeps the joint
 * openings at the end of the landing. Returns false if memory is insufficient. */
bool advise_simulate(struct advise_members *members, const struct advise_braking *braking,
                     bool updates_joint_state, struct advise_outcome *outcome);

/* What was measured in a landing. */
struct advise_observation {
    struct advise_braking braking;
    /* movement of each transducer at the end of the landing; NaN: not read */
    double movement_in[MR_TRANSDUCERS], movement_error_in;
    double survey_before_in[MR_SEGMENTS]; /* sums surveyed before the landing; NaN: not read */
    double survey_after_in[MR_SEGMENTS];  /* sums surveyed after the landing; NaN: not read */
    double survey_error_in;
};
/* Updates the ensemble from a landing: applies the survey before the landing, applies the readings
 * in two passes of the smoother, and then simulates the landing. Returns false if a simulation
 * diverged. */
bool advise_update(struct advise_members *members, const struct advise_observation *observation);

/* Multiplies the spread of the updated properties about their means by `factor` (above 1). Used
 * before a landing that is unlike the previous ones. */
void advise_widen_spread(struct advise_members *members, double factor);

/* The longest compression zone ahead of the wheel. A zone begins and ends with a closed joint (open
 * by less than 0.001 in). Among any ten consecutive joints in it, at most one is open. Joints are
 * counted from 0. 0 mats: there is no zone. */
struct advise_zone {
    unsigned first_mat, mat_count;
};
struct advise_zone advise_find_longest_zone(const float *opening_ft, unsigned joints,
                                            unsigned from);

/* Computes the geometric mean and the relative spread of a property over the members. */
void advise_parameter_moments(const struct advise_members *members, enum advise_unknown unknown,
                              double *mean, double *spread);

/* Ensemble smoother: updates the unknowns of an ensemble from readings, by the correlation between
 * unknowns and predicted readings among the members (Evensen 1994). Several passes with enlarged
 * errors are the method ES-MDA, Emerick and Reynolds 2013. The gain is reduced with distance as in
 * Chen and Oliver 2017. Lost spread is restored as in Whitaker and Hamill 2012. For a linear model
 * with Gaussian unknowns and many members it approaches the Kalman filter
 * (tests/host/test_advise.c). Pure functions, except for memory and random numbers. */

/* Inputs of a smoother pass. Unknowns and readings may have any units. The error of a reading has
 * the unit of the reading. */
struct smoother {
    size_t member_count, state_count, reading_count;
    double *state; /* [members][states]: unknowns of each member, which smoother_update changes */
    const double *predicted; /* [members][data]: readings as predicted by each member */
    const double *reading;   /* [data]: the readings; NaN: not read */
    /* [data]: standard errors, including the error of the model; above 0 */
    const double *reading_error;
    /* Factor by which the variance of the errors is multiplied. n passes with the factor n are
     * equivalent to one pass with the factor 1. */
    double reading_error_factor;
    /* Returns the weight, 0 to 1, with which a reading updates a state. A low weight suppresses
     * spurious correlations. NULL: all weights are 1. */
    double (*taper_weight)(const void *taper_context, size_t state, size_t datum);
    const void *context;
};

/* Runs one pass. The readings are perturbed for each member, with a mean perturbation of 0. Without
 * a reading, nothing changes. */
void smoother_update(const struct smoother *smoother, struct rng *rng);

/* Computes mean and standard deviation of column `column` of [members][states]. */
void smoother_moments(const double *state, size_t members, size_t states, size_t column,
                      double *mean, double *deviation);
/* Restores the fraction `restored_fraction` of the spread that a column has lost in an update;
 * `old_deviation` is its standard deviation before the update. The restored standard deviation is
 * at least `min_deviation`. */
void smoother_restore_spread(double *state, size_t members, size_t states, size_t column,
                             double old_deviation, double restored_fraction, double min_deviation);

/* A weight that falls smoothly from 1 at distance 0 to 0 at distance 2 `half` (Gaspari and Cohn
 * 1999, equation 4.10). */
double smoother_taper(double distance, double half);

/* Prediction of an ensemble for a planned landing: the probability that the wheel reaches a zone of
 * 50 mats, and the station of that zone, as functions of deceleration. These rows give the hardest
 * braking at which the probability stays below a limit.
 *
 * Probabilities are shares of the members, calibrated on series that are not scored
 * (advise_calibrate_share). Their 95 % intervals (Wilson 1927) cover only the finite number of
 * members, not the errors of model and inputs. All decelerations use the same random numbers, so
 * rows differ only by the braking. */

#define ADVISE_RUNWAY_PARTS        6u /* number of equal parts of the runway */
#define ADVISE_ROW_COUNT           9u
/* Relative standard deviation of a measured mean deceleration about the plan, if no earlier landing
 * is known. */
#define ADVISE_PLAN_DEFAULT_SPREAD 0.10

struct advise_plan {
    double speed_ft_s, speed_spread; /* touchdown speed; spreads are relative standard deviations */
    /* planned mean deceleration; the expected actual mean is exp(braking_log_bias) times the
     * planned one */
    double mean_braking_ft_s2, braking_spread, braking_log_bias;
    double touchdown_ft, touchdown_spread_ft;
    struct advise_profile profile; /* deceleration over time; count 0: uniform */
    uint64_t seed;
};

struct advise_probability {
    double probability, low, high;
};

struct advise_row {
    double speed_ft_s, mean_braking_ft_s2; /* planned touchdown speed and mean deceleration */
    double zone_share; /* share of the members in which the wheel reaches a zone, not calibrated */
    struct advise_probability zone_probability;
    /* probability that the wheel reaches a zone before the end of each part of the runway */
    struct advise_probability zone_probability_by_part[ADVISE_RUNWAY_PARTS];
    double off_runway_share; /* share of the members in which the aircraft rolls off the runway */
    /* median of the stations at which zones are reached; NaN: no member reaches a zone */
    double median_zone_station_ft;
};

/* Predicts how far the braking will deviate from the plan. `log_ratio` has `count` natural
 * logarithms of (measured / planned). Returns the mean and standard deviation of the predictive
 * distribution of the next logarithm. The prior is normal-inverse-gamma and has the weight of four
 * landings. Without landings the prediction is 0 +- ADVISE_PLAN_DEFAULT_SPREAD. */
void advise_predict_plan_deviation(const double *log_ratio, size_t count, double *bias,
                                   double *spread);

/* Draws speed, touchdown and braking of the landing of each member, for a planned mean deceleration
 * of `mean_braking_ft_s2`. */
void advise_draw_braking(const struct advise_members *members, const struct advise_plan *plan,
                         double mean_ft_s2, struct advise_braking *braking);

/* Simulates one planned landing on all members and computes its row. `braking` and `outcome` have
 * one element per member; the function writes the landings to them. Returns false if the landings
 * cannot be simulated. */
bool advise_compute_row(struct advise_members *members, const struct advise_plan *plan,
                        double mean_ft_s2, struct advise_braking *braking,
                        struct advise_outcome *outcome, struct advise_row *row);

/* Returns the probability of an event that occurs in `events` of `count` members, and its Wilson
 * interval, all calibrated. */
struct advise_probability advise_compute_probability(size_t events, size_t count, bool surveyed);
/* Converts a share of the members to a calibrated probability. The calibration corrects the log
 * odds (advise_convert_to_log_odds), by a fit to series that are not scored. Shares of 0 and 1 do
 * not give probabilities of 0 and 1. */
double advise_calibrate_share(double share, bool surveyed);
/* Returns the log odds of a share. The share is first limited to the range from 1/128 to 127/128,
 * half a member of 64 from either end. */
double advise_convert_to_log_odds(double share);

/* The mean deceleration that stops the gear at the end of the runway. */
double advise_compute_min_braking_ft_s2(const struct advise_members *members,
                                        const struct advise_plan *plan);

/* Returns the lowest braking of the rows (in ascending order) above which the probability of a zone
 * stays below `limit`; NaN if there is none or if all rows are below the limit. Such braking exists
 * if mats far from touchdown are closed from the start: harder braking then stops the gear before
 * it reaches them. */
double advise_find_stop_short_ft_s2(const struct advise_row *row, size_t rows, double limit);

/* The largest value up to which both the probability of a zone and the share of members that roll
 * off stay below a limit. Its 95 % interval covers only the error due to the finite number of
 * members. */
struct advise_limit_crossing {
    double value;      /* largest value; NaN: the first row is not below the limit */
    double low, high;  /* 95 % interval; NaN: no end on that side */
    bool is_unbounded; /* all rows are below the limit; `value` is that of the last row */
};
/* Finds the limit by linear interpolation between rows. `x`: ascending values of the quantity that
 * varies between rows, such as the touchdown speed. */
struct advise_limit_crossing advise_find_limit_crossing(const double *x,
                                                        const struct advise_row *row, size_t rows,
                                                        double limit);
/* Finds the first pair of adjacent rows that are more than `width` apart and enclose the limit or
 * an end of its interval. Returns the index of the first row of the pair, or `rows` if there is
 * none. */
size_t advise_find_wide_row_step(const double *x, const struct advise_row *row, size_t rows,
                                 double limit, double width);

#endif
