/* The board's messages during a landing: block records, means, state, motion, results. */
#ifndef MATRIG_FIRMWARE_LANDINGLINK_H
#define MATRIG_FIRMWARE_LANDINGLINK_H

#include "common/block.h"
#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

/* The block's record, on serial. */
void landinglink_block(struct telemetry *telemetry, const struct mr_block *block);
/* Means, on CAN: serial has the block records. `fitted`: bit i, transducer or gage i is there.
 * Messages without any that is are not sent. */
void landinglink_displacements(struct telemetry *telemetry, const float value_in[MR_TRANSDUCERS],
                               uint32_t fitted, uint32_t index);
void landinglink_tensions(struct telemetry *telemetry, const float value_lb[MR_GAGES],
                          uint32_t fitted, uint32_t index);
void landinglink_state(struct telemetry *telemetry, const struct landing *landing);
/* The motion that follows from the gates so far, at block `index`; of the whole landing, when it is
 * over. With standard errors, the clock's in them. */
void landinglink_motion(struct telemetry *telemetry, const struct mr_motion_estimate *motion,
                        uint32_t index);
void landinglink_summary(struct telemetry *telemetry, const struct mr_gates_summary *summary);
/* What block `index` made of the landing: edges, push-back, motion, summary, state, in this
 * order. */
void landinglink_news(struct telemetry *telemetry, const struct landing *landing,
                      const struct landing_news *news, uint32_t index);

/* ---- live ---- */

/* Live mode, by command: while idle, for an inspection of the rig, edges are sent as they occur and
 * a block record goes out on serial each 20 blocks (schedule.def). Nothing is recorded, no state
 * changes: a rig walked along by hand makes no landing. Ends by itself, with arming, or with 0
 * seconds, so that a host that disconnected leaves no traffic behind. */

#define LIVE_MOST_S 60

struct live {
    uint32_t until_block;
};

/* The command, while idle; `index` of the block to come. MR_USAGE: more than LIVE_MOST_S
 * seconds. */
enum mr_status live_begin(struct live *live, struct landing *landing,
                          const struct mr_command *command, uint32_t index);
/* Each block, before its edges are sent. */
void live_block(struct live *live, struct landing *landing, struct telemetry *telemetry,
                const struct mr_block *block);

/* ---- regular ---- */

/* The board's regular messages by the schedule (schedule.def): clock, health, links, faults,
 * counts, hello, state. */

/* The regular messages of one block, then what is due of the configuration (configround.h). Also
 * without scans, at the phases that schedule_due_without_scans names. */
void regular_block(struct telemetry *telemetry, const struct landing *landing,
                   const float *slack_in, uint32_t index, uint32_t tick);

#endif
