#include "host/board/charttalk.h"

#include <math.h>
#include <string.h>

#include "common/command.h"

static enum mr_status order(struct dialogue *dialogue, unsigned code, unsigned index,
                            int32_t argument, struct error *error)
{
    const struct dialogue_order order = {.code = (uint8_t)code,
                                         .index = (uint8_t)index,
                                         .argument = argument,
                                         .answer_s = DIALOGUE_ANSWER_S};
    const char *link = dialogue_spec(dialogue);
    struct mr_ack ack;
    enum mr_status status = dialogue_order(dialogue, &order, &ack, error);
    if (status == MR_TIMEOUT)
        return error_set(error, MR_TIMEOUT,
                         "the board did not answer within %.0f s: %s; is it running?",
                         DIALOGUE_ANSWER_S, link);
    if (status != MR_OK || ack.status == MR_OK)
        return status;
    if (ack.status == MR_NOT_NOW)
        return error_set(error, MR_NOT_NOW,
                         "not now: %s; the board is armed or in a landing (disarm it, or wait), or "
                         "no predictor runs (predict.fitted of its configuration)",
                         link);
    if (ack.status == MR_VERSION)
        return error_set(error, MR_VERSION,
                         "a chart of another runway: %s; the board's has had another number of "
                         "landings, ask for the advice again",
                         link);
    return error_set(error, (enum mr_status)ack.status, "the board refused %s (%s): %s; try again",
                     mr_command_name(code), mr_status_text((enum mr_status)ack.status), link);
}

enum mr_status charttalk_give(struct dialogue *dialogue, const struct mr_risk_plan *plan,
                              struct error *error)
{
    /* words of another one that was never taken are of no chart */
    enum mr_status status = order(dialogue, MR_COMMAND_CHART_FORGET, 0, 0, error);
    for (unsigned i = 0; status == MR_OK && i < MR_RISK_ITEMS; i++) {
        float value = mr_risk_item(plan, i);
        int32_t bits;
        memcpy(&bits, &value, sizeof bits);
        if (!isnan(value))
            status = order(dialogue, MR_COMMAND_CHART_WORD, i, bits, error);
    }
    return status == MR_OK
             ? order(dialogue, MR_COMMAND_CHART_TAKE, 0, (int32_t)mr_risk_plan_crc(plan), error)
             : status;
}
