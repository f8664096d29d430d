#include "hil/link/wire_link.h"

/* defines struct termios2, for any rate; cannot be included together with termios.h */
#include <asm/termbits.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "hil/core/wall.h"

#define FRAME_BYTES      16u
#define CAN_EXTENDED     0x80000000u /* linux/can.h: CAN_EFF_FLAG, CAN_RTR_FLAG, CAN_ERR_FLAG */
#define CAN_REMOTE       0x40000000u
#define CAN_ERROR        0x20000000u
/* limit of the output that waits for a link with drops_when_full, in addition to the kernel's
 * buffer */
#define BUFFER_MAX_BYTES 65536u
#define CLOSE_TIMEOUT_MS 500
#define POLL_INTERVAL_MS 100
#define PTY_POLL_INTERVAL_MS \
    2                    /* the kernel does not wake the board when a host opens the terminal */
#define PTY_BAUD 115200u /* rate until a host sets another one */

/* ---- pseudo-terminal: a host program opens its name like a serial port. The rate that the host
 * sets is the rate of its end of the line. Linux drops the parity setting of pseudo-terminals
 * (drivers/tty/pty.c clears PARENB and forces eight bits), so the parity cannot be read here. A
 * program that insists on parity needs its option for none: `stm32flash -m 8n1`. ---- */

static bool set_raw_terminal(int fd, uint32_t baud)
{
    struct termios2 t;
    if (ioctl(fd, TCGETS2, &t) != 0)
        return false;
    t.c_iflag = t.c_oflag = t.c_lflag = 0;
    t.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
    t.c_ospeed = t.c_ispeed = baud;
    return ioctl(fd, TCSETS2, &t) == 0;
}

/* Opens and closes the host's end once: a pseudo-terminal reports that no host is present only
 * after its first close. */
static bool open_host_end_once(int fd)
{
    int other = open(ptsname(fd), O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (other < 0)
        return false;
    close(other);
    return true;
}

/* Opens a pseudo-terminal in raw mode at `baud`, with a symbolic link to it at `path`. Replaces an
 * old link. */
static enum mr_status open_pty(const char *path, uint32_t baud, int *fd, char *error, size_t size)
{
    static const char left[] = "/dev/pts/";
    struct stat st;
    char target[sizeof left] = "";
    *fd = -1;
    if (lstat(path, &st) == 0) {
        if (readlink(path, target, sizeof left - 1) < 0 || strcmp(target, left) != 0) {
            snprintf(error, size,
                     "--serial: %s exists and is not a link to a pseudo-terminal; remove it or "
                     "give a different path",
                     path);
            return MR_IO;
        }
        unlink(path); /* remove a link left by an earlier run */
    }
    *fd = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    if (*fd >= 0 && grantpt(*fd) == 0 && unlockpt(*fd) == 0 && set_raw_terminal(*fd, baud) &&
        open_host_end_once(*fd) && symlink(ptsname(*fd), path) == 0)
        return MR_OK;
    snprintf(error, size,
             "--serial: cannot create a pseudo-terminal at %s: %s; give a different path", path,
             strerror(errno));
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
    return MR_IO;
}

/* True if a host has the pseudo-terminal open. */
static bool is_pty_in_use(int fd)
{
    struct pollfd look = {.fd = fd};
    return poll(&look, 1, 0) >= 0 && !(look.revents & POLLHUP);
}

/* Rate set by the host, bits/s; 0 if it cannot be read. */
static uint32_t get_pty_baud(int fd)
{
    struct termios2 t;
    return ioctl(fd, TCGETS2, &t) == 0 ? t.c_ospeed : 0;
}

/* ---- links ---- */

static const char *get_link_noun(const struct hil_link *link)
{
    return link->kind == HIL_LINK_CAN ? "--can" : "--serial";
}

/* True if a program listens on the socket. Connects with the wrong type of socket, which does not
 * disturb the program but gives another error than without a program. */
static bool is_listening(const struct sockaddr_un *address)
{
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool live = fd >= 0 && connect(fd, (const struct sockaddr *)address, sizeof *address) != 0 &&
                errno == EPROTOTYPE;
    if (fd >= 0)
        close(fd);
    return live;
}

enum mr_status hil_socket_listen(const char *option, const char *path, int *listener, char *error,
                                 size_t size)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    struct stat st;
    if (strlen(path) >= sizeof address.sun_path) {
        snprintf(error, size,
                 "%s: the socket path has %zu characters, but only %zu are allowed; give a shorter "
                 "path than %s",
                 option, strlen(path), sizeof address.sun_path - 1, path);
        return MR_USAGE;
    }
    strcpy(address.sun_path, path);
    if (lstat(path, &st) == 0 && !S_ISSOCK(st.st_mode)) {
        snprintf(error, size,
                 "%s: %s exists and is not a socket; remove it or give a different path", option,
                 path);
        return MR_IO;
    }
    if (is_listening(&address)) {
        snprintf(error, size,
                 "%s: another program listens on %s; end that program or give a different path",
                 option, path);
        return MR_IO;
    }
    unlink(path); /* remove a socket left by an earlier run */
    *listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (*listener < 0 || bind(*listener, (const struct sockaddr *)&address, sizeof address) != 0 ||
        listen(*listener, 1) != 0) {
        snprintf(error, size, "%s: cannot listen on %s: %s; give a path in a writable folder",
                 option, path, strerror(errno));
        return MR_IO;
    }
    return MR_OK;
}

enum mr_status hil_link_open(struct hil_link *link, enum hil_link_kind kind, const char *text,
                             char *error, size_t size)
{
    *link = (struct hil_link){.kind = kind, .listener = -1, .fd = -1};
    if (strcmp(text, "none") == 0)
        return MR_OK;
    if (strncmp(text, "unix:", 5) == 0 && text[5]) {
        link->transport = HIL_LINK_UNIX;
        link->path = text + 5;
        return hil_socket_listen(get_link_noun(link), link->path, &link->listener, error, size);
    }
    if (strncmp(text, "pty:", 4) == 0 && text[4] && kind == HIL_LINK_SERIAL) {
        link->transport = HIL_LINK_PTY;
        link->path = text + 4;
        link->has_host_closed = true;
        return open_pty(link->path, PTY_BAUD, &link->fd, error, size);
    }
    if (strncmp(text, "file:", 5) == 0 && text[5]) {
        link->transport = HIL_LINK_FILE;
        link->path = text + 5;
        if (hil_is_protected_file(link->path)) {
            snprintf(error, size,
                     "would overwrite a database or a program: %s; give a different file",
                     link->path);
            return MR_USAGE;
        }
        link->fd = open(link->path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
        if (link->fd >= 0)
            return MR_OK;
        snprintf(error, size, "%s: cannot write %s: %s; give a different file", get_link_noun(link),
                 link->path, strerror(errno));
        return MR_IO;
    }
    snprintf(error, size,
             "%s: `%s` is not a link of the emulated board; give unix:PATH, file:PATH%s or none",
             get_link_noun(link), text, kind == HIL_LINK_SERIAL ? ", pty:PATH" : "");
    return MR_USAGE;
}

/* Checks once for a host, waiting at most POLL_INTERVAL_MS. */
static bool is_host_connected(struct hil_link *link)
{
    if (link->transport == HIL_LINK_PTY) {
        bool there = is_pty_in_use(link->fd);
        if (!there)
            poll(NULL, 0, PTY_POLL_INTERVAL_MS);
        return there;
    }
    struct pollfd wait = {.fd = link->listener, .events = POLLIN};
    int bytes = 4 << 20;
    if (poll(&wait, 1, POLL_INTERVAL_MS) <= 0)
        return false;
    link->fd = accept4(link->listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    setsockopt(link->fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
    return link->fd >= 0;
}

enum mr_status hil_link_accept(struct hil_link *link, int timeout_ms, const volatile int *stop,
                               char *error, size_t size)
{
    int64_t until = hil_wall_clock_ms() + timeout_ms;
    if (link->transport != HIL_LINK_UNIX && link->transport != HIL_LINK_PTY)
        return MR_OK;
    while (!*stop && hil_wall_clock_ms() < until) {
        if (is_host_connected(link))
            return MR_OK;
    }
    snprintf(error, size,
             "%s: no host connected to %s within %d s; start matrig log on this link, or give none",
             get_link_noun(link), link->path, timeout_ms / 1000);
    return *stop ? MR_CLOSED : MR_TIMEOUT;
}

static void discard_output(struct hil_link *link, size_t n)
{
    link->dropped_count += link->kind == HIL_LINK_CAN ? n / FRAME_BYTES : n;
}

void hil_link_put_bytes(struct hil_link *link, const uint8_t *bytes, size_t n)
{
    if (link->transport == HIL_LINK_NONE)
        return;
    link->has_moved_data = true;
    if (link->has_host_closed ||
        (link->drops_when_full && link->output_end - link->output_start + n > BUFFER_MAX_BYTES)) {
        discard_output(link, link->kind == HIL_LINK_CAN ? FRAME_BYTES : n);
        return;
    }
    if (link->output_start && link->output_end + n > link->capacity) {
        memmove(link->buffer, link->buffer + link->output_start,
                link->output_end - link->output_start);
        link->output_end -= link->output_start;
        link->output_start = 0;
    }
    if (link->output_end + n > link->capacity) {
        size_t room = 2 * (link->output_end + n) + 65536u;
        uint8_t *grown = realloc(link->buffer, room);
        if (!grown)
            abort();
        link->buffer = grown;
        link->capacity = room;
    }
    memcpy(link->buffer + link->output_end, bytes, n);
    link->output_end += n;
}

static void put_candump_line(struct hil_link *link, uint64_t t_ps,
                             const struct hil_can_frame *frame)
{
    char line[80];
    uint64_t t_us = t_ps / HIL_PS_PER_US;
    int n = snprintf(line, sizeof line, "(%010llu.%06llu) can0 %0*X#",
                     (unsigned long long)(t_us / 1000000u), (unsigned long long)(t_us % 1000000u),
                     frame->is_extended ? 8 : 3, (unsigned)frame->id);
    if (frame->is_remote)
        n += snprintf(line + n, sizeof line - (size_t)n, "R%u", frame->length);
    for (unsigned i = 0; !frame->is_remote && i < frame->length; i++)
        n += snprintf(line + n, sizeof line - (size_t)n, "%02X", frame->data[i]);
    line[n++] = '\n';
    hil_link_put_bytes(link, (const uint8_t *)line, (size_t)n);
}

void hil_link_put_frame(struct hil_link *link, uint64_t t_ps, const struct hil_can_frame *frame)
{
    if (link->transport == HIL_LINK_FILE) {
        put_candump_line(link, t_ps, frame);
        return;
    }
    uint8_t bytes[FRAME_BYTES] = {0};
    uint32_t id = frame->id | (frame->is_extended ? CAN_EXTENDED : 0) |
                  (frame->is_remote ? CAN_REMOTE : 0);
    /* in the byte order of this computer, as in the kernel's struct */
    memcpy(bytes, &id, sizeof id);
    bytes[4] = frame->length;
    memcpy(bytes + 8, frame->data, frame->length);
    hil_link_put_bytes(link, bytes, sizeof bytes);
}

static void disconnect_host(struct hil_link *link)
{
    link->has_host_closed = true;
    discard_output(link, link->output_end - link->output_start);
    link->output_start = link->output_end = 0;
}

static ssize_t write_buffered_output(struct hil_link *link)
{
    const uint8_t *from = link->buffer + link->output_start;
    size_t n = link->output_end - link->output_start;
    if (link->transport == HIL_LINK_FILE || link->transport == HIL_LINK_PTY)
        return write(link->fd, from, n);
    return send(link->fd, from, n, MSG_NOSIGNAL);
}

enum mr_status hil_link_flush(struct hil_link *link, int stall_ms, const volatile int *stop,
                              char *error, size_t size)
{
    int64_t moved = hil_wall_clock_ms();
    while (link->fd >= 0 && link->output_start < link->output_end && !link->has_host_closed) {
        ssize_t n = write_buffered_output(link);
        if (n > 0) {
            link->output_start += (size_t)n;
            moved = hil_wall_clock_ms();
            continue;
        }
        if (n < 0 && errno == EINTR)
            continue;
        if (link->transport == HIL_LINK_FILE) {
            snprintf(error, size,
                     "%s: cannot write %s: %s; free disk space or give a different file",
                     get_link_noun(link), link->path, strerror(errno));
            return MR_IO;
        }
        if ((n < 0 && errno != EAGAIN && errno != EWOULDBLOCK) ||
            (link->transport == HIL_LINK_PTY && !is_pty_in_use(link->fd))) {
            disconnect_host(link);
            return MR_OK;
        }
        if (!stall_ms)
            return MR_OK;
        if (*stop)
            return MR_CLOSED;
        if (hil_wall_clock_ms() - moved > stall_ms) {
            snprintf(error, size,
                     "%s: the host has not read from %s for %.4g s; check that the host is "
                     "running, or raise the limit with --stall S",
                     get_link_noun(link), link->path, stall_ms * 1e-3);
            return MR_TIMEOUT;
        }
        struct pollfd wait = {.fd = link->fd, .events = POLLOUT};
        poll(&wait, 1, POLL_INTERVAL_MS);
    }
    if (link->output_start == link->output_end)
        link->output_start = link->output_end = 0;
    return MR_OK;
}

static void receive_frame(struct hil_board *board, const uint8_t bytes[FRAME_BYTES])
{
    uint32_t id;
    memcpy(&id, bytes, sizeof id);
    if (id & CAN_ERROR)
        return; /* a report of the host's controller, not a frame on the bus */
    struct hil_can_frame frame = {
        .is_extended = (id & CAN_EXTENDED) != 0,
        .is_remote = (id & CAN_REMOTE) != 0,
        .id = id & ((id & CAN_EXTENDED) ? 0x1fffffffu : 0x7ffu),
        .length = bytes[4] > 8 ? 8 : bytes[4],
    };
    memcpy(frame.data, bytes + 8, frame.length);
    hil_can_inject(&board->mcu.can, &frame); /* hil_can_inject counts a full queue */
}

static void receive_pty(struct hil_link *link, struct hil_board *board)
{
    uint8_t bytes[4096];
    size_t room = hil_usart_free_space(&board->mcu.usart);
    uint32_t baud = get_pty_baud(link->fd);
    link->has_host_closed = !is_pty_in_use(link->fd);
    if (link->has_host_closed) {
        disconnect_host(link);
        return;
    }
    if (baud && baud != link->baud) {
        link->baud = baud;
        board->options.host_baud = baud;
    }
    struct pollfd look = {.fd = link->fd, .events = POLLIN};
    if (!link->drops_when_full &&
        !link->has_moved_data) /* both ends wait for each other: give the host processor time */
        poll(&look, 1, PTY_POLL_INTERVAL_MS);
    ssize_t n = read(link->fd, bytes, room < sizeof bytes ? room : sizeof bytes);
    link->has_moved_data = n > 0;
    if (n > 0)
        hil_usart_inject(&board->mcu.usart, bytes, (size_t)n);
}

void hil_link_receive(struct hil_link *link, struct hil_board *board)
{
    uint8_t bytes[4096];
    if (link->transport == HIL_LINK_PTY && link->fd >= 0)
        receive_pty(link, board);
    if (link->transport != HIL_LINK_UNIX || link->fd < 0 || link->has_host_closed)
        return;
    for (;;) {
        ssize_t n = recv(link->fd, bytes, sizeof bytes, MSG_DONTWAIT);
        if (n == 0)
            disconnect_host(link);
        if (n <= 0)
            return;
        if (link->kind == HIL_LINK_SERIAL) {
            hil_usart_inject(&board->mcu.usart, bytes, (size_t)n);
            continue;
        }
        for (ssize_t i = 0; i < n; i++) {
            link->partial_frame[link->partial_frame_size++] = bytes[i];
            if (link->partial_frame_size == FRAME_BYTES) {
                link->partial_frame_size = 0;
                receive_frame(board, link->partial_frame);
            }
        }
    }
}

void hil_link_close(struct hil_link *link)
{
    if (link->transport == HIL_LINK_UNIX && link->fd >= 0) {
        uint8_t rest[4096];
        int64_t until = hil_wall_clock_ms() + CLOSE_TIMEOUT_MS;
        shutdown(link->fd, SHUT_WR);
        /* Read remaining input first: closing with unread input would look like an error to the
         * host. */
        while (hil_wall_clock_ms() < until) {
            struct pollfd wait = {.fd = link->fd, .events = POLLIN};
            if (poll(&wait, 1, POLL_INTERVAL_MS) > 0 &&
                recv(link->fd, rest, sizeof rest, MSG_DONTWAIT) == 0)
                break;
        }
    }
    if (link->fd >= 0)
        close(link->fd);
    if (link->listener >= 0)
        close(link->listener);
    if (link->listener >= 0 || (link->transport == HIL_LINK_PTY && link->fd >= 0))
        unlink(link->path);
    free(link->buffer);
    link->buffer = NULL;
    link->fd = link->listener = -1;
}
