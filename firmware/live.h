/* Live on command: while idle, for whoever looks the rig over, edges are told as they come and a
 * block record goes out on serial each 20 blocks (schedule.def). Nothing is recorded, no state
 * changes: a rig walked along by hand makes no landing. Ends by itself, with arming, or with 0
 * seconds, so that a host that went away leaves no chatter behind. */
#ifndef MATRIG_FIRMWARE_LIVE_H
#define MATRIG_FIRMWARE_LIVE_H

#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

#define LIVE_MOST_S 60

struct live {
    uint32_t until_block;
};

/* The command; `index` of the block to come. MR_NOT_NOW: not idle; MR_USAGE: more than LIVE_MOST_S
 * seconds. */
enum mr_status live_begin(struct live *live, struct landing *landing,
                          const struct mr_command *command, uint32_t index);
/* Each block, before its edges are told. */
void live_block(struct live *live, struct landing *landing, struct telemetry *telemetry,
                const struct mr_block *block);

#endif
