#include "host/live/hub.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

#include "common/command.h"
#include "common/emulated.h"
#include "common/fault.h"
#include "common/quantity.h"
#include "common/risk.h"
#include "common/wire.h"
#include "host/board/arm_client.h"
#include "host/board/config_client.h"
#include "host/board/config_text.h"
#include "host/base/cli.h"
#include "host/base/monotonic_clock.h"
#include "host/base/units.h"
#include "host/live/buckets.h"

/* events of one minute: 50 of messages, 20 of readings and 5 of state per second */
#define EVENTS_MAX            4500u
#define EVENT_BYTES_MAX       0x400000u /* maximum of the total bytes of all events */
/* shortest time between two message events; a warning does not wait */
#define MESSAGES_PERIOD_MS    20
#define READINGS_PERIOD_MS    50
#define STATE_PERIOD_MS       200
#define BUCKETS_PER_EVENT     64
#define FIRST_COMMAND_TAG     0x7601u
#define MESSAGE_SLOTS_MAX     1024u
#define OUTCOME_MESSAGE_INDEX ((unsigned)MR_MESSAGE_COUNT) /* slot of the outcome of a landing */
/* readings from CAN are ignored while the newest block record from serial is not older than this */
#define RECORD_AGE_MAX_BLOCKS 500

enum event_kind { EVENT_CONFIGURATION, EVENT_MESSAGES, EVENT_STATE, EVENT_READINGS, EVENT_END };

struct live_event {
    enum event_kind kind;
    char *text;
    size_t length;
};

/* Newest message of one kind, link and subject (channel, switch, ...). */
struct message_slot {
    uint32_t key;
    char *text;
};

struct live_hub {
    pthread_mutex_t lock;
    pthread_cond_t event_added;
    const struct live_source *source;
    struct live_buckets buckets;
    /* random number of this hub, which distinguishes its readings from those of an earlier hub */
    uint32_t hub_id;

    struct message_slot slot[MESSAGE_SLOTS_MAX]; /* slots in order of arrival */
    unsigned slot_count;
    /* the board has another message layout, so its other messages are ignored */
    bool has_other_layout;
    bool is_warning, is_armed;
    struct config_words config[LINK_KINDS];
    /* a sensor is uncalibrated according to the configuration, once it is received */
    bool is_uncalibrated;
    int64_t received_us[LINK_KINDS];
    struct store_link_counts counts[LINK_KINDS];

    struct live_event event[EVENTS_MAX];
    /* ring: event i, from first_event to next_event - 1, is at event[i % EVENTS_MAX] */
    uint64_t first_event, next_event;
    size_t event_bytes;
    FILE *pending_stream; /* JSON of messages for the next event; NULL: none */
    char *pending_text;
    size_t pending_length;
    uint64_t restart_count; /* number of restarts of the board that were reported to viewers */
    /* times at which an event of each kind was last published, ms */
    int64_t messages_published_ms, readings_published_ms, state_published_ms;
    bool has_ended;

    struct mr_command command;
    /* a viewer's command was given, sent, answered */
    bool has_command, command_sent, command_answered;
    int64_t command_expires_us;
    enum mr_status command_answer;
    uint16_t command_tag;
};

/* ---- output as JSON: all numbers in the report's units (in, lb, ft, s) ---- */

#define DISPLACEMENT_STEPS_PER_IN 10000.0
#define TENSION_STEPS_PER_LB      100.0

/* Makes a JSON string of external text; null for NULL. In text that is not valid UTF-8, each
 * non-ASCII byte becomes a question mark. */
static json_t *text_to_json(const char *text)
{
    json_t *string = text ? json_string(text) : json_null();
    if (string)
        return string;
    char plain[300];
    size_t i = 0;
    for (; text[i] && i + 1 < sizeof plain; i++)
        plain[i] = (unsigned char)text[i] < 0x80 ? text[i] : '?';
    plain[i] = '\0';
    return json_string(plain);
}

static json_t *make_units_json(bool si)
{
    static const char *const names[UNIT_MEASURED_KIND_COUNT] = {"station", "displacement", "speed",
                                                                "deceleration", "tension"};
    json_t *units = json_object();
    for (int kind = 0; kind < UNIT_MEASURED_KIND_COUNT; kind++) {
        const struct unit *unit = unit_get((enum unit_kind)kind, si);
        json_object_set_new(units, names[kind],
                            json_pack("{sssf}", "text", unit->text, "factor", unit->factor));
    }
    return units;
}

static json_t *make_quantities_json(void)
{
    json_t *quantities = json_array();
    for (unsigned i = 0; i < MR_QUANTITY_COUNT; i++) {
        const struct mr_quantity_info *q = mr_quantity_at(i);
        json_array_append_new(quantities, json_pack("{sssssssssi}", "key", q->key, "error_key",
                                                    q->error_key, "words", q->text, "unit", q->unit,
                                                    "decimals", q->decimals));
    }
    return quantities;
}

static json_t *make_texts_json(const char *(*text)(unsigned value), unsigned count)
{
    json_t *texts = json_array();
    for (unsigned i = 0; i < count; i++)
        json_array_append_new(texts, json_string(text(i)));
    return texts;
}

/* Returns the text of status -n. */
static const char *get_status_text(unsigned n)
{
    return mr_status_text((enum mr_status) - (int)n);
}

/* Makes the data that is the same for every board: {"units", "source", "layout", "quantities",
 * "faults", "can_states", "statuses", "bucket_s", "transducers"}. */
static json_t *make_configuration_json(const struct live_source *source)
{
    json_t *from = json_pack("{sosososbss?}", "db", text_to_json(source->db), "can",
                             text_to_json(source->can), "serial", text_to_json(source->serial),
                             "commands", source->accepts_commands, "no_commands",
                             source->no_commands_reason);
    return json_pack(
        "{sososisosososos[iii]sisisisisisfsisi}", "units", make_units_json(source->uses_si),
        "source", from, "layout", (int)MR_LAYOUT, "quantities", make_quantities_json(), "faults",
        make_texts_json(mr_fault_text, MR_FAULT_COUNT), "can_states",
        make_texts_json(mr_can_state_text, MR_CAN_MISSING + 1), "statuses",
        make_texts_json(get_status_text, 32), "box_good", MR_BOX_READY, MR_BOX_RECORDING,
        MR_BOX_CLOSING, "lamp_limit_item", (int)MR_RISK_PLAN_ITEM_COUNT, "risk_of_plan",
        MR_RISK_PLAN_USED, "risk_of_chart", MR_RISK_CHART_USED, "arm", MR_COMMAND_ARM, "disarm",
        MR_COMMAND_DISARM, "bucket_s", LIVE_BUCKET_BLOCKS / 1000.0, "transducers",
        (int)MR_TRANSDUCERS, "emulated_lot", (int)MR_EMULATED_LOT);
}

static void write_number(FILE *out, const char *key, double value, int digits)
{
    if (isfinite(value))
        fprintf(out, ",\"%s\":%.*g", key, digits, value);
    else
        fprintf(out, ",\"%s\":null", key);
}

static void write_integer(FILE *out, const char *key, long long value)
{
    fprintf(out, ",\"%s\":%lld", key, value);
}

static void write_text(FILE *out, const char *key, const char *text)
{
    fprintf(out, ",\"%s\":\"%s\"", key, text);
}

/* clang-format off */
/* Writes one message of the catalogue as an object: {"m": its name, "t": host time in us, "l":
 * link, "b": block or null, each field by its name, "FIELD_text" for a code, "notice" and
 * "severity" for a message that is shown as a line, "quantity", "value" and "error" for a displayed
 * number}. */
static void write_message_json(FILE *out, const struct collector_event *event)
{
    const struct mr_message *message = event->message;
    char line[160];
    fprintf(out, "{\"m\":\"%s\"", message->info->name);
    write_integer(out, "t", (long long)event->host_us);
    write_integer(out, "l", event->link);
    if (event->board_us == STORE_NONE)
        fputs(",\"b\":null", out);
    else
        write_integer(out, "b", event->board_us / 1000);
    switch (message->index) {
#define MESSAGE(name, NAME, id, direction, text) \
    case MR_INDEX_##NAME: {                      \
        const struct mr_##name *m = &message->as.name;
#define INTEGER(name, type, field, unit, text) write_integer(out, #field, (long long)m->field);
#define ENUMERATED(name, type, field, values, text) \
    write_integer(out, #field, (long long)m->field);  \
    write_text(out, #field "_text", mr_##values##_text((unsigned)m->field));
#define REAL(name, type, field, counts_per_unit, unit, text) \
    write_number(out, #field, (double)m->field, 7);
#define FLOAT(name, field, unit, text) write_number(out, #field, (double)m->field, 7);
#define QUANTITY(name, NAME, kind, suffix, words, unit, decimals, of, its_error)   \
    write_text(out, "quantity", mr_quantity_at(MR_QUANTITY_##kind)->key);            \
    write_number(out, "value", (double)(of), 9);                                     \
    write_number(out, "error", (double)(its_error), 9);
#define LIVE_NOTICE(name, NAME, severe, ...)  \
    snprintf(line, sizeof line, __VA_ARGS__); \
    write_text(out, "severity", #severe);       \
    write_text(out, "notice", line);
#define END_MESSAGE(name, NAME) \
    break;                      \
    }
#include "common/catalogue.def"
    default: break;
    }
    fputc('}', out);
}
/* clang-format on */

static void write_values(FILE *out, const float values[LIVE_CHANNEL_COUNT])
{
    for (unsigned i = 0; i < LIVE_CHANNEL_COUNT; i++) {
        if (isfinite(values[i]))
            fprintf(out, ",%ld",
                    lround((double)values[i] * (i < MR_TRANSDUCERS ? DISPLACEMENT_STEPS_PER_IN
                                                                   : TENSION_STEPS_PER_LB)));
        else
            fputs(",null", out);
    }
}

/* Makes {"epoch": run and boot, "b": [[bucket, least x 22, most x 22] ..]} in units of 0.0001 in
 * and 0.01 lb; null: no reading. The caller frees the text. */
static char *make_buckets_json(uint32_t run, uint64_t restarts, const struct live_bucket *buckets,
                               unsigned count)
{
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        return NULL;
    fprintf(out, "{\"epoch\":\"%08x-%llu\",\"b\":[", (unsigned)run, (unsigned long long)restarts);
    for (unsigned i = 0; i < count; i++) {
        fprintf(out, "%s[%lld", i ? "," : "", (long long)buckets[i].number);
        write_values(out, buckets[i].min);
        write_values(out, buckets[i].max);
        fputc(']', out);
    }
    fputs("]}", out);
    return fclose(out) == 0 ? text : (free(text), NULL);
}

/* Makes the list of the newest, smallest and largest value of each channel: [[value, least, most,
 * reason without a value] x 22]. */
static json_t *make_readings_json(const struct live_buckets *buckets)
{
    json_t *readings = json_array();
    for (unsigned i = 0; i < LIVE_CHANNEL_COUNT; i++) {
        const struct live_reading *r = &buckets->reading[i];
        json_array_append_new(readings, json_pack("[ooos]", cli_json_number((double)r->value, 7),
                                                  cli_json_number((double)r->min, 7),
                                                  cli_json_number((double)r->max, 7),
                                                  live_buckets_missing_reason(buckets, i)));
    }
    return readings;
}

/* ---- the hub ---- */

static struct timespec compute_deadline(int wait_ms)
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
        return error_set(error, MR_FULL, "out of memory for the live view; close other programs");
    /* Set the seed before threads start; otherwise two threads could set it at the same time. */
    json_object_seed(0);
    pthread_mutex_init(&made->lock, NULL);
    pthread_condattr_init(&steady);
    pthread_condattr_setclock(&steady, CLOCK_MONOTONIC);
    pthread_cond_init(&made->event_added, &steady);
    pthread_condattr_destroy(&steady);
    made->source = source;
    made->command_tag = FIRST_COMMAND_TAG;
    if (getrandom(&made->hub_id, sizeof made->hub_id, GRND_NONBLOCK) !=
        (ssize_t)sizeof made->hub_id)
        made->hub_id = (uint32_t)monotonic_ms();
    live_buckets_init(&made->buckets);
    *hub = made;
    return MR_OK;
}

static void discard_oldest_event(struct live_hub *hub)
{
    struct live_event *event = &hub->event[hub->first_event++ % EVENTS_MAX];
    hub->event_bytes -= event->length;
    free(event->text);
    event->text = NULL;
}

void live_hub_close(struct live_hub *hub)
{
    if (!hub)
        return;
    while (hub->first_event < hub->next_event)
        discard_oldest_event(hub);
    for (unsigned i = 0; i < hub->slot_count; i++)
        free(hub->slot[i].text);
    if (hub->pending_stream)
        fclose(hub->pending_stream);
    free(hub->pending_text);
    pthread_cond_destroy(&hub->event_added);
    pthread_mutex_destroy(&hub->lock);
    free(hub);
}

/* Makes the text of an event for the event stream, and frees `json`. NULL: no memory. */
static char *make_event_text(enum event_kind kind, char *json, uint64_t id)
{
    static const char *const names[] = {"configuration", "messages", "state", "readings", "end"};
    char *text = NULL;
    if (json &&
        asprintf(&text, "event: %s\nid: %" PRIu64 "\ndata: %s\n\n", names[kind], id, json) < 0)
        text = NULL;
    free(json);
    return text;
}

static void publish_event(struct live_hub *hub, enum event_kind kind, char *json)
{
    char *text = make_event_text(kind, json, hub->next_event);
    if (!text)
        return; /* no memory; the next event contains the data again */
    size_t length = strlen(text);
    while (hub->first_event < hub->next_event &&
           (hub->next_event - hub->first_event == EVENTS_MAX ||
            hub->event_bytes + length > EVENT_BYTES_MAX))
        discard_oldest_event(hub);
    hub->event[hub->next_event++ % EVENTS_MAX] = (struct live_event){kind, text, length};
    hub->event_bytes += length;
    pthread_cond_broadcast(&hub->event_added);
}

static char *convert_to_text_and_free(json_t *json)
{
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(json);
    return text;
}

static void publish_readings(struct live_hub *hub)
{
    struct live_bucket buckets[BUCKETS_PER_EVENT];
    unsigned count;
    hub->readings_published_ms = monotonic_ms();
    while ((count = live_buckets_pop(&hub->buckets, buckets, BUCKETS_PER_EVENT)) > 0)
        publish_event(hub, EVENT_READINGS,
                      make_buckets_json(hub->hub_id, hub->restart_count, buckets, count));
}

static void publish_messages(struct live_hub *hub)
{
    hub->messages_published_ms = monotonic_ms();
    if (!hub->pending_stream)
        return;
    fputc(']', hub->pending_stream);
    bool whole = fclose(hub->pending_stream) == 0;
    hub->pending_stream = NULL;
    if (whole)
        publish_event(hub, EVENT_MESSAGES, hub->pending_text);
    else
        free(hub->pending_text);
    hub->pending_text = NULL;
}

/* Makes the state of the links and the newest readings. */
static json_t *make_state_json(const struct live_hub *hub)
{
    json_t *links = json_array();
    int64_t block = live_buckets_newest_block(&hub->buckets),
            record = hub->buckets.newest_record_block;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct store_link_counts *counts = &hub->counts[kind];
        bool used = hub->received_us[kind] ||
                    (kind == LINK_CAN ? hub->source->can : hub->source->serial);
        json_array_append_new(
            links, json_pack("{sssbsIsIsIsIsIsI}", "name", kind == LINK_CAN ? "CAN" : "serial",
                             "used", used, "received", (json_int_t)counts->received, "lost",
                             (json_int_t)counts->lost, "dropped", (json_int_t)counts->dropped,
                             "bad", (json_int_t)counts->bad, "foreign", (json_int_t)counts->foreign,
                             "heard_us", (json_int_t)hub->received_us[kind]));
    }
    return json_pack(
        "{sIsIsssIsososb}", "now_us", (json_int_t)link_now_us(), "block", (json_int_t)block,
        "source", record >= 0 && block - record < RECORD_AGE_MAX_BLOCKS ? "serial, each ms" : "CAN",
        "late", (json_int_t)hub->buckets.late_reading_count, "links", links, "readings",
        make_readings_json(&hub->buckets), "uncalibrated", hub->is_uncalibrated);
}

/* Publishes all events that are due. The caller holds the lock. */
static void publish_due_events(struct live_hub *hub)
{
    int64_t now = monotonic_ms();
    if (hub->buckets.restart_count != hub->restart_count) {
        /* publish first the readings from before the restart */
        publish_readings(hub);
        hub->restart_count = hub->buckets.restart_count;
    }
    if (now - hub->messages_published_ms >= MESSAGES_PERIOD_MS)
        publish_messages(hub);
    if (now - hub->state_published_ms >= STATE_PERIOD_MS) {
        hub->state_published_ms = now;
        publish_event(hub, EVENT_STATE, convert_to_text_and_free(make_state_json(hub)));
    }
    if (now - hub->readings_published_ms >= READINGS_PERIOD_MS) {
        live_buckets_close_complete(&hub->buckets);
        publish_readings(hub);
    }
}

void live_hub_publish_due_events(struct live_hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    publish_due_events(hub);
    pthread_mutex_unlock(&hub->lock);
}

/* ---- messages ---- */

/* Returns false if the page does not need the message, or gets its data as buckets. */
static bool is_shown_on_page(const struct mr_message *message)
{
    switch (message->index) {
#define SERIES_PACK(SERIES_NAME, name, NAME, id, first, count) case MR_INDEX_##NAME:
#include "common/catalogue.def"
    case MR_INDEX_CALIBRATION:
    case MR_INDEX_CLOCK:
    case MR_INDEX_CONFIG_IMAGE:
    case MR_INDEX_CAN_HEALTH:
    case MR_INDEX_SERIAL_HEALTH: return false;
    default: return true;
    }
}

static bool is_landing_message(unsigned place)
{
    switch (place) {
    case MR_INDEX_ZONE:
    case MR_INDEX_ZONE_LEAD:
    case MR_INDEX_ZONE_COMING:
    case MR_INDEX_ZONE_PRESS:
    case MR_INDEX_VERDICT:
    case MR_INDEX_RISK:
    case MR_INDEX_RISK_LEAD:
    case MR_INDEX_EDGE:
    case MR_INDEX_MOTION:
    case MR_INDEX_MOTION_ERROR:
    case MR_INDEX_TOUCHDOWN:
    case MR_INDEX_STOP:
    case OUTCOME_MESSAGE_INDEX: return true;
    default: return false;
    }
}

/* Returns the subject of a message: channel, switch, segment, ... A warning or advice of the
 * predictor has a subject of its own, so that a newer message does not replace it. */
static unsigned get_message_subject(const struct mr_message *m)
{
    switch (m->index) {
    case MR_INDEX_CHANNEL: return m->as.channel.index;
    case MR_INDEX_CHANNEL_ZERO: return m->as.channel_zero.index;
    case MR_INDEX_CHANNEL_EVENT: return m->as.channel_event.index;
    case MR_INDEX_SWITCH_PLACE: return m->as.switch_place.position;
    case MR_INDEX_SLACK: return m->as.slack.segment;
    case MR_INDEX_FAULT: return m->as.fault.code;
    case MR_INDEX_BAND_STATE: return m->as.band_state.band;
    case MR_INDEX_EDGE: return m->as.edge.position;
    case MR_INDEX_RISK_ITEM: return m->as.risk_item.index;
    case MR_INDEX_ZONE_LEAD: return m->as.zone_lead.warning;
    case MR_INDEX_VERDICT: return m->as.verdict.verdict;
    default: return 0;
    }
}

static uint32_t make_slot_key(unsigned place, enum link_kind link, unsigned which)
{
    return (uint32_t)place << 16 | (uint32_t)link << 12 | (which & 0xfffu);
}

static struct message_slot *find_slot(struct live_hub *hub, uint32_t key)
{
    for (unsigned i = 0; i < hub->slot_count; i++) {
        if (hub->slot[i].key == key)
            return &hub->slot[i];
    }
    return NULL;
}

static void remove_slot(struct live_hub *hub, struct message_slot *slot)
{
    free(slot->text);
    hub->slot_count--;
    memmove(slot, slot + 1, (size_t)(hub->slot + hub->slot_count - slot) * sizeof *slot);
}

/* Stores `text` in its slot, and takes ownership of it. */
static void store_slot(struct live_hub *hub, uint32_t key, char *text)
{
    struct message_slot *old = find_slot(hub, key);
    if (old)
        remove_slot(hub, old);
    else if (hub->slot_count == MESSAGE_SLOTS_MAX)
        remove_slot(hub, &hub->slot[0]);
    if (text)
        hub->slot[hub->slot_count++] = (struct message_slot){key, text};
}

/* Discards the messages of a landing. Called when a new landing is armed or the board has
 * restarted. */
static void discard_landing(struct live_hub *hub, bool faults)
{
    for (unsigned i = hub->slot_count; i-- > 0;) {
        unsigned place = hub->slot[i].key >> 16;
        if (is_landing_message(place) || (faults && place == MR_INDEX_FAULT))
            remove_slot(hub, &hub->slot[i]);
    }
    hub->is_warning = false;
}

/* Adds a message to the next event. */
static void append_to_next_event(struct live_hub *hub, const char *text)
{
    if (!hub->pending_stream)
        hub->pending_stream = open_memstream(&hub->pending_text, &hub->pending_length);
    if (hub->pending_stream)
        fprintf(hub->pending_stream, "%c%s", ftell(hub->pending_stream) > 0 ? ',' : '[', text);
}

static void add_notice(struct live_hub *hub, const char *severity, bool is_outcome,
                       const char *words)
{
    pthread_mutex_lock(&hub->lock);
    char *text = convert_to_text_and_free(json_pack(
        "{sssIsisnsssbso}", "m", "notice", "t", (json_int_t)link_now_us(), "l", (int)LINK_SERIAL,
        "b", "severity", severity, "outcome", is_outcome, "notice", text_to_json(words)));
    if (text)
        append_to_next_event(hub, text);
    if (is_outcome) /* for pages that are opened later */
        store_slot(hub, make_slot_key(OUTCOME_MESSAGE_INDEX, LINK_SERIAL, 0), text);
    else
        free(text);
    pthread_mutex_unlock(&hub->lock);
}

void live_hub_add_notice(struct live_hub *hub, const char *words)
{
    add_notice(hub, "ALARM", false, words);
}

void live_hub_add_outcome(struct live_hub *hub, const char *words)
{
    add_notice(hub, "NOTE", true, words);
}

static void show_message(struct live_hub *hub, const struct collector_event *event)
{
    const struct mr_message *m = event->message;
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        return;
    write_message_json(out, event);
    if (fclose(out) != 0) {
        free(text);
        return;
    }
    append_to_next_event(hub, text);
    bool warns = m->index == MR_INDEX_ZONE_LEAD && m->as.zone_lead.warning;
    /* A warning begins: also store its zone. The message with the zone arrived before this one. */
    if (warns && !hub->is_warning) {
        const struct message_slot *zone = find_slot(hub,
                                                    make_slot_key(MR_INDEX_ZONE, event->link, 0));
        store_slot(hub, make_slot_key(MR_INDEX_ZONE, event->link, 1),
                   zone ? strdup(zone->text) : NULL);
    }
    if (!warns || !hub->is_warning)
        store_slot(hub, make_slot_key(m->index, event->link, get_message_subject(m)), text);
    else
        free(text);
    if (m->index == MR_INDEX_ZONE_LEAD && warns != hub->is_warning) {
        hub->is_warning = warns;
        publish_messages(hub);
    }
}

void live_hub_add_message(struct live_hub *hub, const struct collector_event *event)
{
    const struct mr_message *m = event->message;
    int64_t block = event->board_us == STORE_NONE ? -1 : event->board_us / 1000;
    pthread_mutex_lock(&hub->lock);
    hub->received_us[event->link] = (int64_t)event->host_us;
    if (live_buckets_advance(&hub->buckets, event->link, block)) {
        discard_landing(hub, true);
        publish_due_events(hub);
    }
    struct mr_config config;
    if (m->index == MR_INDEX_CONFIG_IMAGE &&
        config_words_add(&hub->config[event->link], &m->as.config_image, &config))
        hub->is_uncalibrated = config_text_undated_channels(&config) != 0;
    if (m->index == MR_INDEX_HELLO)
        hub->has_other_layout = m->as.hello.layout != MR_LAYOUT;
    bool armed = m->index == MR_INDEX_LANDING && m->as.landing.state == MR_LANDING_ARMED;
    if (armed && !hub->is_armed) {
        discard_landing(hub, false);
        live_buckets_reset_extremes(&hub->buckets);
    }
    hub->is_armed = m->index == MR_INDEX_LANDING ? armed : hub->is_armed;
    if (!hub->has_other_layout || m->index == MR_INDEX_HELLO) {
        live_buckets_add_message(&hub->buckets, m, block);
        if (is_shown_on_page(m))
            show_message(hub, event);
    }
    if (m->index == MR_INDEX_ACK && hub->command_sent && !hub->command_answered &&
        m->as.ack.tag == hub->command.tag) {
        hub->command_answered = true;
        hub->command_answer = (enum mr_status)m->as.ack.status;
        pthread_cond_broadcast(&hub->event_added);
    }
    if (hub->buckets.closed_count >= BUCKETS_PER_EVENT)
        publish_readings(hub);
    pthread_mutex_unlock(&hub->lock);
}

void live_hub_add_record(struct live_hub *hub, const struct mr_block *record, int64_t host_us)
{
    pthread_mutex_lock(&hub->lock);
    hub->received_us[LINK_SERIAL] = host_us;
    if (live_buckets_advance(&hub->buckets, LINK_SERIAL, record->index)) {
        discard_landing(hub, true);
        publish_due_events(hub);
    }
    live_buckets_add_record(&hub->buckets, record);
    /* publish now: a campaign may be read faster than live_hub_publish_due_events is called */
    if (hub->buckets.closed_count >= BUCKETS_PER_EVENT)
        publish_readings(hub);
    pthread_mutex_unlock(&hub->lock);
}

void live_hub_set_counts(struct live_hub *hub, enum link_kind kind,
                         const struct store_link_counts *counts)
{
    pthread_mutex_lock(&hub->lock);
    hub->counts[kind] = *counts;
    pthread_mutex_unlock(&hub->lock);
}

/* Makes a list of the newest messages. */
static char *make_slots_text(const struct live_hub *hub)
{
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        return NULL;
    fputc('[', out);
    for (unsigned i = 0; i < hub->slot_count; i++)
        fprintf(out, "%s%s", i ? "," : "", hub->slot[i].text);
    fputc(']', out);
    return fclose(out) == 0 ? text : (free(text), NULL);
}

char *live_hub_snapshot(struct live_hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    char *messages = make_slots_text(hub);
    json_t *state = make_state_json(hub);
    pthread_mutex_unlock(&hub->lock);
    json_t *list = messages ? json_loads(messages, 0, NULL) : NULL;
    free(messages);
    return convert_to_text_and_free(json_pack("{sososo}", "configuration",
                                              make_configuration_json(hub->source), "messages",
                                              list ? list : json_array(), "state", state));
}

/* ---- viewers ---- */

/* Makes the text of the first event for a new viewer. The caller holds the lock. */
static char *make_snapshot_event(struct live_hub *hub, struct live_viewer *viewer, size_t *length)
{
    char *text = NULL;
    publish_messages(hub); /* publish pending messages first, because the snapshot includes them */
    FILE *out = open_memstream(&text, length);
    if (!out)
        return NULL;
    uint64_t before = hub->next_event ? hub->next_event - 1 : 0;
    char *parts[] = {
        make_event_text(EVENT_CONFIGURATION,
                        convert_to_text_and_free(make_configuration_json(hub->source)), before),
        make_event_text(EVENT_MESSAGES, make_slots_text(hub), before),
        make_event_text(EVENT_STATE, convert_to_text_and_free(make_state_json(hub)), before),
    };
    fputs("retry: 500\n", out);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        fputs(parts[i] ? parts[i] : "", out);
        free(parts[i]);
    }
    for (uint64_t i = hub->first_event; i < hub->next_event; i++) {
        if (hub->event[i % EVENTS_MAX].kind == EVENT_READINGS)
            fputs(hub->event[i % EVENTS_MAX].text, out);
    }
    viewer->needs_snapshot = false;
    viewer->next_event = hub->next_event -
                         hub->has_ended; /* a separate event reports the end of the hub */
    return fclose(out) == 0 ? text : (free(text), NULL);
}

char *live_hub_wait_event(struct live_hub *hub, struct live_viewer *viewer, int wait_ms,
                          size_t *length)
{
    struct timespec until = compute_deadline(wait_ms);
    char *text = NULL;
    pthread_mutex_lock(&hub->lock);
    while (!hub->has_ended && !viewer->needs_snapshot && viewer->next_event == hub->next_event &&
           pthread_cond_timedwait(&hub->event_added, &hub->lock, &until) != ETIMEDOUT)
        ;
    if (viewer->next_event < hub->first_event)
        /* the viewer missed events that the ring no longer contains */
        viewer->needs_snapshot = true;
    if (viewer->needs_snapshot) {
        text = make_snapshot_event(hub, viewer, length);
    } else if (viewer->next_event < hub->next_event) {
        const struct live_event *event = &hub->event[viewer->next_event++ % EVENTS_MAX];
        text = malloc(event->length + 1);
        *length = event->length;
        if (text)
            memcpy(text, event->text, event->length + 1);
    }
    pthread_mutex_unlock(&hub->lock);
    return text;
}

void live_hub_end(struct live_hub *hub, const char *why)
{
    pthread_mutex_lock(&hub->lock);
    publish_messages(hub);
    publish_event(hub, EVENT_END,
                  convert_to_text_and_free(json_pack("{so}", "text", text_to_json(why))));
    hub->has_ended = true;
    pthread_cond_broadcast(&hub->event_added);
    pthread_mutex_unlock(&hub->lock);
}

bool live_hub_has_ended(struct live_hub *hub, const struct live_viewer *viewer)
{
    pthread_mutex_lock(&hub->lock);
    bool ended = hub->has_ended && !viewer->needs_snapshot && viewer->next_event == hub->next_event;
    pthread_mutex_unlock(&hub->lock);
    return ended;
}

/* ---- commands ---- */

enum mr_status live_hub_send_command(struct live_hub *hub, unsigned code, int32_t argument,
                                     int64_t until_us, enum mr_status *answer)
{
    struct timespec until = compute_deadline(1000 * ARM_CLIENT_ANSWER_TIMEOUT_S);
    enum mr_status status = MR_NOT_NOW;
    if ((int64_t)link_now_us() >= until_us)
        return MR_LIMIT;
    pthread_mutex_lock(&hub->lock);
    if (hub->source->accepts_commands && !hub->has_command && !hub->has_ended) {
        hub->command = (struct mr_command){
            .code = (uint8_t)code, .tag = hub->command_tag++, .argument = argument};
        hub->command_expires_us = until_us;
        hub->has_command = true;
        hub->command_sent = hub->command_answered = false;
        while (!hub->command_answered && !hub->has_ended &&
               pthread_cond_timedwait(&hub->event_added, &hub->lock, &until) != ETIMEDOUT)
            ;
        status = hub->command_answered ? MR_OK : hub->command_sent ? MR_TIMEOUT : MR_LIMIT;
        *answer = hub->command_answer;
        hub->has_command = false;
    }
    pthread_mutex_unlock(&hub->lock);
    return status;
}

bool live_hub_pop_command(struct live_hub *hub, struct mr_command *command)
{
    pthread_mutex_lock(&hub->lock);
    bool any = hub->has_command && !hub->command_sent &&
               (int64_t)link_now_us() < hub->command_expires_us;
    if (any) {
        *command = hub->command;
        hub->command_sent = true;
    }
    pthread_mutex_unlock(&hub->lock);
    return any;
}
