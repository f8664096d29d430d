/* Troubles of a link: what it saw that is no frame of the board. Each is counted by the link
 * (struct link_counters), recorded in the campaign and shown to the user. The numbers are in
 * campaign databases: new ones go to the end.
 *
 * The first group is what CAN error frames say (linux/can/error.h; host/link/can_error.h translates
 * them), the second what the ways into this computer lost, the last what the queue to the campaign
 * had no room for (host/link/reader.h): frames of CAN, bytes of serial. */
#ifndef MATRIG_HOST_LINK_TROUBLE_H
#define MATRIG_HOST_LINK_TROUBLE_H

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

/* "unknown trouble" for a number not in the table. Static storage. */
const char *link_trouble_text(unsigned trouble);

#endif
