/* The live page, served over HTTP on a loopback address, and on no other.
 *
 *     GET  /          the page; its scripts and styles (host/base/assets.c), /licences.txt
 *     GET  /events    server-sent events (host/live/hub.h)
 *     GET  /state     the snapshot as JSON
 *     POST /command   {"command": "arm" or "disarm", "landing": N, "until_us": T}, with the token
 *                     in X-Matrig-Token; refused from T (Unix time) on
 *
 * A request whose Host is not a name of this computer is refused: a page from elsewhere that made
 * its own name point here (DNS rebinding) gets nothing. Commands need the token, which only who
 * started the program has seen, and come from this page's origin. */
#ifndef MATRIG_HOST_LIVE_SERVER_H
#define MATRIG_HOST_LIVE_SERVER_H

#include "host/collect/collect.h"
#include "host/live/hub.h"

#define LIVE_PORT    8473
#define LIVE_URL_MAX 120

struct live_server;

/* A port; 0: any that is free. MR_USAGE: no such thing. */
enum mr_status live_server_open(const char *where, struct live_hub *hub,
                                struct live_server **server, struct error *error);
/* With the token behind #, which browsers keep to themselves. Static in the server. */
const char *live_server_url(const struct live_server *server);
/* Tells the viewers how it ended, half a second at most, then serves no more. NULL is allowed. */
void live_server_close(struct live_server *server, const char *why);

/* ---- for matrig log: hub and server, fed by a collector ---- */

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
/* `why`: as live_hub_end; also of one that was never opened, all zero. */
void live_close(struct live *live, const char *why);

/* Counts and events that are due: call it 20 times a second or oftener, as long as something
 * comes. */
void live_turn(struct live *live, const struct collector *collector);
/* Arm or disarm, to be sent to the board. */
bool live_take_order(struct live *live, struct mr_command *command);

#endif
