/* Frames of a link, their identifiers, and the counters of a link. */
#ifndef MATRIG_HOST_LINK_LINK_FRAME_H
#define MATRIG_HOST_LINK_LINK_FRAME_H

#include <stdint.h>

#include "common/canbase.h"
#include "common/framing.h"

enum link_kind { LINK_CAN, LINK_SERIAL };
#define LINK_KINDS 2

/* These bits of `id`, as in SocketCAN, mark extended, remote and error frames; 11-bit data frames
 * have none of them set. */
#define LINK_ID_EXTENDED 0x80000000u
#define LINK_ID_REMOTE   0x40000000u
#define LINK_ID_ERROR    0x20000000u

/* link_id_from_bus converts an identifier (with its flags) from the bus to the catalogue, for the
 * board at `base`; link_id_to_bus converts it back. Only 11-bit identifiers are changed. */
static inline uint32_t link_id_from_bus(uint32_t id, uint16_t base)
{
    return id & (LINK_ID_EXTENDED | LINK_ID_ERROR)
             ? id
             : (id & LINK_ID_REMOTE) | mr_can_id_from_bus((uint16_t)(id & MR_CAN_ID_MAX), base);
}
static inline uint32_t link_id_to_bus(uint32_t id, uint16_t base)
{
    return id & (LINK_ID_EXTENDED | LINK_ID_ERROR)
             ? id
             : (id & LINK_ID_REMOTE) | mr_can_id_to_bus((uint16_t)(id & MR_CAN_ID_MAX), base);
}

struct link_frame {
    uint64_t host_us; /* Unix time of reception, us; in a file, time of recording */
    uint32_t id;
    uint8_t length; /* 0 to 8; for a remote frame the requested length */
    uint8_t data[8];
};

/* Errors of a link: events other than frames of the board. The link counts each (struct
 * link_counters); the count is stored in the campaign and shown to the user. Campaign databases
 * contain the numbers: append new entries at the end.
 *
 * The first group is reported in CAN error frames (linux/can/error.h). The second group is losses
 * on the way to this program. The last group is CAN frames and serial bytes lost because the queue
 * to the campaign was full (host/link/queue.h). */

/* name of an error, and its text for a number of errors */
/* clang-format off */
#define LINK_FAULT_TABLE(X)                                                             \
    X(LINK_BUS_OFF,                "bus off")                                             \
    X(LINK_RESTARTED,              "restarted after bus off")                             \
    X(LINK_ERROR_PASSIVE,          "error passive")                                       \
    X(LINK_ERROR_WARNING,          "error warning")                                       \
    X(LINK_ERROR_ACTIVE,           "error active again")                                  \
    X(LINK_NO_ACK,                 "no acknowledgement")                                  \
    X(LINK_ARBITRATION_LOST,       "arbitration lost")                                    \
    X(LINK_PROTOCOL_ERROR,         "protocol error")                                      \
    X(LINK_BUS_ERROR,              "bus error")                                           \
    X(LINK_RX_OVERFLOW,            "receive overflow in the adapter")                     \
    X(LINK_TX_OVERFLOW,            "transmit overflow in the adapter")                    \
    X(LINK_TX_TIMEOUT,             "transmit timeout")                                    \
    X(LINK_TRANSCEIVER,            "transceiver or wiring fault")                         \
    X(LINK_OTHER_ERROR,            "other bus errors")                                    \
    X(LINK_QUEUE_LOST,             "frames lost in this computer's receive queue")        \
    X(LINK_UART_OVERRUN,           "UART overruns")                                       \
    X(LINK_UART_LINE,              "UART framing, parity or break errors")                \
    X(LINK_AWAY,                   "went away")                                           \
    X(LINK_BACK,                   "came back")                                           \
    X(LINK_LOST_LOCK, "frames or bytes that a full queue lost (another program held the " \
      "campaign)")                                                                        \
    X(LINK_LOST_SLOW_DISK,         "frames or bytes that a full queue lost (slow disk)")  \
    X(LINK_LOST_FULL_DISK,         "frames or bytes that a full queue lost (full disk)")  \
    X(LINK_LOST_PROCESSOR,         "frames or bytes that a full queue lost (slow computer)")
/* clang-format on */

enum link_fault {
#define LINK_FAULT_ENUM(name, text) name,
    LINK_FAULT_TABLE(LINK_FAULT_ENUM) LINK_FAULT_COUNT
};
#undef LINK_FAULT_ENUM

/* Data that a link received before a board was identified on it. */
struct link_rx {
    uint64_t start_us; /* start of the counting, by the monotonic clock */
    uint64_t bytes;
    uint64_t valid_frames; /* serial: frames with a valid CRC; counting stops after the first one */
    uint64_t bad_frames;   /* number of frame ends in the data that do not complete a valid frame */
    int baud;              /* rate of the serial line; 0: the link has none */
    struct mr_deframer deframer;
};

struct link_counters {
    uint64_t received_count; /* number of frames or bytes received */
    uint64_t sent_count;
    uint64_t fault_count[LINK_FAULT_COUNT];
    uint64_t fault_total; /* sum of `fault`, which shows whether there was any new error */
    uint64_t
        error_frames;   /* number of error frames of the adapter; not included in received_count */
    uint64_t bad_lines; /* number of invalid lines of a log, which were skipped */
    uint64_t other_interface_frames; /* frames of other buses in a log, which were skipped */
    struct link_rx rx;
};

#endif
