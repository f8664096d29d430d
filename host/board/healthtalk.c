#include "host/board/healthtalk.h"

#include <string.h>

#include "common/command.h"

#define ANSWER_S DIALOGUE_ANSWER_S

#define TAKE(name, into, flag)                            \
    if (mr_##name##_get(&(into), bytes, length) == MR_OK) \
        flag = true;                                      \
    break

/* The board has begun again, or is asked anew: what it said before is over. */
static void forget(struct healthtalk *talk)
{
    talk->restarts_known = talk->upkeep_known = talk->alarm_known = talk->drops_known =
        talk->health_known = false;
    talk->crashed = false;
    talk->crash = (struct crash_report){0};
    memset(talk->fault, 0, sizeof talk->fault);
}

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct healthtalk *talk = context;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    struct mr_fault fault;
    struct mr_crash crash;
    struct mr_self_test test;
    (void)error;
    switch (message->id) {
    case MR_ID_HELLO:
        if (mr_hello_get(&talk->hello, bytes, length) != MR_OK)
            break;
        talk->hellos++;
        if (message->seq == 0)
            forget(talk);
        break;
    case MR_ID_FAULT:
        if (mr_fault_get(&fault, bytes, length) == MR_OK && fault.code < MR_FAULT_COUNT)
            talk->fault[fault.code] = fault;
        break;
    case MR_ID_SELF_TEST:
        if (mr_self_test_get(&test, bytes, length) == MR_OK &&
            test.tag == dialogue_tag(talk->dialogue)) {
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
    default: break;
    }
    return MR_OK;
}

static bool greeted(const void *context)
{
    const struct healthtalk *talk = context;
    return talk->hellos >= talk->wanted;
}

static enum mr_status until_hello(struct healthtalk *talk, unsigned hellos, struct error *error)
{
    talk->wanted = hellos;
    enum mr_status status = dialogue_until(talk->dialogue, greeted, talk, ANSWER_S, error);
    return status == MR_TIMEOUT ? dialogue_no_hello(talk->dialogue, error) : status;
}

enum mr_status healthtalk_begin(struct healthtalk *talk, struct dialogue *dialogue,
                                struct error *error)
{
    memset(talk, 0, sizeof *talk);
    talk->dialogue = dialogue;
    dialogue_subscribe(dialogue, take, talk);
    return dialogue_hello(dialogue, NULL, NULL, error);
}

static enum mr_status order(struct healthtalk *talk, uint8_t code, struct error *error)
{
    struct mr_ack ack;
    enum mr_status status = dialogue_order(
        talk->dialogue, &(struct dialogue_order){.code = code, .answer_s = ANSWER_S}, &ack, error);
    if (status == MR_TIMEOUT)
        return dialogue_lost(talk->dialogue, code, error);
    if (status != MR_OK || ack.status == MR_OK)
        return status;
    return dialogue_refused(talk->dialogue, &ack, "a landing is armed or going on", error);
}

static bool all_known(const void *context)
{
    const struct healthtalk *talk = context;
    return talk->restarts_known && talk->upkeep_known && talk->alarm_known && talk->drops_known &&
           talk->health_known;
}

enum mr_status healthtalk_hear(struct healthtalk *talk, struct error *error)
{
    forget(talk);
    enum mr_status status = order(talk, MR_COMMAND_STATE, error);
    /* a whole second of the board, whatever its speed: from one regular hello to the next */
    if (status == MR_OK)
        status = until_hello(talk, talk->hellos + 2, error);
    if (status == MR_OK)
        status = dialogue_until(talk->dialogue, all_known, talk, ANSWER_S, error);
    return status == MR_TIMEOUT ? error_set(error, MR_TIMEOUT,
                                            "the board does not say how it is: %s; is its firmware "
                                            "of this matrig's version?",
                                            dialogue_spec(talk->dialogue))
                                : status;
}

enum mr_status healthtalk_self_test(struct healthtalk *talk, struct error *error)
{
    enum mr_status status = order(talk, MR_COMMAND_SELF_TEST, error);
    if (status == MR_OK)
        status = dialogue_until(talk->dialogue, dialogue_flag, &talk->tested, ANSWER_S, error);
    return status == MR_TIMEOUT
             ? error_set(error, MR_TIMEOUT, "the self-test does not end: %s; reset the board",
                         dialogue_spec(talk->dialogue))
             : status;
}

enum mr_status healthtalk_reset(struct healthtalk *talk, struct error *error)
{
    enum mr_status status = order(talk, MR_COMMAND_RESET, error);
    unsigned hellos = talk->hellos;
    double until_s = dialogue_now_s(talk->dialogue) + ANSWER_S;
    /* a hello that was on its way still names the reset before */
    while (status == MR_OK && dialogue_now_s(talk->dialogue) < until_s) {
        status = until_hello(talk, ++hellos, error);
        if (status == MR_OK && (talk->hello.reset_cause & 5u) == 4u)
            return MR_OK;
    }
    return status == MR_OK
             ? error_set(error, MR_TIMEOUT, "the board did not restart: %s; switch it off and on",
                         dialogue_spec(talk->dialogue))
             : status;
}
