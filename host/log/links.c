/* What comes over the links of matrig log, out of their queues into the collectors: what a board
 * said into its own, what befell a link into those of all that it carries. */
#include <time.h>

#include "host/link/can.h"
#include "host/log/logger.h"
#include "host/base/monotonic_clock.h"

#define FRAMES_PER_TURN 64u /* less than what a second of any board is: the links stay in step */
#define BYTES_PER_TURN  LINK_QUEUE_READ_MAX

/* The link is over, for whatever reason; a broken one is remembered, and the others go on. */
static enum mr_status end_link(struct logger *logger, unsigned link, const struct error *reason,
                               struct error *error)
{
    struct error tail = {0};
    logger->open[link] = false;
    enum mr_status status = logger_begin(logger, error);
    for (unsigned i = logger_first(link); i < logger_behind(logger, link) && status == MR_OK; i++) {
        status = collector_link_end(logger->board[i].collector, logger_kind(link), &tail);
        if (status == MR_TRUNCATED)
            status = MR_OK;
        else if (status != MR_OK)
            error_set(error, status, "%s", tail.text);
    }
    if (logger->link_error.status == MR_OK)
        logger->link_error = reason->status != MR_OK ? *reason : tail;
    return status;
}

/* What the link saw since the last time: recorded, and told. `frame` is the error frame that tells
 * it, if any. */
static enum mr_status take_troubles(struct logger *logger, unsigned link,
                                    const struct link_frame *frame, struct error *error)
{
    char text[CAN_ERROR_TEXT_MAX];
    if (!logger->troubled[link])
        return MR_OK;
    bool error_frame = frame && frame->id & LINK_ID_ERROR;
    if (error_frame)
        can_error_text(frame, text);
    logger_note_troubles(logger, link, error_frame ? text : NULL);
    enum mr_status status = logger_begin(logger, error);
    for (unsigned i = logger_first(link); i < logger_behind(logger, link) && status == MR_OK; i++)
        status = collector_troubles(logger->board[i].collector, logger_kind(link),
                                    &logger->counters[link], error);
    logger->troubled[link] = status != MR_OK;
    return status;
}

/* After what a collector returned: of several boards one that the log cannot take ends alone. */
static enum mr_status leave_board(struct logger *logger, struct logger_board *board,
                                  enum mr_status status, struct error *error)
{
    if (status == MR_OK || logger->boards == 1 || !collector_turned_away(board->collector))
        return status;
    board->over = true;
    logger_clear_progress(logger);
    cli_note(logger->cli, "the log of the board at 0x%03x ends, the others go on: %s", board->base,
             error->text);
    if (logger->link_error.status == MR_OK)
        logger->link_error = *error;
    *error = (struct error){0};
    return MR_OK;
}

/* Does the identifier belong to a message of the board at this base, or to it? */
static bool is_of(const struct link_frame *frame, uint16_t base)
{
    return !(frame->id & (LINK_ID_EXTENDED | LINK_ID_REMOTE)) &&
           mr_message_find((uint16_t)link_id_from_bus(frame->id, base));
}

/* To the board whose it is. What is of none is kept with the first; what the adapter says of the
 * bus with all. */
static enum mr_status take_frame(struct logger *logger, const struct link_frame *frame,
                                 struct error *error)
{
    struct logger_board *board = &logger->board[0];
    enum mr_status status = MR_OK;
    if (frame->id & LINK_ID_ERROR) {
        for (unsigned i = 0; i < logger->boards && status == MR_OK; i++)
            status = collector_frame(logger->board[i].collector, frame, error);
        return status;
    }
    for (unsigned i = 1; i < logger->boards; i++) { /* no identifier is two boards' */
        if (is_of(frame, logger->board[i].base))
            board = &logger->board[i];
    }
    if (board->over)
        return MR_OK;
    if (link_id_from_bus(frame->id, board->base) == MR_ID_HELLO)
        board->hello = *frame;
    return leave_board(logger, board, collector_frame(board->collector, frame, error), error);
}

static enum mr_status take_clock(struct logger *logger, unsigned link, int64_t jump_us,
                                 struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = logger_first(link); i < logger_behind(logger, link) && status == MR_OK; i++) {
        if (jump_us != 0)
            status = collector_clock_set(logger->board[i].collector, jump_us, error);
        else
            collector_forget_time(logger->board[i].collector, logger_kind(link));
    }
    return status;
}

static enum mr_status take_item(struct logger *logger, unsigned link, const struct link_item *item,
                                struct error *error)
{
    struct logger_board *board = &logger->board[logger_first(link)];
    struct collector *first = board->collector;
    if (item->kind == LINK_ITEM_COUNTERS) {
        logger->counters[link] = item->counters;
        logger->troubled[link] = true;
        return MR_OK;
    }
    if (logger->live.hub) /* what was shown before is not shown again */
        collector_listen(first, item->again ? NULL : &logger->live.listener);
    enum mr_status status = logger_begin(logger, error);
    if (status == MR_OK)
        status = take_troubles(logger, link, item->kind == LINK_ITEM_FRAME ? &item->frame : NULL,
                               error);
    if (status != MR_OK)
        return status;
    switch (item->kind) {
    case LINK_ITEM_FRAME: return take_frame(logger, &item->frame, error);
    case LINK_ITEM_BYTES:
        status = board->over
                   ? MR_OK
                   : collector_bytes(first, item->bytes, item->length, item->host_us, error);
        return leave_board(logger, board, status, error);
    case LINK_ITEM_CLOCK: return take_clock(logger, link, item->jump_us, error);
    default: return end_link(logger, link, &item->end, error);
    }
}

enum mr_status logger_receive(struct logger *logger, unsigned link, struct error *error)
{
    struct link_reader *reader = logger->reader[link];
    struct link_queue *queue = link_reader_queue(reader);
    struct link_item item;
    enum mr_status status = MR_OK;
    if (!link_queue_unread(queue)) /* else what the last turn said of it holds */
        logger->more[link] = link_reader_fd(reader) >= 0 && link_reader_turn(reader);
    size_t most = logger_kind(link) == LINK_CAN ? FRAMES_PER_TURN : BYTES_PER_TURN;
    for (size_t taken = 0; taken < most && status == MR_OK && link_queue_take(queue, &item);) {
        taken += item.kind == LINK_ITEM_BYTES ? item.length : 1;
        status = take_item(logger, link, &item, error);
    }
    return status == MR_OK ? take_troubles(logger, link, NULL, error) : status;
}

/* When both links of a board have something, the one that is behind in board time goes first: they
 * stay in step, whatever waits in which buffer, and neither is ever waited for. The bus waits for
 * the serial line of any of its boards. */
void logger_keep_in_step(const struct logger *logger, bool ready[LOGGER_LINKS])
{
    bool bus = ready[0];
    for (unsigned i = 0; i < logger->boards && bus; i++) {
        const struct collector *collector = logger->board[i].collector;
        if (!ready[1 + i])
            continue;
        bool can_behind = collector_block(collector, LINK_CAN) <=
                          collector_block(collector, LINK_SERIAL);
        ready[can_behind ? 1 + i : 0] = false;
    }
}
