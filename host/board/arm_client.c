#include "host/board/arm_client.h"

#include <math.h>

#include "common/command.h"

#define STATE_S 2.0 /* the board sends its state on change and once a second */

const char *arm_client_refusal(enum mr_status answer)
{
    switch (answer) {
    case MR_WAIT:
        return "the black box is not ready for a landing yet, or a calibration is in progress; try "
               "again in a moment";
    case MR_FULL:
        return "the black box has no room for a landing; read its records and free them (matrig "
               "board list)";
    case MR_NOT_NOW:
        return "not possible in the present state of the board: it is armed, in a landing, or not "
               "measuring; disarm it, or see matrig board health";
    default: return mr_status_text(answer);
    }
}

bool arm_client_recording(unsigned state)
{
    return state == MR_LANDING_ARMED || state == MR_LANDING_LANDING || state == MR_LANDING_SETTLING;
}

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct arm_client *talk = context;
    (void)error;
    if (message->id == MR_ID_LANDING) {
        talk->landing_told |= mr_landing_get(&talk->landing, message->payload, message->length) ==
                              MR_OK;
        talk->landing_known |= talk->landing_told;
    } else if (message->id == MR_ID_BOX_STATE) {
        talk->wait_known |= mr_box_state_get(&talk->box, message->payload, message->length) ==
                            MR_OK;
    }
    return MR_OK;
}

enum mr_status arm_client_begin(struct arm_client *talk, struct dialogue *dialogue,
                                struct error *error)
{
    *talk = (struct arm_client){.dialogue = dialogue};
    dialogue_subscribe(dialogue, take, talk);
    return dialogue_hello(dialogue, dialogue_flag, &talk->landing_known, error);
}

static enum mr_status refused(const struct arm_client *talk, const struct mr_ack *ack,
                              struct error *error)
{
    enum mr_status answer = (enum mr_status)ack->status;
    const char *name = mr_command_name(ack->code), *link = dialogue_spec(talk->dialogue);
    if (answer == MR_NOT_NOW && ack->code == MR_COMMAND_ARM &&
        arm_client_recording(talk->landing.state))
        return error_set(error, answer,
                         "the board refused `arm`: %s; it is %s, with landing %u: wait for the end "
                         "of the landing, or disarm the board",
                         link, mr_landing_state_text(talk->landing.state), talk->landing.landing);
    if (answer == MR_WAIT && talk->wait_known && talk->box.wait_s > 0.0f)
        return error_set(error, answer,
                         "the board refused `%s`: %s; its black box is ready in about %.0f s", name,
                         link, ceil((double)talk->box.wait_s));
    return error_set(error, answer, "the board refused `%s`: %s; %s", name, link,
                     arm_client_refusal(answer));
}

static bool is_reached(const void *context)
{
    const struct arm_client *talk = context;
    return talk->landing_told && talk->landing.state == talk->wanted;
}

/* If the answer is lost: the order worked if the state changed to the wanted one. */
static bool has_changed(const void *context)
{
    const struct arm_client *talk = context;
    return is_reached(talk) && talk->before != talk->wanted;
}

enum mr_status arm_client_order(struct arm_client *talk, uint8_t code, int32_t number,
                                struct error *error)
{
    const struct dialogue_command order = {.code = code,
                                           .argument = number,
                                           .answer_s = ARM_CLIENT_ANSWER_S,
                                           .taken = has_changed,
                                           .context = talk};
    struct mr_ack ack;
    talk->wanted = code == MR_COMMAND_ARM ? MR_LANDING_ARMED : MR_LANDING_IDLE;
    talk->before = talk->landing.state;
    talk->landing_told = talk->wait_known = false;
    enum mr_status status = dialogue_send_command(talk->dialogue, &order, &ack, error);
    if (status == MR_TIMEOUT)
        return error_set(
            error, MR_TIMEOUT,
            "the board did not answer `%s` within %d s: %s; check its state before you try again",
            mr_command_name(code), ARM_CLIENT_ANSWER_S, dialogue_spec(talk->dialogue));
    if (status == MR_OK && ack.status != MR_OK)
        return refused(talk, &ack, error);
    if (status == MR_OK)
        status = dialogue_until(talk->dialogue, is_reached, talk, STATE_S, error);
    return status == MR_TIMEOUT
             ? error_set(
                   error, MR_TIMEOUT,
                   "the board accepted `%s` but did not report the state %s: %s; check its state",
                   mr_command_name(code), mr_landing_state_text(talk->wanted),
                   dialogue_spec(talk->dialogue))
             : status;
}
