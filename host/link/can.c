/* can:IFACE, a CAN interface of the Linux kernel (SocketCAN; can.rst of the kernel). All frames on
 * the bus are received and recorded, because no filter is set. */
#include <errno.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "common/wire.h"
#include "host/base/monotonic_clock.h"
#include "host/link/link.h"
#include "host/link/link_ops.h"

/* ---- Linux's extra data with a received frame ---- */

#define ANCILLARY_DATA_BYTES 128u /* buffer for all control messages of one frame */

struct ancillary_data {
    uint64_t kernel_us; /* Unix time of reception by the kernel; 0: unknown */
    bool lost_known;
    uint32_t lost_count; /* frames lost in the socket's queue so far; a 32-bit counter that wraps */
};

static void read_ancillary_data(struct msghdr *message, struct ancillary_data *control)
{
    *control = (struct ancillary_data){0};
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c)) {
        size_t length = c->cmsg_len - CMSG_LEN(0);
        if (c->cmsg_level != SOL_SOCKET)
            continue;
        if (c->cmsg_type == SO_TIMESTAMPNS && length >= sizeof(struct timespec)) {
            struct timespec at;
            memcpy(&at, CMSG_DATA(c), sizeof at);
            control->kernel_us = (uint64_t)at.tv_sec * 1000000u + (uint64_t)at.tv_nsec / 1000u;
        } else if (c->cmsg_type == SO_RXQ_OVFL && length >= sizeof control->lost_count) {
            memcpy(&control->lost_count, CMSG_DATA(c), sizeof control->lost_count);
            control->lost_known = true;
        }
    }
}

/* ---- the link ---- */

/* A full bus of 1 Mbit/s carries up to 9009 frames/s of 8 bytes, and each frame takes about 700
 * bytes in the queue. The queue therefore holds more than half a second of frames, even if the
 * kernel counts each frame twice. */
#define SOCKET_QUEUE_BYTES (8 * 1024 * 1024)
#define SEND_TIMEOUT_MS    1000

_Static_assert(LINK_ID_EXTENDED == CAN_EFF_FLAG && LINK_ID_REMOTE == CAN_RTR_FLAG &&
                   LINK_ID_ERROR == CAN_ERR_FLAG,
               "identifiers are SocketCAN's");

static bool is_can_interface(int fd, const char *name, short *flags)
{
    struct ifreq request = {0};
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", name);
    if (ioctl(fd, SIOCGIFHWADDR, &request) != 0 || request.ifr_hwaddr.sa_family != ARPHRD_CAN)
        return false;
    if (ioctl(fd, SIOCGIFFLAGS, &request) == 0)
        *flags = request.ifr_flags;
    return true;
}

/* Writes "there are can0, vcan0" or "there is none". */
static void list_interfaces(int fd, char *out, size_t size)
{
    struct if_nameindex *all = if_nameindex();
    size_t used = 0;
    short flags;
    out[0] = '\0';
    for (struct if_nameindex *i = all; i && i->if_index; i++) {
        if (is_can_interface(fd, i->if_name, &flags) && used < size)
            used += (size_t)snprintf(out + used, size - used, "%s%s", used ? ", " : "there are ",
                                     i->if_name);
    }
    if (used == 0)
        snprintf(out, size, "there is none");
    if (all)
        if_freenameindex(all);
}

static enum mr_status check_interface(struct link *link, const char *name, struct error *error)
{
    short flags = 0;
    char known[200];
    if (!is_can_interface(link->fd, name, &flags)) {
        list_interfaces(link->fd, known, sizeof known);
        return error_set(error, MR_IO, "no such CAN interface: %s; %s (ip link lists them)",
                         link->spec, known);
    }
    if (!(flags & IFF_UP))
        return error_set(
            error, MR_IO,
            "the interface is down: %s; run: ip link set %s up type can bitrate 1000000",
            link->spec, name);
    return MR_OK;
}

/* Makes the queue as large as allowed; more than net.core.rmem_max requires CAP_NET_ADMIN. */
static void enlarge_receive_queue(int fd)
{
    int bytes = SOCKET_QUEUE_BYTES;
    if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0)
        setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

static enum mr_status configure_socket(struct link *link, struct error *error)
{
    can_err_mask_t errors = CAN_ERR_MASK;
    int on = 1;
    enlarge_receive_queue(link->fd);
    if (setsockopt(link->fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0 ||
        setsockopt(link->fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0 ||
        setsockopt(link->fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) != 0)
        return error_set(error, MR_IO, "cannot set up the socket (%s): %s; use a newer kernel",
                         strerror(errno), link->spec);
    link->kernel_lost_count = 0;
    return MR_OK;
}

static enum mr_status can_open(struct link *link, const char *name, struct error *error)
{
    size_t length = strlen(name);
    if (length >= IFNAMSIZ)
        return error_set(error, MR_USAGE,
                         "interface name of %zu characters: %s; give 1 to %d characters", length,
                         link->spec, IFNAMSIZ - 1);
    if (strpbrk(name, ":,/@ "))
        return error_set(
            error, MR_USAGE,
            "not a CAN interface: %s; write can:IFACE[,base=N] and set the bit rate with ip link",
            link->spec);
    link->fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (link->fd < 0 && (errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT))
        return error_set(error, MR_IO,
                         "this kernel has no CAN: %s; run modprobe can-raw as root, or use a "
                         "kernel with CONFIG_CAN",
                         link->spec);
    if (link->fd < 0)
        return error_set(error, MR_IO,
                         "cannot create a CAN socket (%s): %s; check the limits of this system",
                         strerror(errno), link->spec);
    enum mr_status status = check_interface(link, name, error) ?: configure_socket(link, error);
    if (status != MR_OK)
        return status;
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name)};
    if (bind(link->fd, (struct sockaddr *)&address, sizeof address) != 0)
        return error_set(error, MR_IO, "cannot use the interface (%s): %s; see ip link",
                         strerror(errno), link->spec);
    return MR_OK;
}

static enum mr_status can_receive_frame(struct link *link, struct link_frame *frame,
                                        struct error *error)
{
    struct can_frame raw;
    char beside[ANCILLARY_DATA_BYTES];
    struct ancillary_data control;
    struct iovec part = {.iov_base = &raw, .iov_len = sizeof raw};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = beside, .msg_controllen = sizeof beside};
    ssize_t count = recvmsg(link->fd, &message, 0);
    if (count < 0 && (errno == EAGAIN || errno == EINTR || errno == ENOBUFS))
        return MR_TOO_FEW;
    if (count < 0)
        return error_set(
            error, MR_IO,
            "the CAN interface was disconnected (%s): %s; check the adapter, and see ip link",
            strerror(errno), link->spec);
    if ((size_t)count != sizeof raw || raw.can_dlc > sizeof frame->data)
        return error_set(error, MR_MALFORMED,
                         "CAN frame of more than 8 bytes: %s; use a bus without CAN FD",
                         link->spec);
    read_ancillary_data(&message, &control);
    if (control.lost_known) {
        link_count_event(link, LINK_QUEUE_LOST,
                         (uint32_t)(control.lost_count - link->kernel_lost_count));
        link->kernel_lost_count = control.lost_count;
    }
    frame->host_us = control.kernel_us ? control.kernel_us : link_now_us();
    frame->id = raw.can_id;
    frame->length = raw.can_dlc;
    memset(frame->data, 0, sizeof frame->data);
    memcpy(frame->data, raw.data, raw.can_dlc);
    return MR_OK;
}

static enum mr_status can_send(struct link *link, const uint8_t *bytes, size_t length,
                               struct error *error)
{
    struct can_frame raw = {.can_id = mr_get_u32(&bytes), .can_dlc = *bytes};
    struct pollfd ready = {.fd = link->fd, .events = POLLOUT};
    uint64_t until_us = monotonic_us() + SEND_TIMEOUT_MS * 1000u;
    (void)length;
    memcpy(raw.data, bytes + 4, sizeof raw.data);
    while (write(link->fd, &raw, sizeof raw) != (ssize_t)sizeof raw) {
        if (errno != EAGAIN && errno != EINTR && errno != ENOBUFS)
            return error_set(error, MR_IO, "cannot send (%s): %s; see ip -details link show",
                             strerror(errno), link->spec);
        if (monotonic_us() > until_us)
            return error_set(error, MR_TIMEOUT,
                             "the bus accepts no frames: %s; check that the board is on and that "
                             "the bus is terminated",
                             link->spec);
        /* do not wait for room in the socket: with ENOBUFS, the queue of the interface is full */
        poll(&ready, 1, errno == ENOBUFS ? 0 : 10);
        poll(NULL, 0, 1);
    }
    return MR_OK;
}

/* Counts lost frames that no later frame has reported. Only if the queue is empty: otherwise the
 * loss would be counted before frames that were received earlier. */
static void can_service(struct link *link)
{
    uint32_t info[SK_MEMINFO_VARS];
    socklen_t length = sizeof info;
    struct pollfd state = {.fd = link->fd, .events = POLLIN};
    if (poll(&state, 1, 0) != 0 ||
        getsockopt(link->fd, SOL_SOCKET, SO_MEMINFO, info, &length) != 0 ||
        length < (SK_MEMINFO_DROPS + 1) * sizeof info[0])
        return;
    link_count_event(link, LINK_QUEUE_LOST,
                     (uint32_t)(info[SK_MEMINFO_DROPS] - link->kernel_lost_count));
    link->kernel_lost_count = info[SK_MEMINFO_DROPS];
}

const struct link_ops link_can_ops = {
    .supported_kinds = 1u << LINK_CAN,
    .is_device = true,
    .open = can_open,
    .receive_frame = can_receive_frame,
    .send = can_send,
    .service = can_service,
};
