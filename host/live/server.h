/* The live page, served over HTTP on a loopback address only.
 *
 *     GET /          the page; its scripts and styles (host/base/assets.c), /licences.txt
 *     GET /events    server-sent events (host/live/hub.h)
 *     GET /state     the snapshot as JSON
 *     POST /command  {"command": "arm" or "disarm", "landing": N, "until_us": T}, with the token in
 *                    X-Matrig-Token; refused from T (Unix time) on
 *
 * A request whose Host is not a name of this computer is refused. This prevents access by foreign
 * web pages through DNS rebinding. Commands need the token, which only the user who started the
 * program has seen, and must come from this page's origin. */
#ifndef MATRIG_HOST_LIVE_SERVER_H
#define MATRIG_HOST_LIVE_SERVER_H

#include "host/collect/collect.h"
#include "host/live/hub.h"

#define LIVE_PORT    8473
#define LIVE_URL_MAX 120

struct live_server;

/* Starts the server. `where`: port number as text; 0: any free port. MR_USAGE: not a port. */
enum mr_status live_server_open(const char *where, struct live_hub *hub,
                                struct live_server **server, struct error *error);
/* Returns the URL with the token after #, a part that browsers do not send. The server owns the
 * text. */
const char *live_server_url(const struct live_server *server);
/* Sends the viewers the reason `why`, waits at most half a second for them, and stops the server.
 * NULL is allowed. */
void live_server_close(struct live_server *server, const char *why);

/* ---- for matrig log: hub and server, fed by a collector ---- */

struct live {
    struct live_source source;
    struct live_hub *hub;
    struct live_server *server;
    struct collector_listener listener; /* to be passed to collector_set_listener */
};

/* Opens hub and server. `live` must not move afterwards; `where` as for live_server_open.
 * Everything that `source` points to must outlive it. */
enum mr_status live_open(struct live *live, const char *where, const struct live_source *source,
                         struct error *error);
/* Closes hub and server. `why`: as for live_hub_end. Also allowed if `live` was never opened and is
 * all zero. */
void live_close(struct live *live, const char *why);

/* Updates the counts of the links and publishes the events that are due. Call it at least 20 times
 * a second as long as data arrives. */
void live_update(struct live *live, const struct collector *collector);
/* Removes and returns an arm or disarm command to be sent to the board. */
bool live_pop_command(struct live *live, struct mr_command *command);

#endif
