/* can:IFACE[:board], a CAN interface of the Linux kernel (SocketCAN). See can.rst and
 * timestamping.rst of the kernel.
 *
 * Without `:board` there is no receive filter: what others say on the bus is kept too. With it the
 * kernel passes the messages of the catalogue and error frames alone, on a bus that others fill. */
#include "host/link/can.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "common/canbase.h"
#include "common/wire.h"
#include "host/base/monotonic_clock.h"
#include "host/link/link_ops.h"

/* ---- an adapter's clock ---- */

#define PERIOD_US 5000000u

uint64_t adapter_clock_time(struct adapter_clock *clock, uint64_t adapter_us, uint64_t host_us)
{
    int64_t offset_us = (int64_t)(host_us - adapter_us);
    bool back = clock->known && adapter_us < clock->period_us; /* the adapter began again */
    if (!clock->known || back) {
        clock->offset_us[0] = clock->offset_us[1] = offset_us;
        clock->period_us = adapter_us;
    } else if (adapter_us - clock->period_us >= PERIOD_US) {
        clock->offset_us[1] = clock->offset_us[0];
        clock->offset_us[0] = offset_us;
        clock->period_us = adapter_us;
    } else if (offset_us < clock->offset_us[0]) {
        clock->offset_us[0] = offset_us;
    }
    clock->known = true;
    int64_t least_us = clock->offset_us[0] < clock->offset_us[1] ? clock->offset_us[0]
                                                                 : clock->offset_us[1];
    return adapter_us + (uint64_t)least_us;
}

/* ---- what Linux tells beside a frame ---- */

static uint64_t microseconds(const struct timespec *at)
{
    return (uint64_t)at->tv_sec * 1000000u + (uint64_t)at->tv_nsec / 1000u;
}

void can_control_take(struct msghdr *message, struct can_control *control)
{
    *control = (struct can_control){0};
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c)) {
        size_t length = c->cmsg_len - CMSG_LEN(0);
        if (c->cmsg_level != SOL_SOCKET)
            continue;
        if (c->cmsg_type == SO_TIMESTAMPNS && length >= sizeof(struct timespec)) {
            struct timespec at;
            memcpy(&at, CMSG_DATA(c), sizeof at);
            control->kernel_us = microseconds(&at);
        } else if (c->cmsg_type == SO_TIMESTAMPING && length >= sizeof(struct scm_timestamping)) {
            struct scm_timestamping at; /* by the kernel; no longer used; by the hardware */
            memcpy(&at, CMSG_DATA(c), sizeof at);
            control->kernel_us = microseconds(&at.ts[0]);
            control->hardware_us = microseconds(&at.ts[2]);
        } else if (c->cmsg_type == SO_RXQ_OVFL && length >= sizeof control->lost) {
            memcpy(&control->lost, CMSG_DATA(c), sizeof control->lost);
            control->lost_known = true;
        }
    }
}

size_t can_board_filters(uint16_t base, struct can_filter *filters, size_t most)
{
    size_t messages, count = 0;
    const struct mr_message_info *info = mr_catalogue(&messages);
    for (size_t i = 0; i < messages && count < most; i++)
        filters[count++] = (struct can_filter){.can_id = mr_can_to_bus(info[i].id, base),
                                               .can_mask = CAN_SFF_MASK | CAN_EFF_FLAG |
                                                           CAN_RTR_FLAG};
    return count;
}

/* ---- error frames ---- */

struct name {
    uint8_t value;
    const char *text;
};

static const struct name controller[] = {
    {CAN_ERR_CRTL_RX_OVERFLOW, "receive overflow in the controller"},
    {CAN_ERR_CRTL_TX_OVERFLOW, "transmit overflow in the controller"},
    {CAN_ERR_CRTL_RX_WARNING, "error warning (receiving)"},
    {CAN_ERR_CRTL_TX_WARNING, "error warning (transmitting)"},
    {CAN_ERR_CRTL_RX_PASSIVE, "error passive (receiving)"},
    {CAN_ERR_CRTL_TX_PASSIVE, "error passive (transmitting)"},
    {CAN_ERR_CRTL_ACTIVE, "error active again"},
};

static const struct name protocol[] = {
    {CAN_ERR_PROT_BIT, "bit error"},
    {CAN_ERR_PROT_FORM, "form error"},
    {CAN_ERR_PROT_STUFF, "bit stuffing error"},
    {CAN_ERR_PROT_BIT0, "cannot send dominant bits"},
    {CAN_ERR_PROT_BIT1, "cannot send recessive bits"},
    {CAN_ERR_PROT_OVERLOAD, "bus overload"},
    {CAN_ERR_PROT_ACTIVE, "active error announced"},
    {CAN_ERR_PROT_TX, "while transmitting"},
};

static const struct name location[] = {
    {CAN_ERR_PROT_LOC_SOF, "start of frame"},
    {CAN_ERR_PROT_LOC_ID28_21, "identifier bits 28 to 21"},
    {CAN_ERR_PROT_LOC_ID20_18, "identifier bits 20 to 18"},
    {CAN_ERR_PROT_LOC_SRTR, "substitute remote bit"},
    {CAN_ERR_PROT_LOC_IDE, "identifier extension bit"},
    {CAN_ERR_PROT_LOC_ID17_13, "identifier bits 17 to 13"},
    {CAN_ERR_PROT_LOC_ID12_05, "identifier bits 12 to 5"},
    {CAN_ERR_PROT_LOC_ID04_00, "identifier bits 4 to 0"},
    {CAN_ERR_PROT_LOC_RTR, "remote bit"},
    {CAN_ERR_PROT_LOC_RES1, "reserved bit 1"},
    {CAN_ERR_PROT_LOC_RES0, "reserved bit 0"},
    {CAN_ERR_PROT_LOC_DLC, "length"},
    {CAN_ERR_PROT_LOC_DATA, "data"},
    {CAN_ERR_PROT_LOC_CRC_SEQ, "checksum"},
    {CAN_ERR_PROT_LOC_CRC_DEL, "checksum delimiter"},
    {CAN_ERR_PROT_LOC_ACK, "acknowledge slot"},
    {CAN_ERR_PROT_LOC_ACK_DEL, "acknowledge delimiter"},
    {CAN_ERR_PROT_LOC_EOF, "end of frame"},
    {CAN_ERR_PROT_LOC_INTERM, "intermission"},
};

/* Transceiver faults: CANH in the low half of the byte, CANL in the high half. */
static const struct name wires[] = {
    {CAN_ERR_TRX_CANH_NO_WIRE, "CANH not connected"},
    {CAN_ERR_TRX_CANH_SHORT_TO_BAT, "CANH shorted to battery"},
    {CAN_ERR_TRX_CANH_SHORT_TO_VCC, "CANH shorted to supply"},
    {CAN_ERR_TRX_CANH_SHORT_TO_GND, "CANH shorted to ground"},
    {CAN_ERR_TRX_CANL_NO_WIRE, "CANL not connected"},
    {CAN_ERR_TRX_CANL_SHORT_TO_BAT, "CANL shorted to battery"},
    {CAN_ERR_TRX_CANL_SHORT_TO_VCC, "CANL shorted to supply"},
    {CAN_ERR_TRX_CANL_SHORT_TO_GND, "CANL shorted to ground"},
    {CAN_ERR_TRX_CANL_SHORT_TO_CANH, "CANL shorted to CANH"},
};

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static const char *name_of(const struct name *names, size_t count, unsigned value)
{
    for (size_t i = 0; i < count; i++) {
        if (names[i].value == value)
            return names[i].text;
    }
    return NULL;
}

static uint32_t controller_troubles(uint8_t state)
{
    uint32_t troubles = 0;
    if (state & CAN_ERR_CRTL_RX_OVERFLOW)
        troubles |= 1u << LINK_RX_OVERFLOW;
    if (state & CAN_ERR_CRTL_TX_OVERFLOW)
        troubles |= 1u << LINK_TX_OVERFLOW;
    if (state & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING))
        troubles |= 1u << LINK_ERROR_WARNING;
    if (state & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE))
        troubles |= 1u << LINK_ERROR_PASSIVE;
    if (state & CAN_ERR_CRTL_ACTIVE)
        troubles |= 1u << LINK_ERROR_ACTIVE;
    return troubles;
}

uint32_t can_error_troubles(const struct link_frame *frame)
{
    static const struct {
        uint32_t class_bit;
        enum link_trouble trouble;
    } classes[] = {
        {CAN_ERR_BUSOFF, LINK_BUS_OFF},
        {CAN_ERR_RESTARTED, LINK_RESTARTED},
        {CAN_ERR_ACK, LINK_NO_ACK},
        {CAN_ERR_LOSTARB, LINK_ARBITRATION_LOST},
        {CAN_ERR_PROT, LINK_PROTOCOL_ERROR},
        {CAN_ERR_BUSERROR, LINK_BUS_ERROR},
        {CAN_ERR_TX_TIMEOUT, LINK_TX_TIMEOUT},
        {CAN_ERR_TRX, LINK_TRANSCEIVER},
    };
    uint32_t troubles = 0;
    for (size_t i = 0; i < COUNT(classes); i++) {
        if (frame->id & classes[i].class_bit)
            troubles |= 1u << classes[i].trouble;
    }
    if (frame->id & CAN_ERR_CRTL)
        troubles |= controller_troubles(frame->data[1]);
    return troubles ? troubles : 1u << LINK_OTHER_ERROR;
}

/* Text that grows by parts, "; " between them. */
struct text {
    char *out;
    size_t used;
};

__attribute__((format(printf, 2, 3))) static void add(struct text *text, const char *format, ...)
{
    va_list arguments;
    if (text->used > 0 && text->used + 2 < CAN_ERROR_TEXT_MAX)
        text->used += (size_t)snprintf(text->out + text->used, CAN_ERROR_TEXT_MAX - text->used,
                                       "; ");
    va_start(arguments, format);
    int length = vsnprintf(text->out + text->used, CAN_ERROR_TEXT_MAX - text->used, format,
                           arguments);
    va_end(arguments);
    text->used += length > 0 ? (size_t)length : 0;
    if (text->used >= CAN_ERROR_TEXT_MAX)
        text->used = CAN_ERROR_TEXT_MAX - 1;
}

static void add_bits(struct text *text, const struct name *names, size_t count, uint8_t bits,
                     const char *otherwise)
{
    if (bits == 0)
        add(text, "%s", otherwise);
    for (size_t i = 0; i < count; i++) {
        if (bits & names[i].value)
            add(text, "%s", names[i].text);
    }
}

static void add_transceiver(struct text *text, uint8_t state)
{
    const char *high = name_of(wires, COUNT(wires), state & 0x0fu);
    const char *low = name_of(wires, COUNT(wires), state & 0xf0u);
    if (high)
        add(text, "%s", high);
    if (low)
        add(text, "%s", low);
    if (!high && !low)
        add(text, "transceiver fault");
}

void can_error_text(const struct link_frame *frame, char out[CAN_ERROR_TEXT_MAX])
{
    struct text text = {out, 0};
    const uint8_t *data = frame->data;
    out[0] = '\0';
    if (frame->id & CAN_ERR_BUSOFF)
        add(&text, "bus off");
    if (frame->id & CAN_ERR_RESTARTED)
        add(&text, "restarted after bus off");
    if (frame->id & CAN_ERR_CRTL)
        add_bits(&text, controller, COUNT(controller), data[1], "controller trouble");
    if (frame->id & CAN_ERR_ACK)
        add(&text, "no acknowledgement");
    if (frame->id & CAN_ERR_LOSTARB && data[0])
        add(&text, "arbitration lost in bit %u", data[0]);
    else if (frame->id & CAN_ERR_LOSTARB)
        add(&text, "arbitration lost");
    if (frame->id & CAN_ERR_PROT) {
        add_bits(&text, protocol, COUNT(protocol), data[2], "protocol error");
        const char *where = name_of(location, COUNT(location), data[3]);
        if (where)
            add(&text, "in the %s", where);
    }
    if (frame->id & CAN_ERR_TRX)
        add_transceiver(&text, data[4]);
    if (frame->id & CAN_ERR_BUSERROR)
        add(&text, "bus error");
    if (frame->id & CAN_ERR_TX_TIMEOUT)
        add(&text, "transmit timeout");
    if (text.used == 0)
        add(&text, "error of unknown class %05X",
            (unsigned)(frame->id & CAN_ERR_MASK & ~CAN_ERR_CNT));
    if (frame->id & CAN_ERR_CNT)
        add(&text, "error counters: transmit %u, receive %u", data[6], data[7]);
}

/* ---- the link ---- */

/* A full bus of 1 Mbit/s brings up to 9009 frames/s of 8 bytes, and a frame takes about 700 bytes
 * of queue: this is more than half a second even when the kernel counts each twice. */
#define QUEUE_BYTES  (8 * 1024 * 1024)
#define SEND_WAIT_MS 1000

_Static_assert(LINK_ID_EXTENDED == CAN_EFF_FLAG && LINK_ID_REMOTE == CAN_RTR_FLAG &&
                   LINK_ID_ERROR == CAN_ERR_FLAG,
               "identifiers are SocketCAN's");

static bool is_can(int fd, const char *name, short *flags)
{
    struct ifreq request = {0};
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", name);
    if (ioctl(fd, SIOCGIFHWADDR, &request) != 0 || request.ifr_hwaddr.sa_family != ARPHRD_CAN)
        return false;
    if (ioctl(fd, SIOCGIFFLAGS, &request) == 0)
        *flags = request.ifr_flags;
    return true;
}

/* "there are can0, vcan0" or "there is none". */
static void list_interfaces(int fd, char *out, size_t size)
{
    struct if_nameindex *all = if_nameindex();
    size_t used = 0;
    short flags;
    out[0] = '\0';
    for (struct if_nameindex *i = all; i && i->if_index; i++) {
        if (is_can(fd, i->if_name, &flags) && used < size)
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
    if (!is_can(link->fd, name, &flags)) {
        list_interfaces(link->fd, known, sizeof known);
        return error_set(error, MR_IO, "no such CAN interface: %s; %s (ip link shows them)",
                         link->spec, known);
    }
    if (!(flags & IFF_UP))
        return error_set(
            error, MR_IO,
            "the interface is down: %s; run: ip link set %s up type can bitrate 1000000",
            link->spec, name);
    return MR_OK;
}

/* As large as allowed: beyond net.core.rmem_max only with CAP_NET_ADMIN. */
static void enlarge_queue(int fd)
{
    int bytes = QUEUE_BYTES;
    if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0)
        setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

/* The adapter's stamps and the kernel's; those of the kernel alone where it does not know the
 * former. */
static bool ask_for_stamps(int fd)
{
    int on = 1, stamps = SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE |
                         SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE;
    return setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPING, &stamps, sizeof stamps) == 0 ||
           setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) == 0;
}

static bool ask_for_board(struct link *link)
{
    struct can_filter filters[CAN_RAW_FILTER_MAX];
    size_t count = can_board_filters(link->base, filters, CAN_RAW_FILTER_MAX);
    return setsockopt(link->fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters,
                      (socklen_t)(count * sizeof filters[0])) == 0;
}

static enum mr_status set_up(struct link *link, bool board, struct error *error)
{
    can_err_mask_t errors = CAN_ERR_MASK;
    int on = 1;
    enlarge_queue(link->fd);
    if (setsockopt(link->fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0 ||
        !ask_for_stamps(link->fd) || (board && !ask_for_board(link)) ||
        setsockopt(link->fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) != 0)
        return error_set(error, MR_IO, "cannot set up the socket (%s): %s; use a newer kernel",
                         strerror(errno), link->spec);
    link->queue_lost = 0;
    link->clock = (struct adapter_clock){0};
    return MR_OK;
}

/* IFACE[:board] */
static enum mr_status parse(const struct link *link, const char *text, char name[IFNAMSIZ],
                            bool *board, struct error *error)
{
    size_t length = strcspn(text, ":");
    *board = strcmp(text + length, ":board") == 0;
    if (text[length] && !*board)
        return error_set(error, MR_USAGE,
                         "no such filter: '%s' of %s; write can:IFACE, or can:IFACE:board for the "
                         "board's messages alone",
                         text + length, link->spec);
    if (length == 0 || length >= IFNAMSIZ)
        return error_set(error, MR_USAGE, "interface name of %zu characters: %s; 1 to %d", length,
                         link->spec, IFNAMSIZ - 1);
    memcpy(name, text, length);
    name[length] = '\0';
    return MR_OK;
}

static enum mr_status can_open(struct link *link, const char *text, struct error *error)
{
    char name[IFNAMSIZ];
    bool board;
    if (parse(link, text, name, &board, error) != MR_OK)
        return error->status;
    link->fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (link->fd < 0 && (errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT))
        return error_set(error, MR_IO,
                         "this kernel has no CAN: %s; run modprobe can-raw as root, or use a "
                         "kernel with CONFIG_CAN",
                         link->spec);
    if (link->fd < 0)
        return error_set(error, MR_IO, "no CAN socket (%s): %s; check the limits of this system",
                         strerror(errno), link->spec);
    enum mr_status status = check_interface(link, name, error);
    if (status == MR_OK)
        status = set_up(link, board, error);
    if (status != MR_OK)
        return status;
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name)};
    if (bind(link->fd, (struct sockaddr *)&address, sizeof address) != 0)
        return error_set(error, MR_IO, "cannot use the interface (%s): %s; see ip link",
                         strerror(errno), link->spec);
    return MR_OK;
}

/* With `:board` the kernel passes messages at the new base. */
static void can_moved(struct link *link)
{
    char name[IFNAMSIZ];
    bool board;
    struct error ignored;
    if (parse(link, strchr(link->name, ':') + 1, name, &board, &ignored) == MR_OK && board)
        (void)ask_for_board(link);
}

/* Time of reception by the adapter's clock, when it has one: it stamps the frame on the bus, while
 * the kernel does so when it gets to it. The kernel's time is of the clock that may be set, and is
 * brought to the other one for that. */
static uint64_t time_of(struct link *link, const struct can_control *control)
{
    uint64_t now_us = link_now_us();
    uint64_t kernel_us = control->kernel_us ? control->kernel_us : now_us;
    if (control->hardware_us == 0)
        return kernel_us;
    uint64_t ahead_us = link_ahead_us(link);
    return adapter_clock_time(&link->clock, control->hardware_us, kernel_us - ahead_us) + ahead_us;
}

static enum mr_status can_receive_frame(struct link *link, struct link_frame *frame,
                                        struct error *error)
{
    struct can_frame raw;
    char beside[CAN_CONTROL_BYTES];
    struct can_control control;
    struct iovec part = {.iov_base = &raw, .iov_len = sizeof raw};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = beside, .msg_controllen = sizeof beside};
    ssize_t count = recvmsg(link->fd, &message, 0);
    if (count < 0 && (errno == EAGAIN || errno == EINTR || errno == ENOBUFS))
        return MR_TOO_FEW;
    if (count < 0)
        return error_set(error, MR_IO,
                         "the CAN interface went away (%s): %s; see ip link, and plug it in",
                         strerror(errno), link->spec);
    if ((size_t)count != sizeof raw || raw.can_dlc > sizeof frame->data)
        return error_set(error, MR_MALFORMED,
                         "no CAN frame of 8 bytes or less: %s; is it a CAN FD bus?", link->spec);
    can_control_take(&message, &control);
    if (control.lost_known) {
        link_trouble(link, LINK_QUEUE_LOST, (uint32_t)(control.lost - link->queue_lost));
        link->queue_lost = control.lost;
    }
    frame->host_us = time_of(link, &control);
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
    uint64_t until_us = monotonic_us() + SEND_WAIT_MS * 1000u;
    (void)length;
    memcpy(raw.data, bytes + 4, sizeof raw.data);
    while (write(link->fd, &raw, sizeof raw) != (ssize_t)sizeof raw) {
        if (errno != EAGAIN && errno != EINTR && errno != ENOBUFS)
            return error_set(error, MR_IO, "cannot send (%s): %s; see ip -details link show",
                             strerror(errno), link->spec);
        if (monotonic_us() > until_us)
            return error_set(
                error, MR_TIMEOUT,
                "the bus accepts no frames: %s; is the board on, and the bus terminated?",
                link->spec);
        /* A full transmit queue of the interface (ENOBUFS) is not something poll waits for. */
        poll(&ready, 1, errno == ENOBUFS ? 0 : 10);
        poll(NULL, 0, 1);
    }
    return MR_OK;
}

/* Frames lost when nothing came after them. Asked only when the queue is empty: else they would be
 * told before what was received before them. */
static void can_service(struct link *link)
{
    uint32_t info[SK_MEMINFO_VARS];
    socklen_t length = sizeof info;
    struct pollfd state = {.fd = link->fd, .events = POLLIN};
    if (poll(&state, 1, 0) != 0 ||
        getsockopt(link->fd, SOL_SOCKET, SO_MEMINFO, info, &length) != 0 ||
        length < (SK_MEMINFO_DROPS + 1) * sizeof info[0])
        return;
    link_trouble(link, LINK_QUEUE_LOST, (uint32_t)(info[SK_MEMINFO_DROPS] - link->queue_lost));
    link->queue_lost = info[SK_MEMINFO_DROPS];
}

const struct link_ops link_can_ops = {
    .kinds = 1u << LINK_CAN,
    .comes_back = true,
    .open = can_open,
    .receive_frame = can_receive_frame,
    .send = can_send,
    .service = can_service,
    .moved = can_moved,
};
