#include "firmware/live.h"

#include "firmware/landinglink.h"
#include "firmware/schedule.h"

enum mr_status live_begin(struct live *live, struct landing *landing,
                          const struct mr_command *command, uint32_t index)
{
    if (command->argument < 0 || command->argument > LIVE_MOST_S)
        return MR_USAGE;
    if (landing->state != LANDING_IDLE)
        return MR_NOT_NOW;
    live->until_block = index + 1000u * (uint32_t)command->argument;
    landing->live = command->argument > 0;
    return MR_OK;
}

void live_block(struct live *live, struct landing *landing, struct telemetry *telemetry,
                const struct mr_block *block)
{
    if (!landing->live)
        return;
    if ((int32_t)(block->index - live->until_block) >= 0)
        landing->live = false;
    else if (DUE(LIVE, block->index))
        landinglink_block(telemetry, block);
}
