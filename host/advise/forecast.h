/* What an ensemble says of a landing that is planned: how probable it is that the wheel comes to a
 * zone of 50 mats, and where, against the deceleration; the hardest braking that stays below a
 * limit.
 *
 * Probabilities are shares of the members, made less timid by what series that are not scored have
 * shown (advise_calibrated). Their intervals (95 %, Wilson 1927) are of the number of members
 * alone: what model and inputs may be wrong by is not in them. All decelerations are played with
 * the same draws, so that rows differ by the braking alone. */
#ifndef MATRIG_HOST_ADVISE_FORECAST_H
#define MATRIG_HOST_ADVISE_FORECAST_H

#include "host/advise/members.h"

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
    double mean_ft_s2;
    double share; /* of the members that come to a zone, as counted */
    struct advise_chance zone;
    struct advise_chance by_station[ADVISE_STATIONS]; /* come to by the end of each part */
    double off_runway;                                /* share of the members that roll off */
    double half_ft; /* where half of those that come to a zone have come to it; NaN: none does */
};

/* How a planned mean deceleration was met: natural logarithms of (measured / planned), `count` of
 * them. Predictive mean and standard deviation of the next one, from a normal-inverse-gamma prior
 * that without landings says 0 +- ADVISE_PLAN_MET and counts as four landings. */
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

/* Hardest braking up to which the probability of a zone stays below `limit`,
 * between rows (ascending) in proportion. NaN: the first is not below; *beyond: all of them are,
 * and it is the last row's. Where mats are closed already far from touchdown, harder braking stops
 * before them: *short_ft_s2 is the least of the rows from which on all are below again, NaN: there
 * is none. */
double advise_hardest_ft_s2(const struct advise_row *row, size_t rows, double limit, bool *beyond,
                            double *short_ft_s2);

#endif
