#include "host/link/reader.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "host/link/link_ops.h"

#define SERVICE_MS 250 /* a link is looked after at least this often */

struct link_reader {
    struct link *link;
    enum link_kind kind;
    struct link_queue *queue;
    link_blame *blame;
    void *context;
    bool recorded; /* no thread */
    bool ended;
    bool dropping;
    uint64_t told; /* of the link's troubles, in the queue */
    pthread_t thread;
    bool started;
    int wake; /* ends a wait */
    atomic_bool stop, holds_up;
    atomic_uint_fast64_t lost;
    uint8_t bytes[LINK_QUEUE_READ_MAX];
};

struct link_queue *link_reader_queue(const struct link_reader *reader)
{
    return reader->queue;
}

uint64_t link_reader_lost(const struct link_reader *reader)
{
    return atomic_load(&reader->lost);
}

bool link_reader_holds_up(const struct link_reader *reader)
{
    return atomic_load(&reader->holds_up);
}

int link_reader_fd(const struct link_reader *reader)
{
    return reader->recorded && !reader->ended ? link_fd(reader->link) : -1;
}

/* Counters stand before what came after they changed. */
static void put_counters(struct link_reader *reader)
{
    const struct link_counters *counters = link_counters(reader->link);
    if (counters->troubles == reader->told)
        return;
    /* what was sent is another thread's */
    struct link_counters copy = {.received = counters->received, .troubles = counters->troubles};
    memcpy(copy.trouble, counters->trouble, sizeof copy.trouble);
    reader->told = counters->troubles;
    link_queue_put_counters(reader->queue, &copy);
}

static void lose(struct link_reader *reader, size_t count)
{
    reader->dropping = true;
    link_trouble(reader->link, reader->blame(reader->context), count);
    atomic_fetch_add(&reader->lost, count);
}

/* One frame or read. False: the reader was stopped. */
static bool deliver(struct link_reader *reader, const struct link_frame *frame, size_t length,
                    uint64_t host_us)
{
    size_t count = reader->kind == LINK_CAN ? 1 : length;
    if (reader->dropping && link_queue_is_tight(reader->queue)) {
        lose(reader, count);
        return true;
    }
    reader->dropping = false;
    put_counters(reader);
    for (;;) {
        bool there = reader->kind == LINK_CAN
                       ? link_queue_put_frame(reader->queue, frame)
                       : link_queue_put_bytes(reader->queue, reader->bytes, length, host_us);
        if (there)
            return true;
        if (!link_waits(reader->link)) {
            lose(reader, count);
            return true;
        }
        atomic_store(&reader->holds_up, true);
        bool room = link_queue_wait_for_room(reader->queue);
        atomic_store(&reader->holds_up, false);
        if (!room)
            return false;
    }
}

static void end(struct link_reader *reader, const struct error *reason)
{
    put_counters(reader);
    link_queue_put_end(reader->queue, reason);
    reader->ended = true;
}

/* What waits in the link, a turn's worth at most. True: there may be more. */
static bool read_turn(struct link_reader *reader)
{
    struct link_frame frame;
    struct error reason = {0};
    size_t length = 0;
    uint64_t host_us = 0;
    for (unsigned i = 0; i < (reader->kind == LINK_CAN ? READER_FRAMES : 1); i++) {
        enum mr_status status = reader->kind == LINK_CAN
                                  ? link_receive_frame(reader->link, &frame, &reason)
                                  : link_receive_bytes(reader->link, reader->bytes,
                                                       sizeof reader->bytes, &length, &host_us,
                                                       &reason);
        if (status == MR_TOO_FEW)
            return false;
        if (status != MR_OK) {
            end(reader, &reason);
            return false;
        }
        if (!deliver(reader, &frame, length, host_us))
            return false;
    }
    return true;
}

bool link_reader_turn(struct link_reader *reader)
{
    bool more = !reader->ended && read_turn(reader);
    put_counters(reader);
    return more;
}

static void service(struct link_reader *reader)
{
    struct error reason = {0};
    enum mr_status status = link_service(reader->link, &reason);
    reader->dropping = reader->dropping && link_queue_is_tight(reader->queue);
    if (status != MR_OK && status != MR_TOO_FEW)
        end(reader, &reason);
    else if (!reader->dropping)
        put_counters(reader);
}

static void *read_on(void *context)
{
    struct link_reader *reader = context;
    while (!atomic_load(&reader->stop) && !reader->ended) {
        service(reader);
        if (reader->ended)
            break;
        bool more = read_turn(reader);
        link_queue_wake(reader->queue);
        struct pollfd polled[] = {{.fd = link_fd(reader->link), .events = POLLIN},
                                  {.fd = reader->wake, .events = POLLIN}};
        if (!more && !reader->ended)
            poll(polled, 2, SERVICE_MS);
    }
    put_counters(reader); /* what was lost last, too */
    link_queue_wake(reader->queue);
    return NULL;
}

enum mr_status link_reader_open(struct link *link, enum link_kind kind, size_t capacity, int news,
                                link_blame *blame, void *context, struct link_reader **reader,
                                struct error *error)
{
    struct link_reader *made = calloc(1, sizeof *made);
    if (!made)
        return error_set(error, MR_FULL, "no memory: link %s; close other programs",
                         link_spec(link));
    made->link = link;
    made->kind = kind;
    made->blame = blame;
    made->context = context;
    made->recorded = link_recorded(link);
    made->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (capacity == 0)
        capacity = kind == LINK_CAN ? LINK_QUEUE_CAN_BYTES : LINK_QUEUE_SERIAL_BYTES;
    if (made->recorded) /* it is taken before more is read */
        capacity = SIZE_MAX / 4;
    enum mr_status status = link_queue_open(capacity, news, &made->queue, error);
    if (status == MR_OK && made->wake < 0)
        status = error_set(error, MR_IO,
                           "no eventfd (%s): link %s; check the limits of this system",
                           strerror(errno), link_spec(link));
    if (status == MR_OK && !made->recorded) {
        int code = pthread_create(&made->thread, NULL, read_on, made);
        made->started = code == 0;
        if (code != 0)
            status = error_set(error, MR_IO,
                               "no thread (%s): link %s; check the limits of this system",
                               strerror(code), link_spec(link));
    }
    if (status != MR_OK) {
        link_reader_close(made);
        return status;
    }
    *reader = made;
    return MR_OK;
}

void link_reader_stop(struct link_reader *reader)
{
    const uint64_t one = 1;
    if (!reader || !reader->started)
        return;
    atomic_store(&reader->stop, true);
    link_queue_stop(reader->queue);
    ssize_t written = write(reader->wake, &one, sizeof one);
    (void)written;
    pthread_join(reader->thread, NULL);
    reader->started = false;
}

void link_reader_close(struct link_reader *reader)
{
    if (!reader)
        return;
    link_reader_stop(reader);
    link_queue_close(reader->queue);
    if (reader->wake >= 0)
        close(reader->wake);
    free(reader);
}
