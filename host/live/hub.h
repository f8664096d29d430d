/* Between what is received and who watches: the model, a ring of events, and commands the other
 * way. For one thread that receives and any number that serve viewers; every function locks for
 * itself.
 *
 * Events are server-sent events as they go out. A state goes out at once when something happens
 * that must be seen, else five times a second; readings 20 times a second. The ring keeps a minute:
 * a viewer that was away goes on where it was, one that was away longer, or is new, gets the
 * configuration, the readings of the ring and the state. A viewer that does not read costs nothing
 * but its place. */
#ifndef MATRIG_HOST_LIVE_HUB_H
#define MATRIG_HOST_LIVE_HUB_H

#include "host/live/json.h"
#include "host/live/model.h"

struct live_hub;

/* `source` must outlive the hub. */
enum mr_status live_hub_open(const struct live_source *source, struct live_hub **hub,
                             struct error *error);
/* No viewer may still be in a call: stop the server before. NULL is allowed. */
void live_hub_close(struct live_hub *hub);

/* As live_model_message and its like. What must be seen at once is an event when the call
 * returns. */
void live_hub_message(struct live_hub *hub, const struct collector_event *event);
void live_hub_record(struct live_hub *hub, const struct mr_block *record, int64_t host_us);
void live_hub_counts(struct live_hub *hub, enum link_kind kind,
                     const struct store_link_counts *counts, int64_t host_us);
/* Frames by now that are not the board's, on its identifiers: a notice when there are more. */
void live_hub_strangers(struct live_hub *hub, int64_t count, int64_t host_us);
/* Makes the events that are due. Call it 20 times a second or oftener. */
void live_hub_turn(struct live_hub *hub);

/* A copy of the model; the caller gives the place. */
void live_hub_look(struct live_hub *hub, struct live_model *model);
bool live_hub_lacks_calibration(struct live_hub *hub); /* live_model_lacks_calibration */
char *live_hub_state(struct live_hub *hub);            /* JSON, to be freed; NULL: no memory */

/* ---- viewers ---- */

/* Where a viewer is. `last`: the Last-Event-ID it came back with; NULL: it is new. */
struct live_viewer {
    uint64_t next;
    bool fresh; /* configuration, the ring's readings and the state are to come first */
};
void live_hub_viewer(struct live_hub *hub, const char *last, struct live_viewer *viewer);
/* The text of the events to come, to be freed; waits up to `wait_ms` for one. NULL: none came. */
char *live_hub_next(struct live_hub *hub, struct live_viewer *viewer, int wait_ms, size_t *length);
/* Wakes all that wait; from now on nobody waits. */
void live_hub_end(struct live_hub *hub);
bool live_hub_ended(struct live_hub *hub);
/* Waits up to `wait_ms` for that. True: it has ended. */
bool live_hub_wait_end(struct live_hub *hub, int wait_ms);

/* ---- commands ---- */

/* For viewers: hands a command over and waits for the board's answer. MR_OK: it was acknowledged
 * with `*answer`; MR_TIMEOUT: not within 3 s; MR_NOT_NOW: another one is under way, or none can be
 * given. */
enum mr_status live_hub_command(struct live_hub *hub, unsigned code, int32_t argument,
                                enum mr_status *answer);
/* For who holds the links: a command to be sent. */
bool live_hub_take_command(struct live_hub *hub, struct mr_command *command);

#endif
