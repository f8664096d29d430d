#include "firmware/telemetry.h"

#include <string.h>

#include "common/framing.h"
#include "firmware/health.h"
#include "firmware/schedule.h"

static void send_can(struct telemetry *telemetry, uint16_t id, const uint8_t *payload,
                     size_t length)
{
    struct board_can_frame frame = {.id = id, .length = (uint8_t)length};
    if (!telemetry->can.is_silent)
        telemetry->sent_counts[TELEMETRY_CAN][mr_message_index(id)]++;
    memcpy(frame.data, payload, length);
    if (!canwatch_is_accepting(&telemetry->can))
        return;
    if (board_can_send(&frame)) {
        telemetry->can_sent++;
    } else {
        health_count_fault(MR_FAULT_CAN_QUEUE_FULL, 0);
        canwatch_count_queue_full(&telemetry->can);
    }
}

static void send_serial(struct telemetry *telemetry, uint16_t id, const uint8_t *payload,
                        size_t length)
{
    uint8_t frame[MR_FRAME_BYTES_MAX];
    telemetry->sent_counts[TELEMETRY_SERIAL][mr_message_index(id)]++;
    size_t size = mr_frame_encode(telemetry->serial_seq, id, payload, length, frame);
    if (board_serial_send(frame, size)) {
        telemetry->serial_seq++;
        telemetry->serial_sent++;
        return;
    }
    if (telemetry->serial_dropped < UINT16_MAX)
        telemetry->serial_dropped++;
    health_count_fault(MR_FAULT_SERIAL_QUEUE_FULL, 0);
}

void telemetry_send(struct telemetry *telemetry, unsigned sinks, uint16_t id,
                    const uint8_t *payload, size_t length)
{
    if (sinks & TO_CONFIGURATION)
        blackbox_record_configuration(telemetry->box, id, payload, length);
    if (sinks & TO_BOX)
        blackbox_record_message(telemetry->box, id, payload, length);
    if (sinks & TO_CAN)
        send_can(telemetry, id, payload, length);
    if (sinks & TO_SERIAL)
        send_serial(telemetry, id, payload, length);
}

bool telemetry_send_probe(struct telemetry *telemetry, uint16_t id, const uint8_t *payload,
                          size_t length)
{
    struct board_can_frame frame = {.id = id, .length = (uint8_t)length};
    memcpy(frame.data, payload, length);
    telemetry->sent_counts[TELEMETRY_CAN][mr_message_index(id)]++;
    bool queued = board_can_send(&frame);
    telemetry->can_sent += queued;
    return queued;
}

bool telemetry_can_burst(struct telemetry *telemetry)
{
    unsigned waiting = board_can_waiting();
    if (waiting == 0)
        telemetry->burst_refusals = 0;
    return waiting <= TELEMETRY_BURST_WAITING_MAX ||
           ++telemetry->burst_refusals > TELEMETRY_REFUSALS_MAX;
}

bool telemetry_has_box(const struct telemetry *telemetry)
{
    return !telemetry->box->is_disabled;
}

void telemetry_start(struct telemetry *telemetry, struct blackbox *box)
{
    memset(telemetry, 0, sizeof *telemetry);
    telemetry->box = box;
    board_identify(&telemetry->identity);
    bool silent = telemetry->identity.clock_source != MR_CLOCK_CRYSTAL;
    canwatch_start(&telemetry->can, silent);
    if (silent)
        health_count_fault(MR_FAULT_CAN_SILENT, 0);
}

/* ---- time synchronisation ---- */

/* longest wait for sending the sync frame; with a full queue before it, it takes 33 ms, and this
 * pair is skipped */
#define FOLLOW_UP_BLOCKS 10u

void timesync_on_block(struct timesync *timesync, struct telemetry *telemetry, uint32_t index,
                       uint32_t tick)
{
    if (DUE(SYNC, index)) {
        *timesync = (struct timesync){.is_due = true, .block = index};
        TELEMETRY_SEND(telemetry, TO_CAN, sync, SYNC, .block = index, .tick = tick);
    } else if (timesync->is_due && index - timesync->block >= FOLLOW_UP_BLOCKS) {
        struct mr_sync_at sync_at = {.block16 = (uint16_t)timesync->block};
        sync_at.sent = board_can_sync_tick(timesync->block, &sync_at.tick);
        TELEMETRY_SEND_MESSAGE(telemetry, TO_CAN, sync_at, SYNC_AT, &sync_at);
        timesync->is_due = false;
    }
}
