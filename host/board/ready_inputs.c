/* Requests to a board for the facts of the readiness check. */
#include "host/board/ready.h"

#include <math.h>

#include "common/command.h"
#include "host/board/config_client.h"

#define ANSWER_TIMEOUT_S 1.5
#define SHUNT_TIMEOUT_S  4.0
#define TEST_TIMEOUT_S   5.0
#define BLOCKS_TIMEOUT_S 5.0
#define BOX_TIMEOUT_S    3.0
/* time for the thermometer reading to settle, and for the board to report persisting faults
 * again */
#define SETTLE_TIME_S    3.0
#define LIVE_DURATION_S  20
#define STORED_FAULTS_PERIOD_MS \
    1500u /* board time within which the board sends each past fault once */
#define EMULATED_CLOCK_ERROR_MIN_PPM \
    700.0 /* a larger clock error means that the board is emulated or recorded */

/* A count that the board reports repeatedly, and its increase since the first report. */
struct counter_increase {
    bool is_known;
    uint16_t first;
};

struct input_query {
    struct dialogue *dialogue;
    struct ready_inputs *facts; /* facts that the queries fill in */
    struct error *error;
    double deadline_s; /* time at which the whole check must end, by the dialogue's clock */

    struct config_client config;
    struct mr_block block[READY_BLOCKS_MAX];
    struct counter_increase lost_increase, can_dropped_increase, serial_dropped_increase,
        fault_increase[MR_FAULT_COUNT];
    bool seq_known, is_can_count_started, clock_known;
    uint16_t last_seq;
    uint32_t can_sent_before, first_clock, newest_clock;
    int64_t can_received_count;
    struct timemap time_map;
};

static uint16_t update_increase(struct counter_increase *rise, uint16_t now)
{
    if (!rise->is_known)
        *rise = (struct counter_increase){true, now};
    return (uint16_t)(now - rise->first);
}

static void handle_fault(struct input_query *a, const struct mr_fault *fault)
{
    struct counter_increase *count = &a->fault_increase[fault->code];
    bool early = !a->clock_known || a->newest_clock - a->first_clock < STORED_FAULTS_PERIOD_MS;
    if (!count->is_known && !early)
        *count = (struct counter_increase){.is_known = true};
    a->facts->fault[fault->code] = *fault;
    a->facts->fault_increase[fault->code] = update_increase(count, fault->count);
}

static void handle_clock(struct input_query *a, const struct mr_clock *clock, uint64_t host_us)
{
    if (!a->clock_known)
        a->first_clock = clock->block;
    a->clock_known = true;
    a->newest_clock = clock->block;
    timemap_add(&a->time_map, 1000.0 * (double)clock->block + TIMEMAP_SERIAL_DELAY_US,
                (int64_t)host_us);
}

#define DECODE_MESSAGE(name, into) (mr_##name##_get(&(into), bytes, length) == MR_OK)

static void handle_serial_message(struct input_query *a, const struct dialogue_message *message)
{
    struct ready_inputs *f = a->facts;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    union {
        struct mr_channel_zero zero;
        struct mr_clock clock;
        struct mr_health health;
        struct mr_can_health can;
        struct mr_serial_health serial;
        struct mr_fault fault;
        struct mr_self_test test;
    } m;
    f->serial_frame_count++;
    if (a->seq_known)
        f->serial_lost_count += (uint16_t)(message->seq - a->last_seq - 1u);
    a->last_seq = message->seq;
    a->seq_known = true;
    switch (message->id) {
    case MR_ID_CHANNEL_ZERO:
        if (DECODE_MESSAGE(channel_zero, m.zero) && m.zero.index < MR_CHANNELS) {
            f->zero_received_bits |= 1u << m.zero.index;
            f->zero_measured_bits |= (m.zero.measured ? 1u : 0u) << m.zero.index;
        }
        break;
    case MR_ID_CLOCK:
        if (DECODE_MESSAGE(clock, m.clock))
            handle_clock(a, &m.clock, message->host_us);
        break;
    case MR_ID_BLOCK:
        if (f->block_count < READY_BLOCKS_MAX &&
            mr_block_decode(&a->block[f->block_count], bytes, length) == MR_OK)
            f->block_count++;
        break;
    case MR_ID_HEALTH:
        if (DECODE_MESSAGE(health, m.health))
            f->lost_block_count = update_increase(&a->lost_increase, m.health.blocks_lost);
        break;
    case MR_ID_CAN_HEALTH:
        if (DECODE_MESSAGE(can_health, m.can))
            f->can_dropped_count = update_increase(&a->can_dropped_increase, m.can.dropped);
        break;
    case MR_ID_SERIAL_HEALTH:
        if (DECODE_MESSAGE(serial_health, m.serial))
            f->serial_dropped_count = update_increase(&a->serial_dropped_increase,
                                                      m.serial.dropped);
        break;
    case MR_ID_FAULT:
        if (DECODE_MESSAGE(fault, m.fault) && m.fault.code < MR_FAULT_COUNT)
            handle_fault(a, &m.fault);
        break;
    case MR_ID_SELF_TEST:
        if (DECODE_MESSAGE(self_test, m.test) && m.test.tag == dialogue_tag(a->dialogue)) {
            f->self_test = m.test;
            f->self_test_done = true;
        }
        break;
    case MR_ID_BOX_STATE: f->box_known |= DECODE_MESSAGE(box_state, f->box_state); break;
    case MR_ID_BOX_SPACE: (void)DECODE_MESSAGE(box_space, f->box_space); break;
    case MR_ID_TEMPERATURE:
        f->temperature_known |= DECODE_MESSAGE(temperature, f->temperature);
        break;
    case MR_ID_CAN_ALARM: f->alarm_known |= DECODE_MESSAGE(can_alarm, f->alarm); break;
    case MR_ID_RESTARTS: f->restarts_known |= DECODE_MESSAGE(restarts, f->restarts); break;
    default: shunts_receive(&f->shunts, message->id, bytes, length); break;
    }
}

/* Compares the number of frames received on CAN with the number that the board reports. Ignores
 * frames of other nodes. */
static void handle_can_message(struct input_query *a, const struct dialogue_message *message)
{
    struct mr_can_health health;
    struct ready_inputs *f = a->facts;
    if (!mr_message_find((uint16_t)message->id))
        return;
    identity_receive(&f->board_on_can, message->id, message->payload, message->length);
    if (message->id == MR_ID_CAN_HEALTH &&
        mr_can_health_get(&health, message->payload, message->length) == MR_OK) {
        int64_t lost = (int64_t)(health.sent - a->can_sent_before) - a->can_received_count;
        if (!a->is_can_count_started) {
            a->is_can_count_started = true;
            a->can_sent_before = health.sent;
            a->can_received_count = 0;
        } else {
            f->can_lost_count = lost > 0 ? lost : 0;
        }
    }
    a->can_received_count++;
    f->can_frame_count++;
}

static enum mr_status handle_message(void *context, const struct dialogue_message *message,
                                     struct error *error)
{
    (void)error;
    (message->kind == LINK_CAN ? handle_can_message : handle_serial_message)(context, message);
    return MR_OK;
}

/* Waits, but not beyond the deadline of the whole check. Facts that did not arrive stay unknown. */
static void wait_for(struct input_query *a, dialogue_condition *done, const void *context,
                     double timeout_s)
{
    if (a->error->status == MR_OK)
        (void)dialogue_wait_until(a->dialogue, done, context,
                                  fmin(timeout_s, a->deadline_s - dialogue_now_s(a->dialogue)),
                                  a->error);
}

/* Sends a command and returns the status of the board's answer; MR_TIMEOUT: no answer. */
static enum mr_status send_command(struct input_query *a, uint8_t code, int32_t argument,
                                   double timeout_s)
{
    struct mr_ack ack;
    const struct dialogue_command query = {
        .code = code,
        .argument = argument,
        .answer_timeout_s = fmin(timeout_s, a->deadline_s - dialogue_now_s(a->dialogue))};
    if (a->error->status != MR_OK)
        return MR_TIMEOUT;
    return dialogue_send_command(a->dialogue, &query, &ack, a->error) ?: (enum mr_status)ack.status;
}

static bool has_enough_blocks(const void *facts)
{
    return ((const struct ready_inputs *)facts)->block_count >= READY_BLOCKS_REQUESTED;
}

static bool is_box_searched(const void *facts)
{
    return ((const struct ready_inputs *)facts)->box_state.state != MR_BOX_SCANNING;
}

/* True after SETTLE_TIME_S of board time. An emulated board's time may run faster than this
 * computer's clock. */
static bool has_settle_time_passed(const void *context)
{
    const struct input_query *a = context;
    return a->newest_clock - a->first_clock >= (uint32_t)(1000.0 * SETTLE_TIME_S);
}

static void query_inputs(struct input_query *a)
{
    struct ready_inputs *f = a->facts;
    double begun_s = dialogue_now_s(a->dialogue);
    /* the board answers with its whole configuration, including the zeros */
    (void)send_command(a, MR_COMMAND_STATE, 0, ANSWER_TIMEOUT_S);
    if (send_command(a, MR_COMMAND_LIVE, LIVE_DURATION_S, ANSWER_TIMEOUT_S) == MR_OK) {
        wait_for(a, has_enough_blocks, f, BLOCKS_TIMEOUT_S);
        (void)send_command(a, MR_COMMAND_LIVE, 0, ANSWER_TIMEOUT_S);
    }
    for (unsigned c = 0; c < MR_CHANNELS; c++)
        ready_summarize_channel(&f->config, a->block, f->block_count, c, &f->channel[c]);
    /* the board sends its answer after the results */
    f->shunt_status = send_command(a, MR_COMMAND_SHUNT, 0, SHUNT_TIMEOUT_S);
    f->shunt_done = f->shunt_status != MR_TIMEOUT;
    if (send_command(a, MR_COMMAND_SELF_TEST, 0, ANSWER_TIMEOUT_S) == MR_OK)
        wait_for(a, dialogue_is_flag_set, &f->self_test_done, TEST_TIMEOUT_S);
    f->box_known = false;
    (void)send_command(a, MR_COMMAND_BOX_LIST, 0, ANSWER_TIMEOUT_S);
    wait_for(a, dialogue_is_flag_set, &f->box_known, ANSWER_TIMEOUT_S);
    if (f->box_known) /* During the search for the black box, its state arrives once a second. */
        wait_for(a, is_box_searched, f, BOX_TIMEOUT_S);
    wait_for(a, has_settle_time_passed, a, begun_s + SETTLE_TIME_S - dialogue_now_s(a->dialogue));
    if (f->config.site[0].thermometer)
        wait_for(a, dialogue_is_flag_set, &f->temperature_known, ANSWER_TIMEOUT_S);
    timemap_fit(&a->time_map, EMULATED_CLOCK_ERROR_MIN_PPM, &f->time_fit);
}

enum mr_status ready_query_inputs(struct dialogue *dialogue, double limit_s,
                                  struct ready_inputs *facts, struct error *error)
{
    static struct input_query asking;
    struct input_query *a = &asking;
    *a = (struct input_query){.dialogue = dialogue,
                              .facts = facts,
                              .error = error,
                              .deadline_s = dialogue_now_s(dialogue) + limit_s};
    if (dialogue->link[LINK_CAN])
        facts->can_base = link_base(dialogue->link[LINK_CAN]);
    dialogue_subscribe(dialogue, handle_message, a);
    enum mr_status status = config_client_begin_and_get(&a->config, dialogue, &facts->config,
                                                        &facts->config_crc, error);
    if (status == MR_OK) {
        wait_for(a, dialogue_is_flag_set, &dialogue->identity.key_known, ANSWER_TIMEOUT_S);
        query_inputs(a);
    }
    facts->config_state = a->config.state;
    facts->identity = dialogue->identity;
    return error->status;
}
