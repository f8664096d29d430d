/* The queue of a link and its reader: order, what is taken back, what a full queue loses and says
 * of it, and who waits. */
#include "tests/cmocka_all.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "host/link/queue.h"

#define WAIT_MS 10000

static struct link_frame frame_of(uint32_t number)
{
    struct link_frame frame = {.host_us = 1000000u + number, .id = 0x100 + number % 7, .length = 4};
    memcpy(frame.data, &number, 4);
    return frame;
}

static uint32_t number_of(const struct link_item *item)
{
    uint32_t number;
    assert_int_equal(item->kind, LINK_ITEM_FRAME);
    memcpy(&number, item->frame.data, 4);
    assert_int_equal(item->frame.host_us, 1000000u + number);
    assert_int_equal(item->frame.id, 0x100 + number % 7);
    assert_int_equal(item->frame.length, 4);
    return number;
}

static struct link_queue *queue_of(size_t capacity, int news)
{
    struct link_queue *queue;
    struct error error = {0};
    assert_int_equal(link_queue_open(capacity, news, &queue, &error), MR_OK);
    return queue;
}

/* Over many pieces of memory, with items of all sizes between. */
TEST(order_is_kept)
{
    enum { COUNT = 60000 };
    struct link_queue *queue = queue_of(64u << 20, -1);
    struct link_item item;
    uint8_t bytes[LINK_QUEUE_READ_MAX];
    for (uint32_t i = 0; i < COUNT; i++) {
        struct link_frame frame = frame_of(i);
        assert_true(link_queue_put_frame(queue, &frame));
        size_t length = i % 1000 == 7 ? 1 + i % sizeof bytes : 0;
        memset(bytes, (int)(i & 0xff), length);
        if (length)
            assert_true(link_queue_put_bytes(queue, bytes, length, i));
    }
    for (uint32_t i = 0; i < COUNT; i++) {
        assert_true(link_queue_read(queue, &item));
        assert_int_equal(number_of(&item), i);
        size_t length = i % 1000 == 7 ? 1 + i % sizeof bytes : 0;
        if (length) {
            assert_true(link_queue_read(queue, &item));
            assert_int_equal(item.kind, LINK_ITEM_BYTES);
            assert_int_equal(item.length, length);
            assert_int_equal(item.host_us, i);
            assert_int_equal(item.bytes[0], i & 0xff);
            assert_int_equal(item.bytes[length - 1], i & 0xff);
        }
    }
    assert_false(link_queue_read(queue, &item));
    assert_int_equal(link_queue_depth(queue).can_frames, COUNT); /* taken is not written */
    link_queue_release(queue);
    struct link_queue_depth depth = link_queue_depth(queue);
    assert_int_equal(depth.bytes, 0);
    assert_int_equal(depth.can_frames + depth.serial_bytes, 0);
    link_queue_close(queue);
}

/* A transaction that failed: the same once more, marked as such, and what came meanwhile after
 * it. */
TEST(taken_back)
{
    struct link_queue *queue = queue_of(1u << 20, -1);
    struct link_item item;
    for (uint32_t i = 0; i < 10; i++) {
        struct link_frame frame = frame_of(i);
        link_queue_put_frame(queue, &frame);
    }
    for (uint32_t i = 0; i < 4; i++)
        assert_true(link_queue_read(queue, &item));
    link_queue_release(queue); /* 0 to 3 are written */
    for (uint32_t i = 4; i < 7; i++) {
        assert_true(link_queue_read(queue, &item));
        assert_false(item.is_repeated);
    }
    link_queue_rewind(queue);
    link_queue_put_clock_jump(queue, -5);
    for (uint32_t i = 4; i < 10; i++) {
        assert_true(link_queue_read(queue, &item));
        assert_int_equal(number_of(&item), i);
        assert_int_equal(item.is_repeated, i < 7);
    }
    assert_true(link_queue_read(queue, &item));
    assert_int_equal(item.kind, LINK_ITEM_CLOCK_JUMP);
    assert_int_equal(item.jump_us, -5);
    link_queue_close(queue);
}

/* What was released comes again when the campaign is lost: the newest half of the capacity at
 * least, to the last, nothing twice. */
TEST(what_was_written_is_kept_for_a_while)
{
    enum { COUNT = 300000, ITEM = 24, CAPACITY = 4u << 20 };
    struct link_queue *queue = queue_of(CAPACITY, -1);
    struct link_item item;
    assert_int_equal(link_queue_oldest_us(queue), 0);
    for (uint32_t i = 0; i < COUNT; i++) {
        struct link_frame frame = frame_of(i);
        assert_true(link_queue_put_frame(queue, &frame));
        assert_true(link_queue_read(queue, &item));
        if (i % 100 == 99)
            link_queue_release(queue);
        if (i == 1000) { /* nothing is gone yet */
            assert_true(link_queue_is_complete(queue));
            assert_int_equal(link_queue_oldest_us(queue), 1000000);
            link_queue_rewind_all(queue);
            for (uint32_t again = 0; again <= i; again++) {
                assert_true(link_queue_read(queue, &item));
                assert_int_equal(number_of(&item), again);
                assert_true(item.is_repeated);
            }
        }
    }
    assert_int_equal(link_queue_depth(queue).bytes, 0); /* what is kept is not what waits */
    assert_false(link_queue_is_complete(queue));
    uint32_t first = (uint32_t)(link_queue_oldest_us(queue) - 1000000u);
    assert_in_range((COUNT - first) * ITEM, CAPACITY / 2, CAPACITY / 2 + (512u << 10));
    link_queue_rewind_all(queue);
    for (uint32_t i = first; i < COUNT; i++) {
        assert_true(link_queue_read(queue, &item));
        assert_int_equal(number_of(&item), i);
        assert_true(item.is_repeated);
    }
    assert_false(link_queue_read(queue, &item));
    link_queue_close(queue);
}

/* A link of LINK_QUEUE_CAPACITY_S at its fullest fits, and no more than a twentieth beyond that of
 * CAN. */
TEST(holds_a_minute)
{
    struct link_queue *can = queue_of(LINK_QUEUE_CAN_BYTES, -1),
                      *serial = queue_of(LINK_QUEUE_SERIAL_BYTES, -1);
    uint8_t read[40] = {0};
    uint64_t frames = 0, bytes = 0;
    struct link_frame frame = frame_of(1);
    while (link_queue_put_frame(can, &frame))
        frames++;
    while (link_queue_put_bytes(serial, read, sizeof read, 1))
        bytes += sizeof read;
    /* 111 bits a frame, nothing stuffed */
    assert_in_range(frames, 60 * 1000000 / 111, 60 * 1000000 / 111 * 21 / 20);
    assert_in_range(bytes, 60 * 200000, 60 * 200000 * 3 / 2);
    link_queue_close(can);
    link_queue_close(serial);
}

/* Who takes sleeps until something is there, and is woken once for a batch. */
TEST(news_when_somebody_listens)
{
    int news = eventfd(0, EFD_NONBLOCK);
    struct link_queue *queue = queue_of(1u << 20, news);
    struct link_frame frame = frame_of(1);
    struct link_item item;
    uint64_t count = 0;
    link_queue_put_frame(queue, &frame);
    link_queue_signal(queue);
    assert_int_equal(read(news, &count, sizeof count), -1); /* nobody listened */
    assert_true(link_queue_request_event(queue));
    assert_true(link_queue_read(queue, &item));
    assert_false(link_queue_request_event(queue));
    link_queue_signal(queue);
    assert_int_equal(read(news, &count, sizeof count), -1); /* nothing is there */
    link_queue_put_frame(queue, &frame);
    link_queue_put_frame(queue, &frame);
    link_queue_signal(queue);
    link_queue_signal(queue);
    assert_int_equal(read(news, &count, sizeof count), sizeof count);
    assert_int_equal(count, 1);
    link_queue_close(queue);
    close(news);
}

/* ---- the reader ---- */

static enum link_fault blamed;
static enum link_fault blame(void *context)
{
    (void)context;
    return blamed;
}

static bool eventually(bool (*there)(void *context), void *context)
{
    for (int waited_ms = 0; waited_ms < WAIT_MS; waited_ms += 5) {
        if (there(context))
            return true;
        poll(NULL, 0, 5);
    }
    return false;
}

/* A pseudo-terminal: `serial:` does not wait for us, like a wire. */
static int open_wire(struct link **link)
{
    struct error error = {0};
    char spec[80];
    int wire = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(wire >= 0 && grantpt(wire) == 0 && unlockpt(wire) == 0);
    snprintf(spec, sizeof spec, "serial:%s:115200", ptsname(wire));
    if (link_open(spec, LINK_SERIAL, link, &error) != MR_OK)
        fail_msg("%s", error.text);
    return wire;
}

static bool is_full_and_loses(void *context)
{
    return link_reader_lost_count(context) > 0;
}

static uint64_t put_all(int fd, size_t length)
{
    uint8_t bytes[500];
    uint64_t sent = 0;
    memset(bytes, 0x5a, sizeof bytes);
    while (sent < length) {
        ssize_t count = write(fd, bytes, sizeof bytes);
        assert_true(count > 0);
        sent += (uint64_t)count;
    }
    return sent;
}

/* Takes until the reader is at rest; sums bytes, and the newest counters. */
static uint64_t drain(struct link_reader *reader, struct link_counters *counters, uint64_t until)
{
    struct link_queue *queue = link_reader_queue(reader);
    struct link_item item;
    uint64_t sum = 0;
    for (int waited_ms = 0; waited_ms < WAIT_MS && sum < until; waited_ms += 2) {
        while (link_queue_read(queue, &item)) {
            sum += item.kind == LINK_ITEM_BYTES ? item.length : 0;
            if (item.kind == LINK_ITEM_COUNTERS)
                *counters = item.counters;
        }
        link_queue_release(queue);
        poll(NULL, 0, 2);
    }
    return sum;
}

/* Nobody takes: what comes once the queue is full is lost, is counted by its cause, and stands
 * before what came after it. */
TEST(a_full_queue_loses_and_says_so)
{
    enum { CAPACITY = 40000, SENT = 200000 };
    struct error error = {0};
    struct link *link;
    struct link_reader *reader;
    struct link_counters counters = {0};
    int wire = open_wire(&link);
    blamed = LINK_LOST_LOCK;
    assert_int_equal(
        link_reader_open(link, LINK_SERIAL, CAPACITY, -1, blame, NULL, &reader, &error), MR_OK);
    uint64_t sent = put_all(wire, SENT);
    assert_true(eventually(is_full_and_loses, reader));
    /* All is read when it is either in the queue or lost. */
    for (int i = 0; i < WAIT_MS / 5 && link_queue_depth(link_reader_queue(reader)).serial_bytes +
                                               link_reader_lost_count(reader) <
                                           sent;
         i++)
        poll(NULL, 0, 5);
    uint64_t lost = link_reader_lost_count(reader);
    assert_int_equal(link_queue_depth(link_reader_queue(reader)).serial_bytes + lost, sent);
    assert_true(lost > SENT - CAPACITY);
    uint64_t came = drain(reader, &counters, sent - lost);
    assert_int_equal(came, sent - lost);
    blamed = LINK_LOST_PROCESSOR;
    sent = put_all(wire, 500);
    assert_int_equal(drain(reader, &counters, sent), sent);
    assert_int_equal(counters.fault_count[LINK_LOST_LOCK], lost);
    assert_int_equal(counters.fault_count[LINK_LOST_PROCESSOR], 0);
    assert_int_equal(link_reader_lost_count(reader), lost);
    link_reader_close(reader);
    link_close(link);
    close(wire);
}

struct sender {
    int fd;
    size_t length;
    atomic_bool done;
};

static void *send_all(void *context)
{
    struct sender *sender = context;
    put_all(sender->fd, sender->length);
    atomic_store(&sender->done, true);
    return NULL;
}

static bool waits(void *context)
{
    return link_reader_is_blocked(context);
}

/* The same over a socket: who sends waits, and nothing is lost. */
TEST(a_sender_that_can_wait_waits)
{
    enum { CAPACITY = 40000, SENT = 2000000 };
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    struct error error = {0};
    struct link *link;
    struct link_reader *reader;
    struct link_counters counters = {0};
    char spec[200], folder[] = "/tmp/matrig-queue.XXXXXX";
    pthread_t thread;
    assert_non_null(mkdtemp(folder));
    snprintf(address.sun_path, sizeof address.sun_path, "%s/s", folder);
    int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(listener, 1), 0);
    snprintf(spec, sizeof spec, "unix:%s", address.sun_path);
    assert_int_equal(link_open(spec, LINK_SERIAL, &link, &error), MR_OK);
    struct sender sender = {.fd = accept(listener, NULL, NULL), .length = SENT};
    assert_int_equal(
        link_reader_open(link, LINK_SERIAL, CAPACITY, -1, blame, NULL, &reader, &error), MR_OK);
    assert_int_equal(pthread_create(&thread, NULL, send_all, &sender), 0);
    assert_true(eventually(waits, reader));
    assert_false(atomic_load(&sender.done));
    assert_int_equal(drain(reader, &counters, SENT), SENT);
    pthread_join(thread, NULL);
    assert_int_equal(link_reader_lost_count(reader), 0);
    assert_int_equal(counters.fault_total, 0);
    /* One that waits for room is stopped all the same. */
    sender = (struct sender){.fd = sender.fd, .length = 100000};
    assert_int_equal(pthread_create(&thread, NULL, send_all, &sender), 0);
    assert_true(eventually(waits, reader));
    link_reader_stop(reader);
    drain(reader, &counters, 1);
    shutdown(sender.fd, SHUT_RD);
    uint8_t rest[4096];
    size_t length;
    uint64_t host_us;
    for (int i = 0; i < WAIT_MS && !atomic_load(&sender.done); i++) {
        /* the thread is gone: the link is ours again */
        if (link_receive_bytes(link, rest, sizeof rest, &length, &host_us, &error) == MR_TOO_FEW)
            poll(NULL, 0, 1);
    }
    pthread_join(thread, NULL);
    link_reader_close(reader);
    link_close(link);
    close(sender.fd);
    close(listener);
    unlink(address.sun_path);
    rmdir(folder);
}
