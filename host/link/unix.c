/* Links unix:PATH: the socket of an emulated board. */
#include <errno.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "common/wire.h"
#include "host/link/link_ops.h"

#define OPEN_TRIES_MAX  250
#define OPEN_PAUSE_MS   20 /* pause between two tries; the tries take 5 s in all */
#define SEND_TIMEOUT_MS 1000
/* struct can_frame: id u32, length, 3 bytes of padding, 8 bytes of data; little-endian hosts */
#define CAN_FRAME_BYTES 16u

static enum mr_status unix_open(struct link *link, const char *path, struct error *error)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path)
        return error_set(error, MR_USAGE, "socket path too long: %s; give at most %zu characters",
                         link->spec, sizeof address.sun_path - 1);
    strcpy(address.sun_path, path);

    int reason = 0;
    for (int i = 0; i < OPEN_TRIES_MAX; i++) {
        /* Non-blocking: connect must not wait while the board has connections that it has not
         * accepted. */
        link->fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        if (link->fd < 0)
            return error_set(error, MR_IO,
                             "cannot create a socket (%s): %s; check the limits of this system",
                             strerror(errno), link->spec);
        if (connect(link->fd, (struct sockaddr *)&address, sizeof address) == 0)
            return MR_OK;
        reason = errno;
        close(link->fd);
        link->fd = -1;
        /* Try again: the board may not have created the socket yet, or the socket is left from an
         * earlier run. */
        if (reason != ENOENT && reason != ECONNREFUSED && reason != EAGAIN)
            break;
        poll(NULL, 0, OPEN_PAUSE_MS);
    }
    if (reason == EAGAIN)
        return error_set(
            error, MR_IO,
            "cannot connect (other programs are waiting): %s; end these programs and restart the "
            "emulated board, which serves only the first program that connects",
            link->spec);
    return error_set(error, MR_IO,
                     "cannot connect (%s): %s; start the emulated board on this socket first",
                     strerror(reason), link->spec);
}

static enum mr_status unix_receive_frame(struct link *link, struct link_frame *frame,
                                         struct error *error)
{
    while (link->buffer_end - link->buffer_start < CAN_FRAME_BYTES) {
        enum mr_status status = link_fill_buffer(link, error);
        if (status == MR_CLOSED && link->buffer_end > link->buffer_start)
            return error_set(error, MR_TRUNCATED,
                             "the link ended inside a frame: %s; all earlier frames are stored",
                             link->spec);
        if (status != MR_OK)
            return status;
    }
    const uint8_t *p = link->buffer + link->buffer_start;
    link->buffer_start += CAN_FRAME_BYTES;
    frame->host_us = link->read_us;
    frame->id = mr_get_u32(&p);
    frame->length = mr_get_u8(&p);
    memset(frame->data, 0, sizeof frame->data);
    if (frame->length > 8)
        return error_set(
            error, MR_MALFORMED,
            "CAN frame with length %u: %s; check that this is the CAN socket of the board",
            frame->length, link->spec);
    memcpy(frame->data, p + 3, frame->length);
    return MR_OK;
}

enum mr_status link_write(struct link *link, const uint8_t *bytes, size_t length,
                          struct error *error)
{
    while (length > 0) {
        ssize_t count = send(link->fd, bytes, length, MSG_NOSIGNAL);
        if (count < 0 && errno == ENOTSOCK)
            count = write(link->fd, bytes, length);
        if (count > 0) {
            bytes += count;
            length -= (size_t)count;
            continue;
        }
        struct pollfd ready = {.fd = link->fd, .events = POLLOUT};
        if (count < 0 && errno != EAGAIN && errno != EINTR)
            return error_set(error, MR_IO, "cannot send (%s): %s; check that the board is running",
                             strerror(errno), link->spec);
        if (poll(&ready, 1, SEND_TIMEOUT_MS) == 0)
            return error_set(error, MR_TIMEOUT,
                             "the board accepts no data: %s; check that the board is running",
                             link->spec);
    }
    return MR_OK;
}

const struct link_ops link_unix_ops = {
    .supported_kinds = 1u << LINK_CAN | 1u << LINK_SERIAL,
    .blocks_sender = true,
    .open = unix_open,
    .receive_frame = unix_receive_frame,
    .send = link_write,
};
