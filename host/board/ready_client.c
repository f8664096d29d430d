#include "host/board/ready_client.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/command.h"
#include "host/base/cli.h"
#include "host/link/link.h"
#include "host/store/store_journal.h"
#include "host/store/store_readiness.h"

#define HELLO_S     4.0
#define ANSWER_S    1.5
#define WORDS_S     3.0
#define SHUNT_S     4.0
#define TEST_S      5.0
#define BLOCKS_S    5.0
#define BOX_S       3.0
#define REST_S      3.0 /* thermometer, and faults that go on */
#define LIVE_S      20
#define WORD_ROUNDS 3
#define FIRST_MS    1500u /* every fault that ever was has been told once by then, board time */
#define PACE_PPM    700.0 /* further off the board is emulated, or a recording */

/* ---- what comes ---- */

static void take_fault(struct ready_client *talk, const struct mr_fault *fault)
{
    if (fault->code >= MR_FAULT_COUNT)
        return;
    if (!talk->fault_known[fault->code]) {
        bool early = !talk->clock_known || talk->newest_clock - talk->first_clock < FIRST_MS;
        talk->first_fault[fault->code] = early ? fault->count : 0;
        talk->fault_known[fault->code] = true;
    }
    talk->facts->fault[fault->code] = *fault;
    talk->facts->fault_rise[fault->code] =
        (uint16_t)(fault->count - talk->first_fault[fault->code]);
}

static void take_clock(struct ready_client *talk, const struct mr_clock *clock, uint64_t host_us)
{
    if (!talk->clock_known)
        talk->first_clock = clock->block;
    talk->clock_known = true;
    talk->newest_clock = clock->block;
    timemap_add(&talk->map, 1000.0 * (double)clock->block + TIMEMAP_SERIAL_US, (int64_t)host_us);
}

static void take_block(struct ready_client *talk, const uint8_t *bytes, size_t length)
{
    struct mr_block block;
    if (mr_block_get(&block, bytes, length) != MR_OK)
        return;
    if (talk->blocks < READY_CLIENT_BLOCKS)
        talk->block[talk->blocks++] = block;
    if (talk->reading)
        talk->reading(talk->context, &block);
}

static uint16_t rise(bool *known, uint16_t *first, uint16_t now)
{
    if (!*known)
        *first = now;
    *known = true;
    return (uint16_t)(now - *first);
}

/* Health of the board and of its links. */
static void take_health(struct ready_client *talk, uint16_t id, const uint8_t *bytes, size_t length)
{
    struct ready_facts *f = talk->facts;
    struct mr_health health;
    struct mr_can_health can;
    struct mr_serial_health serial;
    struct mr_fault fault;
    if (id == MR_ID_HEALTH && mr_health_get(&health, bytes, length) == MR_OK)
        f->blocks_lost = rise(&talk->lost_known, &talk->blocks_lost, health.blocks_lost);
    else if (id == MR_ID_CAN_HEALTH && mr_can_health_get(&can, bytes, length) == MR_OK)
        f->can_dropped = rise(&talk->can_dropped_known, &talk->can_dropped, can.dropped);
    else if (id == MR_ID_SERIAL_HEALTH && mr_serial_health_get(&serial, bytes, length) == MR_OK)
        f->serial_dropped = rise(&talk->serial_dropped_known, &talk->serial_dropped,
                                 serial.dropped);
    else if (id == MR_ID_FAULT && mr_fault_get(&fault, bytes, length) == MR_OK)
        take_fault(talk, &fault);
    else if (id == MR_ID_CAN_ALARM)
        f->alarm_known |= mr_can_alarm_get(&f->alarm, bytes, length) == MR_OK;
    else if (id == MR_ID_RESTARTS)
        f->restarts_known |= mr_restarts_get(&f->restarts, bytes, length) == MR_OK;
    else if (id == MR_ID_SELF_TEST) {
        struct mr_self_test test;
        if (mr_self_test_get(&test, bytes, length) == MR_OK &&
            test.tag == dialogue_tag(talk->dialogue)) {
            f->test = test;
            f->tested = true;
        }
    }
}

static void take_serial(struct ready_client *talk, const struct dialogue_message *message)
{
    struct ready_facts *f = talk->facts;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    struct mr_clock clock;
    struct mr_edge edge;
    struct mr_switch_event event;
    struct mr_channel_zero zero;
    switch (message->id) {
    case MR_ID_CHANNEL_ZERO:
        if (mr_channel_zero_get(&zero, bytes, length) == MR_OK && zero.index < MR_CHANNELS) {
            f->zero_told |= 1u << zero.index;
            f->zero_measured |= (zero.measured ? 1u : 0u) << zero.index;
        }
        break;
    case MR_ID_CLOCK:
        if (mr_clock_get(&clock, bytes, length) == MR_OK)
            take_clock(talk, &clock, message->host_us);
        break;
    case MR_ID_EDGE:
        if (talk->edge && mr_edge_get(&edge, bytes, length) == MR_OK)
            talk->edge(talk->context, &edge);
        break;
    case MR_ID_SWITCH_EVENT:
        if (talk->event && mr_switch_event_get(&event, bytes, length) == MR_OK)
            talk->event(talk->context, &event);
        break;
    case MR_ID_CONFIG_IMAGE: configwords_take(&talk->words, bytes, length); break;
    case MR_ID_CONFIG_STATE:
        f->config_state_known |= mr_config_state_get(&f->config_state, bytes, length) == MR_OK;
        break;
    case MR_ID_BOX_STATE: f->box_known |= mr_box_state_get(&f->box, bytes, length) == MR_OK; break;
    case MR_ID_BOX_SPACE: (void)mr_box_space_get(&f->space, bytes, length); break;
    case MR_ID_TEMPERATURE:
        f->temperature_known |= mr_temperature_get(&f->temperature, bytes, length) == MR_OK;
        break;
    case MR_ID_BLOCK: take_block(talk, bytes, length); break;
    default:
        identity_take(&f->identity, message->id, bytes, length);
        f->hello = f->identity.hello_known;
        shunts_take(&f->shunts, message->id, bytes, length);
        take_health(talk, (uint16_t)message->id, bytes, length);
        break;
    }
}

static void count_serial(struct ready_client *talk, uint16_t seq)
{
    talk->facts->serial_frames++;
    if (talk->seq_known)
        talk->facts->serial_lost += (uint16_t)(seq - talk->last_seq - 1u);
    talk->last_seq = seq;
    talk->seq_known = true;
}

/* CAN is only listened to: how much of what the board queued came. Others on the bus do not
 * count. */
static void count_can(struct ready_client *talk, const struct dialogue_message *message)
{
    struct mr_can_health health;
    struct ready_facts *f = talk->facts;
    if (!mr_message_find((uint16_t)message->id))
        return;
    identity_take(&f->on_can, message->id, message->payload, message->length);
    if (message->id == MR_ID_CAN_HEALTH &&
        mr_can_health_get(&health, message->payload, message->length) == MR_OK) {
        int64_t lost = (int64_t)(health.sent - talk->can_sent) - talk->can_since;
        if (!talk->can_begun) {
            talk->can_begun = true;
            talk->can_sent = health.sent;
            talk->can_since = 0;
        } else {
            f->can_lost = lost > 0 ? lost : 0;
        }
    }
    talk->can_since++;
    f->can_frames++;
}

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct ready_client *talk = context;
    (void)error;
    if (message->kind == LINK_CAN) {
        count_can(talk, message);
    } else {
        count_serial(talk, message->seq);
        take_serial(talk, message);
    }
    return MR_OK;
}

void ready_client_begin(struct ready_client *talk, struct dialogue *dialogue,
                        struct ready_facts *facts, double limit_s)
{
    memset(talk, 0, sizeof *talk);
    talk->dialogue = dialogue;
    talk->facts = facts;
    if (dialogue->link[LINK_CAN])
        facts->can_base = link_base(dialogue->link[LINK_CAN]);
    talk->until_s = dialogue_now_s(dialogue) + limit_s;
    dialogue_subscribe(dialogue, take, talk);
}

/* ---- asking ---- */

/* Not beyond the end of all of it. */
static double at_most(const struct ready_client *talk, double most_s)
{
    return fmin(most_s, talk->until_s - dialogue_now_s(talk->dialogue));
}

/* MR_OK also when the time is over: the facts say what did not come. */
static enum mr_status wait_for(struct ready_client *talk, dialogue_done *done, const void *context,
                               double most_s, struct error *error)
{
    enum mr_status status = dialogue_until(talk->dialogue, done, context, at_most(talk, most_s),
                                           error);
    return status == MR_TIMEOUT ? MR_OK : status;
}

/* talk->acknowledged says whether an answer came. */
static enum mr_status order(struct ready_client *talk, uint8_t code, int32_t argument,
                            double most_s, struct error *error)
{
    const struct dialogue_order order = {
        .code = code, .argument = argument, .answer_s = at_most(talk, most_s)};
    enum mr_status status = dialogue_order(talk->dialogue, &order, &talk->ack, error);
    talk->acknowledged = status == MR_OK;
    return status == MR_TIMEOUT ? MR_OK : status;
}

static enum mr_status read_configuration(struct ready_client *talk, struct error *error)
{
    struct ready_facts *f = talk->facts;
    struct configwords *words = &talk->words;
    enum mr_status status = MR_OK;
    for (int round = 0;
         status == MR_OK && round < WORD_ROUNDS && configwords_absent(words) < MR_CONFIG_WORDS;
         round++) {
        words->ended = false;
        status = order(talk, MR_COMMAND_CONFIG_READ, (int32_t)configwords_absent(words), ANSWER_S,
                       error);
        if (status == MR_OK && talk->acknowledged && talk->ack.status == MR_OK)
            status = wait_for(talk, dialogue_flag, &words->ended, WORDS_S, error);
    }
    if (status == MR_OK && configwords_absent(words) == MR_CONFIG_WORDS)
        f->config_known = configwords_decode(words, &f->config, &f->config_crc) == MR_OK;
    return status;
}

enum mr_status ready_client_meet(struct ready_client *talk, struct error *error)
{
    struct ready_facts *f = talk->facts;
    enum mr_status status = wait_for(talk, dialogue_flag, &f->identity.commit_known, HELLO_S,
                                     error);
    if (status != MR_OK || !f->hello)
        return status;
    if (f->identity.hello.state == MR_LANDING_DONE) {
        /* a landing that is done is kept: nothing ends but its state */
        status = order(talk, MR_COMMAND_DISARM, 0, ANSWER_S, error);
        if (status == MR_OK && talk->acknowledged && talk->ack.status == MR_OK)
            f->identity.hello.state = MR_LANDING_IDLE;
    }
    return status == MR_OK ? read_configuration(talk, error) : status;
}

enum mr_status ready_client_live(struct ready_client *talk, int seconds, struct error *error)
{
    enum mr_status status = order(talk, MR_COMMAND_LIVE, seconds, ANSWER_S, error);
    if (status != MR_OK)
        return status;
    return talk->acknowledged ? (enum mr_status)talk->ack.status : MR_TIMEOUT;
}

static bool enough_blocks(const void *context)
{
    return ((const struct ready_client *)context)->blocks >= READY_BLOCKS;
}

static enum mr_status ask_readings(struct ready_client *talk, struct error *error)
{
    struct ready_facts *f = talk->facts;
    enum mr_status status = MR_OK, live = ready_client_live(talk, LIVE_S, error);
    if (error->status == MR_OK && live == MR_OK)
        status = wait_for(talk, enough_blocks, talk, BLOCKS_S, error);
    f->blocks = talk->blocks;
    for (unsigned c = 0; f->config_known && c < MR_CHANNELS; c++)
        ready_measure(&f->config, talk->block, talk->blocks, c, &f->channel[c]);
    if (status == MR_OK && live == MR_OK)
        (void)ready_client_live(talk, 0, error);
    return error->status;
}

static enum mr_status ask_shunts(struct ready_client *talk, struct error *error)
{
    /* answered when it is over, after its results */
    enum mr_status status = order(talk, MR_COMMAND_SHUNT, 0, SHUNT_S, error);
    talk->facts->shunt_done = talk->acknowledged;
    talk->facts->shunt_status = (enum mr_status)talk->ack.status;
    return status;
}

static bool box_looked_through(const void *context)
{
    return ((const struct ready_facts *)context)->box.state != MR_BOX_LOOKING;
}

static enum mr_status ask_box(struct ready_client *talk, struct error *error)
{
    double until_s = dialogue_now_s(talk->dialogue) + BOX_S;
    struct ready_facts *f = talk->facts;
    f->box_known = false;
    enum mr_status status = order(talk, MR_COMMAND_BOX_LIST, 0, ANSWER_S, error);
    if (status == MR_OK)
        status = wait_for(talk, dialogue_flag, &f->box_known, ANSWER_S, error);
    if (status == MR_OK && f->box_known) /* until then it is told once a second */
        status = wait_for(talk, box_looked_through, f, until_s - dialogue_now_s(talk->dialogue),
                          error);
    return status;
}

/* Board time: an emulated board may be faster than this computer's clock. */
static bool rested(const void *context)
{
    const struct ready_client *talk = context;
    return talk->newest_clock - talk->first_clock >= (uint32_t)(1000.0 * REST_S);
}

enum mr_status ready_client_ask(struct ready_client *talk, struct error *error)
{
    struct ready_facts *f = talk->facts;
    double begun_s = dialogue_now_s(talk->dialogue);
    /* the answer is the whole configuration in force, with the zeros */
    enum mr_status status = order(talk, MR_COMMAND_STATE, 0, ANSWER_S, error);
    if (status == MR_OK)
        status = ask_readings(talk, error);
    if (status == MR_OK)
        status = ask_shunts(talk, error);
    if (status == MR_OK)
        status = order(talk, MR_COMMAND_SELF_TEST, 0, ANSWER_S, error);
    if (status == MR_OK && talk->acknowledged && talk->ack.status == MR_OK)
        status = wait_for(talk, dialogue_flag, &f->tested, TEST_S, error);
    if (status == MR_OK)
        status = ask_box(talk, error);
    if (status == MR_OK)
        status = wait_for(talk, rested, talk, begun_s + REST_S - dialogue_now_s(talk->dialogue),
                          error);
    if (status == MR_OK && !f->temperature_known && f->config_known &&
        f->config.site[0].thermometer)
        status = wait_for(talk, dialogue_flag, &f->temperature_known, ANSWER_S, error);
    timemap_fit(&talk->map, PACE_PPM, &f->time);
    return status;
}

/* ---- the campaign ---- */

/* The spans that the last `matrig ready` of this board kept. */
static void take_spans(const char *checks, float span_lb[MR_GAGES])
{
    json_t *object = json_loads(checks, 0, NULL), *spans = json_object_get(object, "spans_lb");
    for (unsigned i = 0; i < MR_GAGES; i++) {
        json_t *span = json_array_get(spans, i);
        if (json_is_number(span))
            span_lb[i] = (float)json_number_value(span);
    }
    json_decref(object);
}

/* The newest advice that was kept for the landing to come; one of before the newest landing was for
 * that. */
static enum mr_status take_advice(struct store *store, int64_t newest_run, struct ready_facts *f,
                                  struct error *error)
{
    struct store_advice *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_advices(store, &rows, &count, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (rows[i].after_run != newest_run)
            continue;
        snprintf(f->advice, sizeof f->advice, "%s: %s", rows[i].verdict, rows[i].reason);
        f->advised_against = strcmp(rows[i].verdict, "against") == 0;
    }
    free(rows);
    return status;
}

enum mr_status ready_client_look_back(struct store *store, struct ready_facts *f,
                                      struct error *error)
{
    char uid[IDENTITY_UID_TEXT];
    struct store_landing *rows = NULL;
    struct store_readiness last;
    size_t count = 0;
    bool found = false;
    int64_t kept_us = STORE_NONE;
    identity_uid_text(&f->identity, uid);
    enum mr_status status = store_landings(store, &rows, &count, error);
    if (status == MR_OK && count)
        status = take_advice(store, rows[count - 1].id, f, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (strcmp(rows[i].board_uid, uid) != 0)
            continue;
        f->before = true;
        f->before_run = rows[i].id;
        f->before_image = rows[i].image_crc;
        f->before_config = rows[i].config_crc;
    }
    free(rows);
    if (status == MR_OK)
        status = store_board_spans(store, uid, f->before_span_lb, &kept_us, error);
    if (status == MR_OK)
        status = store_readiness_get(store, uid, "ready", (int64_t)link_now_us(), false, &last,
                                     &found, error);
    if (status == MR_OK && found && last.made_us > kept_us)
        take_spans(last.checks, f->before_span_lb);
    if (status == MR_OK && found)
        free(last.checks);
    if (status == MR_OK)
        status = certificates_read(store, uid, &f->certificates, error);
    return status;
}

enum mr_status ready_client_save(struct store *store, const struct identity *identity,
                                 const char *kind, const struct ready_report *report,
                                 const struct ready_facts *f, int64_t made_us, struct error *error)
{
    char uid[IDENTITY_UID_TEXT];
    json_t *spans = json_array();
    struct store_readiness row = {.made_us = made_us};
    for (unsigned gage = 1; f && gage <= MR_GAGES; gage++) {
        double span_lb = (double)NAN;
        for (unsigned i = 0; i < f->shunts.count; i++) {
            if (f->shunts.result[i].gage == gage)
                span_lb = (double)f->shunts.result[i].span_lb;
        }
        json_array_append_new(spans, cli_json_number(span_lb, 7));
    }
    json_t *object = json_pack("{soso}", "checks", ready_json(report), "spans_lb", spans);
    row.checks = json_dumps(object, JSON_COMPACT);
    json_decref(object);
    if (!row.checks)
        abort();
    snprintf(row.verdict, sizeof row.verdict, "%s",
             ready_verdict(report) == READY_GO ? "go" : "no-go");
    identity_uid_text(identity, uid);
    enum mr_status status = store_begin(store, error);
    if (status == MR_OK)
        status = store_readiness_put(store, uid, kind, &row, error);
    if (status == MR_OK)
        status = store_commit(store, error);
    free(row.checks);
    return status;
}
