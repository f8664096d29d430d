/* Risk of a landing: the probability that the wheel will reach a zone of 50 compressed mats
 * (MR_PREDICTOR_WARNING_MATS) before it stops. Inputs are the predictor's zones, the transducers
 * and survey without it, braking now and to come, distance left and configured friction; and, where
 * the host has sent them before the landing, the planned braking (the plan) and the prediction of
 * an ensemble of runways (the chart, host/advise).
 *
 * It is a logistic rule, a set of weights for each kind of knowledge (risk_weights.def), fitted on
 * series of landings that are not scored (tests/score/README.md, "Risk during the landing").
 *
 * The plan. While the speed lost since touchdown is 0.6 to 1.6 times what the plan would have lost,
 * braking to come is the plan's times that ratio; when it is not for 0.3 s, plan and chart are
 * dropped for the rest of the landing. A chart is made for the runway of one landing: it applies as
 * long as the runway has had as many landings as when it was made.
 *
 * A function of the predictor and of its inputs alone: board and host agree on every bit. No heap,
 * single precision, no library call. Feet, pounds, seconds. */
#ifndef MATRIG_COMMON_RISK_H
#define MATRIG_COMMON_RISK_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/predictor.h"

#define MR_RISK_ROWS             9u
#define MR_RISK_KNOTS            12u
/* mats inside a zone where failure is expected: 10 to 15 (report 6.1.4) */
#define MR_RISK_FAILURE_MATS     12.5f
/* joints looked at in a block, of the search at the planned braking */
#define MR_RISK_VISITS_PER_BLOCK 32u

/* What the host gives before a landing. NaN: none; rows and knots end with the first. */
struct mr_risk_plan {
    float landings;   /* of the runway when the chart was made */
    float speed_ft_s; /* at touchdown */
    /* chart: mean decelerations, rising; the logarithm of the odds of a zone p / (1 - p); the
     * station where half of the members that come to one have come to it */
    float row_ft_s2[MR_RISK_ROWS], row_odds[MR_RISK_ROWS], row_ft[MR_RISK_ROWS];
    /* braking over the time from touchdown, straight lines between */
    float knot_s[MR_RISK_KNOTS], knot_ft_s2[MR_RISK_KNOTS];
};
#define MR_RISK_ITEMS (2u + 3u * MR_RISK_ROWS + 2u * MR_RISK_KNOTS)
/* What message risk_item carries: chart and plan, then the lamp's limit. */
#define MR_RISK_TOLD  (MR_RISK_ITEMS + 1u)

void mr_risk_plan_clear(struct mr_risk_plan *plan);
/* As a list of MR_RISK_ITEMS numbers, in the order of the struct. NaN beyond the list. */
float mr_risk_item(const struct mr_risk_plan *plan, unsigned item);
/* False: no such item. */
bool mr_risk_item_set(struct mr_risk_plan *plan, unsigned item, float value);
/* CRC-32 of the list, IEEE 754 singles, little-endian, every NaN alike. */
uint32_t mr_risk_plan_crc(const struct mr_risk_plan *plan);
/* MR_OK; MR_USAGE: it makes no sense: no speed, no braking, decelerations or times that do not
 * rise, odds or stations that are none. A chart needs a plan, a plan no chart. */
enum mr_status mr_risk_plan_check(const struct mr_risk_plan *plan);

/* What the rule is made of; each is about 1 in size. */
enum mr_risk_input {
    MR_RISK_ONE,
    MR_RISK_COMING,    /* the zone to come by the predictor, 50 mats at most, 50 */
    MR_RISK_KINEMATIC, /* closed by transducers and survey alone, 50 mats */
    MR_RISK_OVER,      /* 0 for a zone to come of 40 mats, 1 from 60 on */
    MR_RISK_BRAKING,   /* the largest to come, else now, 6 ft/s2 */
    MR_RISK_WAY,       /* left to the stop, 50 ft; of no weight where a long zone is expected */
    MR_RISK_FRICTION,  /* told, 0.6 */
    MR_RISK_COUNT,     /* of landings, up to six of them, 3 */
    MR_RISK_OPEN,      /* mean opening of the joints on that way, 0.015 in */
    MR_RISK_PLANNED,   /* as COMING and OVER, at the braking planned: the mean of both */
    MR_RISK_CHART,     /* log odds of the chart at the mean deceleration */
    MR_RISK_INPUTS
};
/* Sets of weights: knowledge of the plan, twice for braking known or not, and twice for no
 * transducer. */
#define MR_RISK_NO_PLAN   0u
#define MR_RISK_BY_PLAN   4u
#define MR_RISK_BY_CHART  8u
#define MR_RISK_BRAKED    2u
#define MR_RISK_NO_SENSOR 1u
#define MR_RISK_SETS      12u

struct mr_risk_state {
    struct mr_risk_plan plan;
    bool planned, charted, old; /* given and in force; old: given, of another runway */
    bool left;                  /* the plan was not followed */
    float touchdown_ft;
    bool down;
    float down_ft_s;     /* speed at touchdown */
    float since_s;       /* touchdown */
    float mean_ft_s2;    /* the plan's, over its way */
    float lost_ft_s;     /* of speed since, by the plan */
    float met;           /* braking so far over the plan's */
    uint16_t off_blocks; /* in a row in which it was off */
    float hard_ft_s2;    /* the largest braking to come */
    float hard_in_ft;    /* way until it begins */
    float way_ft;        /* left */
    struct mr_zonescan scan;
    bool scanning;
    unsigned scan_group;
    unsigned planned_mats; /* zone to come at the planned braking */
};

/* One statement. */
struct mr_risk_said {
    float risk;     /* NaN: unknown, without motion and plan */
    unsigned basis; /* bits of enum mr_risk_basis */
    enum mr_risk_reason reason;
    /* until the wheel is at the zone's start, and where failure is expected; NaN: no zone is
     * expected, or the wheel stops before it; the station of the latter */
    float start_s, failure_s, failure_ft;
    /* what it was made of */
    unsigned set;
    float input[MR_RISK_INPUTS];
};

/* A landing begins, after mr_predictor_arm. `plan`: NULL, or what was given, checked. */
void mr_risk_arm(struct mr_risk_state *risk, const struct mr_risk_plan *plan,
                 const struct mr_predictor *predictor, float touchdown_ft);
/* Each block, after mr_predictor_block with the same input. */
void mr_risk_block(struct mr_risk_state *risk, const struct mr_predictor *predictor,
                   const struct mr_predictor_input *input);
/* The risk now; `zone`: mr_predictor_zone of now. */
void mr_risk_say(struct mr_risk_state *risk, const struct mr_predictor *predictor,
                 const struct mr_predictor_zone *zone, struct mr_risk_said *said);

/* Limit of the risk from which the lamp warns. A missed warning costs `cost_ratio` times a needless
 * one, so a warning pays from 1 / (1 + cost_ratio) on. NaN: the lamp follows the verdict. */
float mr_risk_lamp_limit(float cost_ratio);
/* Does the lamp warn? Without a limit or a risk it follows the verdict. */
bool mr_risk_lamp(float limit, const struct mr_predictor_zone *zone,
                  const struct mr_risk_said *said);

/* 1 / (1 + exp(-x)) to 1e-6. */
float mr_risk_logistic(float x);

#endif
