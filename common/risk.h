/* Risk of a landing: the probability that the wheel will reach a zone of 50 compressed mats
 * (MR_PREDICTOR_WARNING_MATS) before it stops. Inputs are the predictor's zones, the zone from
 * transducers and survey only, present and future braking, the remaining distance and the
 * configured friction. If the host has sent them before the landing, the planned braking (the plan)
 * and the prediction of an ensemble of runways (the chart, host/advise) are inputs too.
 *
 * The risk is a logistic regression with a set of weights for each combination of known inputs
 * (risk_weights.def). It was fitted to series of landings that are not scored
 * (tests/score/README.md, "Risk during the landing").
 *
 * Plan: while the loss of speed since touchdown is 0.6 to 1.6 times the planned loss, the future
 * braking is the plan's multiplied by that ratio. When the ratio has been outside this range for
 * 0.3 s, plan and chart are not used for the rest of the landing. A chart is valid for one landing
 * only: the runway must have the same number of landings as when the chart was made.
 *
 * The risk is a function of the predictor and its inputs only: board and host agree on every bit.
 * No heap, single precision, no library call. Feet, pounds, seconds. */
#ifndef MATRIG_COMMON_RISK_H
#define MATRIG_COMMON_RISK_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/predictor.h"

#define MR_RISK_CHART_ROWS       9u
#define MR_RISK_PLAN_KNOTS       12u
/* failure is expected this many mats inside a zone; the report (6.1.4) gives 10 to 15 */
#define MR_RISK_FAILURE_MATS     12.5f
/* joints examined per block in the search at the planned braking */
#define MR_RISK_VISITS_PER_BLOCK 32u

/* Plan and chart, sent by the host before a landing. NaN: not given; the first NaN ends the list of
 * rows or knots. */
struct mr_risk_plan {
    float landing_count; /* number of landings of the runway when the chart was made */
    float speed_ft_s;    /* planned speed at touchdown */
    /* chart: mean decelerations in ascending order; the logarithm of the odds p / (1 - p) of a
     * zone; the median station at which the simulated runways of the ensemble reach a zone */
    float chart_deceleration_ft_s2[MR_RISK_CHART_ROWS], chart_log_odds[MR_RISK_CHART_ROWS],
        chart_zone_ft[MR_RISK_CHART_ROWS];
    /* planned braking as a function of the time since touchdown, linear between knots */
    float plan_time_s[MR_RISK_PLAN_KNOTS], plan_deceleration_ft_s2[MR_RISK_PLAN_KNOTS];
};
#define MR_RISK_PLAN_ITEM_COUNT   (2u + 3u * MR_RISK_CHART_ROWS + 2u * MR_RISK_PLAN_KNOTS)
/* Items of the message risk_item: chart and plan, then the limit of the lamp. */
#define MR_RISK_REPORT_ITEM_COUNT (MR_RISK_PLAN_ITEM_COUNT + 1u)

void mr_risk_plan_clear(struct mr_risk_plan *plan);
/* Item of the plan as a list of MR_RISK_PLAN_ITEM_COUNT numbers, in the order of the struct; NaN
 * beyond the list. */
float mr_risk_plan_get_item(const struct mr_risk_plan *plan, unsigned item);
/* Sets an item of the plan. False: no such item. */
bool mr_risk_plan_set_item(struct mr_risk_plan *plan, unsigned item, float value);
/* CRC-32 of the list as little-endian IEEE 754 singles; every NaN is written with the same bits. */
uint32_t mr_risk_plan_crc(const struct mr_risk_plan *plan);
/* Checks a plan. MR_USAGE: no speed or no braking, decelerations or times not in ascending order,
 * or impossible odds or stations. A chart is allowed only with a plan; a plan may have no chart. */
enum mr_status mr_risk_plan_check(const struct mr_risk_plan *plan);

/* Inputs of the regression, each divided by a scale so that its magnitude is about 1. */
enum mr_risk_input {
    MR_RISK_CONSTANT,
    MR_RISK_FUTURE,    /* predicted future zone, limited to 50 mats; divided by 50 mats */
    MR_RISK_KINEMATIC, /* zone from transducers and survey only; divided by 50 mats */
    MR_RISK_EXCESS,    /* 0 for a future zone of 40 mats, rising to 1 at 60 */
    /* hardest future braking if a plan is used, otherwise present braking; divided by 6 ft/s2 */
    MR_RISK_BRAKING,
    /* remaining distance to the stop, with less weight where a long zone is expected; divided by 50
     * ft */
    MR_RISK_DISTANCE,
    MR_RISK_FRICTION, /* configured friction; divided by 0.6 */
    MR_RISK_LANDINGS, /* number of landings, up to six; divided by 3 */
    /* mean opening of the joints over the remaining distance; divided by 0.015 in */
    MR_RISK_OPENING,
    MR_RISK_PLANNED, /* mean of FUTURE and EXCESS, computed for the planned braking */
    MR_RISK_CHART,   /* logarithm of the chart's odds at the mean deceleration */
    MR_RISK_INPUT_COUNT
};
/* Numbers of the sets of weights: a base that depends on which of plan and chart are known, plus
 * one number if braking is known and one if there is no transducer. */
#define MR_RISK_WEIGHTS_NO_PLAN      0u
#define MR_RISK_WEIGHTS_PLAN         4u
#define MR_RISK_WEIGHTS_CHART        8u
#define MR_RISK_WEIGHTS_IF_BRAKING   2u
#define MR_RISK_WEIGHTS_IF_NO_SENSOR 1u
#define MR_RISK_WEIGHT_SET_COUNT     12u

struct mr_risk_state {
    struct mr_risk_plan plan;
    /* has_plan, has_chart: received and in use; is_chart_stale: received for another state of the
     * runway */
    bool has_plan, has_chart, is_chart_stale;
    bool has_deviated_from_plan; /* the landing deviated from the plan */
    float touchdown_ft;
    bool has_touched_down;
    float touchdown_ft_s;                  /* speed at touchdown */
    float since_touchdown_s;               /* time since touchdown */
    float planned_mean_deceleration_ft_s2; /* mean of the planned decelerations over distance */
    float planned_speed_loss_ft_s;         /* planned loss of speed since touchdown */
    float speed_loss_ratio;                /* measured loss of speed / planned loss of speed */
    /* number of consecutive blocks in which speed_loss_ratio was outside its range */
    uint16_t deviating_blocks;
    float hardest_braking_ft_s2;       /* hardest future braking */
    float hardest_braking_distance_ft; /* distance until the hardest future braking begins */
    float stopping_distance_ft;        /* remaining distance to the stop */
    struct mr_zonescan scan;
    bool is_scanning;
    unsigned scan_group;
    unsigned planned_mats; /* length of the future zone at the planned braking */
};

/* One report of the risk. */
struct mr_risk_report {
    float risk;     /* NaN: unknown, because there is neither motion nor a plan */
    unsigned basis; /* bits of enum mr_risk_basis */
    enum mr_risk_reason reason;
    /* times until the wheel reaches the start of the zone and the station of the expected failure,
     * and that station; NaN: no zone is expected, or the wheel stops before it */
    float start_s, failure_s, failure_ft;
    /* bit mask of the used set of weights and inputs */
    unsigned weight_set;
    float input[MR_RISK_INPUT_COUNT];
};

/* Begins a landing; call after mr_predictor_arm. `plan`: checked by mr_risk_plan_check, or NULL. */
void mr_risk_arm(struct mr_risk_state *risk, const struct mr_risk_plan *plan,
                 const struct mr_predictor *predictor, float touchdown_ft);
/* Call in each block, after mr_predictor_on_block with the same input. */
void mr_risk_on_block(struct mr_risk_state *risk, const struct mr_predictor *predictor,
                      const struct mr_predictor_input *input);
/* Computes the current risk. `zone`: the current result of mr_predictor_get_zone. */
void mr_risk_compute(struct mr_risk_state *risk, const struct mr_predictor *predictor,
                     const struct mr_predictor_zone *zone, struct mr_risk_report *report);

/* Returns the risk above which the lamp is switched on. A missed warning is assumed to cost
 * `cost_ratio` times as much as a false alarm, so the limit is 1 / (1 + cost_ratio). NaN: the
 * verdict of the predictor alone switches the lamp. */
float mr_risk_lamp_limit(float cost_ratio);
/* True if the lamp must be on. Without a limit or a risk, the verdict of the predictor decides. */
bool mr_risk_is_lamp_on(float limit, const struct mr_predictor_zone *zone,
                        const struct mr_risk_report *report);

/* 1 / (1 + exp(-x)), accurate to 1e-6. */
float mr_risk_logistic(float x);

#endif
