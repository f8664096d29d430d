#include "host/board/listen.h"

#include <errno.h>
#include <poll.h>
#include <string.h>

#include "common/catalogue.h"

enum mr_status listen_tenth(struct link *link, struct mr_deframer *deframer, listen_frame *take, void *context,
                            struct error *error)
{
    uint8_t bytes[16384];
    size_t length;
    uint64_t host_us;
    enum mr_status status = link_receive_bytes(link, bytes, sizeof bytes, &length, &host_us, error);
    if (status == MR_TOO_FEW) {
        struct pollfd ready = {.fd = link_fd(link), .events = POLLIN};
        if (poll(&ready, 1, 100) < 0 && errno != EINTR)
            return error_set(error, MR_IO, "cannot wait (%s): %s; try again", strerror(errno), link_spec(link));
        return MR_OK;
    }
    if (status == MR_CLOSED)
        return error_set(error, MR_CLOSED, "the board closed the link: %s; is it still running?", link_spec(link));
    for (size_t i = 0; status == MR_OK && i < length; i++) {
        struct mr_frame frame;
        if (mr_deframer_push(deframer, bytes[i], &frame) == MR_OK)
            status = take(context, &frame, error);
    }
    return status;
}

enum mr_status listen_hello(const struct link *link, const uint8_t *bytes, size_t length, struct error *error)
{
    struct mr_hello hello;
    if (mr_hello_get(&hello, bytes, length) == MR_OK && hello.layout != MR_LAYOUT)
        return error_set(error, MR_VERSION, "board speaks layout %u, this matrig layout %u: %s; use the matrig of its firmware",
                         hello.layout, MR_LAYOUT, link_spec(link));
    return MR_OK;
}
