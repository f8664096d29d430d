#include "firmware/timesync.h"

#include "firmware/schedule.h"

/* a full queue ahead of it takes 33 ms; then there is no pair this time */
#define FOLLOW_BLOCKS 10u

void timesync_block(struct timesync *timesync, struct telemetry *telemetry, uint32_t index,
                    uint32_t tick)
{
    if (DUE(SYNC, index)) {
        *timesync = (struct timesync){.due = true, .block = index};
        TELL(telemetry, TO_CAN, sync, SYNC, .block = index, .tick = tick);
    } else if (timesync->due && index - timesync->block >= FOLLOW_BLOCKS) {
        struct mr_sync_at sync_at = {.block16 = (uint16_t)timesync->block};
        sync_at.sent = board_can_sync_tick(timesync->block, &sync_at.tick);
        TELL_THIS(telemetry, TO_CAN, sync_at, SYNC_AT, &sync_at);
        timesync->due = false;
    }
}
