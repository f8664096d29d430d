/* The queue is a list of pieces of memory. A piece is mapped when the last one is full, and
 * unmapped when all its items are released. A ring buffer would in time touch all of its memory,
 * even if it never contained much. */
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

#define PIECE_BYTES (256u * 1024u)

/* Totals of all items before a position. */
struct queue_totals {
    uint64_t items, memory, frames, octets;
};

struct piece {
    struct piece *next;
    size_t used; /* number of bytes used in `bytes` */
    struct queue_totals before;
    uint8_t bytes[PIECE_BYTES - 48];
};
_Static_assert(sizeof(struct piece) == PIECE_BYTES, "a piece is a whole number of pages");

struct item_header {
    uint64_t host_us;
    uint32_t id;
    uint16_t length;
    uint8_t kind, dlc;
};
_Static_assert(sizeof(struct item_header) == LINK_QUEUE_ITEM_BYTES,
               "the header's sum of memory counts on it");

/* A position in the queue, between two items. */
struct queue_position {
    struct piece *piece;
    size_t offset;
    struct queue_totals totals;
};

struct link_queue {
    pthread_mutex_t lock;
    pthread_cond_t room_freed;
    size_t capacity;
    int event_fd;
    bool wants_event, stopped, was_full;
    /* largest number of items read so far; after a rewind, items below it are repeated */
    uint64_t items_read_max;
    struct piece *spare, *oldest; /* oldest: first piece that has not been discarded */
    size_t history;
    struct queue_position written, read, released;
};

static struct piece *allocate_piece(void)
{
    void *memory = mmap(NULL, sizeof(struct piece), PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return memory == MAP_FAILED ? NULL : memory;
}

enum mr_status link_queue_open(size_t capacity, int event_fd, struct link_queue **queue,
                               struct error *error)
{
    struct link_queue *made = calloc(1, sizeof *made);
    struct piece *piece = made ? allocate_piece() : NULL;
    if (!piece) {
        free(made);
        return error_set(error, MR_FULL,
                         "out of memory for data from a link; close other programs");
    }
    pthread_mutex_init(&made->lock, NULL);
    pthread_cond_init(&made->room_freed, NULL);
    made->capacity = capacity;
    made->event_fd = event_fd;
    made->history = (capacity < LINK_QUEUE_SERIAL_BYTES ? capacity : LINK_QUEUE_SERIAL_BYTES) /
                    LINK_QUEUE_HISTORY_DIVISOR;
    made->oldest = made->written.piece = made->read.piece = made->released.piece = piece;
    *queue = made;
    return MR_OK;
}

void link_queue_close(struct link_queue *queue)
{
    if (!queue)
        return;
    for (struct piece *piece = queue->oldest, *next; piece; piece = next) {
        next = piece->next;
        munmap(piece, sizeof *piece);
    }
    if (queue->spare)
        munmap(queue->spare, sizeof *queue->spare);
    pthread_cond_destroy(&queue->room_freed);
    pthread_mutex_destroy(&queue->lock);
    free(queue);
}

static size_t count_held_bytes(const struct link_queue *queue)
{
    return (size_t)(queue->written.totals.memory - queue->released.totals.memory);
}

static size_t compute_padded_length(size_t length)
{
    return (length + 7u) & ~(size_t)7u;
}

/* Advances a position past the next item. */
static void advance_position(struct queue_position *place, const struct item_header *head)
{
    size_t size = sizeof *head + compute_padded_length(head->length);
    place->offset += size;
    place->totals.memory += size;
    place->totals.items++;
    place->totals.frames += head->kind == LINK_ITEM_FRAME;
    place->totals.octets += head->kind == LINK_ITEM_BYTES ? head->length : 0;
}

/* Appends an item. `beyond_capacity`: also if the queue is full. */
static bool append_item(struct link_queue *queue, const struct item_header *head,
                        const void *content, bool beyond_capacity)
{
    size_t size = sizeof *head + compute_padded_length(head->length);
    pthread_mutex_lock(&queue->lock);
    struct queue_position *end = &queue->written;
    bool fits = beyond_capacity || count_held_bytes(queue) + size <= queue->capacity;
    if (fits && end->offset + size > sizeof end->piece->bytes) {
        struct piece *next = queue->spare ? queue->spare : allocate_piece();
        queue->spare = NULL;
        fits = next != NULL;
        if (next) {
            next->next = NULL;
            next->used = 0;
            next->before = end->totals;
            end->piece->next = next;
            end->piece = next;
            end->offset = 0;
        }
    }
    if (fits) {
        memcpy(end->piece->bytes + end->offset, head, sizeof *head);
        memcpy(end->piece->bytes + end->offset + sizeof *head, content, head->length);
        advance_position(end, head);
        end->piece->used = end->offset;
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

void link_queue_put_clock(struct link_queue *queue, int64_t jump_us)
{
    const struct item_header head = {.length = sizeof jump_us, .kind = LINK_ITEM_CLOCK};
    (void)append_item(queue, &head, &jump_us, true);
}

void link_queue_signal(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    bool signals = queue->wants_event && queue->read.totals.items != queue->written.totals.items;
    queue->wants_event = queue->wants_event && !signals;
    pthread_mutex_unlock(&queue->lock);
    if (signals && queue->event_fd >= 0) {
        const uint64_t one = 1;
        ssize_t written = write(queue->event_fd, &one, sizeof one);
        /* if the counter of the eventfd is full, the write fails, but the reader still wakes */
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
    while (is_nearly_full(queue) && !queue->stopped)
        pthread_cond_wait(&queue->room_freed, &queue->lock);
    bool room = !queue->stopped;
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
static void skip_piece_end(struct queue_position *place)
{
    if (place->offset == place->piece->used && place->piece->next) {
        place->piece = place->piece->next;
        place->offset = 0;
    }
}

bool link_queue_read(struct link_queue *queue, struct link_item *item)
{
    struct item_header head;
    pthread_mutex_lock(&queue->lock);
    bool any = queue->read.totals.items != queue->written.totals.items;
    if (any) {
        skip_piece_end(&queue->read);
        const uint8_t *at = queue->read.piece->bytes + queue->read.offset;
        memcpy(&head, at, sizeof head);
        item->bytes = at + sizeof head;
        advance_position(&queue->read, &head);
        item->is_repeated = queue->read.totals.items <= queue->items_read_max;
        if (!item->is_repeated)
            queue->items_read_max = queue->read.totals.items;
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
    case LINK_ITEM_CLOCK: memcpy(&item->jump_us, item->bytes, sizeof item->jump_us); break;
    case LINK_ITEM_END: memcpy(&item->end, item->bytes, sizeof item->end); break;
    case LINK_ITEM_BYTES: break;
    }
    return true;
}

bool link_queue_has_unread(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    bool unread = queue->read.totals.items != queue->written.totals.items;
    pthread_mutex_unlock(&queue->lock);
    return unread;
}

bool link_queue_request_event(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    bool unread = queue->read.totals.items != queue->written.totals.items;
    queue->wants_event = !unread;
    pthread_mutex_unlock(&queue->lock);
    return unread;
}

void link_queue_release(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    queue->released = queue->read;
    while (queue->oldest != queue->released.piece &&
           queue->released.totals.memory - queue->oldest->next->before.memory >= queue->history) {
        struct piece *old = queue->oldest;
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
    queue->read = queue->released;
    pthread_mutex_unlock(&queue->lock);
}

void link_queue_rewind_all(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    queue->released = queue->read = (struct queue_position){.piece = queue->oldest,
                                                            .totals = queue->oldest->before};
    pthread_mutex_unlock(&queue->lock);
}

bool link_queue_is_complete(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    bool whole = queue->oldest->before.items == 0;
    pthread_mutex_unlock(&queue->lock);
    return whole;
}

uint64_t link_queue_oldest_us(struct link_queue *queue)
{
    uint64_t oldest_us = 0;
    pthread_mutex_lock(&queue->lock);
    struct queue_position place = {.piece = queue->oldest, .totals = queue->oldest->before};
    while (oldest_us == 0 && place.totals.items != queue->written.totals.items) {
        struct item_header head;
        skip_piece_end(&place);
        memcpy(&head, place.piece->bytes + place.offset, sizeof head);
        oldest_us = head.host_us;
        advance_position(&place, &head);
    }
    pthread_mutex_unlock(&queue->lock);
    return oldest_us;
}

void link_queue_stop(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    queue->stopped = true;
    pthread_cond_broadcast(&queue->room_freed);
    pthread_mutex_unlock(&queue->lock);
}

struct link_queue_depth link_queue_depth(struct link_queue *queue)
{
    pthread_mutex_lock(&queue->lock);
    struct link_queue_depth depth = {
        .bytes = count_held_bytes(queue),
        .capacity = queue->capacity,
        .can_frames = queue->written.totals.frames - queue->released.totals.frames,
        .serial_bytes = queue->written.totals.octets - queue->released.totals.octets};
    pthread_mutex_unlock(&queue->lock);
    return depth;
}

/* ---- the reader ---- */

#define SERVICE_MS 250 /* longest time between two calls of a link's service */

struct link_reader {
    struct link *link;
    enum link_kind kind;
    struct link_queue *queue;
    link_cause_finder *find_cause;
    void *context;
    bool recorded; /* the link is a recording, which is read without a thread */
    bool ended;
    bool is_dropping;
    /* number of troubles and bad lines of the link that the queue already contains */
    uint64_t queued_troubles;
    pthread_t thread;
    bool started;
    int wake_fd; /* eventfd that ends a wait */
    atomic_bool stop, is_blocked;
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

bool link_reader_is_blocked(const struct link_reader *reader)
{
    return atomic_load(&reader->is_blocked);
}

int link_reader_fd(const struct link_reader *reader)
{
    return reader->recorded && !reader->ended ? link_fd(reader->link) : -1;
}

/* Puts changed counters into the queue, before the next data. */
static void put_counters(struct link_reader *reader)
{
    const struct link_counters *counters = link_counters(reader->link);
    if (counters->troubles + counters->bad_lines == reader->queued_troubles)
        return;
    /* the count of sent data is left out: another thread changes it */
    struct link_counters copy = {.received = counters->received,
                                 .troubles = counters->troubles,
                                 .bad_lines = counters->bad_lines};
    memcpy(copy.trouble, counters->trouble, sizeof copy.trouble);
    reader->queued_troubles = counters->troubles + counters->bad_lines;
    link_queue_put_counters(reader->queue, &copy);
}

static void drop_queued(struct link_reader *reader, size_t count)
{
    reader->is_dropping = true;
    link_count_event(reader->link, reader->find_cause(reader->context), count);
    atomic_fetch_add(&reader->lost, count);
}

/* Puts one frame or one read into the queue. Returns false if the reader was stopped. */
static bool queue_data(struct link_reader *reader, const struct link_frame *frame, size_t length,
                       uint64_t host_us)
{
    size_t count = reader->kind == LINK_CAN ? 1 : length;
    if (reader->is_dropping && link_queue_is_nearly_full(reader->queue)) {
        drop_queued(reader, count);
        return true;
    }
    reader->is_dropping = false;
    put_counters(reader);
    for (;;) {
        bool has_data = reader->kind == LINK_CAN
                          ? link_queue_put_frame(reader->queue, frame)
                          : link_queue_put_bytes(reader->queue, reader->bytes, length, host_us);
        if (has_data)
            return true;
        if (!link_sender_waits(reader->link)) {
            drop_queued(reader, count);
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
    put_counters(reader);
    link_queue_put_end(reader->queue, reason);
    reader->ended = true;
}

/* Reads the waiting data of the link, up to the limit of one turn. Returns true if there may be
 * more. */
static bool read_once(struct link_reader *reader)
{
    struct link_frame frame;
    struct error reason = {0};
    size_t length = 0;
    uint64_t host_us = 0;
    for (unsigned i = 0; i < (reader->kind == LINK_CAN ? LINK_READER_FRAMES_MAX : 1); i++) {
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
    bool more = !reader->ended && read_once(reader);
    put_counters(reader);
    return more;
}

static void service_link(struct link_reader *reader)
{
    struct error reason = {0};
    enum mr_status status = link_service(reader->link, &reason);
    reader->is_dropping = reader->is_dropping && link_queue_is_nearly_full(reader->queue);
    if (status != MR_OK && status != MR_TOO_FEW)
        end_reading(reader, &reason);
    else if (!reader->is_dropping)
        put_counters(reader);
}

static void *run_reader(void *context)
{
    struct link_reader *reader = context;
    while (!atomic_load(&reader->stop) && !reader->ended) {
        service_link(reader);
        if (reader->ended)
            break;
        bool more = read_once(reader);
        link_queue_signal(reader->queue);
        struct pollfd polled[] = {{.fd = link_fd(reader->link), .events = POLLIN},
                                  {.fd = reader->wake_fd, .events = POLLIN}};
        if (!more && !reader->ended)
            poll(polled, 2, SERVICE_MS);
    }
    put_counters(reader); /* the counters include the last losses */
    link_queue_signal(reader->queue);
    return NULL;
}

enum mr_status link_reader_open(struct link *link, enum link_kind kind, size_t capacity,
                                int event_fd, link_cause_finder *find_cause, void *context,
                                struct link_reader **reader, struct error *error)
{
    struct link_reader *made = calloc(1, sizeof *made);
    if (!made)
        return error_set(error, MR_FULL,
                         "out of memory while opening link %s; close other programs",
                         link_spec(link));
    made->link = link;
    made->kind = kind;
    made->find_cause = find_cause;
    made->context = context;
    made->recorded = link_is_recorded(link);
    made->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (capacity == 0)
        capacity = kind == LINK_CAN ? LINK_QUEUE_CAN_BYTES : LINK_QUEUE_SERIAL_BYTES;
    /* a recording needs no limit: each item is read before the next one is added */
    if (made->recorded)
        capacity = SIZE_MAX / 4;
    enum mr_status status = link_queue_open(capacity, event_fd, &made->queue, error);
    if (status == MR_OK && made->wake_fd < 0)
        status = error_set(
            error, MR_IO, "cannot create an eventfd (%s): link %s; check the limits of this system",
            strerror(errno), link_spec(link));
    if (status == MR_OK && !made->recorded) {
        int code = pthread_create(&made->thread, NULL, run_reader, made);
        made->started = code == 0;
        if (code != 0)
            status =
                error_set(error, MR_IO,
                          "cannot create a thread (%s): link %s; check the limits of this system",
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
    ssize_t written = write(reader->wake_fd, &one, sizeof one);
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
    if (reader->wake_fd >= 0)
        close(reader->wake_fd);
    free(reader);
}
