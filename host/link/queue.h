/* What came over one link and is not in the campaign yet, in order of arrival: a bounded queue in
 * memory between the thread that reads the link and the one that writes. One thread puts, one
 * takes; each function locks for itself.
 *
 * What was taken stays until link_queue_release: a transaction that failed is written again after
 * link_queue_rewind. Of what was released the newest part is kept for the case that the campaign
 * itself is lost: link_queue_rewind_all. */
#ifndef MATRIG_HOST_LINK_QUEUE_H
#define MATRIG_HOST_LINK_QUEUE_H

#include "host/link/link.h"

/* 60 s of a full link. An item takes LINK_QUEUE_ITEM bytes and its content in steps of 8.
 *   CAN: 1 Mbit/s carries at most 9,009 frames/s of 8 bytes (111 bits without stuffing): 24 bytes
 *   each, 13.0 MB. serial: 2 Mbaud carry 200,000 bytes/s; with up to 5,000 reads a second (40 bytes
 *   a read: adapters hand over 32 to 512) 24 bytes are added to each: 19.2 MB.
 * Memory is taken as the queue grows, and given back as it empties, but for a part of the capacity:
 * the newest of what was released, 30 s of a full link. */
#define LINK_QUEUE_S            60u
#define LINK_QUEUE_ITEM         16u
#define LINK_QUEUE_CAN_BYTES    (LINK_QUEUE_S * 9009u * (LINK_QUEUE_ITEM + 8u))
#define LINK_QUEUE_SERIAL_BYTES (LINK_QUEUE_S * (200000u + 5000u * (LINK_QUEUE_ITEM + 8u)))

#define LINK_QUEUE_HISTORY 2u /* this part of the capacity */

#define LINK_QUEUE_READ_MAX 16384u /* bytes of one item */

struct link_queue;

enum link_item_kind {
    LINK_ITEM_FRAME,    /* of CAN */
    LINK_ITEM_BYTES,    /* of serial, read together */
    LINK_ITEM_COUNTERS, /* of the link, before what came after they changed */
    LINK_ITEM_CLOCK,    /* this computer's clock was set: stamps from here on are by the new time */
    LINK_ITEM_END,      /* of the link; nothing comes after it */
};

struct link_item {
    enum link_item_kind kind;
    bool again; /* was taken before: a rewind brought it back */
    struct link_frame frame;
    uint64_t host_us;     /* of the bytes: when they were read, Unix time */
    const uint8_t *bytes; /* valid until the release */
    size_t length;
    struct link_counters counters;
    int64_t jump_us;  /* of the clock */
    struct error end; /* why; MR_OK: it was the end */
};

struct link_queue_depth {
    size_t bytes, capacity;  /* of memory */
    uint64_t frames, octets; /* of CAN, of serial, that are not released */
};

/* `news`: an eventfd that is written to when something is put and link_queue_listen said nothing
 * was there; -1: none. MR_FULL: no memory. */
enum mr_status link_queue_open(size_t capacity, int news, struct link_queue **queue,
                               struct error *error);
void link_queue_close(struct link_queue *queue); /* NULL is allowed; nobody may be in a call */

/* ---- for the thread that reads ---- */

/* False: no room. */
bool link_queue_put_frame(struct link_queue *queue, const struct link_frame *frame);
bool link_queue_put_bytes(struct link_queue *queue, const uint8_t *bytes, size_t length,
                          uint64_t host_us);
/* These few always find room. */
void link_queue_put_counters(struct link_queue *queue, const struct link_counters *counters);
void link_queue_put_end(struct link_queue *queue, const struct error *reason);
/* Wakes the thread that takes, if it listens. After each batch. */
void link_queue_wake(struct link_queue *queue);
/* Waits until a quarter is free, or link_queue_stop: then false. */
bool link_queue_wait_for_room(struct link_queue *queue);
/* It was full, and less than a quarter is free since. */
bool link_queue_is_tight(struct link_queue *queue);

/* ---- for the thread that takes ---- */

/* False: nothing is there. */
bool link_queue_take(struct link_queue *queue, struct link_item *item);
bool link_queue_unread(struct link_queue *queue);
/* As link_queue_unread; when false, what is put from now on is told by the eventfd. */
bool link_queue_listen(struct link_queue *queue);
/* What was taken is written. */
void link_queue_release(struct link_queue *queue);
/* What was taken and not released is taken again. */
void link_queue_rewind(struct link_queue *queue);
/* The same, with all that is kept of what was released. It counts as not written again. */
void link_queue_rewind_all(struct link_queue *queue);
/* All that was ever put is kept. */
bool link_queue_is_whole(struct link_queue *queue);
/* When the oldest of it came, Unix time, microseconds; 0: nothing is kept. */
uint64_t link_queue_oldest_us(struct link_queue *queue);
/* Behind all that was put so far. */
void link_queue_put_clock(struct link_queue *queue, int64_t jump_us);
/* Nobody waits for room from now on. */
void link_queue_stop(struct link_queue *queue);

struct link_queue_depth link_queue_depth(struct link_queue *queue);

/* ---- the reader ----
 *
 * Reads a link into its queue, so that nothing of it waits for whoever writes.
 *
 * A link of the world outside has a thread of its own, that stamps what comes as it comes; when its
 * queue is full, what comes until a quarter is free again is lost: what is in the queue stays
 * whole, the gap has one beginning and one end, and the link's counters say by what
 * (LINK_LOST_...). One whose sender can wait (link_waits) is not read meanwhile. A recording
 * (link_recorded) has no thread: it is read when asked for, so that the same files give the same
 * campaign each time. */

#define READER_FRAMES 1024u /* of CAN that are read in one turn */

struct link_reader;

/* Why nothing is written now: one of the LINK_LOST_ troubles. Called by the reader's thread. */
typedef enum link_trouble link_blame(void *context);

/* `link` must outlive the reader; from now on only link_send_... and link_spec may be called by
 * others. `news` as link_queue_open; `capacity`: bytes of the queue, 0: for LINK_QUEUE_S. */
enum mr_status link_reader_open(struct link *link, enum link_kind kind, size_t capacity, int news,
                                link_blame *blame, void *context, struct link_reader **reader,
                                struct error *error);
/* Reads no more; what is in the queue stays. Waits for the thread. */
void link_reader_stop(struct link_reader *reader);  /* NULL is allowed */
void link_reader_close(struct link_reader *reader); /* NULL is allowed */

struct link_queue *link_reader_queue(const struct link_reader *reader);

/* -1: a thread reads it, and tells by `news`. Else what to wait for until it can be read, then
 * link_reader_turn. */
int link_reader_fd(const struct link_reader *reader);
/* Reads a turn's worth of a recording. True: there may be more at once. */
bool link_reader_turn(struct link_reader *reader);
/* What was lost so far because the queue was full: frames of CAN, bytes of serial. */
uint64_t link_reader_lost(const struct link_reader *reader);
/* The queue is full, and the sender is made to wait. */
bool link_reader_holds_up(const struct link_reader *reader);

#endif
