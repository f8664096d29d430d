/* The two links of the board, each given as `unix:PATH` (the board listens, one host connects),
 * `pty:PATH` (a pseudo-terminal, serial only), `file:PATH` (candump -L text for CAN, raw bytes for
 * serial), or `none`.
 *
 * A CAN socket carries 16-byte frames in both directions, in the layout of Linux's struct can_frame
 * (identifier with flags, length, three bytes of padding, eight bytes of data). A serial socket
 * carries bytes in both directions. Output waits in a buffer until hil_link_flush. If the host
 * disconnects, further output is dropped and counted; this is not an error. A pty can be opened and
 * closed any number of times. */
#ifndef MATRIG_HIL_WIRE_LINK_H
#define MATRIG_HIL_WIRE_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/board/board.h"

enum hil_link_kind { HIL_LINK_CAN, HIL_LINK_SERIAL };
enum hil_link_transport { HIL_LINK_NONE, HIL_LINK_UNIX, HIL_LINK_FILE, HIL_LINK_PTY };

struct hil_link {
    enum hil_link_kind kind;
    enum hil_link_transport transport;
    const char *path; /* path as given; belongs to the caller */
    int listener, fd; /* descriptors; -1: none */
    uint8_t *buffer;
    /* range of the waiting output in `buffer`, and size of the buffer */
    size_t output_start, output_end, capacity;
    /* when the buffer is full, output is dropped instead of enlarging the buffer */
    bool drops_when_full;
    bool has_host_closed;      /* the host has closed its end (a host may open a pty again) */
    bool has_moved_data;       /* pty: data were transferred since the last check */
    uint32_t baud;             /* pty: baud rate that was last reported to the board */
    uint64_t dropped_count;    /* number of dropped frames (CAN) or bytes (serial) */
    uint8_t partial_frame[16]; /* bytes of an incomplete frame */
    size_t partial_frame_size;
};

/* Listens on a socket in the file system. Fails if another program listens on it or a different
 * file has this path. `option` is used in the error text. The caller must close `*listener`, also
 * after an error. MR_OK, MR_USAGE, MR_IO. */
enum mr_status hil_socket_listen(const char *option, const char *path, int *listener, char *error,
                                 size_t size);
/* Opens a link given as text. MR_OK; MR_USAGE: not a link; MR_IO: cannot be opened. `error` has the
 * reason. */
enum mr_status hil_link_open(struct hil_link *link, enum hil_link_kind kind, const char *text,
                             char *error, size_t size);
/* Waits until a host has connected or has opened the pty; returns at once for links without a host.
 * MR_TIMEOUT; MR_IO; MR_CLOSED: `*stop` ended the wait. */
enum mr_status hil_link_accept(struct hil_link *link, int timeout_ms, const volatile int *stop,
                               char *error, size_t size);

void hil_link_put_frame(struct hil_link *link, uint64_t t_ps, const struct hil_can_frame *frame);
void hil_link_put_bytes(struct hil_link *link, const uint8_t *bytes, size_t n);
/* Writes the waiting output. stall_ms 0: as much as possible without waiting; otherwise everything.
 * MR_TIMEOUT: no byte could be written for stall_ms. */
enum mr_status hil_link_flush(struct hil_link *link, int stall_ms, const volatile int *stop,
                              char *error, size_t size);
/* Passes data from the host to the board. */
void hil_link_receive(struct hil_link *link, struct hil_board *board);
/* Signals the end to the host, reads remaining data for a short time, closes the link and removes
 * the socket. */
void hil_link_close(struct hil_link *link);

#endif
