/* What comes over the links of matrig log, out of their queues into the collector. */
#include <time.h>

#include "host/link/can_error.h"
#include "host/log/logger.h"
#include "host/base/steady.h"

#define FRAMES_PER_TURN READER_FRAMES
#define BYTES_PER_TURN  LINK_QUEUE_READ_MAX

/* The link is over, for whatever reason; a broken one is remembered, and the other one goes on. */
static enum mr_status end_link(struct logger *logger, enum link_kind kind,
                               const struct error *reason, struct error *error)
{
    struct error tail = {0};
    logger->open[kind] = false;
    enum mr_status status = logger_begin(logger, error);
    if (status == MR_OK)
        status = collector_link_end(logger->collector, kind, &tail);
    if (status == MR_TRUNCATED)
        status = MR_OK;
    else if (status != MR_OK)
        error_set(error, status, "%s", tail.text);
    if (logger->link_error.status == MR_OK)
        logger->link_error = reason->status != MR_OK ? *reason : tail;
    return status;
}

/* What the link saw since the last time: recorded, and told. `frame` is the error frame that tells
 * it, if any. */
static enum mr_status take_troubles(struct logger *logger, enum link_kind kind,
                                    const struct link_frame *frame, struct error *error)
{
    const struct link_counters *counters = &logger->counters[kind];
    char text[CAN_ERROR_TEXT_MAX];
    if (!logger->troubled[kind])
        return MR_OK;
    bool error_frame = frame && frame->id & LINK_ID_ERROR;
    if (error_frame)
        can_error_text(frame, text);
    logger_note_troubles(logger, kind, error_frame ? text : NULL);
    enum mr_status status = logger_begin(logger, error);
    if (status == MR_OK)
        status = collector_troubles(logger->collector, kind, counters, error);
    logger->troubled[kind] = status != MR_OK;
    return status;
}

static enum mr_status take_item(struct logger *logger, enum link_kind kind,
                                const struct link_item *item, struct error *error)
{
    if (item->kind == LINK_ITEM_COUNTERS) {
        logger->counters[kind] = item->counters;
        logger->troubled[kind] = true;
        return MR_OK;
    }
    if (logger->live.hub) /* what was shown before is not shown again */
        collector_listen(logger->collector, item->again ? NULL : &logger->live.listener);
    enum mr_status status = logger_begin(logger, error);
    if (status == MR_OK)
        status = take_troubles(logger, kind, item->kind == LINK_ITEM_FRAME ? &item->frame : NULL,
                               error);
    if (status != MR_OK)
        return status;
    switch (item->kind) {
    case LINK_ITEM_FRAME:
        if (item->frame.id == MR_ID_HELLO)
            logger->hello = item->frame;
        return collector_frame(logger->collector, &item->frame, error);
    case LINK_ITEM_BYTES:
        return collector_bytes(logger->collector, item->bytes, item->length, item->host_us, error);
    case LINK_ITEM_CLOCK:
        if (item->jump_us != 0)
            return collector_clock_set(logger->collector, item->jump_us, error);
        collector_forget_time(logger->collector, kind);
        return MR_OK;
    default: return end_link(logger, kind, &item->end, error);
    }
}

enum mr_status logger_receive(struct logger *logger, enum link_kind kind, struct error *error)
{
    struct link_reader *reader = logger->reader[kind];
    struct link_queue *queue = link_reader_queue(reader);
    struct link_item item;
    enum mr_status status = MR_OK;
    logger->more[kind] = false;
    if (link_reader_fd(reader) >= 0 && !link_queue_unread(queue))
        logger->more[kind] = link_reader_turn(reader);
    size_t most = kind == LINK_CAN ? FRAMES_PER_TURN : BYTES_PER_TURN;
    for (size_t taken = 0; taken < most && status == MR_OK && link_queue_take(queue, &item);) {
        taken += item.kind == LINK_ITEM_BYTES ? item.length : 1;
        status = take_item(logger, kind, &item, error);
    }
    return status == MR_OK ? take_troubles(logger, kind, NULL, error) : status;
}

/* When both links have something, the one that is behind in board time goes first: they stay in
 * step, whatever waits in which buffer, and neither is ever waited for. */
void logger_keep_in_step(const struct logger *logger, bool ready[LINK_KINDS])
{
    if (ready[LINK_CAN] && ready[LINK_SERIAL]) {
        bool can_behind = collector_block(logger->collector, LINK_CAN) <=
                          collector_block(logger->collector, LINK_SERIAL);
        ready[can_behind ? LINK_SERIAL : LINK_CAN] = false;
    }
}
