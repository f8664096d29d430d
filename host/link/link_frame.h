/* What comes over a link: frames and their identifiers, and what the link counted. */
#ifndef MATRIG_HOST_LINK_LINK_FRAME_H
#define MATRIG_HOST_LINK_LINK_FRAME_H

#include <stdint.h>

#include "common/canbase.h"
#include "common/framing.h"

enum link_kind { LINK_CAN, LINK_SERIAL };
#define LINK_KINDS 2

/* As SocketCAN has it: these bits of `id` mark extended, remote and error frames; 11-bit data
 * frames have none set. */
#define LINK_ID_EXTENDED 0x80000000u
#define LINK_ID_REMOTE   0x40000000u
#define LINK_ID_ERROR    0x20000000u

/* An identifier with its flags for the board at `base`, and back on the bus; only those of 11 bits
 * are moved. */
static inline uint32_t link_id_from_bus(uint32_t id, uint16_t base)
{
    return id & (LINK_ID_EXTENDED | LINK_ID_ERROR)
             ? id
             : (id & LINK_ID_REMOTE) | mr_can_from_bus((uint16_t)(id & MR_CAN_ID_MOST), base);
}
static inline uint32_t link_id_to_bus(uint32_t id, uint16_t base)
{
    return id & (LINK_ID_EXTENDED | LINK_ID_ERROR)
             ? id
             : (id & LINK_ID_REMOTE) | mr_can_to_bus((uint16_t)(id & MR_CAN_ID_MOST), base);
}

struct link_frame {
    uint64_t host_us; /* Unix time of reception; of recording, when it comes from a file */
    uint32_t id;
    uint8_t length; /* 0 to 8; for a remote frame the length it asks for */
    uint8_t data[8];
};

/* Troubles of a link: what it saw that is no frame of the board. Each is counted by the link
 * (struct link_counters), recorded in the campaign and shown to the user. The numbers are in
 * campaign databases: new ones go to the end.
 *
 * The first group is what CAN error frames say (linux/can/error.h), the second what the ways into
 * this computer lost, the last what the queue to the campaign had no room for (host/link/queue.h):
 * frames of CAN, bytes of serial. */

/*        name                     text of one or more of them */
/* clang-format off */
#define LINK_TROUBLE_TABLE(X)                                                             \
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

enum link_trouble {
#define LINK_TROUBLE_ENUM(name, text) name,
    LINK_TROUBLE_TABLE(LINK_TROUBLE_ENUM) LINK_TROUBLES
};
#undef LINK_TROUBLE_ENUM

/* What a link has received before a board is understood on it. */
struct link_rx {
    uint64_t begun_us; /* by the monotonic clock */
    uint64_t bytes;
    uint64_t frames; /* serial: with a good CRC; counting ends with the first */
    uint64_t bad;    /* ends of frames that are none */
    int baud;        /* of the line; 0: it has none */
    struct mr_deframer deframer;
};

struct link_counters {
    uint64_t received; /* frames or bytes */
    uint64_t sent;
    uint64_t trouble[LINK_TROUBLES];
    uint64_t troubles;     /* all of them; when it has not changed, none has */
    uint64_t error_frames; /* what the adapter said of the bus; not in `received` */
    uint64_t bad_lines;    /* of a log: no frames, passed over */
    uint64_t elsewhere;    /* frames of other buses of a log, left out */
    struct link_rx rx;
};

#endif
