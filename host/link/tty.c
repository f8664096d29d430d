/* serial:TTY[:BAUD], a serial port of this computer through libserialport; pty:PATH, the
 * pseudo-terminal of an emulated board. */
#include "host/link/tty.h"

/* Defines struct termios2, which allows any baud rate. Cannot be included together with
 * termios.h. */
#include <asm/termbits.h>
#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <libserialport.h>
#include <limits.h>
#include <linux/serial.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/link/link_ops.h"

/* ---- pseudo-terminals: libserialport rejects them, because Linux stores no parity for them
 * ---- */

static enum mr_status pts_set_baud(struct link *link, int baud, struct error *error)
{
    struct termios2 t;
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
        return error_set(error, MR_IO, "not a terminal (%s): %s; for a socket write unix:PATH",
                         strerror(errno), link->spec);
    ioctl(link->fd, TCFLSH, TCIFLUSH);
    return MR_OK;
}

static enum mr_status pts_open(struct link *link, const char *path, int baud, struct error *error)
{
    link->fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (link->fd < 0)
        return error_set(
            error, MR_IO,
            "cannot open the terminal (%s): %s; start the emulated board on this terminal first",
            strerror(errno), link->spec);
    /* Exclusive lock: two readers would each receive only some of the bytes. */
    if (flock(link->fd, LOCK_EX | LOCK_NB) != 0)
        return error_set(error, MR_IO,
                         "another matrig uses the terminal: %s; end that program first",
                         link->spec);
    return pts_set_baud(link, baud, error);
}

/* ---- serial: ---- */

#define WRITE_TIMEOUT_MS       1000u
#define BAUD_MAX               20000000
/* Directory of pseudo-terminals. They are accepted as serial ports, for socat or an emulated
 * adapter. */
#define PTS_DIRECTORY          "/dev/pts/"
/* a UART loses bytes if its rate has a larger error */
#define BAUD_TOLERANCE_PERCENT 2

struct tty {
    struct sp_port *port; /* port of libserialport; NULL: a pseudo-terminal */
    const char *spec;
    int fd;
    struct serial_icounter_struct last_counters;
    int driver_counts_errors;
};

enum mr_status tty_parse(const char *text, const char *syntax, char path[TTY_PATH_SIZE], int *baud,
                         struct error *error)
{
    const char *colon = strrchr(text, ':');
    size_t length = strlen(text);
    *baud = TTY_BAUD_DEFAULT;
    if (colon && strspn(colon + 1, "0123456789") == strlen(colon + 1)) {
        char *end;
        long value = strtol(colon + 1, &end, 10);
        if (end == colon + 1 || value < 50 || value > BAUD_MAX)
            return error_set(error, MR_USAGE,
                             "not a baud rate: '%s' of '%s'; write %s with a rate of 50 to %d baud",
                             colon + 1, text, syntax, BAUD_MAX);
        *baud = (int)value;
        length = (size_t)(colon - text);
    } else if (colon && colon > text && (size_t)(colon - text) < TTY_PATH_SIZE) {
        /* Split at the last colon only: names in /dev/serial/by-path/ contain colons too. */
        snprintf(path, TTY_PATH_SIZE, "%.*s", (int)(colon - text), text);
        if (access(path, F_OK) == 0 && access(text, F_OK) != 0)
            return error_set(error, MR_USAGE,
                             "not a baud rate: '%s' of '%s'; write %s with a rate of 50 to %d baud",
                             colon + 1, text, syntax, BAUD_MAX);
    }
    if (length == 0 || length >= TTY_PATH_SIZE)
        return error_set(error, MR_USAGE, "not a serial port: '%s'; write %s", text, syntax);
    memcpy(path, text, length);
    path[length] = '\0';
    return MR_OK;
}

/* Writes a text that identifies the adapter of a port: "USB 0403:6001, serial number A50285BI";
 * empty: not USB. */
static void describe_adapter(const struct sp_port *port, char usb[USB_TEXT_SIZE])
{
    const char *number = sp_get_port_usb_serial(port);
    int vendor, product;
    usb[0] = '\0';
    if (sp_get_port_transport(port) == SP_TRANSPORT_USB &&
        sp_get_port_usb_vid_pid(port, &vendor, &product) == SP_OK)
        snprintf(usb, USB_TEXT_SIZE, "USB %04x:%04x%s%s", (unsigned)vendor, (unsigned)product,
                 number ? ", serial number " : "", number ?: "");
}

/* Finds the adapter `usb`, and writes its present name into `real`. The name may have changed, and
 * `real` may have become the name of another adapter. Returns false if the adapter is missing, or
 * if several are alike and none has the old name. */
static bool find_adapter(const char *usb, char real[PATH_MAX])
{
    struct sp_port **ports = NULL;
    char other[USB_TEXT_SIZE], found[PATH_MAX];
    unsigned count = 0;
    bool same = false;
    if (sp_list_ports(&ports) != SP_OK)
        return false;
    for (size_t i = 0; ports[i]; i++) {
        describe_adapter(ports[i], other);
        if (strcmp(other, usb) != 0)
            continue;
        snprintf(found, sizeof found, "%s", sp_get_port_name(ports[i]));
        same |= strcmp(found, real) == 0;
        count++;
    }
    sp_free_port_list(ports);
    if (!same && count == 1)
        strcpy(real, found);
    return same || count == 1;
}

/* Stores which adapter the port belongs to. Nothing is stored if several ports are alike (adapters
 * without serial numbers, or with several ports), because then only the name distinguishes them. */
static void store_adapter_name(struct link *link)
{
    char none[PATH_MAX] = "";
    describe_adapter(link->tty->port, link->adapter);
    if (!find_adapter(link->adapter, none))
        link->adapter[0] = '\0';
}

/* Writes "there are /dev/ttyS0, /dev/ttyUSB0" or "there is none". */
static void list_ports(char *out, size_t size)
{
    struct sp_port **ports = NULL;
    size_t used = 0;
    out[0] = '\0';
    if (sp_list_ports(&ports) == SP_OK) {
        for (size_t i = 0; ports[i] && used < size; i++)
            used += (size_t)snprintf(out + used, size - used, "%s%s", used ? ", " : "there are ",
                                     sp_get_port_name(ports[i]));
        sp_free_port_list(ports);
    }
    if (used == 0)
        snprintf(out, size, "there is none");
}

static enum mr_status set_no_port_error(const char *spec, const char *why, struct error *error)
{
    char known[300];
    list_ports(known, sizeof known);
    return error_set(error, MR_IO, "no serial port (%s): %s; %s%s", why, spec,
                     strpbrk(spec, ",@; ") ? "write serial:TTY[:BAUD]; " : "", known);
}

static enum mr_status set_open_error(const char *spec, const char *real, struct error *error)
{
    int reason = sp_last_error_code();
    struct stat info;
    const struct group *group = stat(real, &info) == 0 ? getgrgid(info.st_gid) : NULL;
    if ((reason == EACCES || reason == EPERM) && group)
        return error_set(error, MR_IO,
                         "no permission to open the serial port (%s; its group is %s, its mode "
                         "%03o): %s; join the group: adduser $USER %s",
                         strerror(reason), group->gr_name, info.st_mode & 0777u, spec,
                         group->gr_name);
    if (reason == EBUSY)
        return error_set(error, MR_IO,
                         "another program uses the serial port: %s; end that program first", spec);
    return set_no_port_error(spec, strerror(reason), error);
}

static enum mr_status configure_port(struct tty *tty, int baud, struct error *error)
{
    struct sp_port_config *config = NULL;
    int actual_baud = 0;
    if (sp_set_baudrate(tty->port, baud) != SP_OK || sp_set_bits(tty->port, 8) != SP_OK ||
        sp_set_parity(tty->port, SP_PARITY_NONE) != SP_OK ||
        sp_set_stopbits(tty->port, 1) != SP_OK ||
        sp_set_flowcontrol(tty->port, SP_FLOWCONTROL_NONE) != SP_OK)
        return error_set(
            error, MR_IO,
            "the serial port does not support %d baud, 8N1 (%s): %s; give a different rate", baud,
            strerror(sp_last_error_code()), tty->spec);
    /* Reads the rate back, because a driver that does not support it uses another one without an
     * error. */
    if (sp_new_config(&config) == SP_OK) {
        if (sp_get_config(tty->port, config) != SP_OK ||
            sp_get_config_baudrate(config, &actual_baud) != SP_OK)
            actual_baud = 0;
        sp_free_config(config);
    }
    if (actual_baud > 0 && abs(actual_baud - baud) > baud / 100 * BAUD_TOLERANCE_PERCENT)
        return error_set(error, MR_IO,
                         "the serial port does not support %d baud and uses %d baud instead: %s; "
                         "give a different rate",
                         baud, actual_baud, tty->spec);
    return MR_OK;
}

/* Locks the port in two ways: TIOCEXCL excludes other programs, except those of root; the file lock
 * excludes another matrig. */
static enum mr_status lock_port(struct tty *tty, struct error *error)
{
    if (flock(tty->fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return error_set(error, MR_IO,
                         "another program uses the serial port: %s; end that program first",
                         tty->spec);
    ioctl(tty->fd, TIOCEXCL);
    return MR_OK;
}

static enum mr_status open_port(struct tty *tty, const char *real, int baud, struct error *error)
{
    enum mr_status status = MR_OK;
    if (sp_get_port_by_name(real, &tty->port) != SP_OK)
        status = set_no_port_error(tty->spec, "not a serial device", error);
    else if (sp_open(tty->port, SP_MODE_READ_WRITE) != SP_OK) {
        status = set_open_error(tty->spec, real, error);
        sp_free_port(tty->port);
        tty->port = NULL;
    } else if (sp_get_port_handle(tty->port, &tty->fd) != SP_OK)
        status = error_set(error, MR_IO,
                           "cannot share the serial port with the reading thread: %s; try again",
                           tty->spec);
    if (status == MR_OK)
        status = lock_port(tty, error);
    return status ?: configure_port(tty, baud, error);
}

static void serial_close(struct link *link)
{
    struct tty *tty = link->tty;
    if (!tty)
        return;
    if (tty->port) {
        if (tty->fd > 0)
            ioctl(tty->fd, TIOCNXCL);
        sp_close(tty->port);
        sp_free_port(tty->port);
    } else if (tty->fd >= 0) {
        close(tty->fd);
    }
    free(tty);
    link->tty = NULL;
}

static enum mr_status serial_open(struct link *link, const char *text, struct error *error)
{
    /* libserialport does not follow symbolic links in /dev */
    char path[TTY_PATH_SIZE], real[PATH_MAX];
    char away[USB_TEXT_SIZE + 20];
    int baud;
    enum mr_status status = tty_parse(text, link->syntax, path, &baud, error);
    if (status != MR_OK)
        return status;
    if (!realpath(path, real)) {
        if (!link->adapter[0])
            return set_no_port_error(link->spec, strerror(errno), error);
        snprintf(real, sizeof real, "%s", path);
    }
    if (link->adapter[0] && !find_adapter(link->adapter, real)) {
        snprintf(away, sizeof away, "%s does not exist", link->adapter);
        return set_no_port_error(link->spec, away, error);
    }
    struct tty *tty = calloc(1, sizeof *tty);
    if (!tty)
        return error_set(error, MR_FULL,
                         "out of memory while opening link %s; close other programs", link->spec);
    tty->spec = link->spec;
    tty->fd = -1;
    link->tty = tty;
    if (strncmp(real, PTS_DIRECTORY, strlen(PTS_DIRECTORY)) == 0) {
        status = pts_open(link, real, baud, error);
        tty->fd = link->fd;
    } else {
        status = open_port(tty, real, baud, error);
    }
    link->fd = -1;
    if (status != MR_OK) {
        serial_close(link);
        return status;
    }
    if (tty->port && !link->adapter[0])
        store_adapter_name(link);
    tty->driver_counts_errors = ioctl(tty->fd, TIOCGICOUNT, &tty->last_counters) == 0;
    link->fd = tty->fd;
    link_restart_counting(link, baud);
    return MR_OK;
}

static enum mr_status serial_set_baud(struct link *link, int baud, struct error *error)
{
    struct tty *tty = link->tty;
    if (!tty->port)
        return pts_set_baud(link, baud, error);
    enum mr_status status = configure_port(tty, baud, error);
    if (status == MR_OK)
        sp_flush(tty->port, SP_BUF_INPUT);
    return status;
}

static ssize_t serial_read(struct link *link, uint8_t *bytes, size_t size)
{
    const struct tty *tty = link->tty;
    ssize_t count = tty->port ? (ssize_t)sp_nonblocking_read(tty->port, bytes, size)
                              : read(tty->fd, bytes, size);
    if (count > 0)
        return count;
    /* no error yet: the other end may have closed while data is still waiting */
    if (!tty->port && count < 0 && (errno == EAGAIN || errno == EINTR))
        count = 0;
    /* After a hang-up the port is always readable and returns no bytes. */
    struct pollfd state = {.fd = tty->fd, .events = POLLIN};
    if (count < 0 || (poll(&state, 1, 0) > 0 && state.revents & (POLLHUP | POLLERR | POLLNVAL))) {
        errno = ENODEV;
        return -1;
    }
    errno = EAGAIN;
    return -1;
}

static enum mr_status serial_send(struct link *link, const uint8_t *bytes, size_t length,
                                  struct error *error)
{
    const struct tty *tty = link->tty;
    if (!tty->port)
        return link_write(link, bytes, length, error);
    enum sp_return count = sp_blocking_write(tty->port, bytes, length, WRITE_TIMEOUT_MS);
    if (count < 0)
        return error_set(error, MR_IO, "cannot send (%s): %s; check that the device is plugged in",
                         strerror(sp_last_error_code()), tty->spec);
    if ((size_t)count < length)
        return error_set(error, MR_TIMEOUT, "the serial port accepts no data: %s; check the cable",
                         tty->spec);
    return MR_OK;
}

static void serial_service(struct link *link)
{
    struct tty *tty = link->tty;
    struct serial_icounter_struct now = {0}, *before = &tty->last_counters;
    if (!tty->driver_counts_errors || ioctl(tty->fd, TIOCGICOUNT, &now) != 0)
        return;
    link_count_event(link, LINK_UART_OVERRUN,
                     (unsigned)(now.overrun - before->overrun) +
                         (unsigned)(now.buf_overrun - before->buf_overrun));
    link_count_event(link, LINK_UART_LINE,
                     (unsigned)(now.frame - before->frame) +
                         (unsigned)(now.parity - before->parity) +
                         (unsigned)(now.brk - before->brk));
    *before = now;
}

const struct link_ops link_serial_ops = {
    .supported_kinds = 1u << LINK_SERIAL,
    .is_device = true,
    .open = serial_open,
    .send = serial_send,
    .read = serial_read,
    .service = serial_service,
    .set_baud = serial_set_baud,
    .close = serial_close,
};

/* ---- pty: ---- */

#define OPEN_TRIES_MAX 250
/* pause between two tries. The tries take 5 s in all, as for unix: links, because the board may
 * still be starting */
#define OPEN_PAUSE_MS  20

static enum mr_status pty_open(struct link *link, const char *path, struct error *error)
{
    bool first = link->absence_reason.status ==
                 /* Not an error for a device that was present before: link.c waits for it. */
                 MR_OK;
    for (int i = 0; first && i < OPEN_TRIES_MAX && access(path, F_OK) != 0 && errno == ENOENT; i++)
        poll(NULL, 0, OPEN_PAUSE_MS);
    link_restart_counting(link, TTY_BAUD_DEFAULT);
    return pts_open(link, path, TTY_BAUD_DEFAULT, error);
}

const struct link_ops link_pty_ops = {
    .supported_kinds = 1u << LINK_SERIAL,
    .blocks_sender = true,
    .open = pty_open,
    .send = link_write,
    .set_baud = pts_set_baud,
};
