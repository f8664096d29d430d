#include "host/board/healthtalk.h"
#include "host/link/diagnose.h"

#include <string.h>

#include "common/command.h"
#include "host/board/listen.h"

#define ANSWER_S 10.0

#define TAKE(name, into, flag)                                     \
    if (mr_##name##_get(&(into), bytes, length) == MR_OK)          \
        flag = true;                                               \
    break

/* The board has begun again, or is asked anew: what it said before is over. */
static void forget(struct healthtalk *talk)
{
    talk->restarts_known = talk->upkeep_known = talk->alarm_known = talk->drops_known = talk->health_known = false;
    talk->crashed = false;
    talk->crash = (struct crash_report){0};
    memset(talk->fault, 0, sizeof talk->fault);
}

static enum mr_status take_frame(void *context, const struct mr_frame *frame, struct error *error)
{
    struct healthtalk *talk = context;
    const uint8_t *bytes = frame->payload;
    size_t length = frame->length;
    struct mr_fault fault;
    struct mr_crash crash;
    struct mr_self_test test;
    switch (frame->type) {
    case MR_ID_HELLO:
        if (mr_hello_get(&talk->hello, bytes, length) != MR_OK)
            break;
        if (talk->hello.layout != MR_LAYOUT)
            return error_set(error, MR_VERSION, "board speaks layout %u, this matrig layout %u: %s; use the matrig of its firmware",
                             talk->hello.layout, MR_LAYOUT, link_spec(talk->link));
        talk->hellos++;
        if (frame->seq == 0)
            forget(talk);
        break;
    case MR_ID_ACK:
        talk->acknowledged |= listen_ack(bytes, length, talk->tag, &talk->ack);
        break;
    case MR_ID_FAULT:
        if (mr_fault_get(&fault, bytes, length) == MR_OK && fault.code < MR_FAULT_COUNT)
            talk->fault[fault.code] = fault;
        break;
    case MR_ID_SELF_TEST:
        if (mr_self_test_get(&test, bytes, length) == MR_OK && test.tag == talk->tag) {
            talk->test = test;
            talk->tested = true;
        }
        break;
    case MR_ID_CRASH:
        if (mr_crash_get(&crash, bytes, length) == MR_OK)
            talk->crashed |= crash_take(&talk->crash, &crash);
        break;
    case MR_ID_RESTARTS: TAKE(restarts, talk->restarts, talk->restarts_known);
    case MR_ID_UPKEEP: TAKE(upkeep, talk->upkeep, talk->upkeep_known);
    case MR_ID_CAN_ALARM: TAKE(can_alarm, talk->alarm, talk->alarm_known);
    case MR_ID_CAN_DROPS: TAKE(can_drops, talk->drops, talk->drops_known);
    case MR_ID_HEALTH: TAKE(health, talk->health, talk->health_known);
    default:
        break;
    }
    return MR_OK;
}

/* What comes within a tenth of a second. */
static enum mr_status listen(struct healthtalk *talk, struct error *error)
{
    return listen_tenth(talk->link, &talk->deframer, take_frame, talk, error);
}

static enum mr_status until_hello(struct healthtalk *talk, unsigned hellos, struct error *error)
{
    double until_s = listen_now_s() + ANSWER_S;
    enum mr_status status = MR_OK;
    while (status == MR_OK && talk->hellos < hellos) {
        if (listen_now_s() > until_s)
            return link_no_board(talk->link, error);
        status = listen(talk, error);
    }
    return status;
}

enum mr_status healthtalk_begin(struct healthtalk *talk, struct link *link, struct error *error)
{
    memset(talk, 0, sizeof *talk);
    talk->link = link;
    mr_deframer_init(&talk->deframer);
    return until_hello(talk, 1, error);
}

static enum mr_status order(struct healthtalk *talk, uint8_t code, struct error *error)
{
    uint8_t payload[MR_MESSAGE_MAX], frame[MR_FRAME_MAX];
    struct mr_command command = {.code = code, .tag = ++talk->tag};
    size_t length = mr_command_put(&command, payload);
    double until_s = listen_now_s() + ANSWER_S;
    talk->acknowledged = false;
    enum mr_status status =
        link_send_bytes(talk->link, frame, mr_frame_encode(talk->seq++, MR_ID_COMMAND, payload, length, frame), error);
    while (status == MR_OK && !talk->acknowledged) {
        if (listen_now_s() > until_s)
            return error_set(error, MR_TIMEOUT, "the board does not answer `%s`: %s; is it running and connected?",
                             mr_command_name(code), link_spec(talk->link));
        status = listen(talk, error);
    }
    if (status != MR_OK || talk->ack.status == MR_OK)
        return status;
    if (talk->ack.status == MR_NOT_NOW)
        return error_set(error, MR_NOT_NOW, "the board refuses `%s` now: %s; a landing is armed or going on", mr_command_name(code),
                         link_spec(talk->link));
    return error_set(error, (enum mr_status)talk->ack.status, "the board refuses `%s`: %s; %s", mr_command_name(code),
                     link_spec(talk->link), mr_status_text((enum mr_status)talk->ack.status));
}

enum mr_status healthtalk_hear(struct healthtalk *talk, struct error *error)
{
    forget(talk);
    enum mr_status status = order(talk, MR_COMMAND_STATE, error);
    unsigned hellos = talk->hellos;
    double until_s = listen_now_s() + ANSWER_S;
    /* a whole second of the board, whatever its speed: from one regular hello to the next */
    if (status == MR_OK)
        status = until_hello(talk, hellos + 2, error);
    while (status == MR_OK && !(talk->restarts_known && talk->upkeep_known && talk->alarm_known && talk->drops_known && talk->health_known)) {
        if (listen_now_s() > until_s)
            return error_set(error, MR_TIMEOUT, "the board does not say how it is: %s; is its firmware of this matrig's version?",
                             link_spec(talk->link));
        status = listen(talk, error);
    }
    return status;
}

enum mr_status healthtalk_self_test(struct healthtalk *talk, struct error *error)
{
    double until_s = listen_now_s() + ANSWER_S;
    enum mr_status status = order(talk, MR_COMMAND_SELF_TEST, error);
    while (status == MR_OK && !talk->tested) {
        if (listen_now_s() > until_s)
            return error_set(error, MR_TIMEOUT, "the self-test does not end: %s; reset the board", link_spec(talk->link));
        status = listen(talk, error);
    }
    return status;
}

enum mr_status healthtalk_reset(struct healthtalk *talk, struct error *error)
{
    enum mr_status status = order(talk, MR_COMMAND_RESET, error);
    unsigned hellos = talk->hellos;
    double until_s = listen_now_s() + ANSWER_S;
    /* a hello that was on its way still names the reset before */
    while (status == MR_OK && listen_now_s() < until_s) {
        status = until_hello(talk, ++hellos, error);
        if (status == MR_OK && (talk->hello.reset_cause & 5u) == 4u)
            return MR_OK;
    }
    return status == MR_OK ? error_set(error, MR_TIMEOUT, "the board did not restart: %s; switch it off and on", link_spec(talk->link))
                           : status;
}
