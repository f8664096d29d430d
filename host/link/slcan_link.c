/* slcan:TTY[:BAUD], a LAWICEL adapter: opened at 1 Mbit/s, with time stamps when it has them, and
 * asked for its status once a second. */
#include <poll.h>
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/link/link_ops.h"
#include "host/link/slcan.h"
#include "host/link/tty.h"
#include "host/base/steady.h"

#define ANSWER_US 500000u

struct slcan {
    struct slcan_parser parser;
    struct slcan_clock clock;
    uint8_t status; /* last flags */
};

/* The next item of what has come. SLCAN_MORE: nothing whole is there; then `*status` says why. */
static enum slcan_kind next_item(struct link *link, enum mr_status *status, struct error *error)
{
    for (;;) {
        while (link->start < link->end) {
            enum slcan_kind kind = slcan_push(&link->slcan->parser,
                                              (char)link->buffer[link->start++]);
            if (kind != SLCAN_MORE)
                return kind;
        }
        *status = link_fill(link, error);
        if (*status != MR_OK)
            return SLCAN_MORE;
    }
}

/* Send a command and wait for its answer; frames that come in between belong to a channel that is
 * still open, and are passed over. SLCAN_MORE: no answer in time. */
static enum slcan_kind command(struct link *link, const char *text, struct error *error)
{
    uint64_t until_us = steady_us() + ANSWER_US;
    enum mr_status status = tty_write(link->tty, (const uint8_t *)text, strlen(text), error);
    while (status == MR_OK && steady_us() < until_us) {
        enum slcan_kind kind = next_item(link, &status, error);
        if (kind == SLCAN_DONE || kind == SLCAN_REFUSED || kind == SLCAN_STATUS)
            return kind;
        if (kind != SLCAN_MORE)
            continue;
        struct pollfd ready = {.fd = tty_fd(link->tty), .events = POLLIN};
        if (status == MR_TOO_FEW && poll(&ready, 1, 20) >= 0)
            status = MR_OK;
    }
    return SLCAN_MORE;
}

/* An adapter may hold half a line of an earlier program, and may be open already. */
static enum mr_status start(struct link *link, struct error *error)
{
    if (command(link, "\r", error) == SLCAN_MORE && error->status == MR_OK)
        command(link, "\r", error);
    enum slcan_kind closed = command(link, "C\r", error);
    if (error->status == MR_OK && closed == SLCAN_MORE)
        return error_set(
            error, MR_TIMEOUT,
            "no SLCAN adapter answers: %s; check the port and its baud rate (slcan:TTY:BAUD)",
            link->spec);
    if (error->status == MR_OK && command(link, "S8\r", error) != SLCAN_DONE)
        return error_set(error, MR_IO, "the adapter does not do 1 Mbit/s (S8): %s; use another one",
                         link->spec);
    /* Adapters without time stamps refuse this; the host's clock does then. */
    if (error->status == MR_OK)
        command(link, "Z1\r", error);
    if (error->status == MR_OK && command(link, "O\r", error) != SLCAN_DONE)
        return error_set(error, MR_IO,
                         "the adapter does not open its channel (O): %s; unplug it and try again",
                         link->spec);
    return error->status;
}

static void slcan_close(struct link *link)
{
    struct error ignored = {0};
    if (link->tty && link->away.status == MR_OK)
        tty_write(link->tty, (const uint8_t *)"C\r", 2, &ignored);
    tty_close(link->tty);
    free(link->slcan);
    link->tty = NULL;
    link->slcan = NULL;
}

static enum mr_status slcan_open(struct link *link, const char *text, struct error *error)
{
    char path[TTY_PATH_MAX];
    int baud;
    link->slcan = calloc(1, sizeof *link->slcan);
    if (!link->slcan)
        return error_set(error, MR_FULL, "no memory: link %s; close other programs", link->spec);
    enum mr_status status = tty_parse(text, link->form, path, &baud, error);
    if (status == MR_OK && baud == TTY_BAUD_FIND)
        status = error_set(error, MR_USAGE, "an adapter's rate is not looked for: %s; write %s",
                           link->spec, link->form);
    if (status == MR_OK)
        status = tty_open(link->spec, path, baud, &link->tty, error);
    if (status != MR_OK)
        return status;
    link->fd = tty_fd(link->tty);
    return start(link, error);
}

static ssize_t slcan_read(struct link *link, uint8_t *bytes, size_t size)
{
    return tty_read(link->tty, bytes, size);
}

/* Flags that stay set are told once; those of lost frames each time. False: nothing to tell. */
static bool take_status(const struct link *link, struct slcan *slcan, struct link_frame *frame)
{
    uint8_t now = slcan->parser.status;
    uint8_t told = now & (uint8_t)(~slcan->status | SLCAN_STATUS_LOST);
    slcan->status = now;
    if (!slcan_status_frame(told, frame))
        return false;
    frame->host_us = link->read_us;
    return true;
}

static enum mr_status slcan_receive_frame(struct link *link, struct link_frame *frame,
                                          struct error *error)
{
    struct slcan *slcan = link->slcan;
    for (;;) {
        enum mr_status status = MR_OK;
        switch (next_item(link, &status, error)) {
        case SLCAN_FRAME:
            *frame = slcan->parser.frame;
            frame->host_us = slcan_time(&slcan->clock, slcan->parser.stamp_ms,
                                        link->read_monotonic_us) +
                             link_ahead_us(link);
            return MR_OK;
        case SLCAN_STATUS:
            if (take_status(link, slcan, frame))
                return MR_OK;
            break;
        case SLCAN_GARBLED: link_trouble(link, LINK_GARBLED, 1); break;
        case SLCAN_REFUSED: link_trouble(link, LINK_REFUSED, 1); break;
        case SLCAN_MORE: return status;
        default: break;
        }
    }
}

static enum mr_status slcan_send(struct link *link, const uint8_t *bytes, size_t length,
                                 struct error *error)
{
    struct link_frame frame = {.id = mr_get_u32(&bytes), .length = *bytes};
    char line[SLCAN_LINE_MAX];
    (void)length;
    memcpy(frame.data, bytes + 4, sizeof frame.data);
    size_t count = slcan_print(&frame, line);
    return tty_write(link->tty, (const uint8_t *)line, count, error);
}

static void slcan_service(struct link *link)
{
    struct error ignored = {0}; /* a port that broke is found by the next read */
    tty_write(link->tty, (const uint8_t *)"F\r", 2, &ignored);
    tty_news(link->tty, link);
}

const struct link_ops link_slcan_ops = {
    .kinds = 1u << LINK_CAN,
    .comes_back = true,
    .open = slcan_open,
    .receive_frame = slcan_receive_frame,
    .send = slcan_send,
    .read = slcan_read,
    .service = slcan_service,
    .close = slcan_close,
};
