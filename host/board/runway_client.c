#include "host/board/runway_client.h"

#include <math.h>
#include <string.h>

#include "common/command.h"
#include "common/runway.h"

/* ---- runway ---- */

#define ROUNDS 3

static void take_joints(struct runway_client *talk, const struct mr_runway_joints *joints)
{
    if (talk->parts >= mr_runway_messages(&talk->state) ||
        joints->index != 1u + MR_RUNWAY_PER_MESSAGE * talk->parts)
        return;
    mr_runway_apply_message(&talk->state, joints);
    talk->whole = ++talk->parts == mr_runway_messages(&talk->state);
}

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct runway_client *talk = context;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    struct mr_runway runway;
    struct mr_runway_joints joints;
    (void)error;
    if (message->id == MR_ID_HELLO) {
        talk->said_hello = true;
    } else if (message->id == MR_ID_RUNWAY_STORE) {
        talk->stored_known |= mr_runway_store_get(&talk->stored, bytes, length) == MR_OK;
        talk->looked = talk->stored_known && talk->stored.copy_a != MR_RUNWAY_UNREAD;
    } else if (message->id == MR_ID_RUNWAY && mr_runway_get(&runway, bytes, length) == MR_OK) {
        talk->state = (struct mr_predictor_state){
            .mats = runway.mats, .landings = runway.landings, .scale = runway.resistance};
        talk->parts = 0;
        talk->whole = false;
    } else if (message->id == MR_ID_RUNWAY_JOINTS &&
               mr_runway_joints_get(&joints, bytes, length) == MR_OK) {
        take_joints(talk, &joints);
    }
    return MR_OK;
}

static enum mr_status wait_for(struct runway_client *talk, const bool *what, const char *name,
                               struct error *error)
{
    enum mr_status status = dialogue_until(talk->dialogue, dialogue_flag, what, DIALOGUE_ANSWER_S,
                                           error);
    return status == MR_TIMEOUT ? error_set(error, MR_TIMEOUT,
                                            "the board did not %s within %.0f s: %s; check that it "
                                            "is running and has a predictor",
                                            name, DIALOGUE_ANSWER_S, dialogue_spec(talk->dialogue))
                                : status;
}

enum mr_status runway_client_begin(struct runway_client *talk, struct dialogue *dialogue,
                                   struct error *error)
{
    *talk = (struct runway_client){.dialogue = dialogue};
    dialogue_subscribe(dialogue, take, talk);
    enum mr_status status = dialogue_hello(dialogue, NULL, NULL, error);
    return status ?: wait_for(talk, &talk->looked, "read its memory", error);
}

static enum mr_status order(struct dialogue *dialogue, unsigned code, unsigned index,
                            int32_t argument, struct error *error)
{
    const struct dialogue_command order = {.code = (uint8_t)code,
                                           .index = (uint8_t)index,
                                           .argument = argument,
                                           .answer_s = DIALOGUE_ANSWER_S};
    const char *link = dialogue_spec(dialogue);
    struct mr_ack ack;
    enum mr_status status = dialogue_send_command(dialogue, &order, &ack, error);
    if (status == MR_TIMEOUT)
        return dialogue_lost(dialogue, code, error);
    if (status != MR_OK || ack.status == MR_OK)
        return status;
    if (ack.status == MR_MALFORMED)
        return error_set(error, MR_MALFORMED,
                         "the board refused this runway: %s; give a runway with the board's number "
                         "of mats, and no joint wider than its slack",
                         link);
    if (ack.status == MR_VERSION)
        return error_set(error, MR_VERSION,
                         "chart for a different runway: %s; the runway of the board has a "
                         "different number of landings, run matrig advise again",
                         link);
    return dialogue_refused(dialogue, &ack,
                            "the board is armed or in a landing (disarm it, or wait), or its "
                            "predictor is off (predict.fitted of its configuration)",
                            error);
}

enum mr_status runway_client_read(struct runway_client *talk, struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned round = 0; status == MR_OK && round < ROUNDS; round++) {
        talk->whole = talk->stored_known = false;
        status = order(talk->dialogue, MR_COMMAND_RUNWAY_READ, 0, 0, error) ?:
                 wait_for(talk, &talk->whole, "send all of its runway", error) ?:
                 wait_for(talk, &talk->stored_known, "report the origin of its runway", error);
        if (status == MR_OK && mr_runway_crc(&talk->state) == talk->stored.crc)
            return MR_OK;
    }
    return status != MR_OK
             ? status
             : error_set(error, MR_CRC, "the runway was received damaged: %s; check the cable",
                         dialogue_spec(talk->dialogue));
}

/* The board stores a new runway after half a second, and sends a hello once a second. */
static enum mr_status wait_until_kept(struct runway_client *talk, struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < 2 && status == MR_OK; i++) {
        talk->said_hello = false;
        status = wait_for(talk, &talk->said_hello, "send another hello", error);
    }
    return status;
}

enum mr_status runway_client_load(struct runway_client *talk,
                                  const struct mr_predictor_state *state, struct error *error)
{
    enum mr_status status = runway_client_read(talk, error);
    if (status == MR_OK && talk->state.mats != state->mats)
        status = error_set(error, MR_LIMIT,
                           "the runway of the file has %u mats, that of the board %u: %s; check "
                           "site.mats of the board's configuration",
                           state->mats, talk->state.mats, dialogue_spec(talk->dialogue));
    for (unsigned i = 0; status == MR_OK && i < MR_RUNWAY_WORDS; i++)
        status = order(talk->dialogue, MR_COMMAND_RUNWAY_WORD, i, mr_runway_word_argument(state, i),
                       error);
    for (unsigned i = 0; status == MR_OK && i < 256 && 2 * i <= state->mats; i++)
        status = order(talk->dialogue, MR_COMMAND_RUNWAY_JOINTS, i,
                       mr_runway_joints_argument(state, i), error);
    if (status == MR_OK)
        status = order(talk->dialogue, MR_COMMAND_RUNWAY_TAKE, 0, (int32_t)mr_runway_crc(state),
                       error);
    return status ?: wait_until_kept(talk, error);
}

enum mr_status runway_client_discard(struct runway_client *talk, struct error *error)
{
    return order(talk->dialogue, MR_COMMAND_RUNWAY_FORGET, 0, 0, error)
             ?: wait_until_kept(talk, error);
}

/* ---- chart ---- */

enum mr_status runway_client_chart(struct dialogue *dialogue, const struct mr_risk_plan *plan,
                                   struct error *error)
{
    /* drops words of an earlier, incomplete chart */
    enum mr_status status = order(dialogue, MR_COMMAND_CHART_FORGET, 0, 0, error);
    for (unsigned i = 0; status == MR_OK && i < MR_RISK_ITEMS; i++) {
        float value = mr_risk_item(plan, i);
        int32_t bits;
        memcpy(&bits, &value, sizeof bits);
        if (!isnan(value))
            status = order(dialogue, MR_COMMAND_CHART_WORD, i, bits, error);
    }
    return status
             ?: order(dialogue, MR_COMMAND_CHART_TAKE, 0, (int32_t)mr_risk_plan_crc(plan), error);
}
