/* The predictor (common/predictor.h) on the board: armed with the landing, given each block after
 * its readings, told and warned by while a landing is recorded, folded when it is done. What it
 * knows of the runway lives on from landing to landing (firmware/runwaystore.h keeps it through
 * resets).
 *
 * Everything it says follows from blocks, edges, commands, the parameters and the runway it was
 * armed with: these two are told when armed, on both links and in the black box. One thing more is
 * an input: when PREDICT_BACKLOG_BLOCKS wait as its turn comes, it goes on at the next cheaper
 * level, and the message backlog says so; a replay gives that by the command backlog.
 *
 * Chart and plan (common/risk.h) are given for one landing, by commands: they are in force for the
 * next one armed, and forgotten when it is over. When the lamp warns by the risk is
 * common/risk.h's.
 *
 * It runs last of what a block brings: nothing waits for it but the next block, and those are taken
 * by interrupts. */
#ifndef MATRIG_FIRMWARE_PREDICT_H
#define MATRIG_FIRMWARE_PREDICT_H

#include "common/command.h"
#include "common/onboard/predict_feed.h"
#include "common/risk.h"
#include "common/predictor.h"
#include "common/runway.h"
#include "firmware/telemetry.h"

#define PREDICT_TRUST_BLOCKS     1000u
#define PREDICT_JOINTS_PER_BLOCK 2u /* messages: all of 420 mats in 70 ms */

struct predict {
    struct mr_predictor predictor;
    /* MR_OK: it runs; MR_NOT_NOW: none is configured; else why it was refused */
    enum mr_status status;
    struct mr_predictor_zone zone; /* newest */
    struct predict_motion motion;
    bool warning;        /* the lamp's */
    uint32_t doubts;     /* as told */
    uint32_t updates;    /* of the landing, when last told */
    uint32_t told_block; /* of the message trust */
    bool hurried;
    uint32_t hurried_block;
    uint16_t backlog_given; /* by command; 0: none */

    struct mr_risk_state risk;
    struct mr_risk_said risk_said;  /* newest */
    struct mr_risk_plan plan;       /* for the next landing, or of this one */
    struct mr_risk_plan plan_given; /* by commands, to be taken */
    bool has_plan;
    unsigned telling_risk; /* next of its items; UINT32_MAX: none */
    float lamp_limit;      /* of the risk; NaN: the lamp follows the verdict */

    /* the one a landing was armed with, to be told; or kept: runwaystore.h */
    struct mr_predictor_state state;
    unsigned telling;                /* next of its messages; UINT32_MAX: none */
    struct mr_predictor_state given; /* by commands, to be taken */
    uint8_t source;                  /* enum mr_runway_source */
    /* by a landing or a command: what is in the memory is not loaded over it */
    bool given_whole;
    bool dirty;     /* changed since it was kept */
    bool store_due; /* message runway_store */
    uint32_t changed_block;
    uint32_t crc; /* of the runway in force */
};

/* Neither chart nor plan; before predict_configure. */
void predict_start(struct predict *predict);
/* The configuration is another one, or known now. The runway stays what it was, also while no
 * predictor is configured, if it has as many mats and no joint is wider than the slack; else it is
 * one that nobody has measured, but for the survey. */
void predict_configure(struct predict *predict, const float *slack_in);
/* A landing is armed; its record begins with block `index`. `slack_in`: the survey, MR_SEGMENTS;
 * NaN: not surveyed since a landing. */
void predict_arm(struct predict *predict, struct telemetry *telemetry, const float *slack_in,
                 uint32_t index);
/* Into the black box's record of the landing just armed. */
void predict_store(struct predict *predict, struct telemetry *telemetry, const uint8_t *copy);
/* The runway found in the memory is in `state`: it is in force unless one was given meanwhile, the
 * survey (MR_SEGMENTS) on top of it. MR_OK, or why not. */
enum mr_status predict_load(struct predict *predict, enum mr_runway_source source,
                            const float *slack_in);
/* The runway in force, to be kept; then: it is. */
const struct mr_predictor_state *predict_state(struct predict *predict);
/* `crc`: of the one that is kept. */
void predict_kept(struct predict *predict, uint32_t crc);
/* `copy`: the two in the memory, as the message runway_store tells them. Each second, and when
 * something changed. */
void predict_regular(struct predict *predict, struct telemetry *telemetry, const uint8_t *copy,
                     uint32_t index);
/* Each block: while recorded all of it, else what is to be told. */
void predict_block(struct predict *predict, struct telemetry *telemetry,
                   const struct landing *landing, const struct predict_block *block);
/* The landing is over, or being disarmed. When a gear rolled, or two transducers moved and no
 * switch said anything, the joints are others now; else it was armed for nothing. True: the survey,
 * if any, is used up. */
bool predict_end(struct predict *predict, struct telemetry *telemetry,
                 const struct landing *landing, uint32_t index);
void predict_survey(struct predict *predict, const float *slack_in, uint32_t index);
/* The command backlog, while a landing is armed or goes on. */
enum mr_status predict_backlog(struct predict *predict, int32_t waiting);
/* Commands runway-* and chart-*. True in `forgotten`: the survey holds no more. */
enum mr_status predict_obey(struct predict *predict, struct telemetry *telemetry,
                            const struct mr_command *command, uint32_t index, bool *forgotten);

#endif
