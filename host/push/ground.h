/* What push tests say of the ground under the gear: which law it has, and the scene keys gear_* of
 * the elastic one with 95 % intervals.
 *
 * Each test is fitted alone (fit.h); then the tests are held together. Stiffness by the load:
 *
 *     ln(K / mats) = ln k + axle_law ln(load / axle load) + place
 *
 * k is that of one mat under the load of one axle, as the scene key gear_k_lb_ft has it: K is
 * divided by the mats that the load presses, as a mat brings all of its ground to bear. Where tests
 * differ by more than their readings explain, places differ: their scatter is estimated (Paule and
 * Mandel), and Student's t of the tests widens the interval. It takes two tests more than
 * parameters to do so always; with one more it is done where they contradict each other.
 *
 * The law is the one that the tests make PUSH_ODDS times as likely as the other, both as likely
 * before; else nobody can tell. What is not told has value NaN and a reason. */
#ifndef MATRIG_HOST_PUSH_GROUND_H
#define MATRIG_HOST_PUSH_GROUND_H

#include <stdbool.h>

#include "host/base/answer.h"
#include "host/push/fit.h"

#define PUSH_ODDS           20.0
#define PUSH_REASON         200u
#define PUSH_MATS_MOST      4u /* gear_foot_ft */
/* Report 2.6: 120 lb sink by 0.050 in; 2 (1 - nu)/(2 - nu) = 0.82 of that along the ground
 * (Mindlin, nu 0.3), half of it under each of two mats. */
#define PUSH_EXPECTED_LB_FT 11800.0

struct push_setting {
    struct push_gages gages;
    unsigned mats;        /* that the load presses, and that move together */
    double mat_weight_lb; /* 0: not known, left out of the friction */
    double axle_load_lb;  /* 0: the least load tested */
};

enum push_law { PUSH_UNDECIDED, PUSH_ELASTIC, PUSH_RIGID };

struct push_told {
    struct push_interval of;  /* value NaN: not told */
    char reason[PUSH_REASON]; /* why not; or what the value rests on */
};

struct push_ground {
    enum push_law law;
    double log_odds; /* natural: elastic against rigid, all tests */
    struct push_told k_lb_ft, unloading, axle_law, friction;
    double axle_load_lb;
    double spread;  /* of ln k from place to place; NaN: too few tests */
    bool poor;      /* readings scatter more than the gages explain (by chance once in 1,000) */
    double stretch; /* of the intervals by that, at least 1 */
    double scatter; /* of the readings, in stated errors */
    size_t untold;  /* tests whose stiffness is not told */
    struct push_fit *fit; /* of each test; allocated */
};

/* MR_TOO_FEW as push_fit; MR_NUMERICS. The caller frees it, also when it fails. */
enum mr_status push_ground_find(const struct push_readings *readings,
                                const struct push_setting *setting, struct push_ground *ground,
                                struct error *error);
void push_ground_free(struct push_ground *ground);

/* What push tests say, for people, programs and pages (host/base/answer.h). */

/* The law and what it rests on; what is not told, with the reason; for which rig it holds. */
void push_answer_law(struct answer *answer, const struct push_ground *ground,
                     const struct push_setting *setting);
/* A row for each test. */
void push_answer_tests(struct answer *answer, const struct push_readings *readings,
                       const struct push_ground *ground);

#endif
