/* Between what is received and who watches: the newest of each message, a ring of events, and
 * orders the other way. For one thread that receives and any number that serve viewers; every
 * function locks for itself.
 *
 * The page keeps the state of the board: it gets the messages. Events are server-sent events as
 * they go out: messages 50 times a second, a change of the warning at once; readings 20 times, and
 * what the host knows of the links 5 times. The ring keeps a minute: a viewer that is new, or was
 * away, gets a snapshot (configuration, the newest of each message) and the readings of the ring. A
 * viewer that does not read costs nothing but its connection. */
#ifndef MATRIG_HOST_LIVE_HUB_H
#define MATRIG_HOST_LIVE_HUB_H

#include "host/collect/collect.h"

/* Where it comes from, for people. Owned by the caller. */
struct live_source {
    const char *db;
    const char *can, *serial; /* links; NULL: not used, or not known */
    bool commands;            /* arm and disarm can be given here */
    const char *no_commands;  /* why not, one line */
    bool si;
};

struct live_hub;

/* `source` must outlive the hub. */
enum mr_status live_hub_open(const struct live_source *source, struct live_hub **hub,
                             struct error *error);
/* No viewer may still be in a call: stop the server before. NULL is allowed. */
void live_hub_close(struct live_hub *hub);

/* A message of the board, as the collector has it; a block record. */
void live_hub_message(struct live_hub *hub, const struct collector_event *event);
void live_hub_record(struct live_hub *hub, const struct mr_block *record, int64_t host_us);
/* A line for people under "Events". */
void live_hub_notice(struct live_hub *hub, const char *words);
void live_hub_counts(struct live_hub *hub, enum link_kind kind,
                     const struct store_link_counts *counts);
/* Makes the events that are due. Call it 20 times a second or oftener. */
void live_hub_turn(struct live_hub *hub);

/* {"configuration", "messages", "state"}, to be freed; NULL: no memory. */
char *live_hub_snapshot(struct live_hub *hub);

/* ---- viewers ---- */

/* Where a viewer is; it begins with {.fresh = true}. */
struct live_viewer {
    uint64_t next;
    bool fresh; /* the snapshot and the ring's readings are to come first */
};
/* The text of the events to come, to be freed; waits up to `wait_ms` for one. NULL: none came. */
char *live_hub_next(struct live_hub *hub, struct live_viewer *viewer, int wait_ms, size_t *length);
/* The last event: how it ended, a line for people. Wakes all that wait; from now on nobody waits,
 * and there are no more orders. */
void live_hub_end(struct live_hub *hub, const char *why);
/* It has ended, and the viewer knows all. */
bool live_hub_ended(struct live_hub *hub, const struct live_viewer *viewer);

/* ---- orders ---- */

/* For viewers: hands an order over and waits for the board's answer. `until_us`: Unix time from
 * which on it must not be carried out. MR_OK: it was acknowledged with `*answer`; MR_TIMEOUT: not
 * within 3 s; MR_LIMIT: it is too old; MR_NOT_NOW: another one is under way, or none can be
 * given. */
enum mr_status live_hub_order(struct live_hub *hub, unsigned code, int32_t argument,
                              int64_t until_us, enum mr_status *answer);
/* For who holds the links: an order to be sent. */
bool live_hub_take_order(struct live_hub *hub, struct mr_command *command);

#endif
