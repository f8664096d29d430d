/* What matrig log asks of the board by itself, and for the viewers of the live page. */
#include "host/log/logger.h"

#include "host/base/monotonic_clock.h"

#define ASK_US        1000000u /* between two requests for the configuration */
/* for the same; a board that does not answer, or of another table, is left alone then */
#define ASKS          5u
#define LIVE_S        30        /* so long a board without CAN tells readings while idle, */
#define LIVE_AGAIN_US 20000000u /* and so often it is asked */

bool logger_send(struct logger *logger, const struct mr_command *command, bool unasked)
{
    uint8_t payload[MR_MESSAGE_MAX];
    size_t length = mr_command_put(command, payload);
    for (int kind = LINK_KINDS - 1; kind >= 0; kind--) {
        unsigned link = (unsigned)kind;
        struct error reason = {0};
        if (!logger->open[link] || (unasked && logger->mute[link]))
            continue;
        enum mr_status status = link_send_message(logger->link[link], logger->base, 0,
                                                  MR_ID_COMMAND, payload, length, &reason);
        logger->mute[link] = logger->mute[link] || (unasked && status != MR_OK);
        if (status == MR_OK)
            return true;
    }
    return false;
}

/* Asks the board for its configuration, over serial when it can be. A link that does not take it,
 * such as a file, is asked once. */
void logger_ask_for_configuration(struct logger *logger)
{
    const struct mr_command command = {.code = MR_COMMAND_CONFIG_READ};
    uint64_t now_us = monotonic_us();
    if (!collector_lacks_configuration(logger->collector)) {
        struct collector_progress p;
        collector_progress(logger->collector, &p);
        if (p.run) /* what it was telling ended with the arming: ask at once when it is done */
            logger->asked_us = logger->asks = 0;
        return;
    }
    if (logger->asks == ASKS || (logger->asked_us && now_us - logger->asked_us < ASK_US))
        return;
    logger->asked_us = now_us;
    logger->asks++;
    (void)logger_send(logger, &command, true);
}

/* An idle board tells its readings on CAN alone. Without CAN it is asked for a record each 20 ms,
 * so that something moves. */
static void keep_it_live(struct logger *logger)
{
    struct mr_command command = {.code = MR_COMMAND_LIVE, .argument = LIVE_S};
    struct collector_progress p;
    collector_progress(logger->collector, &p);
    uint64_t now_us = monotonic_us();
    if (logger->open[LINK_CAN] || p.run || !p.hello ||
        (logger->live_us && now_us - logger->live_us < LIVE_AGAIN_US))
        return;
    logger->live_us = now_us;
    (void)logger_send(logger, &command, true);
}

/* A board tells its channels in turn, which takes 8 s; asked, it tells them in 0.2 s. Until then a
 * viewer sees no reading of a record. */
static void ask_for_channels(struct logger *logger)
{
    const struct mr_command command = {.code = MR_COMMAND_STATE};
    struct collector_progress p;
    uint64_t now_us = monotonic_us();
    collector_progress(logger->collector, &p);
    if (!p.hello || logger->channel_asks == ASKS ||
        (logger->channel_asks && now_us - logger->channels_us < ASK_US) ||
        !live_hub_lacks_calibration(logger->live.hub))
        return;
    logger->channels_us = now_us;
    logger->channel_asks++;
    (void)logger_send(logger, &command, true);
}

void logger_serve_live(struct logger *logger)
{
    struct mr_command command;
    if (!logger->live.hub)
        return;
    ask_for_channels(logger);
    keep_it_live(logger);
    live_turn(&logger->live, logger->collector);
    if (live_take_order(&logger->live, &command))
        (void)logger_send(logger, &command, false);
}
