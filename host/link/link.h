/* A link to a board: CAN frames or serial bytes, independent of the transport.
 *
 * A LINK is written `unix:PATH`, `can:IFACE`, ...; kinds.def lists all kinds.
 *
 * unix: is a stream socket on which an emulated board listens; it carries the 16-byte struct
 * can_frame of SocketCAN for CAN, and plain bytes for serial. file: reads a `candump -L` log for
 * CAN, or recorded bytes for serial, from a file or a pipe. can: is a CAN interface of the Linux
 * kernel. serial: is a serial port, 8N1, default 2000000 baud. pty: is the pseudo-terminal of an
 * emulated board.
 *
 * A LINK that carries CAN may end in ,base=N, the board's base on the bus (common/canbase.h):
 * can:can0,base=0x190. The default base is 0. Frames have the identifiers of the bus in both
 * directions.
 *
 * Receiving never blocks. Wait for link_fd to be readable, then receive until MR_TOO_FEW, because
 * bytes may be buffered inside the link where poll does not see them. Call link_service at least
 * once a second. A device that disappears (unplugged, interface down) is opened again when it
 * returns within 10 s, or within the time set by link_set_absence_limit; meanwhile link_fd is -1
 * and receiving returns MR_TOO_FEW.
 *
 * One thread may receive and service a link while a second thread sends. */
#ifndef MATRIG_HOST_LINK_LINK_H
#define MATRIG_HOST_LINK_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"
#include "host/link/link_frame.h"

/* Returns the name of a link error; "unknown trouble" for a number that is not in the table. Static
 * storage. */
const char *link_fault_text(unsigned trouble);

#define LINK_BOARD_BAUD 2000000 /* baud rate of the board's USART1 */

struct link;
struct candump_log;

#define LINK_SPEC_SIZE 4200u

/* Returns MR_USAGE if the text does not begin with a kind of link. */
enum mr_status link_check(const char *spec, struct error *error);

/* True if the LINK always carries CAN frames (can:). */
bool link_is_can(const char *spec);

/* True if the LINK is a device, which may disappear and return (can:, serial:). */
bool link_is_device(const char *spec);

/* Opens a link; the caller closes it. Waits at most 5 s for a unix: socket to appear. MR_USAGE: not
 * a LINK, or a kind that does not exist in this version or cannot carry this data. MR_IO,
 * MR_TIMEOUT: it cannot be opened. */
enum mr_status link_open(const char *spec, enum link_kind kind, struct link **link,
                         struct error *error);
/* Opens a candump log in memory, like file:PATH. The text must outlive the link. `interface`: the
 * interface to read; NULL: the one on which the board at `base` sends. */
enum mr_status link_open_text(const char *text, size_t length, const char *path, uint16_t base,
                              const char *interface, struct link **link, struct error *error);
void link_close(struct link *link); /* NULL is allowed */

/* Sets how long to wait for a device that has disappeared. */
void link_set_absence_limit(struct link *link, double seconds);

/* Removes ,base=N from the LINK text, in place, and returns N in `*base` (0 if there is none).
 * MR_USAGE: N is not a base, or the LINK does not carry CAN. */
enum mr_status link_split_base(char *spec, uint16_t *base, struct error *error);
/* Parses a base, decimal or 0x190, which must be the whole of `text`. MR_USAGE: not a base; `where`
 * is the position of the text for the message. */
enum mr_status link_parse_base_number(const char *text, const char *where, uint16_t *base,
                                      struct error *error);

/* True if the sender waits until its data is read, so that no data is lost if the reader pauses. */
bool link_blocks_sender(const struct link *link);
/* True for a recording, which can be read as fast as the reader wants. */
bool link_is_from_recording(const struct link *link);

/* Returns the base of the board on CAN; for serial: 0. */
uint16_t link_base(const struct link *link);
/* Sets the base after the board has changed it. */
void link_set_base(struct link *link, uint16_t base);

int link_fd(const struct link *link);
const char *link_get_spec(const struct link *link);
const struct link_counters *link_counters(const struct link *link);
/* Returns the state of reading the log; only for file: links that carry CAN. */
const struct candump_log *link_candump(const struct link *link);

/* Receives the next CAN frame; LINK_ID_ERROR marks the adapter's reports about the bus. MR_TOO_FEW:
 * no frame at present. MR_CLOSED: the end was reached and no data is missing. Otherwise `error` is
 * set: MR_TRUNCATED: the end is inside a frame. MR_MALFORMED: not a frame (for file:, `error` names
 * the line). MR_IO: the link failed. */
enum mr_status link_receive_frame(struct link *link, struct link_frame *frame, struct error *error);

/* Does periodic work: adapter status, driver counters, reopening a device that has disappeared.
 * MR_TOO_FEW: the device is away; wait. Other statuses: the device has not returned in time;
 * `error` has the device and the reason. */
enum mr_status link_service(struct link *link, struct error *error);

/* Receives up to `size` serial bytes; `*length` is their number. Statuses as link_receive_frame,
 * but the deframer detects truncation. */
enum mr_status link_receive_bytes(struct link *link, uint8_t *bytes, size_t size, size_t *length,
                                  uint64_t *host_us, struct error *error);

/* Sets the baud rate and discards bytes received before. Has no effect on links without a serial
 * line. MR_IO: the port does not support the rate. */
enum mr_status link_set_baud(struct link *link, int baud, struct error *error);

/* The next two functions send data to the board, and wait at most 1 s for room in the device's
 * buffer. MR_NOT_NOW: the link is a file. MR_IO: the device is away or failed. */
enum mr_status link_send_frame(struct link *link, const struct link_frame *frame,
                               struct error *error);
enum mr_status link_send_bytes(struct link *link, const uint8_t *bytes, size_t length,
                               struct error *error);

/* Sends a message of the catalogue in the form of the link's kind: one CAN frame to the board at
 * `base`, or one serial frame (common/framing.h) with number `seq`. */
enum mr_status link_send_message(struct link *link, uint16_t base, uint16_t seq, uint16_t id,
                                 const uint8_t *payload, size_t length, struct error *error);

/* Returns the current Unix time, microseconds. */
uint64_t link_now_us(void);

/* Returns the offset of the time of day from the monotonic clock (host/base/monotonic_clock.h),
 * microseconds. If the thread was interrupted between reading the two clocks, they are read
 * again. */
uint64_t link_wall_clock_offset_us(void);

/* ---- why no board is understood on a link ----
 *
 * Either no data arrives, or the data contains no frames because the baud rate is wrong, or the bus
 * has only errors. */

#define DIAGNOSIS_TEXT_SIZE 400u
/* Beginning of an error message of link_set_no_board_error; the link and advice follow. */
#define LINK_NO_HELLO       "no hello from a board"

enum diagnosis {
    DIAGNOSIS_SILENT,  /* no data */
    DIAGNOSIS_GARBLED, /* bytes were received, but no valid frame; usually a wrong baud rate */
    /* only error frames were received; usually a wrong bit rate or missing termination */
    DIAGNOSIS_BUS_ERRORS,
    DIAGNOSIS_NO_HELLO, /* frames were received, but none that identifies the board */
};

/* Finds out why no board was identified on the link. `text`: "NAME: what was received; what to do",
 * one line. */
enum diagnosis link_diagnose(const struct link *link, char text[DIAGNOSIS_TEXT_SIZE]);
/* Returns the reason as one word for programs: "silent", "garbled", "bus-errors", "no-hello".
 * Static storage. */
const char *diagnosis_name(enum diagnosis diagnosis);
/* Sets the error of a link on which no board identified itself in time: MR_TIMEOUT if nothing was
 * received, otherwise MR_IO. */
enum mr_status link_set_no_board_error(const struct link *link, struct error *error);

#endif
