/* The predictor (common/predictor.h) on the board. It is armed with the landing and run on each
 * block after the readings. While a landing is recorded, its results are reported and used for
 * warnings; after the landing, the runway is updated. The runway persists from landing to landing
 * (firmware/runwaystore.h keeps it through resets).
 *
 * The output depends only on blocks, edges, commands, and the parameters and the runway at arming.
 * Parameters and runway are sent at arming, on both links and to the black box. There is one
 * exception: when PREDICT_BACKLOG_BLOCKS blocks are waiting, the predictor continues at the next
 * cheaper level and sends the message `backlog`; a replay repeats this with the command `backlog`.
 *
 * Commands set chart and plan (common/risk.h) for one landing: they apply to the next armed landing
 * and are dropped after it. common/risk.h defines the risk above which the lamp is switched on.
 *
 * The predictor runs last in the processing of a block, so it delays only the next block;
 * interrupts continue to collect blocks in the meantime. */
#ifndef MATRIG_FIRMWARE_PREDICT_H
#define MATRIG_FIRMWARE_PREDICT_H

#include "common/command.h"
#include "common/onboard/predict_feed.h"
#include "common/risk.h"
#include "common/predictor.h"
#include "common/runway.h"
#include "firmware/telemetry.h"

#define PREDICT_TRUST_BLOCKS     1000u
/* number of messages with joints per block; with two, all joints of 420 mats are sent in 70 ms */
#define PREDICT_JOINTS_PER_BLOCK 2u

struct predict {
    struct mr_predictor predictor;
    /* MR_OK: the predictor runs; MR_NOT_NOW: it is not configured; otherwise the reason why its
     * parameters are refused */
    enum mr_status status;
    struct mr_predictor_zone zone; /* newest result */
    struct predict_motion motion;
    bool is_warning;          /* state of the lamp */
    uint32_t reported_doubts; /* doubted transducers as last reported (bit mask) */
    uint32_t updates;         /* number of mat updates of the landing, as last reported */
    uint32_t trust_block;     /* block of the last message trust */
    bool has_backlog;
    uint32_t backlog_block;
    uint16_t backlog_command; /* number of waiting blocks set by the command backlog; 0: none */

    struct mr_risk_state risk;
    struct mr_risk_report risk_report; /* newest result */
    struct mr_risk_plan plan;          /* plan and chart for the next landing or the present one */
    struct mr_risk_plan staged_plan;   /* plan and chart received by commands but not active yet */
    bool has_plan;
    unsigned next_risk_item; /* next item of the plan to be sent; UINT32_MAX: none */
    /* risk above which the lamp is switched on; NaN: the verdict of the predictor decides */
    float lamp_limit;

    /* runway state to be sent (as it was at arming) or to be stored (runwaystore.h) */
    struct mr_predictor_state state;
    unsigned next_report_message; /* next message of the runway to be sent; UINT32_MAX: none */
    /* runway state received by commands but not active yet */
    struct mr_predictor_state staged_state;
    uint8_t source; /* origin of the runway state, enum mr_runway_source */
    /* the runway was set by a landing or a command, so the stored runway must not replace it */
    bool is_runway_set;
    bool is_dirty;     /* the runway has changed since it was stored */
    bool is_store_due; /* the message runway_store must be sent */
    uint32_t changed_block;
    uint32_t crc; /* CRC of the active runway */
};

/* Starts without chart and plan; call before predict_configure. */
void predict_start(struct predict *predict);
/* Call when the configuration is known or has changed. The runway is kept, also while no predictor
 * is configured, if its number of mats is the same and no joint is wider than the slack. Otherwise
 * the runway is reset to an unmeasured one, to which the survey is applied. */
void predict_configure(struct predict *predict, const float *slack_in);
/* Call when a landing is armed; its record begins with block `index`. `slack_in`: the survey,
 * MR_SEGMENTS values; NaN: not surveyed since a landing. */
void predict_arm(struct predict *predict, struct telemetry *telemetry, const float *slack_in,
                 uint32_t index);
/* Writes parameters and runway into the black box's record of the landing that was just armed. */
void predict_store_in_box(struct predict *predict, struct telemetry *telemetry,
                          const uint8_t *copy);
/* Activates the stored runway, which the caller has read into `state`, and applies the survey
 * (MR_SEGMENTS values) to it. Does nothing if a landing or command has set a runway since the
 * start. Returns MR_OK or the reason for failure. */
enum mr_status predict_load(struct predict *predict, enum mr_runway_source source,
                            const float *slack_in);
/* Returns the active runway for storage. When it has been stored, call predict_mark_stored. */
const struct mr_predictor_state *predict_get_state(struct predict *predict);
/* Call when the runway has been stored; `crc`: CRC of the stored runway. */
void predict_mark_stored(struct predict *predict, uint32_t crc);
/* Call every second and after a change. `copy`: states of the two stored copies, with the values of
 * the message runway_store. */
void predict_send_regular(struct predict *predict, struct telemetry *telemetry, const uint8_t *copy,
                          uint32_t index);
/* Call in each block: runs the predictor while a landing is recorded; otherwise sends only the
 * messages that are due. */
void predict_on_block(struct predict *predict, struct telemetry *telemetry,
                      const struct landing *landing, const struct predict_block *block);
/* Call when the landing has ended or is disarmed. The runway is updated if a gear has rolled, or if
 * two transducers have moved without any switch opening. Returns true if it was, so that a survey
 * no longer applies. */
bool predict_end(struct predict *predict, struct telemetry *telemetry,
                 const struct landing *landing, uint32_t index);
void predict_set_survey(struct predict *predict, const float *slack_in, uint32_t index);
/* Executes the command `backlog`, if a landing is armed or in progress. */
enum mr_status predict_set_backlog(struct predict *predict, int32_t waiting);
/* Executes the commands runway-* and chart-*. Sets `is_survey_discarded` if the survey no longer
 * applies. */
enum mr_status predict_execute_command(struct predict *predict, struct telemetry *telemetry,
                                       const struct mr_command *command, uint32_t index,
                                       bool *is_survey_discarded);

#endif
