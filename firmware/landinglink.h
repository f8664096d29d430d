/* The board's messages during a landing: block records, means, state, motion, results. */
#ifndef MATRIG_FIRMWARE_LANDINGLINK_H
#define MATRIG_FIRMWARE_LANDINGLINK_H

#include "common/block.h"
#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

/* Sends the block record on serial. */
void landinglink_send_block(struct telemetry *telemetry, const struct mr_block *block);
/* Sends means. Only on CAN, because serial carries the block records. Bit i of `fitted`: transducer
 * or gage i is fitted. A message without any fitted channel is not sent. */
void landinglink_send_displacements(struct telemetry *telemetry,
                                    const float value_in[MR_TRANSDUCERS], uint32_t fitted,
                                    uint32_t index);
void landinglink_send_tensions(struct telemetry *telemetry, const float value_lb[MR_GAGES],
                               uint32_t fitted, uint32_t index);
void landinglink_send_state(struct telemetry *telemetry, const struct landing *landing);
/* Sends the motion computed from the gates so far, at block `index`, and after the end of the
 * landing that of the whole landing. The standard errors include that of the clock. */
void landinglink_send_motion(struct telemetry *telemetry, const struct mr_motion_estimate *motion,
                             uint32_t index);
void landinglink_send_summary(struct telemetry *telemetry, const struct mr_gates_summary *summary);
/* Sends the changes caused by block `index`: edges, push-back, motion, summary and state, in this
 * order. */
void landinglink_send_changes(struct telemetry *telemetry, const struct landing *landing,
                              const struct landing_block_changes *changes, uint32_t index);

/* ---- live mode ---- */

/* Live mode, by command, for an inspection of the rig while idle: edges are sent as they occur, and
 * a block record is sent on serial every 20 blocks (schedule.def). Nothing is recorded and no state
 * changes, so opening switches by hand does not count as a landing. Live mode ends after its time,
 * at arming, or by the command with 0 seconds; it therefore also ends if the host disconnects. */

#define LIVE_MAX_S 60

struct live {
    uint32_t until_block;
};

/* Executes the command while idle; `index`: the next block. MR_USAGE: more than LIVE_MAX_S
 * seconds. */
enum mr_status live_begin(struct live *live, struct landing *landing,
                          const struct mr_command *command, uint32_t index);
/* Call in each block, before its edges are sent. */
void live_on_block(struct live *live, struct landing *landing, struct telemetry *telemetry,
                   const struct mr_block *block);

/* ---- regular messages ---- */

/* The board's regular messages according to schedule.def: clock, health, links, faults, counts,
 * hello, state. */

/* Sends the regular messages of one block, then the items of the configuration that are due
 * (configround.h). Without scans, call at the phases that schedule_due_without_scans returns. */
void landinglink_send_regular(struct telemetry *telemetry, const struct landing *landing,
                              const float *slack_in, uint32_t index, uint32_t tick);

#endif
