/* pty:PATH, the pseudo-terminal of an emulated board, which follows the rate that is set here. */
#include <errno.h>
#include <poll.h>
#include <unistd.h>

#include "host/link/link_ops.h"
#include "host/link/pts.h"
#include "host/link/tty.h"

#define OPEN_TRIES    250
#define OPEN_PAUSE_MS 20 /* 5 s in all, as unix: does: the board may just be starting */

static enum mr_status pty_line(struct link *link, int baud, struct error *error)
{
    return pts_line(link->spec, link->fd, baud, error);
}

static enum mr_status pty_open(struct link *link, const char *path, struct error *error)
{
    bool first = link->away.status == MR_OK; /* one that was there is waited for in link.c */
    for (int i = 0; first && i < OPEN_TRIES && access(path, F_OK) != 0 && errno == ENOENT; i++)
        poll(NULL, 0, OPEN_PAUSE_MS);
    link_hear_anew(link, TTY_BAUD_DEFAULT);
    return pts_open(link->spec, path, TTY_BAUD_DEFAULT, &link->fd, error);
}

static enum mr_status pty_send(struct link *link, const uint8_t *bytes, size_t length,
                               struct error *error)
{
    return link_write(link->spec, link->fd, bytes, length, error);
}

const struct link_ops link_pty_ops = {
    .kinds = 1u << LINK_SERIAL,
    .waits = true,
    .open = pty_open,
    .send = pty_send,
    .line = pty_line,
};
