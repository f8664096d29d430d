/* Reads a link into its queue, so that nothing of it waits for whoever writes.
 *
 * A link of the world outside has a thread of its own, that stamps what comes as it comes; when its
 * queue is full, what comes until a quarter is free again is lost: what is in the queue stays
 * whole, the gap has one beginning and one end, and the link's counters say by what
 * (LINK_LOST_...). One whose sender can wait (link_waits) is not read meanwhile. A recording
 * (link_recorded) has no thread: it is read when asked for, so that the same files give the same
 * campaign each time. */
#ifndef MATRIG_HOST_LINK_READER_H
#define MATRIG_HOST_LINK_READER_H

#include "host/link/queue.h"

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
