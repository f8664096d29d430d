/* pty:PATH, the pseudo-terminal of an emulated board, which follows the rate that is set here. */
#include "host/link/link_ops.h"
#include "host/link/pts.h"
#include "host/link/tty.h"

static enum mr_status pty_line(struct link *link, int baud, bool even_parity, struct error *error)
{
    (void)even_parity;
    return pts_line(link->spec, link->fd, baud, error);
}

static enum mr_status pty_open(struct link *link, const char *path, struct error *error)
{
    return pts_open(link->spec, path, TTY_BAUD_DEFAULT, &link->fd, error);
}

static enum mr_status pty_send(struct link *link, const uint8_t *bytes, size_t length, struct error *error)
{
    return pts_write(link->spec, link->fd, bytes, length, error);
}

const struct link_ops link_pty_ops = {
    .prefix = "pty:",
    .form = "pty:PATH",
    .kinds = 1u << LINK_SERIAL,
    .open = pty_open,
    .send = pty_send,
    .line = pty_line,
};
