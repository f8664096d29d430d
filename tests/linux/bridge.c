/* Feeds a CAN interface inside the guest, paced to the bit time at 1 Mbit/s: no frame is sent
 * before those ahead of it have had their time on the bus, stuff bits included. The pace is kept by
 * a 2 ms timer, as the guest is slow.
 *
 *     bridge board PORT IFACE SHARE       frames of the emulated board, which is outside, come
 *                                         through PORT (16 bytes each, as struct can_frame) and go
 *                                         to the bus, of which they take SHARE percent; what is on
 *                                         the bus goes back
 *     bridge load IFACE ID OTHER S SHARE  sends numbered frames ID for S seconds, at SHARE percent
 *                                         of the bus, and checks the numbers of the frames OTHER
 *                                         that come
 *
 * Prints one line of figures. Exit: 0, 1 something was lost, 2 usage, 3 cannot go on. Every wait is
 * bounded. */
#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "hil/periph/canbits.h"

#define BIT_NS      1000u
#define CONNECT_S   60
#define STALL_S     20
#define QUIET_S     2 /* nothing for so long after the end: nothing more comes */
#define TICK_NS     2000000u
#define CATCH_UP_NS 10000000u   /* a late sender sends at most so much at once */
#define START_NS    1000000000u /* until both ends of a load listen */
#define QUEUE_BYTES (4 * 1024 * 1024)
#define NS          1000000000ull

__attribute__((format(printf, 1, 2), noreturn)) static void give_up(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("bridge: ", stderr);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, " (%s)\n", strerror(errno));
    va_end(arguments);
    exit(3);
}

static uint64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * NS + (uint64_t)t.tv_nsec;
}

static int open_can(const char *name)
{
    int size = QUEUE_BYTES;
    int fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK, CAN_RAW);
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name)};
    if (fd < 0 || address.can_ifindex == 0 ||
        bind(fd, (struct sockaddr *)&address, sizeof address) != 0)
        give_up("cannot open %s", name);
    setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &size, sizeof size);
    return fd;
}

/* Time the frame takes on the bus, intermission included. */
static uint64_t frame_ns(const struct can_frame *raw)
{
    struct hil_can_frame frame = {.id = raw->can_id, .length = raw->can_dlc};
    memcpy(frame.data, raw->data, sizeof frame.data);
    return (hil_can_frame_bits(&frame).length + HIL_CAN_INTERMISSION_BITS) * (uint64_t)BIT_NS;
}

/* False: the interface has no room now. */
static bool send_frame(int can, const struct can_frame *frame)
{
    if (write(can, frame, sizeof *frame) == (ssize_t)sizeof *frame)
        return true;
    if (errno != ENOBUFS && errno != EAGAIN && errno != EINTR)
        give_up("cannot send");
    return false;
}

/* When the bus is free for the next frame. */
struct pace {
    uint64_t due_ns;
    uint64_t share_percent;
    bool full; /* the interface had no room */
};

/* Sends a frame if its time has come. */
static bool send_paced(struct pace *pace, int can, const struct can_frame *frame, uint64_t now)
{
    pace->full = false;
    if (pace->due_ns + CATCH_UP_NS < now)
        pace->due_ns = now - CATCH_UP_NS;
    if (now < pace->due_ns)
        return false;
    pace->full = !send_frame(can, frame);
    if (!pace->full)
        pace->due_ns += frame_ns(frame) * 100 / pace->share_percent;
    return !pace->full;
}

/* When to look again. */
static uint64_t next_look_ns(const struct pace *pace, uint64_t now)
{
    return pace->full                   ? now + 100 * BIT_NS
         : now + TICK_NS > pace->due_ns ? now + TICK_NS
                                        : pace->due_ns;
}

static void wait_until(struct pollfd *polled, nfds_t count, uint64_t at_ns)
{
    uint64_t now = now_ns();
    uint64_t wait_ns = at_ns > now ? at_ns - now : 0;
    struct timespec wait = {.tv_sec = (time_t)(wait_ns / NS), .tv_nsec = (long)(wait_ns % NS)};
    if (ppoll(polled, count, &wait, NULL) < 0 && errno != EINTR)
        give_up("cannot wait");
}

/* ---- board ---- */

struct relay {
    int port;
    int can;
    struct can_frame frame[4096]; /* from the board, waiting for the bus */
    size_t first;
    size_t bytes; /* after frame[first] */
    uint64_t to_bus, to_board;
    bool ended; /* the board has gone */
};

static int open_port(const char *path)
{
    int port = open(path, O_RDWR | O_NONBLOCK);
    if (port < 0)
        give_up("cannot open %s", path);
    /* A virtio port hangs up as long as nobody is at its other end. */
    struct pollfd state = {.fd = port, .events = POLLIN};
    for (int i = 0; i < CONNECT_S * 50; i++) {
        state.revents = 0;
        poll(&state, 1, 0);
        if (!(state.revents & POLLHUP))
            return port;
        poll(NULL, 0, 20);
    }
    errno = ETIMEDOUT;
    give_up("no board at %s", path);
}

static void take_from_board(struct relay *r)
{
    memmove(r->frame, &r->frame[r->first], r->bytes);
    r->first = 0;
    if (r->ended || r->bytes == sizeof r->frame)
        return;
    ssize_t count = read(r->port, (char *)r->frame + r->bytes, sizeof r->frame - r->bytes);
    if (count > 0)
        r->bytes += (size_t)count;
    else if (count == 0)
        r->ended = true;
    else if (errno != EAGAIN && errno != EINTR)
        give_up("cannot read the board's frames");
}

static void take_from_bus(struct relay *r)
{
    struct can_frame frame;
    while (read(r->can, &frame, sizeof frame) == (ssize_t)sizeof frame) {
        r->to_board++;
        if (!r->ended && write(r->port, &frame, sizeof frame) != (ssize_t)sizeof frame)
            r->ended = true;
    }
}

static int relay_board(const char *port, const char *interface, uint64_t share_percent)
{
    static struct relay r;
    uint64_t moved_ns = now_ns();
    struct pace pace = {.due_ns = moved_ns, .share_percent = share_percent};
    r.can = open_can(interface);
    r.port = open_port(port);
    while (!r.ended || r.bytes >= sizeof r.frame[0]) {
        if (r.bytes < sizeof r.frame[0])
            take_from_board(&r);
        take_from_bus(&r);
        uint64_t now = now_ns();
        if (r.bytes >= sizeof r.frame[0] && send_paced(&pace, r.can, &r.frame[r.first], now)) {
            moved_ns = now;
            r.first++;
            r.bytes -= sizeof r.frame[0];
            r.to_bus++;
            continue;
        }
        if (now - moved_ns > STALL_S * NS)
            give_up("nothing moves on %s", interface);
        struct pollfd polled[2] = {{.fd = r.can, .events = POLLIN},
                                   {.fd = r.port, .events = POLLIN}};
        bool waiting = r.bytes >= sizeof r.frame[0];
        wait_until(polled, waiting ? 1 : 2, waiting ? next_look_ns(&pace, now) : now + NS / 10);
    }
    printf("%s: %llu frames of the board put on the bus, %llu from the bus to the board\n",
           interface, (unsigned long long)r.to_bus, (unsigned long long)r.to_board);
    return 0;
}

/* ---- load ---- */

struct load {
    int can;
    uint32_t other;
    uint64_t sent, bits_ns;
    uint32_t expected; /* next number */
    uint64_t received, lost, misordered;
    uint64_t heard_ns;
};

static void check_numbers(struct load *load)
{
    struct can_frame frame;
    while (read(load->can, &frame, sizeof frame) == (ssize_t)sizeof frame) {
        uint32_t number;
        if (frame.can_id != load->other)
            continue;
        memcpy(&number, frame.data, sizeof number);
        load->received++;
        load->heard_ns = now_ns();
        if (number < load->expected)
            load->misordered++;
        else
            load->lost += number - load->expected;
        load->expected = number + 1;
    }
}

static struct can_frame numbered(uint32_t id, uint64_t number)
{
    struct can_frame frame = {.can_id = id, .can_dlc = 8};
    uint32_t low = (uint32_t)number;
    uint32_t mixed = low * 2654435761u; /* so that lengths differ, as stuff bits make them */
    memcpy(frame.data, &low, sizeof low);
    memcpy(frame.data + 4, &mixed, sizeof mixed);
    return frame;
}

static int run_load(const char *interface, uint32_t id, uint32_t other, uint64_t seconds,
                    uint64_t share_percent)
{
    struct load load = {.can = open_can(interface), .other = other};
    struct pace pace = {.due_ns = now_ns() + START_NS, .share_percent = share_percent};
    uint64_t end_ns = pace.due_ns + seconds * NS;
    for (uint64_t now = now_ns(); now < end_ns; now = now_ns()) {
        struct can_frame frame = numbered(id, load.sent);
        if (send_paced(&pace, load.can, &frame, now)) {
            load.bits_ns += frame_ns(&frame);
            load.sent++;
            continue;
        }
        check_numbers(&load);
        wait_until(NULL, 0, next_look_ns(&pace, now));
    }
    load.heard_ns = now_ns();
    while (now_ns() - load.heard_ns < QUIET_S * NS) {
        struct pollfd polled = {.fd = load.can, .events = POLLIN};
        poll(&polled, 1, 100);
        check_numbers(&load);
    }
    printf("%s: sent %llu frames in %llu s (%.1f %% of 1 Mbit/s), received %llu, lost %llu, out of "
           "order %llu\n",
           interface, (unsigned long long)load.sent, (unsigned long long)seconds,
           100.0 * (double)load.bits_ns / (double)(seconds * NS), (unsigned long long)load.received,
           (unsigned long long)load.lost, (unsigned long long)load.misordered);
    return load.lost || load.misordered ? 1 : 0;
}

int main(int argc, char **argv)
{
    prctl(PR_SET_TIMERSLACK, 1000);
    if (argc == 5 && strcmp(argv[1], "board") == 0)
        return relay_board(argv[2], argv[3], strtoul(argv[4], NULL, 10));
    if (argc == 7 && strcmp(argv[1], "load") == 0)
        return run_load(argv[2], (uint32_t)strtoul(argv[3], NULL, 16),
                        (uint32_t)strtoul(argv[4], NULL, 16), strtoul(argv[5], NULL, 10),
                        strtoul(argv[6], NULL, 10));
    fputs("usage: bridge board PORT IFACE SHARE | bridge load IFACE ID OTHER SECONDS SHARE\n",
          stderr);
    return 2;
}
