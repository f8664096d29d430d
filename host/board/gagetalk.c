#include "host/board/gagetalk.h"

#include "common/command.h"

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct gagetalk *talk = context;
    (void)error;
    shunts_take(&talk->shunts, message->id, message->payload, message->length);
    if (message->id == MR_ID_ZERO_RESULT && talk->zeros < MR_CHANNELS &&
        mr_zero_result_get(&talk->zero[talk->zeros], message->payload, message->length) == MR_OK)
        talk->zeros++;
    return MR_OK;
}

enum mr_status gagetalk_order(struct gagetalk *talk, struct dialogue *dialogue, unsigned code,
                              int32_t argument, struct error *error)
{
    const struct dialogue_order order = {
        .code = (uint8_t)code, .argument = argument, .answer_s = DIALOGUE_ANSWER_S};
    const char *link = dialogue_spec(dialogue);
    *talk = (struct gagetalk){.zeros = 0};
    dialogue_subscribe(dialogue, take, talk);
    enum mr_status status = dialogue_hello(dialogue, NULL, NULL, error);
    if (status == MR_OK)
        status = dialogue_order(dialogue, &order, &talk->ack, error);
    if (status == MR_TIMEOUT)
        return error_set(
            error, MR_TIMEOUT,
            "the board did not answer within %.0f s: %s; is it powered, are its scans running?",
            DIALOGUE_ANSWER_S, link);
    if (status != MR_OK)
        return status;
    if (talk->ack.status == MR_NOT_NOW)
        return error_set(error, MR_NOT_NOW,
                         "the board is armed, in a landing, or calibrating: %s; disarm it, or wait",
                         link);
    if (talk->ack.status != MR_OK && talk->ack.status != MR_LIMIT)
        return error_set(error, (enum mr_status)talk->ack.status,
                         "the board refused %s (%s): %s; see matrig gages --help",
                         mr_command_name(code), mr_status_text((enum mr_status)talk->ack.status),
                         link);
    return MR_OK;
}
