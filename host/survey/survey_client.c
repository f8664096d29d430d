#include "host/survey/survey_client.h"

#include <math.h>
#include <string.h>

#include "common/command.h"
#include "host/board/dialogue.h"

#define ANSWER_S  2.0 /* then it is sent again */
#define TRIES     3
#define DIGITS_IN 1e-4 /* of the command and of the message */

struct talk {
    struct dialogue *dialogue;
    bool told[SURVEY_SPANS];
    unsigned tolds;
    double slack_in[SURVEY_SPANS];
};

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct talk *talk = context;
    struct mr_slack slack;
    (void)error;
    if (message->id == MR_ID_SLACK &&
        mr_slack_get(&slack, message->payload, message->length) == MR_OK &&
        slack.segment < SURVEY_SPANS) {
        talk->tolds += !talk->told[slack.segment];
        talk->told[slack.segment] = true;
        talk->slack_in[slack.segment] = (double)slack.slack_in;
    }
    return MR_OK;
}

static bool all_told(const void *context)
{
    return ((const struct talk *)context)->tolds == SURVEY_SPANS;
}

static enum mr_status order(struct talk *talk, unsigned code, unsigned segment, int32_t argument,
                            struct error *error)
{
    const struct dialogue_order order = {.code = (uint8_t)code,
                                         .index = (uint8_t)segment,
                                         .argument = argument,
                                         .answer_s = ANSWER_S,
                                         .tries = TRIES};
    struct mr_ack ack;
    enum mr_status status = dialogue_order(talk->dialogue, &order, &ack, error);
    if (status == MR_TIMEOUT)
        return dialogue_lost(talk->dialogue, code, error);
    if (status != MR_OK || ack.status == MR_OK)
        return status;
    if (ack.status == MR_NOT_NOW)
        return error_set(
            error, MR_NOT_NOW,
            "the board takes no survey now, a landing is armed or going on: %s; disarm it, or wait",
            dialogue_spec(talk->dialogue));
    return error_set(error, (enum mr_status)ack.status,
                     "the board refuses segment %u of the survey (%s): %s; look at its readings",
                     segment, mr_status_text((enum mr_status)ack.status),
                     dialogue_spec(talk->dialogue));
}

static enum mr_status read_back(struct talk *talk, struct error *error)
{
    enum mr_status status = MR_TIMEOUT;
    memset(talk->told, 0, sizeof talk->told);
    talk->tolds = 0;
    for (int tries = 0; tries < TRIES && status == MR_TIMEOUT && error->status == MR_OK; tries++) {
        status = order(talk, MR_COMMAND_STATE, 0, 0, error);
        if (status == MR_OK)
            status = dialogue_until(talk->dialogue, all_told, talk, ANSWER_S, error);
    }
    return status == MR_TIMEOUT
             ? error_set(error, MR_TIMEOUT,
                         "the board told %u of %u segments of what it holds now: %s; load it again",
                         talk->tolds, SURVEY_SPANS, dialogue_spec(talk->dialogue))
             : status;
}

static void compare(const struct talk *talk, const struct survey_slack *slack,
                    struct survey_loaded *loaded)
{
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        double wanted_in = slack->segment[k].value_in;
        loaded->board_in[k] = talk->slack_in[k];
        if (isnan(wanted_in))
            loaded->older += isnan(talk->slack_in[k]) ? 0u : 1u;
        else
            loaded->different += fabs(talk->slack_in[k] - wanted_in) <= 0.51 * DIGITS_IN ? 0u : 1u;
    }
}

static enum mr_status load(struct talk *talk, const struct survey_slack *slack,
                           struct survey_loaded *loaded, struct error *error)
{
    enum mr_status status = dialogue_hello(talk->dialogue, NULL, NULL, error);
    for (unsigned k = 0; k < SURVEY_SPANS && status == MR_OK; k++) {
        double slack_in = slack->segment[k].value_in;
        if (isnan(slack_in))
            continue;
        status = order(talk, MR_COMMAND_SURVEY, k, (int32_t)lround(slack_in / DIGITS_IN), error);
        loaded->sent += status == MR_OK;
    }
    if (status == MR_OK)
        status = read_back(talk, error);
    if (status == MR_OK)
        compare(talk, slack, loaded);
    return status;
}

enum mr_status survey_load(const char *can, const char *serial, const struct survey_slack *slack,
                           struct survey_loaded *loaded, struct error *error)
{
    struct dialogue dialogue;
    struct talk talk = {.dialogue = &dialogue};
    memset(loaded, 0, sizeof *loaded);
    enum mr_status status = dialogue_open(&dialogue, can, serial, error);
    dialogue_subscribe(&dialogue, take, &talk);
    if (status == MR_OK)
        status = load(&talk, slack, loaded, error);
    dialogue_close(&dialogue);
    return status;
}
