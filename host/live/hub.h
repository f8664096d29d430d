/* Distribution of received data to viewers as a ring of events, and of the viewers' commands to the
 * board. One thread receives and any number of threads serve viewers; every function locks the hub.
 *
 * The page builds the state of the board from the messages that it receives. Events are stored as
 * server-sent events, ready to be sent. Messages are sent 50 times a second (a change of the
 * warning at once), readings 20 times a second, and the host's data about the links 5 times a
 * second. The ring keeps one minute. A viewer that is new or missed events gets a snapshot
 * (configuration, the newest message of each kind) and the readings in the ring. A viewer that does
 * not read takes no memory except its connection. */
#ifndef MATRIG_HOST_LIVE_HUB_H
#define MATRIG_HOST_LIVE_HUB_H

#include "host/collect/collect.h"

/* Source of the data, as shown on the page. The caller owns the texts. */
struct live_source {
    const char *db;
    const char *can, *serial;       /* LINK texts; NULL: not used, or not known */
    bool accepts_commands;          /* arm and disarm can be sent from the page */
    const char *no_commands_reason; /* reason why commands cannot be sent, one line */
    bool uses_si;
};

struct live_hub;

/* Opens a hub. `source` must outlive it. */
enum mr_status live_hub_open(const struct live_source *source, struct live_hub **hub,
                             struct error *error);
/* Closes a hub; NULL is allowed. No viewer may be in a call: stop the server first. */
void live_hub_close(struct live_hub *hub);

/* Adds a message that the board sent, or a block record. */
void live_hub_add_message(struct live_hub *hub, const struct collector_event *event);
void live_hub_add_record(struct live_hub *hub, const struct mr_block *record, int64_t host_us);
/* Adds a line to the page's list "Events". */
void live_hub_add_notice(struct live_hub *hub, const char *words);
/* Adds the outcome of the landing to the page's list "Events" and to the display of the warning. */
void live_hub_add_outcome(struct live_hub *hub, const char *words);
void live_hub_set_counts(struct live_hub *hub, enum link_kind kind,
                         const struct store_link_counts *counts);
/* Creates the events that are due. Call it at least 20 times a second. */
void live_hub_publish_due_events(struct live_hub *hub);

/* Returns {"configuration", "messages", "state"} as text, which the caller frees; NULL: no
 * memory. */
char *live_hub_snapshot(struct live_hub *hub);

/* ---- viewers ---- */

/* Position of a viewer in the ring; initialise it with {.needs_snapshot = true}. */
struct live_viewer {
    uint64_t next_event;
    bool needs_snapshot; /* send the snapshot and the ring's readings first */
};
/* Returns the text of the next events, which the caller frees. Waits up to `wait_ms` for an event.
 * NULL: there was none. */
char *live_hub_wait_event(struct live_hub *hub, struct live_viewer *viewer, int wait_ms,
                          size_t *length);
/* Adds the last event, whose text is the reason. All waiting calls return; later calls do not wait
 * and accept no commands. */
void live_hub_end(struct live_hub *hub, const char *why);
/* True if the hub has ended and the viewer has received everything. */
bool live_hub_has_ended(struct live_hub *hub, const struct live_viewer *viewer);

/* ---- commands ---- */

/* Sends a command for a viewer and waits for the board's answer. `until_us`: Unix time after which
 * the command must not be executed. MR_OK: the board answered with `*answer`. MR_TIMEOUT: no answer
 * within 3 s. MR_LIMIT: the command is too old. MR_NOT_NOW: another command is in progress, or
 * commands are not available. */
enum mr_status live_hub_send_command(struct live_hub *hub, unsigned code, int32_t argument,
                                     int64_t until_us, enum mr_status *answer);
/* Removes and returns a command, which the owner of the links must send. */
bool live_hub_pop_command(struct live_hub *hub, struct mr_command *command);

#endif
