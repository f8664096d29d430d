/* The predictor (common/predictor.h) on the board: armed with the landing, run on each block after
 * its readings, reported and used for warnings while a landing is recorded, folded when it is done.
 * Its runway persists from landing to landing (firmware/runwaystore.h keeps it through resets).
 *
 * Its output follows from blocks, edges, commands, the parameters and the runway it was armed with;
 * the last two are sent when armed, on both links and to the black box. There is one more input:
 * when PREDICT_BACKLOG_BLOCKS are waiting at its turn, it continues at the next cheaper level and
 * sends the message backlog; a replay repeats that by the command backlog.
 *
 * Chart and plan (common/risk.h) are set for one landing, by commands: they apply to the next one
 * armed and are dropped when it is over. When the lamp warns by the risk is common/risk.h's.
 *
 * It runs last in the work of a block: only the next block waits for it, and interrupts collect
 * those. */
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
    uint32_t updates;    /* in the landing, when last reported */
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

    /* the one a landing was armed with, to be sent; or kept: runwaystore.h */
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
 * an unmeasured runway, apart from the survey. */
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
/* `copy`: the two in the memory, as in the message runway_store. Each second, and when something
 * changed. */
void predict_regular(struct predict *predict, struct telemetry *telemetry, const uint8_t *copy,
                     uint32_t index);
/* Each block: all of it while recording, else only what is to be sent. */
void predict_block(struct predict *predict, struct telemetry *telemetry,
                   const struct landing *landing, const struct predict_block *block);
/* The landing is over, or being disarmed. When a gear rolled, or two transducers moved without any
 * switch, the joints have changed; otherwise the runway is as before. True: the survey, if any, is
 * used up. */
bool predict_end(struct predict *predict, struct telemetry *telemetry,
                 const struct landing *landing, uint32_t index);
void predict_survey(struct predict *predict, const float *slack_in, uint32_t index);
/* The command backlog, while a landing is armed or goes on. */
enum mr_status predict_backlog(struct predict *predict, int32_t waiting);
/* Commands runway-* and chart-*. True in `forgotten`: the survey holds no more. */
enum mr_status predict_obey(struct predict *predict, struct telemetry *telemetry,
                            const struct mr_command *command, uint32_t index, bool *forgotten);

#endif
