/* The ground under the gear from push tests: which law applies, and the scene keys gear_* of the
 * elastic law with 95 % intervals.
 *
 * Each test is fitted separately (fit.h); then the tests are combined. Stiffness as a function of
 * load:
 *
 *     ln(K / mats) = ln k + axle_law ln(load / axle load) + place
 *
 * k belongs to one mat under the load of one axle, like the scene key gear_k_lb_ft: K is divided by
 * the number of mats under the load, because the ground under a mat acts over its whole length. If
 * tests differ by more than their reading errors explain, the ground differs between places. The
 * scatter between places is then estimated (Paule and Mandel), and Student's t for the number of
 * tests widens the interval. This is done if there are at least two more tests than parameters;
 * with one more test, only if the tests contradict each other.
 *
 * A law is chosen if the tests make it PUSH_ODDS_MIN times as likely as the other law, with equal
 * prior odds; otherwise the law is undecided. A parameter that is not determined has value NaN and
 * a reason. */
#ifndef MATRIG_HOST_PUSH_GROUND_H
#define MATRIG_HOST_PUSH_GROUND_H

#include <stdbool.h>

#include "host/base/answer.h"
#include "host/push/fit.h"

#define PUSH_ODDS_MIN                 20.0
#define PUSH_REASON_SIZE              200u
/* largest number of mats under the load, as for gear_foot_ft */
#define PUSH_MATS_MAX                 4u
/* Stiffness along the ground of one mat, expected from report 2.6: a load of 120 lb sinks by 0.050
 * in, and the stiffness along the ground is 2 (1 - nu)/(2 - nu) = 0.82 of that (Mindlin, nu 0.3);
 * two mats share this stiffness. */
#define PUSH_EXPECTED_STIFFNESS_LB_FT 11800.0

struct push_setting {
    struct push_errors gage_errors;
    unsigned mat_count;   /* number of mats under the load, which move together */
    double mat_weight_lb; /* 0: not known; the friction then excludes the weight of the mats */
    double axle_load_lb;  /* 0: the smallest load of the tests is used */
};

enum push_law { PUSH_UNDECIDED, PUSH_ELASTIC, PUSH_RIGID };

struct push_parameter {
    struct push_interval interval; /* value NaN: not determined */
    /* why the parameter is not determined, or what the value is based on */
    char reason[PUSH_REASON_SIZE];
};

struct push_ground {
    enum push_law law;
    double log_odds; /* natural logarithm of the odds of elastic to rigid, from all tests */
    struct push_parameter k_lb_ft, unloading_ratio, axle_law, friction;
    double axle_load_lb;
    double spread; /* scatter of ln k between places; NaN: too few tests */
    /* the readings scatter more than the stated errors explain (by chance in 1 of 1,000 tests) */
    bool has_excess_scatter;
    double interval_factor;    /* factor, at least 1, by which this scatter widens the intervals */
    double scatter;            /* scatter of the readings divided by the stated errors */
    size_t undetermined_count; /* number of tests whose stiffness is not determined */
    struct push_fit *fit;      /* one fit per test; allocated */
};

/* Combines all tests. MR_TOO_FEW as push_fit. MR_NUMERICS: the fit failed. The caller frees
 * `ground`, also after a failure. */
enum mr_status push_ground_estimate(const struct push_readings *readings,
                                    const struct push_setting *setting, struct push_ground *ground,
                                    struct error *error);
void push_ground_free(struct push_ground *ground);

/* Adds the law and its evidence, the reason for each parameter that is not determined, and the rig
 * for which the results are valid. */
void push_add_law(struct answer *answer, const struct push_ground *ground,
                  const struct push_setting *setting);
/* Adds one row per test. */
void push_add_tests(struct answer *answer, const struct push_readings *readings,
                    const struct push_ground *ground);

#endif
