#include "host/board/runway_client.h"

#include <math.h>
#include <string.h>

#include "common/command.h"
#include "common/runway.h"

/* ---- runway ---- */

#define ATTEMPTS_MAX 3

static void handle_joints(struct runway_client *client, const struct mr_runway_joints *joints)
{
    if (client->received_part_count >= mr_runway_message_count(&client->state) ||
        joints->index != 1u + MR_RUNWAY_JOINTS_PER_MESSAGE * client->received_part_count)
        return;
    mr_runway_apply_message(&client->state, joints);
    client->is_complete = ++client->received_part_count == mr_runway_message_count(&client->state);
}

static enum mr_status handle_message(void *context, const struct dialogue_message *message,
                                     struct error *error)
{
    struct runway_client *client = context;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    struct mr_runway runway;
    struct mr_runway_joints joints;
    (void)error;
    if (message->id == MR_ID_HELLO) {
        client->hello_received = true;
    } else if (message->id == MR_ID_RUNWAY_STORE) {
        client->stored_known |= mr_runway_store_get(&client->stored, bytes, length) == MR_OK;
        client->is_memory_read = client->stored_known &&
                                 client->stored.copy_a != MR_RUNWAY_NOT_READ;
    } else if (message->id == MR_ID_RUNWAY && mr_runway_get(&runway, bytes, length) == MR_OK) {
        client->state = (struct mr_predictor_state){.mats = runway.mats,
                                                    .landing_count = runway.landings,
                                                    .resistance_scale = runway.resistance};
        client->received_part_count = 0;
        client->is_complete = false;
    } else if (message->id == MR_ID_RUNWAY_JOINTS &&
               mr_runway_joints_get(&joints, bytes, length) == MR_OK) {
        handle_joints(client, &joints);
    }
    return MR_OK;
}

static enum mr_status wait_for(struct runway_client *client, const bool *what, const char *name,
                               struct error *error)
{
    enum mr_status status = dialogue_wait_until(client->dialogue, dialogue_is_flag_set, what,
                                                DIALOGUE_ANSWER_TIMEOUT_S, error);
    return status == MR_TIMEOUT
             ? error_set(error, MR_TIMEOUT,
                         "the board did not %s within %.0f s: %s; check that the board is running "
                         "and has a predictor",
                         name, DIALOGUE_ANSWER_TIMEOUT_S, dialogue_spec(client->dialogue))
             : status;
}

enum mr_status runway_client_begin(struct runway_client *client, struct dialogue *dialogue,
                                   struct error *error)
{
    *client = (struct runway_client){.dialogue = dialogue};
    dialogue_subscribe(dialogue, handle_message, client);
    enum mr_status status = dialogue_wait_for_hello(dialogue, NULL, NULL, error);
    return status ?: wait_for(client, &client->is_memory_read, "read its memory", error);
}

static enum mr_status send_command(struct dialogue *dialogue, unsigned code, unsigned index,
                                   int32_t argument, struct error *error)
{
    const struct dialogue_command order = {.code = (uint8_t)code,
                                           .index = (uint8_t)index,
                                           .argument = argument,
                                           .answer_timeout_s = DIALOGUE_ANSWER_TIMEOUT_S};
    const char *link = dialogue_spec(dialogue);
    struct mr_ack ack;
    enum mr_status status = dialogue_send_command(dialogue, &order, &ack, error);
    if (status == MR_TIMEOUT)
        return dialogue_set_no_answer_error(dialogue, code, error);
    if (status != MR_OK || ack.status == MR_OK)
        return status;
    if (ack.status == MR_MALFORMED)
        return error_set(error, MR_MALFORMED,
                         "the board refused this runway: %s; give a runway with the board's number "
                         "of mats, in which no opening exceeds the slack of a joint",
                         link);
    if (ack.status == MR_VERSION)
        return error_set(error, MR_VERSION,
                         "the chart is for a different runway than that of the board, with a "
                         "different number of landings: %s; run matrig advise again",
                         link);
    return dialogue_set_refusal_error(
        dialogue, &ack,
        "wait until no landing is armed or in progress, or switch the predictor on (predict.fitted "
        "of the board's configuration)",
        error);
}

enum mr_status runway_client_read(struct runway_client *client, struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned round = 0; status == MR_OK && round < ATTEMPTS_MAX; round++) {
        client->is_complete = client->stored_known = false;
        status = send_command(client->dialogue, MR_COMMAND_RUNWAY_READ, 0, 0, error) ?:
                 wait_for(client, &client->is_complete, "send its whole runway", error) ?:
                 wait_for(client, &client->stored_known, "report the origin of its runway", error);
        if (status == MR_OK && mr_runway_crc(&client->state) == client->stored.crc)
            return MR_OK;
    }
    return status != MR_OK
             ? status
             : error_set(error, MR_CRC,
                         "the runway data was damaged on the link: %s; check the cable",
                         dialogue_spec(client->dialogue));
}

/* Waits until the board has stored the new runway, which it does after half a second; it then
 * reports that in its hello, once a second. */
static enum mr_status wait_until_stored(struct runway_client *client, struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < 2 && status == MR_OK; i++) {
        client->hello_received = false;
        status = wait_for(client, &client->hello_received, "send another hello", error);
    }
    return status;
}

enum mr_status runway_client_load(struct runway_client *client,
                                  const struct mr_predictor_state *state, struct error *error)
{
    enum mr_status status = runway_client_read(client, error);
    if (status == MR_OK && client->state.mats != state->mats)
        status = error_set(error, MR_LIMIT,
                           "the file has a runway of %u mats, but the board has one of %u: %s; "
                           "check site.mats of the board's configuration",
                           state->mats, client->state.mats, dialogue_spec(client->dialogue));
    for (unsigned i = 0; status == MR_OK && i < MR_RUNWAY_WORD_COUNT; i++)
        status = send_command(client->dialogue, MR_COMMAND_RUNWAY_WORD, i,
                              mr_runway_make_word_argument(state, i), error);
    for (unsigned i = 0; status == MR_OK && i < 256 && 2 * i <= state->mats; i++)
        status = send_command(client->dialogue, MR_COMMAND_RUNWAY_JOINTS, i,
                              mr_runway_make_joints_argument(state, i), error);
    if (status == MR_OK)
        status = send_command(client->dialogue, MR_COMMAND_RUNWAY_TAKE, 0,
                              (int32_t)mr_runway_crc(state), error);
    return status ?: wait_until_stored(client, error);
}

enum mr_status runway_client_discard(struct runway_client *client, struct error *error)
{
    return send_command(client->dialogue, MR_COMMAND_RUNWAY_FORGET, 0, 0, error)
             ?: wait_until_stored(client, error);
}

/* ---- chart ---- */

enum mr_status runway_client_send_chart(struct dialogue *dialogue, const struct mr_risk_plan *plan,
                                        struct error *error)
{
    /* make the board discard the words of an earlier, incomplete chart */
    enum mr_status status = send_command(dialogue, MR_COMMAND_CHART_FORGET, 0, 0, error);
    for (unsigned i = 0; status == MR_OK && i < MR_RISK_PLAN_ITEM_COUNT; i++) {
        float value = mr_risk_plan_get_item(plan, i);
        int32_t bits;
        memcpy(&bits, &value, sizeof bits);
        if (!isnan(value))
            status = send_command(dialogue, MR_COMMAND_CHART_WORD, i, bits, error);
    }
    return status
             ?: send_command(dialogue, MR_COMMAND_CHART_TAKE, 0, (int32_t)mr_risk_plan_crc(plan),
                             error);
}
