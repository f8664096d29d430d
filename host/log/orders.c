/* What matrig log asks of the board by itself, and for the viewers of the live page. */
#include "host/log/logger.h"

#include "host/base/monotonic_clock.h"

#define ASK_US        1000000u /* between two requests for the configuration */
/* for the same; a board that does not answer, or of another table, is left alone then */
#define ASKS          5u
#define LIVE_S        30        /* so long a board without CAN tells readings while idle, */
#define LIVE_AGAIN_US 20000000u /* and so often it is asked */

bool logger_send(struct logger *logger, unsigned board, const struct mr_command *command,
                 bool unasked)
{
    uint8_t payload[MR_MESSAGE_MAX];
    size_t length = mr_command_put(command, payload);
    for (int kind = LINK_KINDS - 1; kind >= 0; kind--) {
        unsigned link = logger_link_of(board, (enum link_kind)kind);
        struct error reason = {0};
        if (!logger->open[link] || (unasked && logger->mute[link]))
            continue;
        enum mr_status status = link_send_message(logger->link[link], logger->board[board].base, 0,
                                                  MR_ID_COMMAND, payload, length, &reason);
        logger->mute[link] = logger->mute[link] || (unasked && status != MR_OK);
        if (status == MR_OK)
            return true;
    }
    return false;
}

static void ask_board(struct logger *logger, unsigned i)
{
    const struct mr_command command = {.code = MR_COMMAND_CONFIG_READ};
    struct logger_board *board = &logger->board[i];
    uint64_t now_us = monotonic_us();
    if (!collector_lacks_configuration(board->collector)) {
        struct collector_progress p;
        collector_progress(board->collector, &p);
        if (p.run) /* what it was telling ended with the arming: ask at once when it is done */
            board->asked_us = board->asks = 0;
        return;
    }
    if (board->asks == ASKS || (board->asked_us && now_us - board->asked_us < ASK_US))
        return;
    board->asked_us = now_us;
    board->asks++;
    (void)logger_send(logger, i, &command, true);
}

/* Asks each board for its configuration, over serial when it can be. A link that does not take it,
 * such as a file, is asked once. */
void logger_ask_for_configuration(struct logger *logger)
{
    for (unsigned i = 0; i < logger->boards; i++)
        ask_board(logger, i);
}

/* An idle board tells its readings on CAN alone. Without CAN it is asked for a record each 20 ms,
 * so that something moves. */
static void keep_it_live(struct logger *logger)
{
    struct mr_command command = {.code = MR_COMMAND_LIVE, .argument = LIVE_S};
    struct collector_progress p;
    collector_progress(logger->board[0].collector, &p);
    uint64_t now_us = monotonic_us();
    if (logger->open[LINK_CAN] || p.run || !p.hello ||
        (logger->live_us && now_us - logger->live_us < LIVE_AGAIN_US))
        return;
    logger->live_us = now_us;
    (void)logger_send(logger, 0, &command, true);
}

/* A board tells its channels in turn, which takes 8 s; asked, it tells them in 0.2 s. Until then a
 * viewer sees no reading of a record. */
static void ask_for_channels(struct logger *logger)
{
    const struct mr_command command = {.code = MR_COMMAND_STATE};
    struct collector_progress p;
    uint64_t now_us = monotonic_us();
    collector_progress(logger->board[0].collector, &p);
    if (!p.hello || logger->channel_asks == ASKS ||
        (logger->channel_asks && now_us - logger->channels_us < ASK_US) ||
        !live_hub_lacks_calibration(logger->live.hub))
        return;
    logger->channels_us = now_us;
    logger->channel_asks++;
    (void)logger_send(logger, 0, &command, true);
}

/* The live view is of one board. */
void logger_serve_live(struct logger *logger)
{
    struct mr_command command;
    if (!logger->live.hub)
        return;
    ask_for_channels(logger);
    keep_it_live(logger);
    live_turn(&logger->live, logger->board[0].collector);
    if (live_take_order(&logger->live, &command))
        (void)logger_send(logger, 0, &command, false);
}
