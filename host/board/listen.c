#include "host/board/listen.h"

#include <errno.h>
#include <poll.h>
#include <string.h>
#include <time.h>

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

static enum mr_status receive(struct link *link, enum link_kind kind, struct mr_deframer *deframer, listen_message *take, void *context,
                              struct error *error)
{
    uint8_t bytes[16384];
    size_t length;
    uint64_t host_us;
    struct link_frame can;
    if (kind == LINK_CAN) {
        enum mr_status status = link_receive_frame(link, &can, error);
        return status == MR_OK ? take(context, can.id, can.data, can.length, error) : status;
    }
    enum mr_status status = link_receive_bytes(link, bytes, sizeof bytes, &length, &host_us, error);
    for (size_t i = 0; status == MR_OK && i < length; i++) {
        struct mr_frame frame;
        if (mr_deframer_push(deframer, bytes[i], &frame) == MR_OK)
            status = take(context, frame.type, frame.payload, frame.length, error);
    }
    return status;
}

enum mr_status listen_either(struct link *link, enum link_kind kind, struct mr_deframer *deframer, listen_message *take, void *context,
                             struct error *error)
{
    enum mr_status status = receive(link, kind, deframer, take, context, error);
    if (status == MR_TOO_FEW) {
        struct pollfd ready = {.fd = link_fd(link), .events = POLLIN};
        if (poll(&ready, 1, 100) < 0 && errno != EINTR)
            return error_set(error, MR_IO, "cannot wait (%s): %s; try again", strerror(errno), link_spec(link));
        struct error away = {0};
        status = link_service(link, &away);
        if (status != MR_OK && status != MR_TOO_FEW)
            return error_set(error, status, "%s", away.text);
        return MR_OK;
    }
    if (status == MR_CLOSED)
        return error_set(error, MR_CLOSED, "the board closed the link: %s; is it still running?", link_spec(link));
    return status;
}

enum mr_status listen_send(struct link *link, enum link_kind kind, uint16_t *seq, uint16_t id, const uint8_t *payload, size_t length,
                           struct error *error)
{
    uint8_t bytes[MR_FRAME_MAX];
    struct link_frame frame = {.id = id, .length = (uint8_t)length};
    if (kind == LINK_SERIAL)
        return link_send_bytes(link, bytes, mr_frame_encode((*seq)++, id, payload, length, bytes), error);
    memcpy(frame.data, payload, length);
    return link_send_frame(link, &frame, error);
}

enum mr_status listen_hello(const struct link *link, const uint8_t *bytes, size_t length, struct error *error)
{
    struct mr_hello hello;
    if (mr_hello_get(&hello, bytes, length) == MR_OK && hello.layout != MR_LAYOUT)
        return error_set(error, MR_VERSION, "board speaks layout %u, this matrig layout %u: %s; use the matrig of its firmware",
                         hello.layout, MR_LAYOUT, link_spec(link));
    return MR_OK;
}

bool listen_ack(const uint8_t *bytes, size_t length, uint16_t tag, struct mr_ack *ack)
{
    struct mr_ack heard;
    if (mr_ack_get(&heard, bytes, length) != MR_OK || heard.tag != tag)
        return false;
    *ack = heard;
    return true;
}

double listen_now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
