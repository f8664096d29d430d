/* The board's ends of its two wires: `unix:PATH` (the board listens, one host connects), `pty:PATH`
 * (serial only: a pseudo-terminal), `file:PATH` (candump -L text for CAN, raw
 * bytes for serial), `none`.
 *
 * A CAN socket carries 16-byte frames in the layout of Linux's struct can_frame (identifier with
 * flags, length, three bytes of padding, eight of data) each way, a serial socket bytes each way.
 * What is put waits in a buffer until hil_link_flush; a host that hangs up is no error, what is for
 * it is dropped and counted. A pty: can be opened and closed any number of times. */
#ifndef MATRIG_HIL_WIRE_LINK_H
#define MATRIG_HIL_WIRE_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/board/board.h"

enum hil_link_kind { HIL_LINK_CAN, HIL_LINK_SERIAL };
enum hil_link_type { HIL_LINK_NONE, HIL_LINK_UNIX, HIL_LINK_FILE, HIL_LINK_PTY };

struct hil_link {
    enum hil_link_kind kind;
    enum hil_link_type type;
    const char *path; /* not owned */
    int listener, fd; /* -1: none */
    uint8_t *buffer;
    size_t start, end, room; /* of what waits in buffer */
    bool drops;              /* when full, drop instead of growing */
    bool hung_up;            /* the host closed its end, for good or (pty) for now */
    bool moved;              /* pty: something went over it since the last look */
    uint32_t baud;           /* pty: as last reported to the board */
    uint64_t dropped;        /* frames (CAN) or bytes (serial) */
    uint8_t partial[16];     /* a frame that came in part */
    size_t partial_size;
};

/* Listen at a socket of the file system, where neither another program does nor another file is.
 * `option` is for errors; `*listener` is the caller's to close, also after an error. MR_USAGE,
 * MR_IO. */
enum mr_status hil_socket_listen(const char *option, const char *path, int *listener, char *error,
                                 size_t size);
/* Open a link from its text. MR_USAGE: not a link; MR_IO: cannot be opened. `error` has the
 * reason. */
enum mr_status hil_link_open(struct hil_link *link, enum hil_link_kind kind, const char *text,
                             char *error, size_t size);
/* Wait until a host has connected, or has the pty open; at once for links without one. MR_TIMEOUT,
 * MR_IO. `*stop` ends it (MR_CLOSED). */
enum mr_status hil_link_accept(struct hil_link *link, int timeout_ms, const volatile int *stop,
                               char *error, size_t size);

void hil_link_put_frame(struct hil_link *link, uint64_t t_ps, const struct hil_can_frame *frame);
void hil_link_put_bytes(struct hil_link *link, const uint8_t *bytes, size_t n);
/* Write what waits. stall_ms 0: as much as goes without waiting; else until all is written,
 * MR_TIMEOUT when nothing moves for that long. */
enum mr_status hil_link_flush(struct hil_link *link, int stall_ms, const volatile int *stop,
                              char *error, size_t size);
/* Give the board what the host has sent. */
void hil_link_receive(struct hil_link *link, struct hil_board *board);
/* Finish: signal the end to the host, read for a moment what it still sends, close, remove the
 * socket. */
void hil_link_close(struct hil_link *link);

#endif
