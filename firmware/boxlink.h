/* Commands and messages of the black box on the links. */
#ifndef MATRIG_FIRMWARE_BOXLINK_H
#define MATRIG_FIRMWARE_BOXLINK_H

#include "common/onboard/landing.h"
#include "firmware/blackbox.h"
#include "firmware/telemetry.h"

struct boxlink {
    bool is_listing;
    unsigned next_record; /* index of the next record to be listed */
};

/* Executes a command. Returns MR_OK or the reason for refusal. MR_UNKNOWN: no such record, or the
 * command is not for the black box. */
enum mr_status boxlink_execute(struct boxlink *link, struct blackbox *box,
                               struct telemetry *telemetry, const struct mr_command *command);
/* Call when a landing has been armed: passes the facts and the configuration of the landing to the
 * box. */
void boxlink_arm(struct blackbox *box, struct telemetry *telemetry, const struct landing *landing,
                 const float *slack_in);
void boxlink_report_state(const struct blackbox *box, struct telemetry *telemetry);
/* Call in each block: passes the block and the beginning and end of the landing to the box, and
 * sends messages and pages being read out. */
void boxlink_on_block(struct boxlink *link, struct blackbox *box, struct telemetry *telemetry,
                      const struct landing *landing, const struct mr_block *block, bool was_armed);

#endif
