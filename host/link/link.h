/* A link to a board: CAN frames or serial bytes, whatever carries them.
 *
 * A LINK is written `unix:PATH`, `can:IFACE`, ...; kinds.def has all kinds.
 *
 * unix: is a stream socket on which an emulated board listens; it carries the 16-byte struct
 * can_frame of SocketCAN for CAN, plain bytes for serial. file: reads a `candump -L` log for CAN,
 * recorded bytes for serial, from a file or a pipe. can: is a CAN interface of the Linux kernel,
 * serial: a serial port, 8N1, 2000000 baud unless given, pty: the pseudo-terminal of an emulated
 * board.
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

#include "host/base/error.h"
#include "host/link/link_frame.h"

/* "unknown trouble" for a number not in the table. Static storage. */
const char *link_trouble_text(unsigned trouble);

#define LINK_BOARD_BAUD 2000000 /* the board's USART1 */

struct link;
struct candump_log;

#define LINK_SPEC_MAX 4200u

/* MR_USAGE: it does not begin with a kind of link. */
enum mr_status link_check(const char *spec, struct error *error);

/* It carries CAN frames whatever else could be meant: can:. */
bool link_is_can(const char *spec);

/* A device, which may be away and come back: can:, serial:. */
bool link_comes_back(const char *spec);

/* Open a link. The caller closes it. Waits at most 5 s for a unix: socket to
 * appear. MR_USAGE: not a LINK, or of a kind that this version or this use does not have; MR_IO,
 * MR_TIMEOUT: does not open. */
enum mr_status link_open(const char *spec, enum link_kind kind, struct link **link,
                         struct error *error);
/* A candump log in memory, which outlives the link, as file:PATH would be. `interface`: the one to
 * take; NULL: on which the board at `base` speaks. */
enum mr_status link_open_text(const char *text, size_t length, const char *path, uint16_t base,
                              const char *interface, struct link **link, struct error *error);
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
/* file: of CAN: what became of the log so far. */
const struct candump_log *link_candump(const struct link *link);

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

/* ---- why no board is understood on a link ----
 *
 * Nothing comes, or what comes is no frame, because of the rate, or the bus has errors alone. */

#define DIAGNOSIS_TEXT 400u
/* how such a message begins; the link follows, then what to do */
#define LINK_NO_HELLO  "no hello from a board"

enum diagnosis {
    DIAGNOSIS_SILENT,     /* nothing at all */
    DIAGNOSIS_GARBLED,    /* bytes, and not a frame among them: the rate */
    DIAGNOSIS_BUS_ERRORS, /* error frames alone: the bit rate, or the termination */
    DIAGNOSIS_NO_HELLO,   /* frames, and none that says who speaks */
};

/* `text`: "NAME: what came; what to do", one line. */
enum diagnosis link_diagnose(const struct link *link, char text[DIAGNOSIS_TEXT]);
/* One word for programs: "silent", "garbled", "bus-errors", "no-hello". Static storage. */
const char *diagnosis_word(enum diagnosis diagnosis);
/* Sets the error, of a link on which no board spoke within the time allowed: MR_TIMEOUT when
 * nothing came, else MR_IO. */
enum mr_status link_no_board(const struct link *link, struct error *error);

#endif
