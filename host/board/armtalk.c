#include "host/board/armtalk.h"
#include "host/link/diagnose.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/command.h"
#include "host/board/listen.h"
#include "host/collect/collect.h"

#define HELLO_S 10.0
#define ANSWER_S 3.0 /* as the live page waits */
#define STATE_S 2.0  /* it is told on change, and once a second */

const char *armtalk_refusal(enum mr_status answer)
{
    switch (answer) {
    case MR_WAIT:
        return "the black box is not ready for a landing yet, or a calibration is under way; try again in a moment";
    case MR_FULL:
        return "the black box has no room for a landing; fetch its records and free them (matrig board list)";
    case MR_NOT_NOW:
        return "not in this state of the board: it is armed, a landing is going on, or nothing is measured; disarm it, or see matrig "
               "board health";
    default:
        return mr_status_text(answer);
    }
}

bool armtalk_recording(unsigned state)
{
    return state == MR_LANDING_ARMED || state == MR_LANDING_LANDING || state == MR_LANDING_SETTLING;
}

static enum mr_status take(void *context, uint32_t id, const uint8_t *bytes, size_t length, struct error *error)
{
    struct armtalk *talk = context;
    switch (id) {
    case MR_ID_HELLO:
        talk->hello = true;
        return listen_hello(talk->link, bytes, length, error);
    case MR_ID_LANDING:
        talk->landing_told |= mr_landing_get(&talk->landing, bytes, length) == MR_OK;
        talk->landing_known |= talk->landing_told;
        break;
    case MR_ID_BOX_STATE:
        talk->wait_known |= mr_box_state_get(&talk->box, bytes, length) == MR_OK;
        break;
    case MR_ID_ACK:
        talk->acknowledged |= listen_ack(bytes, length, talk->tag, &talk->ack);
        break;
    default:
        break;
    }
    return MR_OK;
}

static enum mr_status listen(struct armtalk *talk, struct error *error)
{
    return listen_either(talk->link, talk->kind, &talk->deframer, take, talk, error);
}

enum mr_status armtalk_begin(struct armtalk *talk, struct link *link, enum link_kind kind, struct error *error)
{
    double until_s = listen_now_s() + HELLO_S;
    enum mr_status status = MR_OK;
    *talk = (struct armtalk){.link = link, .kind = kind, .tag = (uint16_t)(link_now_us() / 1000u)}; /* not that of who else asks */
    mr_deframer_init(&talk->deframer);
    while (status == MR_OK && !(talk->hello && talk->landing_known)) {
        if (listen_now_s() > until_s)
            return link_no_board(link, error);
        status = listen(talk, error);
    }
    return status;
}

static enum mr_status refused(const struct armtalk *talk, uint8_t code, struct error *error)
{
    enum mr_status answer = (enum mr_status)talk->ack.status;
    const char *name = mr_command_name(code), *link = link_spec(talk->link);
    if (answer == MR_NOT_NOW && code == MR_COMMAND_ARM && armtalk_recording(talk->landing.state))
        return error_set(error, answer, "the board refuses `arm`: %s; it is %s, with landing %u: wait for its end, or disarm it", link,
                         mr_landing_state_text(talk->landing.state), talk->landing.landing);
    if (answer == MR_WAIT && talk->wait_known && talk->box.wait_s > 0.0f)
        return error_set(error, answer, "the board refuses `%s`: %s; its black box is ready in about %.0f s", name, link,
                         ceil((double)talk->box.wait_s));
    return error_set(error, answer, "the board refuses `%s`: %s; %s", name, link, armtalk_refusal(answer));
}

enum mr_status armtalk_order(struct armtalk *talk, uint8_t code, int32_t number, struct error *error)
{
    uint8_t payload[MR_MESSAGE_MAX];
    unsigned wanted = code == MR_COMMAND_ARM ? MR_LANDING_ARMED : MR_LANDING_IDLE, before = talk->landing.state;
    struct mr_command command = {.code = code, .argument = number, .tag = ++talk->tag};
    talk->acknowledged = talk->landing_told = talk->wait_known = false;
    enum mr_status status = listen_send(talk->link, talk->kind, &talk->seq, MR_ID_COMMAND, payload, mr_command_put(&command, payload), error);
    for (double until_s = listen_now_s() + ANSWER_S; status == MR_OK && !talk->acknowledged && listen_now_s() < until_s;)
        status = listen(talk, error);
    bool reached = talk->landing_told && talk->landing.state == wanted;
    if (status != MR_OK)
        return status;
    if (!talk->acknowledged && reached && before != wanted) /* only the answer was lost */
        return MR_OK;
    if (!talk->acknowledged)
        return error_set(error, MR_TIMEOUT, "the board does not answer `%s` within %.0f s: %s; look what state it is in before trying again",
                         mr_command_name(code), ANSWER_S, link_spec(talk->link));
    if (talk->ack.status != MR_OK)
        return refused(talk, code, error);
    for (double until_s = listen_now_s() + STATE_S; status == MR_OK && !reached && listen_now_s() < until_s;) {
        status = listen(talk, error);
        reached = talk->landing_told && talk->landing.state == wanted;
    }
    return status == MR_OK && !reached
               ? error_set(error, MR_TIMEOUT, "the board took `%s` and does not say it is %s: %s; look what state it is in",
                           mr_command_name(code), mr_landing_state_text(wanted), link_spec(talk->link))
               : status;
}
