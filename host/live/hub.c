#include "host/live/hub.h"

#include <errno.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

#include "host/board/armtalk.h"
#include "host/base/steady.h"

/* a minute: 20 of readings and 5 of state a second, and some at once */
#define EVENTS           1600u
#define EVENT_BYTES      0x300000u /* of all together */
#define READINGS_MS      50
#define STATE_MS         200
#define AT_ONCE_MS       20 /* between two states, however much happens; a warning does not wait */
#define BUCKETS_AN_EVENT 64
#define FIRST_TAG        0x7601u

enum event_kind { EVENT_CONFIGURATION, EVENT_STATE, EVENT_READINGS };

struct event {
    enum event_kind kind;
    char *text;
    size_t length;
};

struct live_hub {
    pthread_mutex_t lock;
    pthread_cond_t news;
    const struct live_source *source;
    struct live_model model;
    uint32_t run; /* of this hub: ids of another one say nothing here */
    struct event event[EVENTS];
    uint64_t first, next; /* events held: first to next - 1, event[i % EVENTS] */
    size_t bytes;
    uint64_t configured, changes, restarts; /* of the model, told */
    bool warned;
    int64_t readings_ms, state_ms; /* when they were told last */
    bool ended;

    struct mr_command command;
    bool waiting, sent, answered; /* a command: asked for; taken; acknowledged */
    enum mr_status answer;
    uint16_t tag;
};

static struct timespec after_ms(int wait_ms)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += wait_ms / 1000;
    until.tv_nsec += wait_ms % 1000 * 1000000l;
    if (until.tv_nsec >= 1000000000l) {
        until.tv_sec++;
        until.tv_nsec -= 1000000000l;
    }
    return until;
}

enum mr_status live_hub_open(const struct live_source *source, struct live_hub **hub,
                             struct error *error)
{
    struct live_hub *made = calloc(1, sizeof *made);
    pthread_condattr_t steady;
    if (!made)
        return error_set(error, MR_FULL, "no memory: the live view; close other programs");
    json_object_seed(0); /* else the first objects of two threads at once would both do it */
    pthread_mutex_init(&made->lock, NULL);
    pthread_condattr_init(&steady);
    pthread_condattr_setclock(&steady, CLOCK_MONOTONIC);
    pthread_cond_init(&made->news, &steady);
    pthread_condattr_destroy(&steady);
    made->source = source;
    made->tag = FIRST_TAG;
    made->configured = UINT64_MAX;
    if (getrandom(&made->run, sizeof made->run, GRND_NONBLOCK) != (ssize_t)sizeof made->run)
        made->run = (uint32_t)steady_ms();
    live_model_start(&made->model, source->can != NULL, source->serial != NULL);
    *hub = made;
    return MR_OK;
}

static void drop_oldest(struct live_hub *hub)
{
    struct event *event = &hub->event[hub->first++ % EVENTS];
    hub->bytes -= event->length;
    free(event->text);
    event->text = NULL;
}

void live_hub_close(struct live_hub *hub)
{
    if (!hub)
        return;
    while (hub->first < hub->next)
        drop_oldest(hub);
    pthread_cond_destroy(&hub->news);
    pthread_mutex_destroy(&hub->lock);
    free(hub);
}

/* An event as it goes out; frees `json`. NULL: no memory. */
static char *event_text(const struct live_hub *hub, enum event_kind kind, char *json, uint64_t id)
{
    static const char *const names[] = {"configuration", "state", "readings"};
    char *text = NULL;
    if (json && asprintf(&text, "event: %s\nid: %08" PRIx32 "-%" PRIu64 "\ndata: %s\n\n",
                         names[kind], hub->run, id, json) < 0)
        text = NULL;
    free(json);
    return text;
}

static void publish(struct live_hub *hub, enum event_kind kind, char *json)
{
    char *text = event_text(hub, kind, json, hub->next);
    if (!text)
        return; /* no memory: the next one tells it again */
    size_t length = strlen(text);
    while (hub->first < hub->next &&
           (hub->next - hub->first == EVENTS || hub->bytes + length > EVENT_BYTES))
        drop_oldest(hub);
    hub->event[hub->next++ % EVENTS] = (struct event){kind, text, length};
    hub->bytes += length;
    pthread_cond_broadcast(&hub->news);
}

static char *dumped(json_t *json)
{
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(json);
    return text;
}

static void publish_readings(struct live_hub *hub)
{
    struct live_bucket buckets[BUCKETS_AN_EVENT];
    unsigned count;
    hub->readings_ms = steady_ms();
    while ((count = live_model_take(&hub->model, buckets, BUCKETS_AN_EVENT)) > 0)
        publish(hub, EVENT_READINGS, live_json_buckets(hub->run, hub->restarts, buckets, count));
}

static void publish_state(struct live_hub *hub)
{
    hub->state_ms = steady_ms();
    hub->changes = hub->model.changes;
    hub->warned = hub->model.warning.on;
    publish(hub, EVENT_STATE, dumped(live_json_state(&hub->model, (int64_t)link_now_us())));
}

/* What is due. Locked by the caller. */
static void turn(struct live_hub *hub)
{
    int64_t now = steady_ms();
    bool warning = hub->model.warning.on != hub->warned;
    if (hub->model.restarts != hub->restarts) {
        /* what was read before belongs to the boot before */
        publish_readings(hub);
        hub->restarts = hub->model.restarts;
    }
    if (warning || (hub->model.changes != hub->changes && now - hub->state_ms >= AT_ONCE_MS) ||
        now - hub->state_ms >= STATE_MS) {
        if (hub->model.configured != hub->configured) {
            hub->configured = hub->model.configured;
            publish(hub, EVENT_CONFIGURATION,
                    dumped(live_json_configuration(&hub->model, hub->source)));
        }
        publish_state(hub);
    }
    if (now - hub->readings_ms >= READINGS_MS) {
        live_model_settle(&hub->model);
        publish_readings(hub);
    }
}

void live_hub_turn(struct live_hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    turn(hub);
    pthread_mutex_unlock(&hub->lock);
}

void live_hub_message(struct live_hub *hub, const struct collector_event *event)
{
    pthread_mutex_lock(&hub->lock);
    uint64_t acks = hub->model.acks;
    live_model_message(&hub->model, event);
    if (hub->model.acks != acks && hub->sent && !hub->answered &&
        hub->model.ack.tag == hub->command.tag) {
        hub->answered = true;
        hub->answer = (enum mr_status)hub->model.ack.status;
        pthread_cond_broadcast(&hub->news);
    }
    if (hub->model.warning.on != hub->warned || hub->model.restarts != hub->restarts)
        turn(hub);
    if (hub->model.closed_count >= BUCKETS_AN_EVENT)
        publish_readings(hub);
    pthread_mutex_unlock(&hub->lock);
}

void live_hub_record(struct live_hub *hub, const struct mr_block *record, int64_t host_us)
{
    pthread_mutex_lock(&hub->lock);
    live_model_record(&hub->model, record, host_us);
    if (hub->model.restarts != hub->restarts)
        turn(hub);
    /* a campaign that is gone through faster than turns come */
    if (hub->model.closed_count >= BUCKETS_AN_EVENT)
        publish_readings(hub);
    pthread_mutex_unlock(&hub->lock);
}

void live_hub_counts(struct live_hub *hub, enum link_kind kind,
                     const struct store_link_counts *counts, int64_t host_us)
{
    pthread_mutex_lock(&hub->lock);
    live_model_counts(&hub->model, kind, counts, host_us);
    pthread_mutex_unlock(&hub->lock);
}

void live_hub_strangers(struct live_hub *hub, int64_t count, int64_t host_us)
{
    pthread_mutex_lock(&hub->lock);
    live_model_strangers(&hub->model, count, host_us);
    pthread_mutex_unlock(&hub->lock);
}

void live_hub_look(struct live_hub *hub, struct live_model *model)
{
    pthread_mutex_lock(&hub->lock);
    *model = hub->model;
    pthread_mutex_unlock(&hub->lock);
}

bool live_hub_lacks_calibration(struct live_hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    bool lacks = live_model_lacks_calibration(&hub->model);
    pthread_mutex_unlock(&hub->lock);
    return lacks;
}

char *live_hub_state(struct live_hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    json_t *state = live_json_state(&hub->model, (int64_t)link_now_us());
    json_object_set_new(state, "configuration", live_json_configuration(&hub->model, hub->source));
    pthread_mutex_unlock(&hub->lock);
    return dumped(state);
}

/* ---- viewers ---- */

void live_hub_viewer(struct live_hub *hub, const char *last, struct live_viewer *viewer)
{
    uint32_t run;
    uint64_t id;
    pthread_mutex_lock(&hub->lock);
    bool known = last && sscanf(last, "%8" SCNx32 "-%" SCNu64, &run, &id) == 2 && run == hub->run &&
                 id + 1 >= hub->first && id < hub->next;
    *viewer = (struct live_viewer){.next = known ? id + 1 : hub->next, .fresh = !known};
    pthread_mutex_unlock(&hub->lock);
}

/* All that a viewer without a past needs. Locked by the caller. */
static char *whole(struct live_hub *hub, struct live_viewer *viewer, size_t *length)
{
    char *text = NULL;
    FILE *out = open_memstream(&text, length);
    if (!out)
        return NULL;
    uint64_t before = hub->next ? hub->next - 1 : 0;
    char *configuration = event_text(hub, EVENT_CONFIGURATION,
                                     dumped(live_json_configuration(&hub->model, hub->source)),
                                     before);
    char *state = event_text(hub, EVENT_STATE,
                             dumped(live_json_state(&hub->model, (int64_t)link_now_us())), before);
    fputs("retry: 500\n", out);
    fputs(configuration ? configuration : "", out);
    for (uint64_t i = hub->first; i < hub->next; i++) {
        if (hub->event[i % EVENTS].kind == EVENT_READINGS)
            fputs(hub->event[i % EVENTS].text, out);
    }
    fputs(state ? state : "", out);
    free(configuration);
    free(state);
    viewer->fresh = false;
    viewer->next = hub->next;
    return fclose(out) == 0 ? text : (free(text), NULL);
}

char *live_hub_next(struct live_hub *hub, struct live_viewer *viewer, int wait_ms, size_t *length)
{
    struct timespec until = after_ms(wait_ms);
    char *text = NULL;
    pthread_mutex_lock(&hub->lock);
    while (!hub->ended && !viewer->fresh && viewer->next == hub->next &&
           pthread_cond_timedwait(&hub->news, &hub->lock, &until) != ETIMEDOUT)
        ;
    if (viewer->next < hub->first)
        viewer->fresh = true; /* did not read for longer than the ring remembers */
    if (hub->ended) {
        text = NULL;
    } else if (viewer->fresh) {
        text = whole(hub, viewer, length);
    } else if (viewer->next < hub->next) {
        const struct event *event = &hub->event[viewer->next++ % EVENTS];
        text = malloc(event->length + 1);
        *length = event->length;
        if (text)
            memcpy(text, event->text, event->length + 1);
    }
    pthread_mutex_unlock(&hub->lock);
    return text;
}

void live_hub_end(struct live_hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    hub->ended = true;
    pthread_cond_broadcast(&hub->news);
    pthread_mutex_unlock(&hub->lock);
}

bool live_hub_ended(struct live_hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    bool ended = hub->ended;
    pthread_mutex_unlock(&hub->lock);
    return ended;
}

bool live_hub_wait_end(struct live_hub *hub, int wait_ms)
{
    struct timespec until = after_ms(wait_ms);
    pthread_mutex_lock(&hub->lock);
    while (!hub->ended && pthread_cond_timedwait(&hub->news, &hub->lock, &until) != ETIMEDOUT)
        ;
    bool ended = hub->ended;
    pthread_mutex_unlock(&hub->lock);
    return ended;
}

/* ---- commands ---- */

enum mr_status live_hub_command(struct live_hub *hub, unsigned code, int32_t argument,
                                enum mr_status *answer)
{
    struct timespec until = after_ms(1000 * ARMTALK_ANSWER_S);
    enum mr_status status = MR_NOT_NOW;
    pthread_mutex_lock(&hub->lock);
    if (hub->source->commands && !hub->waiting && !hub->ended) {
        hub->command =
            (struct mr_command){.code = (uint8_t)code, .tag = hub->tag++, .argument = argument};
        hub->waiting = true;
        hub->sent = hub->answered = false;
        while (!hub->answered && !hub->ended &&
               pthread_cond_timedwait(&hub->news, &hub->lock, &until) != ETIMEDOUT)
            ;
        status = hub->answered ? MR_OK : MR_TIMEOUT;
        *answer = hub->answer;
        hub->waiting = false;
    }
    pthread_mutex_unlock(&hub->lock);
    return status;
}

bool live_hub_take_command(struct live_hub *hub, struct mr_command *command)
{
    pthread_mutex_lock(&hub->lock);
    bool any = hub->waiting && !hub->sent;
    if (any) {
        *command = hub->command;
        hub->sent = true;
    }
    pthread_mutex_unlock(&hub->lock);
    return any;
}
