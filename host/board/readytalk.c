#include "host/board/readytalk.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <string.h>
#include <time.h>

#include "common/command.h"
#include "common/wire.h"
#include "host/board/listen.h"

#define POLL_MS 100
#define HELLO_MS 4000u
#define ANSWER_MS 1500u
#define WORDS_MS 3000u
#define SHUNT_MS 4000u
#define TEST_MS 5000u
#define BLOCKS_MS 5000u
#define BOX_MS 3000u
#define REST_MS 3000u     /* thermometer, and faults that go on */
#define LIVE_S 20
#define WORD_ROUNDS 3
#define FIRST_MS 1500u    /* every fault that ever was has been told once by then, board time */
#define RECEIVE_TURNS 64
#define PACE_PPM 700.0    /* further off the board is emulated, or a recording */

static uint64_t now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000u + (uint64_t)now.tv_nsec / 1000000u;
}

void readytalk_begin(struct readytalk *talk, struct link *serial, struct link *can, struct ready_facts *facts, double limit_s)
{
    memset(talk, 0, sizeof *talk);
    talk->link[LINK_SERIAL] = serial;
    talk->link[LINK_CAN] = can;
    talk->facts = facts;
    talk->tag = (uint16_t)now_ms();
    talk->until_ms = now_ms() + (uint64_t)(1000.0 * limit_s);
    facts->can_used = can != NULL;
    mr_deframer_init(&talk->deframer);
}

/* ---- what comes ---- */

static void take_fault(struct readytalk *talk, const struct mr_fault *fault)
{
    if (fault->code >= MR_FAULT_COUNT)
        return;
    if (!talk->fault_known[fault->code]) {
        bool early = !talk->clock_known || talk->newest_clock - talk->first_clock < FIRST_MS;
        talk->first_fault[fault->code] = early ? fault->count : 0;
        talk->fault_known[fault->code] = true;
    }
    talk->facts->fault[fault->code] = *fault;
    talk->facts->fault_rise[fault->code] = (uint16_t)(fault->count - talk->first_fault[fault->code]);
}

static void take_clock(struct readytalk *talk, const struct mr_clock *clock, uint64_t host_us)
{
    if (!talk->clock_known)
        talk->first_clock = clock->block;
    talk->clock_known = true;
    talk->newest_clock = clock->block;
    timemap_add(&talk->map, 1000.0 * (double)clock->block + TIMEMAP_SERIAL_US, (int64_t)host_us);
}

static void take_shunt(struct readytalk *talk, uint16_t id, const uint8_t *bytes, size_t length)
{
    struct ready_facts *f = talk->facts;
    struct mr_shunt_check check;
    if (id == MR_ID_SHUNT) {
        talk->shunts_begun = true;
        f->shunts = 0;
    } else if (id == MR_ID_SHUNT_RESULT) {
        if (talk->shunts_begun && f->shunts < MR_GAGES && mr_shunt_result_get(&f->shunt[f->shunts], bytes, length) == MR_OK)
            f->shunt_check[f->shunts++] = (struct mr_shunt_check){.expected_lb = NAN, .change_lb = NAN, .zero_change_lb = NAN};
    } else if (f->shunts && mr_shunt_check_get(&check, bytes, length) == MR_OK && check.gage == f->shunt[f->shunts - 1].gage) {
        f->shunt_check[f->shunts - 1] = check;
    }
}

static void take_block(struct readytalk *talk, const uint8_t *bytes, size_t length)
{
    struct mr_block block;
    if (mr_block_get(&block, bytes, length) != MR_OK)
        return;
    if (talk->blocks < READYTALK_BLOCKS)
        talk->block[talk->blocks++] = block;
    if (talk->reading)
        talk->reading(talk->context, &block);
}

static void take_word(struct readytalk *talk, const struct mr_config_image *word)
{
    if (word->words != MR_CONFIG_WORDS || word->offset >= MR_CONFIG_WORDS)
        return;
    mr_put_u32(talk->image + 4u * word->offset, word->value);
    talk->present[word->offset] = 1;
}

static uint16_t rise(bool *known, uint16_t *first, uint16_t now)
{
    if (!*known)
        *first = now;
    *known = true;
    return (uint16_t)(now - *first);
}

static void take_identity(struct readytalk *talk, uint16_t id, const uint8_t *bytes, size_t length)
{
    struct identity *identity = &talk->facts->identity;
    struct mr_board_uid uid;
    struct mr_board_image image;
    if (id == MR_ID_HELLO) {
        talk->facts->hello |= mr_hello_get(&identity->hello, bytes, length) == MR_OK;
    } else if (id == MR_ID_BOARD_UID && mr_board_uid_get(&uid, bytes, length) == MR_OK) {
        identity->uid[0] = uid.uid0;
        identity->uid[1] = uid.uid1;
    } else if (id == MR_ID_BOARD_IMAGE && mr_board_image_get(&image, bytes, length) == MR_OK) {
        identity->uid[2] = image.uid2;
        identity->image_crc = image.image_crc;
    } else if (id == MR_ID_IMAGE_COMMIT) {
        (void)mr_image_commit_get(&identity->commit, bytes, length);
    } else if (id == MR_ID_IMAGE_HEADER && mr_image_header_get(&identity->header, bytes, length) == MR_OK) {
        identity->commit_known = talk->facts->hello; /* the last of them */
    }
}

/* Health of the board and of its links. */
static void take_health(struct readytalk *talk, uint16_t id, const uint8_t *bytes, size_t length)
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
        f->serial_dropped = rise(&talk->serial_dropped_known, &talk->serial_dropped, serial.dropped);
    else if (id == MR_ID_FAULT && mr_fault_get(&fault, bytes, length) == MR_OK)
        take_fault(talk, &fault);
    else if (id == MR_ID_CAN_ALARM)
        f->alarm_known |= mr_can_alarm_get(&f->alarm, bytes, length) == MR_OK;
    else if (id == MR_ID_SELF_TEST) {
        struct mr_self_test test;
        if (mr_self_test_get(&test, bytes, length) == MR_OK && test.tag == talk->tag) {
            f->test = test;
            f->tested = true;
        }
    }
}

static void take_message(struct readytalk *talk, uint16_t id, const uint8_t *bytes, size_t length, uint64_t host_us)
{
    struct ready_facts *f = talk->facts;
    struct mr_clock clock;
    struct mr_edge edge;
    struct mr_switch_event event;
    struct mr_config_image word;
    switch (id) {
    case MR_ID_CLOCK:
        if (mr_clock_get(&clock, bytes, length) == MR_OK)
            take_clock(talk, &clock, host_us);
        break;
    case MR_ID_ACK:
        talk->acknowledged |= listen_ack(bytes, length, talk->tag, &talk->ack);
        break;
    case MR_ID_EDGE:
        if (talk->edge && mr_edge_get(&edge, bytes, length) == MR_OK)
            talk->edge(talk->context, &edge);
        break;
    case MR_ID_SWITCH_EVENT:
        if (talk->event && mr_switch_event_get(&event, bytes, length) == MR_OK)
            talk->event(talk->context, &event);
        break;
    case MR_ID_CONFIG_IMAGE:
        if (mr_config_image_get(&word, bytes, length) == MR_OK)
            take_word(talk, &word);
        break;
    case MR_ID_CONFIG_STATE:
        f->config_state_known |= mr_config_state_get(&f->config_state, bytes, length) == MR_OK;
        break;
    case MR_ID_SHUNT:
    case MR_ID_SHUNT_RESULT:
    case MR_ID_SHUNT_CHECK:
        take_shunt(talk, id, bytes, length);
        break;
    case MR_ID_BOX_STATE:
        f->box_known |= mr_box_state_get(&f->box, bytes, length) == MR_OK;
        break;
    case MR_ID_BOX_SPACE:
        (void)mr_box_space_get(&f->space, bytes, length);
        break;
    case MR_ID_TEMPERATURE:
        f->temperature_known |= mr_temperature_get(&f->temperature, bytes, length) == MR_OK;
        break;
    case MR_ID_BLOCK:
        take_block(talk, bytes, length);
        break;
    default:
        take_identity(talk, id, bytes, length);
        take_health(talk, id, bytes, length);
        break;
    }
}

static enum mr_status take_serial(struct readytalk *talk, struct error *error)
{
    uint8_t bytes[16384];
    size_t length;
    uint64_t host_us;
    struct ready_facts *f = talk->facts;
    enum mr_status status = link_receive_bytes(talk->link[LINK_SERIAL], bytes, sizeof bytes, &length, &host_us, error);
    for (size_t i = 0; status == MR_OK && i < length; i++) {
        struct mr_frame frame;
        if (mr_deframer_push(&talk->deframer, bytes[i], &frame) != MR_OK)
            continue;
        f->serial_frames++;
        if (talk->seq_known)
            f->serial_lost += (uint16_t)(frame.seq - talk->last_seq - 1u);
        talk->last_seq = frame.seq;
        talk->seq_known = true;
        take_message(talk, frame.type, frame.payload, frame.length, host_us);
    }
    return status;
}

/* CAN is only listened to: how much of what the board queued came. */
static enum mr_status take_can(struct readytalk *talk, struct error *error)
{
    struct link_frame frame;
    struct mr_can_health health;
    struct ready_facts *f = talk->facts;
    enum mr_status status = link_receive_frame(talk->link[LINK_CAN], &frame, error);
    if (status != MR_OK || frame.id & (LINK_ID_ERROR | LINK_ID_REMOTE | LINK_ID_EXTENDED))
        return status;
    if (frame.id == MR_ID_CAN_HEALTH && mr_can_health_get(&health, frame.data, frame.length) == MR_OK) {
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
    return MR_OK;
}

enum mr_status readytalk_listen(struct readytalk *talk, struct error *error)
{
    struct pollfd ready[LINK_KINDS];
    bool any = false;
    enum mr_status status;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct error away = {0};
        ready[kind] = (struct pollfd){.fd = -1, .events = POLLIN};
        if (!talk->link[kind])
            continue;
        status = MR_OK;
        for (int turn = 0; status == MR_OK && turn < RECEIVE_TURNS; turn++) {
            status = kind == LINK_CAN ? take_can(talk, error) : take_serial(talk, error);
            any |= status == MR_OK;
        }
        if (status == MR_CLOSED)
            return error_set(error, MR_CLOSED, "the board closed the link: %s; is it still running?", link_spec(talk->link[kind]));
        if (status != MR_OK && status != MR_TOO_FEW)
            return status;
        status = link_service(talk->link[kind], &away);
        if (status != MR_OK && status != MR_TOO_FEW)
            return error_set(error, status, "%s", away.text);
        ready[kind].fd = link_fd(talk->link[kind]);
    }
    if (!any && poll(ready, LINK_KINDS, POLL_MS) < 0 && errno != EINTR)
        return error_set(error, MR_IO, "cannot wait (%s): the links; try again", strerror(errno));
    return MR_OK;
}

/* ---- asking ---- */

/* Until `*what`, at most `most_ms` and until all of it must end. */
static enum mr_status wait_for(struct readytalk *talk, const bool *what, unsigned most_ms, struct error *error)
{
    enum mr_status status = MR_OK;
    uint64_t until_ms = now_ms() + most_ms;
    while (status == MR_OK && !*what && now_ms() < until_ms && now_ms() < talk->until_ms)
        status = readytalk_listen(talk, error);
    return status;
}

/* talk->acknowledged says whether an answer came. */
static enum mr_status order(struct readytalk *talk, uint8_t code, int32_t argument, unsigned most_ms, struct error *error)
{
    uint8_t payload[MR_MESSAGE_MAX], frame[MR_FRAME_MAX];
    struct mr_command command = {.code = code, .argument = argument, .tag = ++talk->tag};
    size_t length = mr_command_put(&command, payload);
    talk->acknowledged = false;
    enum mr_status status =
        link_send_bytes(talk->link[LINK_SERIAL], frame, mr_frame_encode(talk->seq++, MR_ID_COMMAND, payload, length, frame), error);
    return status == MR_OK ? wait_for(talk, &talk->acknowledged, most_ms, error) : status;
}

static unsigned first_absent(const struct readytalk *talk)
{
    unsigned word = 0;
    while (word < MR_CONFIG_WORDS && talk->present[word])
        word++;
    return word;
}

static enum mr_status read_configuration(struct readytalk *talk, struct error *error)
{
    struct ready_facts *f = talk->facts;
    enum mr_status status = MR_OK;
    for (int round = 0; status == MR_OK && round < WORD_ROUNDS && first_absent(talk) < MR_CONFIG_WORDS; round++) {
        bool last = false;
        uint64_t until_ms = now_ms() + WORDS_MS;
        status = order(talk, MR_COMMAND_CONFIG_READ, (int32_t)first_absent(talk), ANSWER_MS, error);
        while (status == MR_OK && talk->acknowledged && talk->ack.status == MR_OK && !last && now_ms() < until_ms && now_ms() < talk->until_ms) {
            status = readytalk_listen(talk, error);
            last = talk->present[MR_CONFIG_WORDS - 1] != 0;
        }
    }
    if (status != MR_OK || first_absent(talk) < MR_CONFIG_WORDS)
        return status;
    const uint8_t *p = talk->image + MR_CONFIG_IMAGE - 4;
    f->config_crc = mr_get_u32(&p);
    f->config_known = mr_config_decode(talk->image, MR_CONFIG_IMAGE, &f->config) == MR_OK;
    return MR_OK;
}

enum mr_status readytalk_meet(struct readytalk *talk, struct error *error)
{
    struct ready_facts *f = talk->facts;
    enum mr_status status = wait_for(talk, &f->identity.commit_known, HELLO_MS, error);
    if (status != MR_OK || !f->hello)
        return status;
    if (f->identity.hello.layout != MR_LAYOUT)
        return error_set(error, MR_VERSION, "board speaks layout %u, this matrig layout %u: %s; use the matrig of its firmware",
                         f->identity.hello.layout, MR_LAYOUT, link_spec(talk->link[LINK_SERIAL]));
    if (f->identity.hello.state == MR_LANDING_DONE) { /* a landing that is done is kept: nothing ends but its state */
        status = order(talk, MR_COMMAND_DISARM, 0, ANSWER_MS, error);
        if (status == MR_OK && talk->acknowledged && talk->ack.status == MR_OK)
            f->identity.hello.state = 0;
    }
    return status == MR_OK ? read_configuration(talk, error) : status;
}

enum mr_status readytalk_live(struct readytalk *talk, int seconds, struct error *error)
{
    enum mr_status status = order(talk, MR_COMMAND_LIVE, seconds, ANSWER_MS, error);
    if (status != MR_OK)
        return status;
    return talk->acknowledged ? (enum mr_status)talk->ack.status : MR_TIMEOUT;
}

static enum mr_status ask_shunts(struct readytalk *talk, struct error *error)
{
    enum mr_status status = order(talk, MR_COMMAND_SHUNT, 0, SHUNT_MS, error); /* answered when it is over, after its results */
    talk->facts->shunt_done = talk->acknowledged;
    talk->facts->shunt_status = (enum mr_status)talk->ack.status;
    return status;
}

static enum mr_status ask_box(struct readytalk *talk, struct error *error)
{
    uint64_t until_ms = now_ms() + BOX_MS;
    struct ready_facts *f = talk->facts;
    f->box_known = false;
    enum mr_status status = order(talk, MR_COMMAND_BOX_LIST, 0, ANSWER_MS, error);
    if (status == MR_OK)
        status = wait_for(talk, &f->box_known, ANSWER_MS, error);
    while (status == MR_OK && f->box_known && f->box.state == MR_BOX_LOOKING && now_ms() < until_ms && now_ms() < talk->until_ms)
        status = readytalk_listen(talk, error); /* it is still being looked through, and told once a second */
    return status;
}

enum mr_status readytalk_ask(struct readytalk *talk, struct error *error)
{
    struct ready_facts *f = talk->facts;
    uint64_t begun_ms = now_ms();
    enum mr_status live = readytalk_live(talk, LIVE_S, error);
    enum mr_status status = error->status;
    while (status == MR_OK && live == MR_OK && talk->blocks < READY_BLOCKS && now_ms() < begun_ms + BLOCKS_MS && now_ms() < talk->until_ms)
        status = readytalk_listen(talk, error);
    f->blocks = talk->blocks;
    if (f->config_known) {
        for (unsigned c = 0; c < MR_CHANNELS; c++)
            ready_measure(&f->config, talk->block, talk->blocks, c, &f->channel[c]);
    }
    if (status == MR_OK && live == MR_OK)
        (void)readytalk_live(talk, 0, error);
    if (error->status == MR_OK)
        status = ask_shunts(talk, error);
    if (status == MR_OK)
        status = order(talk, MR_COMMAND_SELF_TEST, 0, ANSWER_MS, error);
    if (status == MR_OK && talk->acknowledged && talk->ack.status == MR_OK)
        status = wait_for(talk, &f->tested, TEST_MS, error);
    if (status == MR_OK)
        status = ask_box(talk, error);
    while (status == MR_OK && now_ms() < begun_ms + REST_MS && talk->newest_clock - talk->first_clock < REST_MS && now_ms() < talk->until_ms)
        status = readytalk_listen(talk, error);
    if (status == MR_OK && !f->temperature_known && f->config_known && f->config.site[0].thermometer)
        status = wait_for(talk, &f->temperature_known, ANSWER_MS, error);
    timemap_fit(&talk->map, PACE_PPM, &f->time);
    return status;
}
