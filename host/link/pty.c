/* pty:PATH, the pseudo-terminal of an emulated board, which follows the rate that is set here. libserialport does not take it:
 * there is no device behind it. */
#include <asm/termbits.h> /* struct termios2, for any rate; not to be mixed with termios.h */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "host/link/link_ops.h"
#include "host/link/tty.h"

#define OPEN_TRIES 250
#define OPEN_PAUSE_MS 20 /* 5 s in all, as unix: does: the board may just be starting */
#define SEND_WAIT_MS 1000

/* Linux keeps no parity for pseudo-terminals: nobody would see it. */
static enum mr_status pty_line(struct link *link, int baud, bool even_parity, struct error *error)
{
    struct termios2 t;
    (void)even_parity;
    bool set = ioctl(link->fd, TCGETS2, &t) == 0;
    if (set) {
        t.c_iflag = t.c_oflag = t.c_lflag = 0;
        t.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
        t.c_ispeed = t.c_ospeed = (speed_t)baud;
        t.c_cc[VMIN] = 1;
        t.c_cc[VTIME] = 0;
        set = ioctl(link->fd, TCSETS2, &t) == 0;
    }
    if (!set)
        return error_set(error, MR_IO, "no terminal (%s): %s; write unix:PATH for a socket", strerror(errno), link->spec);
    ioctl(link->fd, TCFLSH, TCIFLUSH);
    return MR_OK;
}

static enum mr_status pty_open(struct link *link, const char *path, struct error *error)
{
    bool first = link->away.status == MR_OK; /* one that was there is waited for in link.c */
    for (int i = 0; i < OPEN_TRIES; i++) {
        link->fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
        if (link->fd >= 0 || errno != ENOENT || !first)
            break;
        poll(NULL, 0, OPEN_PAUSE_MS);
    }
    if (link->fd < 0)
        return error_set(error, MR_IO, "cannot open the terminal (%s): %s; start the emulated board there first",
                         strerror(errno), link->spec);
    if (flock(link->fd, LOCK_EX | LOCK_NB) != 0) /* each would take bytes from the other */
        return error_set(error, MR_IO, "another matrig has the terminal: %s; end it first", link->spec);
    return pty_line(link, TTY_BAUD_DEFAULT, false, error);
}

static enum mr_status pty_send(struct link *link, const uint8_t *bytes, size_t length, struct error *error)
{
    while (length > 0) {
        ssize_t count = write(link->fd, bytes, length);
        if (count > 0) {
            bytes += count;
            length -= (size_t)count;
            continue;
        }
        struct pollfd ready = {.fd = link->fd, .events = POLLOUT};
        if (count < 0 && errno != EAGAIN && errno != EINTR)
            return error_set(error, MR_IO, "cannot send (%s): %s; is the board still there?", strerror(errno), link->spec);
        if (poll(&ready, 1, SEND_WAIT_MS) == 0)
            return error_set(error, MR_TIMEOUT, "the board takes nothing: %s; is it stopped?", link->spec);
    }
    return MR_OK;
}

const struct link_ops link_pty_ops = {
    .prefix = "pty:",
    .form = "pty:PATH",
    .kinds = 1u << LINK_SERIAL,
    .open = pty_open,
    .send = pty_send,
    .line = pty_line,
};
