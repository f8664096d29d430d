/* Data received on one link and not yet stored in the campaign, in order of arrival: a bounded
 * queue in memory between the thread that reads the link and the thread that writes the campaign.
 * One thread appends, another reads; each function locks the queue.
 *
 * Items that were read are kept until link_queue_release. If a transaction fails, link_queue_rewind
 * makes them readable again. The newest of the released items are also kept, in case the campaign
 * file is lost; link_queue_rewind_all makes them readable again too. */
#ifndef MATRIG_HOST_LINK_QUEUE_H
#define MATRIG_HOST_LINK_QUEUE_H

#include "host/link/link.h"

/* Capacity: 60 s of a fully loaded link. An item takes LINK_QUEUE_ITEM_BYTES bytes plus its
 * content, rounded up to a multiple of 8. CAN: 1 Mbit/s carries at most 9,009 frames/s of 8 bytes
 * (111 bits without stuffing), 24 bytes each: 13.0 MB. Serial: 2 Mbaud carry 200,000 bytes/s in up
 * to 5,000 reads a second (40 bytes a read: adapters deliver 32 to 512), which add 24 bytes each:
 * 19.2 MB. Memory is allocated as the queue grows and freed as it empties, except for the newest
 * released items, which may use half of the capacity. */
#define LINK_QUEUE_CAPACITY_S 60u
#define LINK_QUEUE_ITEM_BYTES 16u
#define LINK_QUEUE_CAN_BYTES  (LINK_QUEUE_CAPACITY_S * 9009u * (LINK_QUEUE_ITEM_BYTES + 8u))
#define LINK_QUEUE_SERIAL_BYTES \
    (LINK_QUEUE_CAPACITY_S * (200000u + 5000u * (LINK_QUEUE_ITEM_BYTES + 8u)))

/* the released items use up to 1/LINK_QUEUE_HISTORY_DIVISOR of the capacity */
#define LINK_QUEUE_HISTORY_DIVISOR 2u

#define LINK_QUEUE_READ_MAX 16384u /* maximum number of bytes of one item */

struct link_queue;

enum link_item_kind {
    LINK_ITEM_FRAME, /* a CAN frame */
    LINK_ITEM_BYTES, /* serial bytes of one read */
    /* counters of the link, placed before the data received after they changed */
    LINK_ITEM_COUNTERS,
    LINK_ITEM_CLOCK_JUMP, /* this computer's clock was set: later time stamps use the new time */
    LINK_ITEM_END,        /* end of the link; the last item */
};

struct link_item {
    enum link_item_kind kind;
    bool is_repeated; /* the item was read before and returned by a rewind */
    struct link_frame frame;
    uint64_t host_us;     /* Unix time at which the bytes were read */
    const uint8_t *bytes; /* bytes, valid until the release of the item */
    size_t length;
    struct link_counters counters;
    int64_t jump_us;         /* change of the clock, for LINK_ITEM_CLOCK_JUMP */
    struct error end_reason; /* reason for the end; MR_OK: end of file */
};

struct link_queue_depth {
    size_t bytes, capacity;            /* bytes of memory used, and their limit */
    uint64_t can_frames, serial_bytes; /* CAN frames and serial bytes that are not released */
};

/* Opens a queue. `event_fd`: an eventfd (-1: none). After link_queue_request_event has returned
 * false, the next item added to the queue is signalled on it. MR_FULL: no memory. */
enum mr_status link_queue_open(size_t capacity, int event_fd, struct link_queue **queue,
                               struct error *error);
void link_queue_close(struct link_queue *queue); /* NULL is allowed; no thread may be in a call */

/* ---- for the thread that reads the link ---- */

/* Both functions return false if there is no room. */
bool link_queue_put_frame(struct link_queue *queue, const struct link_frame *frame);
bool link_queue_put_bytes(struct link_queue *queue, const uint8_t *bytes, size_t length,
                          uint64_t host_us);
/* The next two functions add rare items, for which there is always room. */
void link_queue_put_counters(struct link_queue *queue, const struct link_counters *counters);
void link_queue_put_end(struct link_queue *queue, const struct error *reason);
/* Writes the eventfd if the other thread requested an event. Call it after each batch. */
void link_queue_signal(struct link_queue *queue);
/* Waits until a quarter of the queue is free. Returns false after link_queue_stop. */
bool link_queue_wait_for_room(struct link_queue *queue);
/* True if the queue was full and less than a quarter of it has been free since. */
bool link_queue_is_nearly_full(struct link_queue *queue);

/* ---- for the thread that writes the campaign ---- */

/* Reads the next item. Returns false if there is none. */
bool link_queue_read(struct link_queue *queue, struct link_item *item);
bool link_queue_has_unread(struct link_queue *queue);
/* As link_queue_has_unread. If it returns false, the next items are signalled on the eventfd. */
bool link_queue_request_event(struct link_queue *queue);
/* Releases the items read so far. Call it when they are stored. */
void link_queue_release(struct link_queue *queue);
/* Makes the items that were read and not released readable again. */
void link_queue_rewind(struct link_queue *queue);
/* As link_queue_rewind, also for all released items that the queue still has. Such items are
 * counted only once. */
void link_queue_rewind_all(struct link_queue *queue);
/* True if the queue still has every item that was ever appended. */
bool link_queue_is_complete(struct link_queue *queue);
/* Returns the Unix time of arrival of the oldest item in the queue, microseconds; 0: there is
 * none. */
uint64_t link_queue_oldest_us(struct link_queue *queue);
/* Adds a LINK_ITEM_CLOCK_JUMP after all items so far. */
void link_queue_put_clock_jump(struct link_queue *queue, int64_t jump_us);
/* Ends all waiting for room, now and in later calls. */
void link_queue_stop(struct link_queue *queue);

struct link_queue_depth link_queue_depth(struct link_queue *queue);

/* ---- the reader ----
 *
 * Reads a link into its queue, so that reading never waits for the thread that writes the campaign.
 *
 * A live link has a separate thread, which puts a time stamp on data as it arrives. When its queue
 * is full, all data is lost until a quarter is free again: the queued data stays complete, the gap
 * has one beginning and one end, and the link's counters show the cause (LINK_LOST_...). A link
 * whose sender can wait (link_blocks_sender) is not read meanwhile, and loses nothing. A recording
 * (link_is_from_recording) has no thread: it is read on request, so that the same files always give
 * the same campaign. */

#define LINK_READER_FRAMES_PER_READ 1024u /* maximum number of CAN frames read in one turn */

struct link_reader;

/* Returns the reason why the campaign is not being written at present: one of the LINK_LOST_
 * values. Called by the reader's thread. */
typedef enum link_fault link_loss_cause_finder(void *context);

/* Opens a reader. `link` must outlive it; from now on other code may call only link_send_... and
 * link_spec. `event_fd`: as for link_queue_open. `capacity`: bytes of the queue; 0: enough for
 * LINK_QUEUE_CAPACITY_S. */
enum mr_status link_reader_open(struct link *link, enum link_kind kind, size_t capacity,
                                int event_fd, link_loss_cause_finder *find_cause, void *context,
                                struct link_reader **reader, struct error *error);
/* Stops reading and waits for the thread; queued items are kept. */
void link_reader_stop(struct link_reader *reader);  /* NULL is allowed */
void link_reader_close(struct link_reader *reader); /* NULL is allowed */

struct link_queue *link_reader_queue(const struct link_reader *reader);

/* Returns the descriptor to wait for before link_reader_read. -1: a thread reads the link and
 * signals new data on `event_fd`. */
int link_reader_fd(const struct link_reader *reader);
/* Reads the next part of a recording. Returns true if more data may be available immediately. */
bool link_reader_read(struct link_reader *reader);
/* Returns the amount of data lost so far because the queue was full: CAN frames or serial bytes. */
uint64_t link_reader_lost_count(const struct link_reader *reader);
/* True if the queue is full and the sender is waiting. */
bool link_reader_is_blocked(const struct link_reader *reader);

#endif
