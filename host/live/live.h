/* A live view of what a collector receives: model, hub and page in one, for the program that holds
 * the links. */
#ifndef MATRIG_HOST_LIVE_LIVE_H
#define MATRIG_HOST_LIVE_LIVE_H

#include "host/collect/collect.h"
#include "host/live/hub.h"
#include "host/live/server.h"

struct live {
    struct live_source source;
    struct live_hub *hub;
    struct live_server *server;
    struct collector_listener listener; /* give it to collector_listen */
};

/* `live` stays where it is; `where` as live_server_open. What `source` points to must outlive
 * it. */
enum mr_status live_open(struct live *live, const char *where, const struct live_source *source,
                         struct error *error);
void live_close(struct live *live); /* also of one that was never opened, all zero */

/* Counts and events that are due: call it 20 times a second or oftener, as long as something
 * comes. */
void live_turn(struct live *live, const struct collector *collector);
/* Arm or disarm, to be sent to the board. */
bool live_take_order(struct live *live, struct mr_command *command);

#endif
