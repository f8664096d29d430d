/* A link to a board: CAN frames or serial bytes, whatever carries them.
 *
 * A LINK is written `unix:PATH`, `can:IFACE`, ...; kinds.def has all kinds.
 *
 * unix: is a stream socket on which an emulated board listens; it carries the 16-byte struct
 * can_frame of SocketCAN for CAN, plain bytes for serial. file: reads a `candump -L` log for CAN,
 * recorded bytes for serial, from a file or a pipe. can: is a CAN interface of the Linux kernel,
 * with :board the board's messages alone, serial: a serial port, 8N1, 2000000 baud unless given, or
 * the usual rate at which frames come, pty: the pseudo-terminal of an emulated board.
 *
 * A LINK that carries CAN may end in ,base=N, the board's base on the bus (common/canbase.h):
 * can:can0,base=0x190. Without it the base is 0. Frames carry the identifiers of the bus both ways.
 *
 * A link never blocks once open. Wait for link_fd to be readable, then receive until MR_TOO_FEW:
 * bytes may wait inside the link where poll does not see them. Call link_service at least once a
 * second: a device that went away (unplugged, interface down) is opened again when it comes back
 * within 10 s, or link_patience; meanwhile link_fd is -1 and receiving gives MR_TOO_FEW.
 *
 * One thread may receive and service a link while another one sends. */
#ifndef MATRIG_HOST_LINK_LINK_H
#define MATRIG_HOST_LINK_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/canbase.h"
#include "host/base/error.h"
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
 * The first group is what CAN error frames say (linux/can/error.h; host/link/can.h translates
 * them), the second what the ways into this computer lost, the last what the queue to the campaign
 * had no room for (host/link/reader.h): frames of CAN, bytes of serial. */

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
    struct link_rx rx;
};

#define LINK_BOARD_BAUD 2000000 /* the board's USART1 */

struct link;

/* The LINK that a name without a kind can only mean: an interface of the kernel is can:, a serial
 * port serial:, a file file:, a socket unix:, a pseudo-terminal pty:. What is a LINK already is
 * copied. MR_USAGE: it can mean two things, belongs to the other kind, or is none; MR_IO: there is
 * no such thing. */
#define LINK_SPEC_MAX 4200u
enum mr_status link_complete(const char *spec, enum link_kind kind, char out[LINK_SPEC_MAX],
                             struct error *error);

/* It carries CAN frames whatever else could be meant: can:, or the name of an interface. */
bool link_is_can(const char *spec);

/* Open a link, also by such a name. The caller closes it. Waits at most 5 s for a unix: socket to
 * appear. MR_USAGE: not a LINK, or of a kind that this version or this use does not have; MR_IO,
 * MR_TIMEOUT: does not open. */
enum mr_status link_open(const char *spec, enum link_kind kind, struct link **link,
                         struct error *error);
void link_close(struct link *link); /* NULL is allowed */

/* How long a device that went away is waited for. */
void link_patience(struct link *link, double seconds);

/* Takes ,base=N off a LINK that carries CAN, in place; 0 without it. MR_USAGE: no base. */
enum mr_status link_take_base(char *spec, uint16_t *base, struct error *error);
/* Reads a base, decimal or 0x190, from all of `text`. MR_USAGE: no base; `where` names the text's
 * place. */
enum mr_status link_read_base(const char *text, const char *where, uint16_t *base,
                              struct error *error);

/* Its sender waits until it is read: nothing is lost by not reading. */
bool link_waits(const struct link *link);
/* It was recorded earlier: reading decides how fast it goes. */
bool link_recorded(const struct link *link);

/* The base of its board; serial: 0. */
uint16_t link_base(const struct link *link);
/* Its board has moved to another base. */
void link_set_base(struct link *link, uint16_t base);

int link_fd(const struct link *link);
const char *link_spec(const struct link *link);
const struct link_counters *link_counters(const struct link *link);

/* The next CAN frame; LINK_ID_ERROR marks what the adapter says about the bus. MR_OK; MR_TOO_FEW:
 * none now; MR_CLOSED: the end, nothing is missing; else `error` says: MR_TRUNCATED: the end is
 * inside a frame; MR_MALFORMED: no frame (file: names the line); MR_IO. */
enum mr_status link_receive_frame(struct link *link, struct link_frame *frame, struct error *error);

/* What must be done now and then: status of the adapter, counters of the driver, a device that went
 * away. MR_OK; MR_TOO_FEW: the device is away, wait; else it stays away, and `error` says which and
 * why. */
enum mr_status link_service(struct link *link, struct error *error);

/* Up to `size` serial bytes, `*length` of them. Status as above; truncation is the deframer's to
 * see. */
enum mr_status link_receive_bytes(struct link *link, uint8_t *bytes, size_t size, size_t *length,
                                  uint64_t *host_us, struct error *error);

/* Rate of the line from now on; what was received before is forgotten.
 * Links that have no line stay as they are. MR_IO: the port does not do it. */
enum mr_status link_line(struct link *link, int baud, struct error *error);

/* Send to the board; waits at most 1 s for room. MR_NOT_NOW: a file cannot be sent to;
 * MR_IO: the device is away, or fails. */
enum mr_status link_send_frame(struct link *link, const struct link_frame *frame,
                               struct error *error);
enum mr_status link_send_bytes(struct link *link, const uint8_t *bytes, size_t length,
                               struct error *error);

/* A message of the catalogue, as the link's kind carries it: one CAN frame to the board at `base`,
 * or one serial frame (common/framing.h) of number `seq`. */
enum mr_status link_send_message(struct link *link, uint16_t base, uint16_t seq, uint16_t id,
                                 const uint8_t *payload, size_t length, struct error *error);

/* Unix time now, microseconds. */
uint64_t link_now_us(void);

/* How far the time of day is ahead of the monotonic clock (host/base/monotonic_clock.h),
 * microseconds; when the processor was taken away between the two clocks, they are read again. */
uint64_t link_clock_ahead_us(void);

#endif
