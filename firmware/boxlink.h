/* The black box and the links: its commands and messages. */
#ifndef MATRIG_FIRMWARE_BOXLINK_H
#define MATRIG_FIRMWARE_BOXLINK_H

#include "common/onboard/landing.h"
#include "firmware/blackbox.h"
#include "firmware/telemetry.h"

struct boxlink {
    bool listing;
    unsigned next; /* place to be listed */
};

/* MR_OK, or why not; MR_UNKNOWN also when the command is none of the black box's. */
enum mr_status boxlink_obey(struct boxlink *link, struct blackbox *box, struct telemetry *telemetry,
                            const struct mr_command *command);
/* A landing was armed: the box is given what is known of it. */
void boxlink_arm(struct blackbox *box, struct telemetry *telemetry, const struct landing *landing,
                 const float *slack_in);
void boxlink_tell_state(const struct blackbox *box, struct telemetry *telemetry);
/* The work of a block: the block itself, the landing's beginning and end, messages and pages to be
 * read out. */
void boxlink_block(struct boxlink *link, struct blackbox *box, struct telemetry *telemetry,
                   const struct landing *landing, const struct mr_block *block, bool was_armed);

#endif
