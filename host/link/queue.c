/* The queue is a list of pieces of memory. A piece is mapped when the last one is full, and
 * unmapped when all its items are released. A ring buffer is not used, because over time it would
 * occupy its whole memory even with few items. */
#include "host/link/queue.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

#include "host/link/link_ops.h"

#define QUEUE_CHUNK_BYTES (256u * 1024u)

/* Sums over all items before a position. */
struct queue_totals {
    uint64_t item_count, memory_bytes, frame_count, serial_byte_count;
};

struct queue_chunk {
    struct queue_chunk *next;
    size_t used; /* number of bytes used in `bytes` */
    struct queue_totals totals_before;
    uint8_t bytes[QUEUE_CHUNK_BYTES - 48];
};
_Static_assert(sizeof(struct queue_chunk) == QUEUE_CHUNK_BYTES,
               "the size of a piece is a multiple of the page size");

struct item_header {
    uint64_t host_us;
    uint32_t id;
    uint16_t length;
    uint8_t kind, dlc;
};
_Static_assert(sizeof(struct item_header) == LINK_QUEUE_ITEM_BYTES,
               "the calculation of memory in the header uses this size");

/* A position in the queue, between two items. */
struct queue_position {
    struct queue_chunk *chunk;
    size_t offset;
    struct queue_totals totals;
};

struct link_queue {
    pthread_mutex_t lock;
    pthread_cond_t room_freed;
    size_t capacity;
    int event_fd;
    bool wants_event, is_stopped, was_full;
    /* largest number of items read so far; after a rewind, smaller item numbers are read again */
    uint64_t max_read_item_count;
    struct queue_chunk *spare, *oldest; /* oldest: first piece that has not been discarded */
    size_t history_bytes_max;
    struct queue_position write_position, read_position, release_position;
};

static struct queue_chunk *allocate_chunk(void)
{
    void *memory = mmap(NULL, sizeof(struct queue_chunk), PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return memory == MAP_FAILED ? NULL : memory;
}

enum mr_status link_queue_open(size_t capacity, int event_fd, struct link_queue **queue,
                               struct error *error)
{
    struct link_queue *made = calloc(1, sizeof *made);
    struct queue_chunk *chunk = made ? allocate_chunk() : NULL;
    if (!chunk) {
        free(made);
        return error_set(error, MR_FULL,
                         "out of memory for data from a link; close other programs");
    }
    pthread_mutex_init(&made->lock, NULL);
    pthread_cond_init(&made->room_freed, NULL);
    made->capacity = capacity;
    made->event_fd = event_fd;
    made->history_bytes_max = (capacity < LINK_QUEUE_SERIAL_BYTES ? capacity
                                                                  : LINK_QUEUE_SERIAL_BYTES) /
                              LINK_QUEUE_HISTORY_DIVISOR;
    made->oldest = made->write_position.chunk = made->read_position.chunk =
        made->release_position.chunk = chunk;
    *queue = made;
    return MR_OK;
}

void link_queue_close(struct link_queue *queue)
{
    if (!queue)
        return;
    for (struct queue_chunk *chunk = queue->oldest, *next; chunk; chunk = next) {
        next = chunk->next;
        munmap(chunk, sizeof *chunk);
    }
    if (queue->spare)
        munmap(queue->spare, sizeof *queue->spare);
    pthread_cond_destroy(&queue->room_freed);
    pthread_mutex_destroy(&queue->lock);
    free(queue);
}

static size_t count_held_bytes(const struct link_queue *queue)
{
    return (size_t)(queue->write_position.totals.memory_bytes -
                    queue->release_position.totals.memory_bytes);
}

static size_t pad_item_length(size_t length)
{
    return (length + 7u) & ~(size_t)7u;
}

/* Advances a position past the next item. */
static void advance_position(struct queue_position *place, const struct item_header *head)
{
    size_t size = sizeof *head + pad_item_length(head->length);
    place->offset += size;
    place->totals.memory_bytes += size;
    place->totals.item_count++;
    place->totals.frame_count += head->kind == LINK_ITEM_FRAME;
    place->totals.serial_byte_count += head->kind == LINK_ITEM_BYTES ? head->length : 0;
}

/* Appends an item. `beyond_capacity`: appends it even if the queue is full. */
static bool append_item(struct link_queue *queue, const struct item_header *head,
                        const void *content, bool beyond_capacity)
{
    size_t size = sizeof *head + pad_item_length(head->length);
    pthread_mutex_lock(&queue->lock);
    struct queue_position *end = &queue->write_position;
    bool fits = beyond_capacity || count_held_bytes(queue) + size <= queue->capacity;
    if (fits && end->offset + size > sizeof end->chunk->bytes) {
        struct queue_chunk *next = queue->spare ? queue->spare : allocate_chunk();
        queue->spare = NULL;
        fits = next != NULL;
        if (next) {
            next->next = NULL;
            next->used = 0;
            next->totals_before = end->totals;
            end->chunk->next = next;
            end->chunk = next;
            end->offset = 0;
        }
    }
    if (fits) {
        memcpy(end->chunk->bytes + end->offset, head, sizeof *head);
        memcpy(end->chunk->bytes + end->offset + sizeof *head, content, head->length);
        advance_position(end, head);
        end->chunk->used = end->offset;
    } else {
        queue->was_full = true;
    }
    pthread_mutex_unlock(&queue->lock);
    return fits;
}

bool link_queue_put_frame(struct link_queue *queue, const struct link_frame *frame)
{
    const struct item_header head = {.host_us = frame->host_us,
                                     .id = frame->id,
                                     .length = sizeof frame->data,
                                     .kind = LINK_ITEM_FRAME,
                                     .dlc = frame->length};
    return append_item(queue, &head, frame->data, false);
}

bool link_queue_put_bytes(struct link_queue *queue, const uint8_t *bytes, size_t length,
                          uint64_t host_us)
{
    const struct item_header head = {
        .host_us = host_us, .length = (uint16_t)length, .kind = LINK_ITEM_BYTES};
    return append_item(queue, &head, bytes, false);
}

void link_queue_put_counters(struct link_queue *queue, const struct link_counters *counters)
{
    const struct item_header head = {.length = sizeof *counters, .kind = LINK_ITEM_COUNTERS};
    (void)append_item(queue, &head, counters, true);
}

void link_queue_put_end(struct link_queue *queue, const struct error *reason)
{
    const struct item_header head = {.length = sizeof *reason, .kind = LINK_ITEM_END};
    (void)append_item(queue, &head, reason, true);
}

void link_queue_put_clock_jump(struct link_queue *queue, int64_t jump_us)
{
    const struct item_header head = {.length = sizeof jump_us, .kind = LINK_ITEM_CLOCK_JUMP};
    (void)append_item(queue, &head, &jump_us, true);
}

void link_queue_signal(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    bool signals = queue->wants_event && queue->read_position.totals.item_count !=
                                             queue->write_position.totals.item_count;
    queue->wants_event = queue->wants_event && !signals;
    pthread_mutex_unlock(&queue->lock);
    if (signals && queue->event_fd >= 0) {
        const uint64_t one = 1;
        ssize_t written = write(queue->event_fd, &one, sizeof one);
        /* The write fails only if the counter of the eventfd is full, and then the reader is
         * signalled anyway. */
        (void)written;
    }
}

static bool is_nearly_full(const struct link_queue *queue)
{
    return count_held_bytes(queue) > queue->capacity / 4 * 3;
}

bool link_queue_wait_for_room(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    while (is_nearly_full(queue) && !queue->is_stopped)
        pthread_cond_wait(&queue->room_freed, &queue->lock);
    bool room = !queue->is_stopped;
    pthread_mutex_unlock(&queue->lock);
    return room;
}

bool link_queue_is_nearly_full(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    queue->was_full = queue->was_full && is_nearly_full(queue);
    bool tight = queue->was_full;
    pthread_mutex_unlock(&queue->lock);
    return tight;
}

/* Moves a position at the end of a piece to the beginning of the next one. */
static void skip_chunk_end(struct queue_position *place)
{
    if (place->offset == place->chunk->used && place->chunk->next) {
        place->chunk = place->chunk->next;
        place->offset = 0;
    }
}

bool link_queue_read(struct link_queue *queue, struct link_item *item)
{
    struct item_header head;
    pthread_mutex_lock(&queue->lock);
    bool any = queue->read_position.totals.item_count != queue->write_position.totals.item_count;
    if (any) {
        skip_chunk_end(&queue->read_position);
        const uint8_t *at = queue->read_position.chunk->bytes + queue->read_position.offset;
        memcpy(&head, at, sizeof head);
        item->bytes = at + sizeof head;
        advance_position(&queue->read_position, &head);
        item->is_repeated = queue->read_position.totals.item_count <= queue->max_read_item_count;
        if (!item->is_repeated)
            queue->max_read_item_count = queue->read_position.totals.item_count;
    }
    pthread_mutex_unlock(&queue->lock);
    if (!any)
        return false;
    item->kind = (enum link_item_kind)head.kind;
    item->host_us = head.host_us;
    item->length = head.length;
    switch (item->kind) {
    case LINK_ITEM_FRAME:
        item->frame =
            (struct link_frame){.host_us = head.host_us, .id = head.id, .length = head.dlc};
        memcpy(item->frame.data, item->bytes, sizeof item->frame.data);
        break;
    case LINK_ITEM_COUNTERS: memcpy(&item->counters, item->bytes, sizeof item->counters); break;
    case LINK_ITEM_CLOCK_JUMP: memcpy(&item->jump_us, item->bytes, sizeof item->jump_us); break;
    case LINK_ITEM_END: memcpy(&item->end_reason, item->bytes, sizeof item->end_reason); break;
    case LINK_ITEM_BYTES: break;
    }
    return true;
}

bool link_queue_has_unread(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    bool unread = queue->read_position.totals.item_count != queue->write_position.totals.item_count;
    pthread_mutex_unlock(&queue->lock);
    return unread;
}

bool link_queue_request_event(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    bool unread = queue->read_position.totals.item_count != queue->write_position.totals.item_count;
    queue->wants_event = !unread;
    pthread_mutex_unlock(&queue->lock);
    return unread;
}

void link_queue_release(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    queue->release_position = queue->read_position;
    while (queue->oldest != queue->release_position.chunk &&
           queue->release_position.totals.memory_bytes -
                   queue->oldest->next->totals_before.memory_bytes >=
               queue->history_bytes_max) {
        struct queue_chunk *old = queue->oldest;
        queue->oldest = old->next;
        if (queue->spare)
            munmap(old, sizeof *old);
        else
            queue->spare = old;
    }
    if (!is_nearly_full(queue))
        pthread_cond_broadcast(&queue->room_freed);
    pthread_mutex_unlock(&queue->lock);
}

void link_queue_rewind(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    queue->read_position = queue->release_position;
    pthread_mutex_unlock(&queue->lock);
}

void link_queue_rewind_all(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    queue->release_position = queue->read_position =
        (struct queue_position){.chunk = queue->oldest, .totals = queue->oldest->totals_before};
    pthread_mutex_unlock(&queue->lock);
}

bool link_queue_is_complete(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    bool whole = queue->oldest->totals_before.item_count == 0;
    pthread_mutex_unlock(&queue->lock);
    return whole;
}

uint64_t link_queue_oldest_us(struct link_queue *queue)
{
    uint64_t oldest_us = 0;
    pthread_mutex_lock(&queue->lock);
    struct queue_position place = {.chunk = queue->oldest, .totals = queue->oldest->totals_before};
    while (oldest_us == 0 && place.totals.item_count != queue->write_position.totals.item_count) {
        struct item_header head;
        skip_chunk_end(&place);
        memcpy(&head, place.chunk->bytes + place.offset, sizeof head);
        oldest_us = head.host_us;
        advance_position(&place, &head);
    }
    pthread_mutex_unlock(&queue->lock);
    return oldest_us;
}

void link_queue_stop(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    queue->is_stopped = true;
    pthread_cond_broadcast(&queue->room_freed);
    pthread_mutex_unlock(&queue->lock);
}

struct link_queue_depth link_queue_depth(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    struct link_queue_depth depth = {
        .bytes = count_held_bytes(queue),
        .capacity = queue->capacity,
        .can_frames = queue->write_position.totals.frame_count -
                      queue->release_position.totals.frame_count,
        .serial_bytes = queue->write_position.totals.serial_byte_count -
                        queue->release_position.totals.serial_byte_count};
    pthread_mutex_unlock(&queue->lock);
    return depth;
}

/* ---- the reader ---- */

#define SERVICE_PERIOD_MAX_MS 250 /* longest time between two calls of a link's service */

struct link_reader {
    struct link *link;
    enum link_kind kind;
    struct link_queue *queue;
    link_loss_cause_finder *find_loss_cause;
    void *context;
    bool is_recording; /* the link is a recording, which is read without a thread */
    bool has_ended;
    bool is_discarding_data;
    /* number of faults and bad lines of the link that the queue already contains */
    uint64_t queued_fault_total;
    pthread_t thread;
    bool is_thread_started;
    int wake_fd; /* eventfd that makes a waiting thread return */
    atomic_bool must_stop, is_blocked;
    atomic_uint_fast64_t lost_count;
    uint8_t bytes[LINK_QUEUE_READ_MAX];
};

struct link_queue *link_reader_queue(const struct link_reader *reader)
{
    return reader->queue;
}

uint64_t link_reader_lost_count(const struct link_reader *reader)
{
    return atomic_load(&reader->lost_count);
}

bool link_reader_is_blocked(const struct link_reader *reader)
{
    return atomic_load(&reader->is_blocked);
}

int link_reader_fd(const struct link_reader *reader)
{
    return reader->is_recording && !reader->has_ended ? link_fd(reader->link) : -1;
}

/* Puts changed counters into the queue, before the next data. */
static void queue_counters(struct link_reader *reader)
{
    const struct link_counters *counters = link_counters(reader->link);
    if (counters->fault_total + counters->bad_lines == reader->queued_fault_total)
        return;
    /* without the count of sent data, which another thread changes */
    struct link_counters copy = {.received_count = counters->received_count,
                                 .fault_total = counters->fault_total,
                                 .bad_lines = counters->bad_lines};
    memcpy(copy.fault_count, counters->fault_count, sizeof copy.fault_count);
    reader->queued_fault_total = counters->fault_total + counters->bad_lines;
    link_queue_put_counters(reader->queue, &copy);
}

static void count_dropped_data(struct link_reader *reader, size_t count)
{
    reader->is_discarding_data = true;
    link_count_event(reader->link, reader->find_loss_cause(reader->context), count);
    atomic_fetch_add(&reader->lost_count, count);
}

/* Adds one frame, or the bytes of one read, to the queue. Returns false if the reader was
 * stopped. */
static bool queue_data(struct link_reader *reader, const struct link_frame *frame, size_t length,
                       uint64_t host_us)
{
    size_t count = reader->kind == LINK_CAN ? 1 : length;
    if (reader->is_discarding_data && link_queue_is_nearly_full(reader->queue)) {
        count_dropped_data(reader, count);
        return true;
    }
    reader->is_discarding_data = false;
    queue_counters(reader);
    for (;;) {
        bool has_data = reader->kind == LINK_CAN
                          ? link_queue_put_frame(reader->queue, frame)
                          : link_queue_put_bytes(reader->queue, reader->bytes, length, host_us);
        if (has_data)
            return true;
        if (!link_blocks_sender(reader->link)) {
            count_dropped_data(reader, count);
            return true;
        }
        atomic_store(&reader->is_blocked, true);
        bool room = link_queue_wait_for_room(reader->queue);
        atomic_store(&reader->is_blocked, false);
        if (!room)
            return false;
    }
}

static void end_reading(struct link_reader *reader, const struct error *reason)
{
    queue_counters(reader);
    link_queue_put_end(reader->queue, reason);
    reader->has_ended = true;
}

/* Reads waiting data of the link, limited to the amount of one turn. Returns true if there may be
 * more. */
static bool read_link_once(struct link_reader *reader)
{
    struct link_frame frame;
    struct error reason = {0};
    size_t length = 0;
    uint64_t host_us = 0;
    for (unsigned i = 0; i < (reader->kind == LINK_CAN ? LINK_READER_FRAMES_PER_READ : 1); i++) {
        enum mr_status status = reader->kind == LINK_CAN
                                  ? link_receive_frame(reader->link, &frame, &reason)
                                  : link_receive_bytes(reader->link, reader->bytes,
                                                       sizeof reader->bytes, &length, &host_us,
                                                       &reason);
        if (status == MR_TOO_FEW)
            return false;
        if (status != MR_OK) {
            end_reading(reader, &reason);
            return false;
        }
        if (!queue_data(reader, &frame, length, host_us))
            return false;
    }
    return true;
}

bool link_reader_read(struct link_reader *reader)
{
    bool more = !reader->has_ended && read_link_once(reader);
    queue_counters(reader);
    return more;
}

static void service_link(struct link_reader *reader)
{
    struct error reason = {0};
    enum mr_status status = link_service(reader->link, &reason);
    reader->is_discarding_data = reader->is_discarding_data &&
                                 link_queue_is_nearly_full(reader->queue);
    if (status != MR_OK && status != MR_TOO_FEW)
        end_reading(reader, &reason);
    else if (!reader->is_discarding_data)
        queue_counters(reader);
}

static void *run_reader_thread(void *context)
{
    struct link_reader *reader = context;
    while (!atomic_load(&reader->must_stop) && !reader->has_ended) {
        service_link(reader);
        if (reader->has_ended)
            break;
        bool more = read_link_once(reader);
        link_queue_signal(reader->queue);
        struct pollfd polled[] = {{.fd = link_fd(reader->link), .events = POLLIN},
                                  {.fd = reader->wake_fd, .events = POLLIN}};
        if (!more && !reader->has_ended)
            poll(polled, 2, SERVICE_PERIOD_MAX_MS);
    }
    queue_counters(reader); /* at the end, report the last losses */
    link_queue_signal(reader->queue);
    return NULL;
}

enum mr_status link_reader_open(struct link *link, enum link_kind kind, size_t capacity,
                                int event_fd, link_loss_cause_finder *find_cause, void *context,
                                struct link_reader **reader, struct error *error)
{
    struct link_reader *made = calloc(1, sizeof *made);
    if (!made)
        return error_set(error, MR_FULL,
                         "out of memory while opening link %s; close other programs",
                         link_get_spec(link));
    made->link = link;
    made->kind = kind;
    made->find_loss_cause = find_cause;
    made->context = context;
    made->is_recording = link_is_from_recording(link);
    made->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (capacity == 0)
        capacity = kind == LINK_CAN ? LINK_QUEUE_CAN_BYTES : LINK_QUEUE_SERIAL_BYTES;
    /* no limit: a recording is read item by item, so the queue never grows */
    if (made->is_recording)
        capacity = SIZE_MAX / 4;
    enum mr_status status = link_queue_open(capacity, event_fd, &made->queue, error);
    if (status == MR_OK && made->wake_fd < 0)
        status = error_set(
            error, MR_IO, "cannot create an eventfd (%s): link %s; check the limits of this system",
            strerror(errno), link_get_spec(link));
    if (status == MR_OK && !made->is_recording) {
        int code = pthread_create(&made->thread, NULL, run_reader_thread, made);
        made->is_thread_started = code == 0;
        if (code != 0)
            status =
                error_set(error, MR_IO,
                          "cannot create a thread (%s): link %s; check the limits of this system",
                          strerror(code), link_get_spec(link));
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
    if (!reader || !reader->is_thread_started)
        return;
    atomic_store(&reader->must_stop, true);
    link_queue_stop(reader->queue);
    ssize_t written = write(reader->wake_fd, &one, sizeof one);
    (void)written;
    pthread_join(reader->thread, NULL);
    reader->is_thread_started = false;
}

void link_reader_close(struct link_reader *reader)
{
    if (!reader)
        return;
    link_reader_stop(reader);
    link_queue_close(reader->queue);
    if (reader->wake_fd >= 0)
        close(reader->wake_fd);
    free(reader);
}
