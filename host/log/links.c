/* What comes over the links of matrig log, out of their queues into the collector. */
#include <time.h>

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
    if (status == MR_OK) {
        status = collector_link_end(logger->collector, (enum link_kind)link, &tail);
        if (status == MR_TRUNCATED)
            status = MR_OK;
        else if (status != MR_OK)
            error_set(error, status, "%s", tail.text);
    }
    if (logger->link_error.status == MR_OK)
        logger->link_error = reason->status != MR_OK ? *reason : tail;
    return status;
}

/* What the link saw since the last time: recorded, and told. */
static enum mr_status take_troubles(struct logger *logger, unsigned link, struct error *error)
{
    if (!logger->troubled[link])
        return MR_OK;
    logger_note_troubles(logger, link);
    enum mr_status status = logger_begin(logger, error);
    if (status == MR_OK)
        status = collector_troubles(logger->collector, (enum link_kind)link,
                                    &logger->counters[link], error);
    logger->troubled[link] = status != MR_OK;
    return status;
}

static enum mr_status take_frame(struct logger *logger, const struct link_frame *frame,
                                 struct error *error)
{
    if (link_id_from_bus(frame->id, logger->base) == MR_ID_HELLO)
        logger->hello = *frame;
    logger_note_other(logger, frame);
    return collector_frame(logger->collector, frame, error);
}

static enum mr_status take_clock(struct logger *logger, unsigned link, int64_t jump_us,
                                 struct error *error)
{
    if (jump_us != 0)
        return collector_clock_set(logger->collector, jump_us, error);
    collector_forget_time(logger->collector, (enum link_kind)link);
    return MR_OK;
}

static enum mr_status take_item(struct logger *logger, unsigned link, const struct link_item *item,
                                struct error *error)
{
    if (item->kind == LINK_ITEM_COUNTERS) {
        logger->counters[link] = item->counters;
        logger->troubled[link] = true;
        return MR_OK;
    }
    if (logger->live.hub) /* what was shown before is not shown again */
        collector_listen(logger->collector, item->again ? NULL : &logger->live.listener);
    enum mr_status status = logger_begin(logger, error);
    if (status == MR_OK)
        status = take_troubles(logger, link, error);
    if (status != MR_OK)
        return status;
    switch (item->kind) {
    case LINK_ITEM_FRAME: return take_frame(logger, &item->frame, error);
    case LINK_ITEM_BYTES:
        return collector_bytes(logger->collector, item->bytes, item->length, item->host_us, error);
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
    size_t most = (enum link_kind)link == LINK_CAN ? FRAMES_PER_TURN : BYTES_PER_TURN;
    for (size_t taken = 0; taken < most && status == MR_OK && link_queue_take(queue, &item);) {
        taken += item.kind == LINK_ITEM_BYTES ? item.length : 1;
        status = take_item(logger, link, &item, error);
    }
    return status == MR_OK ? take_troubles(logger, link, error) : status;
}

/* When both links have something, the one that is behind in board time goes first: they stay in
 * step, whatever waits in which buffer, and neither is ever waited for. */
void logger_keep_in_step(const struct logger *logger, bool ready[LINK_KINDS])
{
    if (!ready[LINK_CAN] || !ready[LINK_SERIAL])
        return;
    bool can_behind = collector_block(logger->collector, LINK_CAN) <=
                      collector_block(logger->collector, LINK_SERIAL);
    ready[can_behind ? LINK_SERIAL : LINK_CAN] = false;
}
