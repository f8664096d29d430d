/* A full CAN bus and a full serial line, for as long as it is told, on two sockets that matrig log
 * opens as unix:PATH. A board made by hand (tests/host/stream.h) plays a landing every half minute;
 * what it leaves of 1 Mbit/s is filled with frames of somebody else on the bus, what it leaves of 2
 * Mbaud with parts of a black box. Frames take the bit time of their own bits, stuff bits included.
 *
 *     sender CAN_SOCKET SERIAL_SOCKET SECONDS [QUEUE [MARKS]]
 *
 * QUEUE: bytes that wait for the reader on each link, as in an adapter, at most; what comes while
 * it is full is lost and counted. 0: none is lost, the sender waits (and says how late it became).
 * MARKS: a file of lines "UNIX_US FILLS", one whenever the reader has taken all that was sent:
 * FILLS frames of 0x555 until then. Prints what was sent and lost, as JSON. */
#include <errno.h>
#include <linux/sockios.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "hil/periph/canbits.h"
#include "tests/host/stream.h"

#define FILL_ID             0x555u
#define BITS_PER_MS         1000.0 /* 1 Mbit/s */
#define SERIAL_BYTES_PER_MS 200    /* 2 Mbaud, 8N1 */
#define LANDING_EVERY_MS    30000u
#define TICK_MS             4u /* between two looks at the clock */
#define CONNECT_MS          10000
#define STALL_S             60
#define OUT_BYTES           (1u << 20)

/* One link: what waits to be written, and what is counted. */
struct out {
    int fd;
    uint8_t bytes[OUT_BYTES];
    size_t start, end;
    uint64_t sent, lost; /* frames, those of others and parts not counted */
    uint64_t fills, fills_lost;
};

static struct sender {
    struct stream stream;
    struct out can, serial;
    size_t queue; /* 0: nothing is lost */
    FILE *marks;
    double bits;           /* of the bus, used */
    uint64_t serial_bytes; /* used */
    uint32_t paced_ms;     /* board time up to which the links are filled */
    uint64_t begun_us;     /* monotonic */
    uint64_t latest_us;    /* how late the sender has been at most: the reader did not take it */
    uint32_t blocks, random;
} sender;

__attribute__((format(printf, 1, 2), noreturn)) static void give_up(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("sender: ", stderr);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, " (%s)\n", strerror(errno));
    va_end(arguments);
    exit(3);
}

static uint64_t clock_us(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (uint64_t)t.tv_sec * 1000000u + (uint64_t)t.tv_nsec / 1000u;
}

static int accept_at(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path)
        give_up("path too long: %s", path);
    strcpy(address.sun_path, path);
    int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    unlink(path);
    if (bind(listener, (struct sockaddr *)&address, sizeof address) != 0 ||
        listen(listener, 1) != 0)
        give_up("cannot listen at %s", path);
    return listener;
}

static int accepted(int listener)
{
    struct pollfd ready = {.fd = listener, .events = POLLIN};
    if (poll(&ready, 1, CONNECT_MS) <= 0)
        give_up("nobody opens the links");
    int fd = accept4(listener, NULL, NULL, SOCK_NONBLOCK);
    close(listener);
    return fd;
}

/* Writes what the reader takes. False: something still waits. */
static bool drain(struct out *out)
{
    while (out->start < out->end) {
        ssize_t count = write(out->fd, out->bytes + out->start, out->end - out->start);
        if (count < 0 && (errno == EPIPE || errno == ECONNRESET))
            exit(0); /* the reader was killed */
        if (count < 0 && errno != EAGAIN && errno != EINTR)
            give_up("cannot write");
        if (count <= 0)
            return false;
        out->start += (size_t)count;
    }
    out->start = out->end = 0;
    return true;
}

/* False: the queue is full, and it is lost. */
static bool put(struct out *out, const void *bytes, size_t size)
{
    size_t waits = out->end - out->start;
    if (sender.queue && waits + size > sender.queue && !drain(out)) {
        waits = out->end - out->start;
        if (waits + size > sender.queue)
            return false;
    }
    if (out->end + size > OUT_BYTES) {
        memmove(out->bytes, out->bytes + out->start, waits);
        out->start = 0;
        out->end = waits;
    }
    for (uint64_t until_us = clock_us(CLOCK_MONOTONIC) + STALL_S * 1000000u;
         out->end + size > OUT_BYTES; waits = out->end - out->start) {
        struct pollfd ready = {.fd = out->fd, .events = POLLOUT};
        if (clock_us(CLOCK_MONOTONIC) > until_us)
            give_up("nobody reads");
        poll(&ready, 1, 100);
        drain(out);
    }
    memcpy(out->bytes + out->end, bytes, size);
    out->end += size;
    return true;
}

static bool put_can(const struct link_frame *frame)
{
    struct hil_can_frame bits = {.id = frame->id, .length = frame->length};
    uint8_t raw[16] = {(uint8_t)frame->id, (uint8_t)(frame->id >> 8), 0, 0, frame->length};
    memcpy(bits.data, frame->data, sizeof bits.data);
    memcpy(raw + 8, frame->data, 8);
    sender.bits += hil_can_frame_bits(&bits).length + HIL_CAN_INTERMISSION_BITS;
    return put(&sender.can, raw, sizeof raw);
}

/* Somebody else's frame: a number, and bytes of all kinds. */
static void fill_bus(void)
{
    struct link_frame frame = {.id = FILL_ID, .length = 8};
    uint32_t number = (uint32_t)sender.can.fills;
    sender.random = sender.random * 1664525u + 1013904223u;
    memcpy(frame.data, &number, 4);
    memcpy(frame.data + 4, &sender.random, 4);
    sender.can.fills++;
    sender.can.fills_lost += !put_can(&frame);
}

static void fill_line(void)
{
    uint8_t payload[MR_FRAME_PAYLOAD_BYTES_MAX] = {0}, frame[MR_FRAME_BYTES_MAX];
    uint32_t number = (uint32_t)sender.serial.fills;
    memcpy(payload, &number, 4);
    memset(payload + 4, 0xa5, sizeof payload - 4);
    size_t size = mr_frame_encode(sender.stream.seq++, MR_ID_BOX_PART, payload, sizeof payload,
                                  frame);
    sender.serial.fills++;
    sender.serial_bytes += size;
    sender.serial.fills_lost += !put(&sender.serial, frame, size);
}

static void mark(void)
{
    int unread = 1;
    if (sender.marks && sender.can.end == 0 && ioctl(sender.can.fd, SIOCOUTQ, &unread) == 0 &&
        unread == 0) {
        fprintf(sender.marks, "%llu %llu\n", (unsigned long long)clock_us(CLOCK_REALTIME),
                (unsigned long long)sender.can.fills);
        fflush(sender.marks);
    }
}

/* The board's time has come to a new millisecond: the one before is filled, and the clock waited
 * for. */
static void pace(void)
{
    while (sender.paced_ms < sender.stream.block) {
        sender.paced_ms++;
        while (sender.bits < BITS_PER_MS * sender.paced_ms)
            fill_bus();
        while (sender.serial_bytes + MR_FRAME_BYTES_MAX <
               (uint64_t)SERIAL_BYTES_PER_MS * sender.paced_ms)
            fill_line();
        if (sender.paced_ms % TICK_MS)
            continue;
        drain(&sender.can);
        drain(&sender.serial);
        uint64_t due_us = sender.begun_us + 1000ull * sender.paced_ms,
                 now_us = clock_us(CLOCK_MONOTONIC);
        if (now_us < due_us) {
            struct timespec wait = {0, (long)(due_us - now_us) * 1000};
            nanosleep(&wait, NULL);
        } else if (now_us - due_us > sender.latest_us) {
            sender.latest_us = now_us - due_us;
        }
        mark();
    }
}

static void take_can(struct stream *stream, const struct link_frame *frame)
{
    (void)stream;
    pace();
    sender.can.sent++;
    sender.can.lost += !put_can(frame);
}

static void take_serial(struct stream *stream, const uint8_t *frame, size_t size)
{
    (void)stream; /* has its number already: what fills the line comes before the next CAN frame */
    bool there = put(&sender.serial, frame, size);
    sender.serial.sent++;
    sender.serial_bytes += size;
    sender.serial.lost += !there;
}

/* Every frame that is still queued goes out, and the reader has time for it. */
static void finish(struct out *out)
{
    for (uint64_t until_us = clock_us(CLOCK_MONOTONIC) + STALL_S * 1000000u; !drain(out);) {
        struct pollfd ready = {.fd = out->fd, .events = POLLOUT};
        if (clock_us(CLOCK_MONOTONIC) > until_us)
            give_up("nobody reads");
        poll(&ready, 1, 100);
    }
    close(out->fd);
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        fputs("usage: sender CAN_SOCKET SERIAL_SOCKET SECONDS [QUEUE [MARKS]]\n", stderr);
        return 2;
    }
    uint32_t end_ms = (uint32_t)(strtod(argv[3], NULL) * 1000.0), landings = 0;
    signal(SIGPIPE, SIG_IGN);
    sender.queue = argc > 4 ? strtoul(argv[4], NULL, 10) : 0;
    if (argc > 5 && !(sender.marks = fopen(argv[5], "w")))
        give_up("cannot write %s", argv[5]);
    int can = accept_at(argv[1]), serial = accept_at(argv[2]);
    sender.can.fd = accepted(can);
    sender.serial.fd = accepted(serial);
    sender.begun_us = clock_us(CLOCK_MONOTONIC);
    sender.stream = (struct stream){.take_can = take_can, .take_serial = take_serial};
    stream_hello(&sender.stream, MR_LAYOUT);
    stream_configuration(&sender.stream);
    stream_idle(&sender.stream, 1000);
    while (sender.stream.block < end_ms) {
        struct stream_truth truth = {.v0_ft_s = 35.0, .a_ft_s2 = 8.0, .peak_in = 0.4, .warn = true};
        stream_landing(&sender.stream, &truth, ++landings);
        uint32_t next_ms = landings * LANDING_EVERY_MS < end_ms ? landings * LANDING_EVERY_MS
                                                                : end_ms;
        if (next_ms > sender.stream.block)
            stream_idle(&sender.stream, next_ms - sender.stream.block);
        else
            stream_idle(&sender.stream, 500);
    }
    stream_idle(&sender.stream, 200); /* the last counts of what was sent */
    finish(&sender.can);
    finish(&sender.serial);
    double s = (double)sender.paced_ms / 1000.0;
    printf("{\"seconds\":%.3f,\"landings\":%u,\"can_sent\":%llu,\"can_lost\":%llu,\"fills\":%llu,"
           "\"fills_lost\":%llu,"
           "\"serial_sent\":%llu,\"serial_lost\":%llu,\"can_per_s\":%.0f,\"bus_percent\":%.1f,"
           "\"serial_bytes_per_s\":%.0f,"
           "\"latest_ms\":%.1f}\n",
           s, landings, (unsigned long long)sender.can.sent, (unsigned long long)sender.can.lost,
           (unsigned long long)sender.can.fills, (unsigned long long)sender.can.fills_lost,
           (unsigned long long)(sender.serial.sent + sender.serial.fills),
           (unsigned long long)(sender.serial.lost + sender.serial.fills_lost),
           (double)(sender.can.sent + sender.can.fills) / s, sender.bits / 1e4 / s,
           (double)sender.serial_bytes / s, (double)sender.latest_us / 1000.0);
    return 0;
}
