/* Telemetry: where messages go. Each names its sinks; a sink that is full drops the message and
 * counts it, so telemetry never delays acquisition.
 *
 *     firmware/landinglink.h   what a landing needs, as it happens
 *     firmware/landinglink.h       clock, health, faults, state: by the schedule
 *     firmware/configround.h   the configuration, an item at a time
 *     and boxlink, healthlink, predict, bandwatch, calibrate ... for what is theirs */
#ifndef MATRIG_FIRMWARE_TELEMETRY_H
#define MATRIG_FIRMWARE_TELEMETRY_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "firmware/blackbox.h"
#include "firmware/board.h"
#include "firmware/canwatch.h"

/* Sinks, as bits. */
enum telemetry_sink {
    TO_CAN = 1,
    TO_SERIAL = 2,
    TO_LINKS = TO_CAN | TO_SERIAL,
    TO_NOTES = 4,                    /* the notes of the black box's record, while one is open */
    TO_RECORD = TO_LINKS | TO_NOTES, /* a message that a landing's record needs */
    /* the configuration of the black box's record of a landing that was just armed */
    TO_CONFIGURATION = 8,
};

struct telemetry {
    struct board_identity identity;
    uint32_t config_crc;
    struct mr_config_state config_state;
    struct mr_bus_key bus_key;

    uint16_t serial_seq;
    struct canwatch can;
    uint32_t can_sent; /* queued; of them errors.removed were dropped later */
    uint32_t serial_sent;
    uint16_t serial_dropped;
    uint16_t serial_bad;
    uint16_t blocks_lost;

    unsigned refusals;           /* of telemetry_may_burst, since nothing waited */
    uint32_t said[2][MR_PLACES]; /* by link, CAN and serial: times a message was meant for it */
    unsigned count_place;        /* whose count is sent next */

    struct {
        unsigned item;    /* next to go out */
        bool bursting;    /* one item per block, up to the last */
    } round;              /* of configround.h */
    struct blackbox *box; /* keeps what a landing's record needs */
};

enum { TELEMETRY_CAN, TELEMETRY_SERIAL }; /* places in `said`, one for each link */

/* `box` is kept. */
void telemetry_start(struct telemetry *telemetry, struct blackbox *box);
void telemetry_send(struct telemetry *telemetry, unsigned sinks, uint16_t id,
                    const uint8_t *payload, size_t length);
/* On CAN, whatever its state. */
bool telemetry_probe(struct telemetry *telemetry, uint16_t id, const uint8_t *payload,
                     size_t length);
/* Messages sent in turn pause while more frames than these wait for the bus, which another board
 * may fill; readings need the rest of the queue. A bus that stays full does not hold them: after so
 * many refusals, about a second, serial must have them, whatever CAN drops. */
#define TELEMETRY_BURST_WAITING 64u
#define TELEMETRY_REFUSALS_MOST 1500u
bool telemetry_may_burst(struct telemetry *telemetry);
/* There is a black box, so that TO_CONFIGURATION leads somewhere. */
bool telemetry_has_box(const struct telemetry *telemetry);

/* Send a message of the catalogue that is there: TELL_THIS(telemetry, TO_RECORD, edge, EDGE,
 * &edge). */
#define TELL_THIS(telemetry, sinks, name, NAME, message)         \
    do {                                                         \
        uint8_t payload_[MR_MESSAGE_MAX];                        \
        telemetry_send(telemetry, sinks, MR_ID_##NAME, payload_, \
                       mr_##name##_put(message, payload_));      \
    } while (0)

/* Build one on the spot and send it: TELL(telemetry, TO_RECORD, mark, MARK, .number = 1). */
#define TELL(telemetry, sinks, name, NAME, ...)             \
    do {                                                    \
        const struct mr_##name message_ = {__VA_ARGS__};    \
        TELL_THIS(telemetry, sinks, name, NAME, &message_); \
    } while (0)

/* ---- timesync ---- */

/* Time sync over CAN, in two steps: once a second a sync frame, and 10 ms later the board's time at
 * which that frame had left. However long the frame waited for the bus, a receiver that noted its
 * arrival has a pair of times. */

struct timesync {
    bool due;       /* sync_at is still to follow */
    uint32_t block; /* of the sync frame */
};

/* Each block, before any other message of the block: the queue is at its shortest. */
void timesync_block(struct timesync *timesync, struct telemetry *telemetry, uint32_t index,
                    uint32_t tick);

#endif
