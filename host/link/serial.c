/* serial:TTY[:BAUD|:find], a serial port of this computer. */
#include <stdio.h>

#include "host/link/find_baud.h"
#include "host/link/link_ops.h"
#include "host/link/tty.h"

static enum mr_status serial_open(struct link *link, const char *text, struct error *error)
{
    char path[TTY_PATH_MAX];
    int baud;
    enum mr_status status = tty_parse(text, link->form, path, &baud, error);
    bool find = status == MR_OK && baud == TTY_BAUD_FIND;
    if (find)
        baud = link->baud ? link->baud : TTY_BAUD_DEFAULT; /* one that comes back is what it was */
    if (status == MR_OK)
        status = tty_open(link->spec, path, baud, &link->tty, error);
    if (status == MR_OK && find && link->baud == 0)
        status = find_baud(link->tty, link->spec, &baud, error);
    if (status != MR_OK)
        return status;
    if (find && link->baud == 0)
        fprintf(stderr, "matrig: %s: frames come at %d baud\n", link->spec, baud);
    link->baud = baud;
    link_hear_anew(link, baud);
    link->fd = tty_fd(link->tty);
    return MR_OK;
}

static ssize_t serial_read(struct link *link, uint8_t *bytes, size_t size)
{
    return tty_read(link->tty, bytes, size);
}

static enum mr_status serial_send(struct link *link, const uint8_t *bytes, size_t length,
                                  struct error *error)
{
    return tty_write(link->tty, bytes, length, error);
}

static void serial_service(struct link *link)
{
    tty_news(link->tty, link);
}

static enum mr_status serial_line(struct link *link, int baud, struct error *error)
{
    return tty_line(link->tty, baud, error);
}

static void serial_close(struct link *link)
{
    tty_close(link->tty);
    link->tty = NULL;
}

const struct link_ops link_serial_ops = {
    .kinds = 1u << LINK_SERIAL,
    .comes_back = true,
    .open = serial_open,
    .send = serial_send,
    .read = serial_read,
    .service = serial_service,
    .line = serial_line,
    .close = serial_close,
};
