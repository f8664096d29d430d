#include "host/board/gage_client.h"

#include <math.h>

#include "common/command.h"

/* ---- shunts ---- */

void shunts_receive(struct shunts *shunts, uint32_t id, const uint8_t *bytes, size_t length)
{
    struct mr_shunt_check check;
    if (id == MR_ID_SHUNT) {
        shunts->has_begun = true;
        shunts->count = 0;
    } else if (id == MR_ID_SHUNT_RESULT) {
        if (shunts->has_begun && shunts->count < MR_GAGES &&
            mr_shunt_result_get(&shunts->result[shunts->count], bytes, length) == MR_OK)
            shunts->check[shunts->count++] = (struct mr_shunt_check){
                .expected_lb = NAN, .change_lb = NAN, .zero_change_lb = NAN};
    } else if (id == MR_ID_SHUNT_CHECK && shunts->count &&
               mr_shunt_check_get(&check, bytes, length) == MR_OK &&
               check.gage == shunts->result[shunts->count - 1].gage) {
        shunts->check[shunts->count - 1] = check;
    }
}

const char *shunts_verdict_text(int64_t verdict)
{
    return verdict >= MR_SHUNT_GOOD && verdict <= MR_SHUNT_WRONG
             ? mr_shunt_verdict_text((unsigned)verdict)
             : "not calibrated";
}

/* ---- zeros and shunts of a board ---- */

static enum mr_status handle_message(void *context, const struct dialogue_message *message,
                                     struct error *error)
{
    struct gage_client *client = context;
    (void)error;
    shunts_receive(&client->shunts, message->id, message->payload, message->length);
    if (message->id == MR_ID_ZERO_RESULT && client->zero_count < MR_CHANNELS &&
        mr_zero_result_get(&client->zero[client->zero_count], message->payload, message->length) ==
            MR_OK)
        client->zero_count++;
    return MR_OK;
}

enum mr_status gage_client_send(struct gage_client *client, struct dialogue *dialogue,
                                unsigned code, int32_t argument, struct error *error)
{
    const struct dialogue_command order = {
        .code = (uint8_t)code, .argument = argument, .answer_timeout_s = DIALOGUE_ANSWER_TIMEOUT_S};
    *client = (struct gage_client){.zero_count = 0};
    dialogue_subscribe(dialogue, handle_message, client);
    enum mr_status status = dialogue_wait_for_hello(dialogue, NULL, NULL, error)
                              ?: dialogue_send_command(dialogue, &order, &client->ack, error);
    if (status == MR_TIMEOUT && error->status == MR_OK)
        return dialogue_set_no_answer_error(dialogue, code, error);
    if (status != MR_OK || client->ack.status == MR_OK || client->ack.status == MR_LIMIT)
        return status;
    return dialogue_set_refusal_error(
        dialogue, &client->ack,
        "the board is armed, in a landing, or calibrating: disarm it, or wait", error);
}
