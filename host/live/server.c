#include "host/live/server.h"

#include <arpa/inet.h>
#include <errno.h>
#include <microhttpd.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <time.h>

#include "common/command.h"
#include "host/board/arm_client.h"
#include "host/base/assets.h"

#define CONNECTIONS_MAX        64u
/* an idle connection ends after this time, and so does an event stream whose viewer does not
 * read */
#define CONNECTION_TIMEOUT_S   15u
#define HEARTBEAT_PERIOD_MS    1000
#define END_EVENT_TIMEOUT_MS   500 /* time that viewers have to receive the last event */
#define END_POLL_MS            5
#define COMMAND_BODY_BYTES_MAX 1000u
#define CHUNK_BYTES            65536u
#define TOKEN_BYTES            16u
#define LANDING_NUMBER_MAX     65535

struct live_server {
    struct live_hub *hub;
    struct MHD_Daemon *daemon;
    _Atomic unsigned stream_count;
    char token[2 * TOKEN_BYTES + 1];
    char url[LIVE_URL_MAX];
};

struct command_request {
    char body[COMMAND_BODY_BYTES_MAX + 1];
    size_t length;
    bool is_too_long;
};

struct event_stream {
    struct live_server *server;
    struct live_hub *hub;
    struct live_viewer viewer;
    char *text; /* text of which a part is being sent */
    size_t length, sent_length;
};

/* ---- answers ---- */

static enum MHD_Result send_response(struct MHD_Connection *connection, unsigned code,
                                     struct MHD_Response *response, const char *type)
{
    if (!response)
        return MHD_NO;
    MHD_add_response_header(response, "Content-Type", type);
    MHD_add_response_header(response, "Cache-Control", "no-store");
    MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    MHD_add_response_header(response, "Referrer-Policy", "no-referrer");
    MHD_add_response_header(response, "Cross-Origin-Resource-Policy", "same-origin");
    MHD_add_response_header(response, "Content-Security-Policy",
                            "default-src 'none'; script-src 'self'; style-src 'self'; connect-src "
                            "'self'; img-src 'self' data:; "
                            "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    enum MHD_Result result = MHD_queue_response(connection, code, response);
    MHD_destroy_response(response);
    return result;
}

static enum MHD_Result respond_text(struct MHD_Connection *connection, unsigned code,
                                    const char *text)
{
    return send_response(connection, code,
                         MHD_create_response_from_buffer(strlen(text), (void *)(uintptr_t)text,
                                                         MHD_RESPMEM_MUST_COPY),
                         "text/plain; charset=utf-8");
}

/* Sends `text` and frees it. */
static enum MHD_Result respond_json(struct MHD_Connection *connection, unsigned code, char *text)
{
    if (!text)
        return respond_text(connection, MHD_HTTP_SERVICE_UNAVAILABLE, "no memory\n");
    return send_response(connection, code,
                         MHD_create_response_from_buffer(strlen(text), text, MHD_RESPMEM_MUST_FREE),
                         "application/json");
}

static const char *get_request_header(struct MHD_Connection *connection, const char *name)
{
    return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
}

/* Accepts only requests whose Host is a name of this computer. Any port is accepted, because a
 * tunnel may use another one. */
static bool is_local_host(const char *host)
{
    static const char *const ours[] = {"127.0.0.1", "localhost"};
    for (size_t i = 0; host && i < sizeof ours / sizeof ours[0]; i++) {
        size_t length = strlen(ours[i]);
        if (strncasecmp(host, ours[i], length) == 0 &&
            (host[length] == '\0' || host[length] == ':') &&
            (host[length] == '\0' ||
             strspn(host + length + 1, "0123456789") == strlen(host + length + 1)))
            return true;
    }
    return false;
}

/* Compares the token in constant time, so that the time does not reveal how much of a wrong token
 * is right. */
static bool is_token_valid(const struct live_server *server, const char *token)
{
    unsigned differ = 0;
    if (!token || strlen(token) != 2 * TOKEN_BYTES)
        return false;
    for (size_t i = 0; i < 2 * TOKEN_BYTES; i++)
        differ |= (unsigned)(unsigned char)token[i] ^ (unsigned)(unsigned char)server->token[i];
    return differ == 0;
}

/* ---- events ---- */

static ssize_t stream_read(void *context, uint64_t position, char *out, size_t most)
{
    struct event_stream *stream = context;
    (void)position;
    if (!stream->text) {
        stream->sent_length = 0;
        stream->text = live_hub_wait_event(stream->hub, &stream->viewer, HEARTBEAT_PERIOD_MS,
                                           &stream->length);
    }
    if (!stream->text && live_hub_has_ended(stream->hub, &stream->viewer))
        return MHD_CONTENT_READER_END_OF_STREAM;
    /* While there is no event, send a comment line: sending detects closed connections. */
    if (!stream->text) {
        memcpy(out, ":\n\n", 3);
        return 3;
    }
    size_t length = stream->length - stream->sent_length < most
                      ? stream->length - stream->sent_length
                      : most;
    memcpy(out, stream->text + stream->sent_length, length);
    stream->sent_length += length;
    if (stream->sent_length == stream->length) {
        free(stream->text);
        stream->text = NULL;
    }
    return (ssize_t)length;
}

static void stream_free(void *context)
{
    struct event_stream *stream = context;
    stream->server->stream_count--;
    free(stream->text);
    free(stream);
}

static enum MHD_Result serve_events(struct live_server *server, struct MHD_Connection *connection)
{
    struct event_stream *stream = calloc(1, sizeof *stream);
    if (!stream)
        return respond_text(connection, MHD_HTTP_SERVICE_UNAVAILABLE, "no memory\n");
    stream->server = server;
    server->stream_count++;
    stream->hub = server->hub;
    stream->viewer.needs_snapshot = true;
    struct MHD_Response *response = MHD_create_response_from_callback(
        MHD_SIZE_UNKNOWN, CHUNK_BYTES, stream_read, stream, stream_free);
    if (!response)
        stream_free(stream);
    return send_response(connection, MHD_HTTP_OK, response, "text/event-stream");
}

/* ---- commands ---- */

/* Executes the command in the body; `json` receives the reply. Returns the HTTP code. */
static unsigned run_command(struct live_server *server, const json_t *body, json_t *json)
{
    const char *name = json_string_value(json_object_get(body, "command"));
    json_t *landing = json_object_get(body, "landing"), *until = json_object_get(body, "until_us");
    bool arm = name && strcmp(name, "arm") == 0, disarm = name && strcmp(name, "disarm") == 0;
    json_int_t number = json_integer_value(landing);
    enum mr_status of_board = MR_OK;
    char refused[200];
    if ((!arm && !disarm) || (landing && (!json_is_integer(landing) || !arm)) || number < 0 ||
        number > LANDING_NUMBER_MAX || !json_is_integer(until)) {
        json_object_set_new(
            json, "error",
            json_string("invalid command; give command (arm or disarm), until_us (time limit for "
                        "the execution) and, optionally for arm, landing (0 to 65535)"));
        return MHD_HTTP_BAD_REQUEST;
    }
    enum mr_status status =
        live_hub_send_command(server->hub, arm ? MR_COMMAND_ARM : MR_COMMAND_DISARM,
                              (int32_t)number, json_integer_value(until), &of_board);
    snprintf(refused, sizeof refused, "refused: %s", arm_client_refusal_text(of_board));
    const char *error = status == MR_TIMEOUT ? "the board did not answer within 3 s"
                      : status == MR_LIMIT
                          ? "the time limit of the command has passed: repeat the command"
                      : status != MR_OK
                          ? "another command is in progress, or this page cannot send commands"
                      : of_board != MR_OK ? refused
                                          : NULL;
    json_object_set_new(json, "done", json_boolean(!error));
    if (error)
        json_object_set_new(json, "error", json_string(error));
    return status == MR_TIMEOUT ? MHD_HTTP_GATEWAY_TIMEOUT
         : error                ? MHD_HTTP_CONFLICT
                                : MHD_HTTP_OK;
}

static enum MHD_Result serve_command(struct live_server *server, struct MHD_Connection *connection,
                                     const struct command_request *request)
{
    const char *origin = get_request_header(connection, "Origin"),
               *type = get_request_header(connection, "Content-Type");
    const char *host = get_request_header(connection, "Host");
    bool elsewhere = origin &&
                     (strncmp(origin, "http://", 7) != 0 || strcasecmp(origin + 7, host) != 0);
    if (elsewhere || !type || strncasecmp(type, "application/json", 16) != 0)
        return respond_text(connection, MHD_HTTP_FORBIDDEN,
                            "commands are accepted only from the live page, as JSON\n");
    if (!is_token_valid(server, get_request_header(connection, "X-Matrig-Token")))
        return respond_text(
            connection, MHD_HTTP_FORBIDDEN,
            "the command has no valid token: open the address that matrig printed\n");
    if (request->is_too_long)
        return respond_text(connection, MHD_HTTP_CONTENT_TOO_LARGE, "the command is too long\n");
    json_t *json = json_object(), *body = json_loadb(request->body, request->length, 0, NULL);
    unsigned code = run_command(server, body, json);
    char *text = json_dumps(json, JSON_COMPACT);
    json_decref(body);
    json_decref(json);
    return respond_json(connection, code, text);
}

/* ---- requests ---- */

static enum MHD_Result serve_get(struct live_server *server, struct MHD_Connection *connection,
                                 const char *url)
{
    const struct asset *asset = asset_find(url);
    if (asset)
        return send_response(connection, MHD_HTTP_OK,
                             MHD_create_response_from_buffer((size_t)(asset->end - asset->bytes),
                                                             (void *)(uintptr_t)asset->bytes,
                                                             MHD_RESPMEM_PERSISTENT),
                             asset->type);
    if (strcmp(url, "/events") == 0)
        return serve_events(server, connection);
    if (strcmp(url, "/state") == 0)
        return respond_json(connection, MHD_HTTP_OK, live_hub_snapshot(server->hub));
    return respond_text(connection, MHD_HTTP_NOT_FOUND, "no such page\n");
}

static void append_body(struct command_request *request, const char *data, size_t size)
{
    request->is_too_long = request->is_too_long || size > COMMAND_BODY_BYTES_MAX - request->length;
    if (request->is_too_long)
        return;
    memcpy(request->body + request->length, data, size);
    request->length += size;
}

static enum MHD_Result serve_request(void *context, struct MHD_Connection *connection,
                                     const char *url, const char *method, const char *version,
                                     const char *data, size_t *size, void **kept)
{
    struct live_server *server = context;
    struct command_request *request = *kept;
    (void)version;
    if (!request) { /* only the headers have arrived, not the body */
        *kept = calloc(1, sizeof *request);
        return *kept ? MHD_YES : MHD_NO;
    }
    if (*size > 0) {
        append_body(request, data, *size);
        *size = 0;
        return MHD_YES;
    }
    if (!is_local_host(get_request_header(connection, "Host")))
        return respond_text(
            connection, MHD_HTTP_FORBIDDEN,
            "the live page is served only to this computer: use 127.0.0.1, or an ssh tunnel\n");
    bool post = strcmp(method, "POST") == 0 && strcmp(url, "/command") == 0;
    if (!post && strcmp(method, "GET") != 0)
        return respond_text(connection, MHD_HTTP_METHOD_NOT_ALLOWED,
                            "the method is not supported: use GET, or POST to /command\n");
    return post ? serve_command(server, connection, request) : serve_get(server, connection, url);
}

static void free_request(void *context, struct MHD_Connection *connection, void **kept,
                         enum MHD_RequestTerminationCode why)
{
    (void)context;
    (void)connection;
    (void)why;
    free(*kept);
    *kept = NULL;
}

/* ---- opening ---- */

static void make_token(struct live_server *server)
{
    unsigned char bytes[TOKEN_BYTES];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        abort(); /* do not continue without a secret token: any program could arm the board */
    for (size_t i = 0; i < TOKEN_BYTES; i++)
        snprintf(server->token + 2 * i, 3, "%02x", bytes[i]);
}

static struct MHD_Daemon *start_daemon(struct live_server *server,
                                       const struct sockaddr_in *address)
{
    return MHD_start_daemon(
        MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_THREAD_PER_CONNECTION | MHD_USE_POLL, 0, NULL,
        NULL, serve_request, server, MHD_OPTION_SOCK_ADDR, address, MHD_OPTION_CONNECTION_LIMIT,
        CONNECTIONS_MAX, MHD_OPTION_CONNECTION_TIMEOUT, CONNECTION_TIMEOUT_S,
        MHD_OPTION_NOTIFY_COMPLETED, free_request, server, MHD_OPTION_END);
}

enum mr_status live_server_open(const char *where, struct live_hub *hub,
                                struct live_server **server, struct error *error)
{
    char *end;
    long number = strtol(where, &end, 10);
    if (*where < '0' || *where > '9' || *end || number > 65535)
        return error_set(
            error, MR_USAGE,
            "not a port: '%s'; give 1 to 65535, or 0 for any free port. The page is served only on "
            "127.0.0.1; from other computers use ssh -L 8473:127.0.0.1:8473",
            where);
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
                                        .sin_port = htons((uint16_t)number)};
    struct live_server *made = calloc(1, sizeof *made);
    if (!made)
        return error_set(error, MR_FULL, "out of memory for the live page; close other programs");
    made->hub = hub;
    make_token(made);
    made->daemon = start_daemon(made, &address);
    if (!made->daemon) {
        int code = errno;
        free(made);
        return error_set(error, MR_IO,
                         "cannot serve the live page at %s (%s); another matrig may use this port: "
                         "give a different port, or 0",
                         where, code ? strerror(code) : "no reason given");
    }
    const union MHD_DaemonInfo *info = MHD_get_daemon_info(made->daemon, MHD_DAEMON_INFO_BIND_PORT);
    snprintf(made->url, sizeof made->url, "http://127.0.0.1:%u/#%s", info ? info->port : 0u,
             made->token);
    *server = made;
    return MR_OK;
}

const char *live_server_url(const struct live_server *server)
{
    return server->url;
}

void live_server_close(struct live_server *server, const char *why)
{
    if (!server)
        return;
    live_hub_end(server->hub, why);
    for (int ms = 0; ms < END_EVENT_TIMEOUT_MS && server->stream_count > 0; ms += END_POLL_MS)
        nanosleep(&(const struct timespec){.tv_nsec = END_POLL_MS * 1000000l}, NULL);
    MHD_stop_daemon(server->daemon);
    free(server);
}

/* ---- interface for matrig log ---- */

static void add_message(void *context, const struct collector_event *event)
{
    struct live *live = context;
    live_hub_add_message(live->hub, event);
}

static void add_record(void *context, const struct mr_block *block, uint64_t host_us)
{
    struct live *live = context;
    live_hub_add_record(live->hub, block, (int64_t)host_us);
}

enum mr_status live_open(struct live *live, const char *where, const struct live_source *source,
                         struct error *error)
{
    live->source = *source;
    live->listener = (struct collector_listener){add_message, add_record, live};
    enum mr_status status = live_hub_open(&live->source, &live->hub, error);
    return status == MR_OK ? live_server_open(where, live->hub, &live->server, error) : status;
}

void live_close(struct live *live, const char *why)
{
    live_server_close(live->server, why);
    live_hub_close(live->hub);
    live->server = NULL;
    live->hub = NULL;
}

void live_update(struct live *live, const struct collector *collector)
{
    struct collector_progress progress;
    if (!live->hub)
        return;
    collector_get_progress(collector, &progress);
    for (int kind = 0; kind < LINK_KINDS; kind++)
        live_hub_set_counts(live->hub, (enum link_kind)kind, &progress.counts[kind]);
    live_hub_publish_due_events(live->hub);
}

bool live_pop_command(struct live *live, struct mr_command *command)
{
    return live->hub && live_hub_pop_command(live->hub, command);
}
