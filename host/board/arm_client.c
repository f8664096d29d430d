#include "host/board/arm_client.h"

#include <math.h>

#include "common/command.h"

#define STATE_TIMEOUT_S 2.0 /* the board sends its state on change and once a second */

const char *arm_client_refusal_text(enum mr_status answer)
{
    switch (answer) {
    case MR_WAIT:
        return "the black box is not ready for a landing yet, or a calibration is in progress; try "
               "again in a moment";
    case MR_FULL:
        return "the black box has no room for a landing; read its records and free them (matrig "
               "board list)";
    case MR_NOT_NOW:
        return "the board is armed, in a landing, or does not measure; disarm the board, or see "
               "matrig board health";
    default: return mr_status_text(answer);
    }
}

bool arm_client_is_recording(unsigned state)
{
    return state == MR_LANDING_ARMED || state == MR_LANDING_LANDING || state == MR_LANDING_SETTLING;
}

static enum mr_status handle_message(void *context, const struct dialogue_message *message,
                                     struct error *error)
{
    struct arm_client *client = context;
    (void)error;
    if (message->id == MR_ID_LANDING) {
        client->landing_state_received |= mr_landing_get(&client->landing, message->payload,
                                                         message->length) == MR_OK;
        client->landing_known |= client->landing_state_received;
    } else if (message->id == MR_ID_BOX_STATE) {
        client->box_state_known |= mr_box_state_get(&client->box_state, message->payload,
                                                    message->length) == MR_OK;
    }
    return MR_OK;
}

enum mr_status arm_client_begin(struct arm_client *client, struct dialogue *dialogue,
                                struct error *error)
{
    *client = (struct arm_client){.dialogue = dialogue};
    dialogue_subscribe(dialogue, handle_message, client);
    return dialogue_wait_for_hello(dialogue, dialogue_is_flag_set, &client->landing_known, error);
}

static enum mr_status set_refusal_error(const struct arm_client *client, const struct mr_ack *ack,
                                        struct error *error)
{
    enum mr_status answer = (enum mr_status)ack->status;
    const char *name = mr_command_name(ack->code), *link = dialogue_spec(client->dialogue);
    if (answer == MR_NOT_NOW && ack->code == MR_COMMAND_ARM &&
        arm_client_is_recording(client->landing.state))
        return error_set(
            error, answer,
            "the board refused `arm`: %s; the board is %s, with landing %u: wait for the end "
            "of the landing, or disarm the board",
            link, mr_landing_state_text(client->landing.state), client->landing.landing);
    if (answer == MR_WAIT && client->box_state_known && client->box_state.wait_s > 0.0f)
        return error_set(
            error, answer,
            "the board refused `%s`: %s; try again in about %.0f s, when the black box is ready",
            name, link, ceil((double)client->box_state.wait_s));
    return error_set(error, answer, "the board refused `%s`: %s; %s", name, link,
                     arm_client_refusal_text(answer));
}

static bool is_state_reached(const void *context)
{
    const struct arm_client *client = context;
    return client->landing_state_received && client->landing.state == client->wanted_state;
}

/* Checks whether the board has reached the wanted landing state. Used if the answer is lost. */
static bool has_landing_state_changed(const void *context)
{
    const struct arm_client *client = context;
    return is_state_reached(client) && client->previous_state != client->wanted_state;
}

enum mr_status arm_client_send(struct arm_client *client, uint8_t code, int32_t number,
                               struct error *error)
{
    const struct dialogue_command order = {.code = code,
                                           .argument = number,
                                           .answer_timeout_s = ARM_CLIENT_ANSWER_TIMEOUT_S,
                                           .was_executed = has_landing_state_changed,
                                           .context = client};
    struct mr_ack ack;
    client->wanted_state = code == MR_COMMAND_ARM ? MR_LANDING_ARMED : MR_LANDING_IDLE;
    client->previous_state = client->landing.state;
    client->landing_state_received = client->box_state_known = false;
    enum mr_status status = dialogue_send_command(client->dialogue, &order, &ack, error);
    if (status == MR_TIMEOUT)
        return error_set(error, MR_TIMEOUT,
                         "the board did not answer `%s` within %d s: %s; before you try again, "
                         "check the state of the board",
                         mr_command_name(code), ARM_CLIENT_ANSWER_TIMEOUT_S,
                         dialogue_spec(client->dialogue));
    if (status == MR_OK && ack.status != MR_OK)
        return set_refusal_error(client, &ack, error);
    if (status == MR_OK)
        status = dialogue_wait_until(client->dialogue, is_state_reached, client, STATE_TIMEOUT_S,
                                     error);
    return status == MR_TIMEOUT
             ? error_set(error, MR_TIMEOUT,
                         "the board accepted `%s` but did not report the state %s: %s; check the "
                         "state of the board with matrig ready",
                         mr_command_name(code), mr_landing_state_text(client->wanted_state),
                         dialogue_spec(client->dialogue))
             : status;
}
