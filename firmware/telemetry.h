/* Telemetry: sends messages to the sinks (links, black box) that the caller names. If a sink is
 * full, the message is dropped and counted, so that telemetry never delays acquisition. The
 * messages are built in these files:
 *
 *     firmware/landinglink.h   data of a landing as they occur; regular messages (clock, health,
 *                              faults, state)
 *     firmware/configround.h   the configuration, one item at a time
 *     boxlink, healthlink, predict, bandwatch, calibrate and others: their own messages */
#ifndef MATRIG_FIRMWARE_TELEMETRY_H
#define MATRIG_FIRMWARE_TELEMETRY_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "firmware/blackbox.h"
#include "firmware/board.h"
#include "firmware/canwatch.h"

/* Sinks, as a bit mask. */
enum telemetry_sink {
    TO_CAN = 1,
    TO_SERIAL = 2,
    TO_LINKS = TO_CAN | TO_SERIAL,
    TO_BOX = 4,                    /* the record of the black box, while one is open */
    TO_RECORD = TO_LINKS | TO_BOX, /* all sinks of a message that the record of a landing needs */
    /* configuration part of the black box's record of a landing that was just armed */
    TO_CONFIGURATION = 8,
};

struct telemetry {
    struct board_identity identity;
    uint32_t config_crc;
    struct mr_config_state config_state;
    struct mr_bus_key bus_key;

    uint16_t serial_seq;
    struct canwatch can;
    /* number of queued frames, including those that were dropped later (errors.removed) */
    uint32_t can_sent;
    uint32_t serial_sent;
    uint16_t serial_dropped;
    uint16_t serial_refused_count;
    uint16_t blocks_lost;

    /* number of refusals by telemetry_can_burst since no frame was waiting */
    unsigned burst_refusals;
    /* number of messages sent, by link (CAN, serial) and message */
    uint32_t sent_counts[2][MR_MESSAGE_COUNT];
    unsigned count_index; /* index of the message whose count is sent next */

    struct {
        unsigned item; /* next item to be sent */
        /* a burst is in progress: one item is sent per block until the last one */
        bool is_bursting;
    } round;              /* state of the round, used by configround.h */
    struct blackbox *box; /* receives the messages for a landing's record */
};

enum { TELEMETRY_CAN, TELEMETRY_SERIAL }; /* indices of the links in `sent_counts` */

/* Clears the counts and stores the pointer `box`, which must remain valid. */
void telemetry_start(struct telemetry *telemetry, struct blackbox *box);
void telemetry_send(struct telemetry *telemetry, unsigned sinks, uint16_t id,
                    const uint8_t *payload, size_t length);
/* Sends on CAN even if the link is blocked. */
bool telemetry_send_probe(struct telemetry *telemetry, uint16_t id, const uint8_t *payload,
                          size_t length);
/* Messages of a round or burst pause while more than TELEMETRY_BURST_WAITING_MAX frames are waiting
 * for the bus, which other boards may fill; the readings need the rest of the queue. After
 * TELEMETRY_REFUSALS_MAX refusals, about a second, they are sent even if the bus is full, so that
 * serial receives them; CAN may drop them. */
#define TELEMETRY_BURST_WAITING_MAX 64u
#define TELEMETRY_REFUSALS_MAX      1500u
bool telemetry_can_burst(struct telemetry *telemetry);
/* True if there is a black box, which TO_CONFIGURATION requires. */
bool telemetry_has_box(const struct telemetry *telemetry);

/* Sends a message that is already filled in: TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, edge,
 * EDGE, &edge). */
#define TELEMETRY_SEND_MESSAGE(telemetry, sinks, name, NAME, message) \
    do {                                                              \
        uint8_t payload_[MR_MESSAGE_BYTES_MAX];                       \
        telemetry_send(telemetry, sinks, MR_ID_##NAME, payload_,      \
                       mr_##name##_put(message, payload_));           \
    } while (0)

/* Builds a message from its fields and sends it: TELEMETRY_SEND(telemetry, TO_RECORD, mark, MARK,
 * .number = 1). */
#define TELEMETRY_SEND(telemetry, sinks, name, NAME, ...)                \
    do {                                                                 \
        const struct mr_##name message_ = {__VA_ARGS__};                 \
        TELEMETRY_SEND_MESSAGE(telemetry, sinks, name, NAME, &message_); \
    } while (0)

/* ---- time synchronisation ---- */

/* Time synchronisation over CAN in two steps: once per second a sync frame, and 10 ms later the
 * board time at which that frame was sent. A receiver that recorded the arrival of the frame then
 * has a pair of times, however long the frame waited for the bus. */

struct timesync {
    bool is_due;    /* the message sync_at must still be sent */
    uint32_t block; /* block of the sync frame */
};

/* Call in each block before any other message is sent, when the queue is shortest. */
void timesync_on_block(struct timesync *timesync, struct telemetry *telemetry, uint32_t index,
                       uint32_t tick);

#endif
