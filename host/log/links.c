/* What comes over the links of matrig log, into the collector. */
#include <string.h>
#include <time.h>

#include "host/link/can_error.h"
#include "host/log/logger.h"

#define FRAMES_PER_TURN 1024
#define BYTES_PER_TURN 16384

uint64_t logger_now_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

enum mr_status logger_begin(struct logger *logger, struct error *error)
{
    if (logger->in_transaction)
        return MR_OK;
    enum mr_status status = store_begin(logger->store, error);
    logger->in_transaction = status == MR_OK;
    logger->begun_us = logger_now_us();
    return status;
}

enum mr_status logger_commit(struct logger *logger, struct error *error)
{
    if (!logger->in_transaction)
        return MR_OK;
    enum mr_status status = collector_put_counts(logger->collector, error);
    if (status == MR_OK)
        status = store_commit(logger->store, error);
    logger->in_transaction = false;
    return status;
}

/* The link is over, for whatever reason; a broken one is remembered, and the other one goes on. */
static enum mr_status end_link(struct logger *logger, enum link_kind kind, struct error *reason,
                               struct error *error)
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

/* What the link saw since the last time: recorded, and told. `frame` is the error frame that tells it, if any. */
static enum mr_status take_troubles(struct logger *logger, enum link_kind kind, const struct link_frame *frame,
                                    struct error *error)
{
    const struct link_counters *counters = link_counters(logger->link[kind]);
    char text[CAN_ERROR_TEXT_MAX];
    if (counters->troubles == logger->troubles[kind])
        return MR_OK;
    logger->troubles[kind] = counters->troubles;
    bool error_frame = frame && frame->id & LINK_ID_ERROR;
    if (error_frame)
        can_error_text(frame, text);
    logger_note_troubles(logger, kind, error_frame ? text : NULL);
    enum mr_status status = logger_begin(logger, error);
    return status == MR_OK ? collector_troubles(logger->collector, kind, counters, error) : status;
}

/* Keeps the links in order: a device that went away comes back, or ends its link. */
enum mr_status logger_service_links(struct logger *logger, struct error *error)
{
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct error reason = {0};
        if (!logger->open[kind])
            continue;
        enum mr_status serviced = link_service(logger->link[kind], &reason);
        enum mr_status status = take_troubles(logger, (enum link_kind)kind, NULL, error);
        if (status == MR_OK && serviced != MR_OK && serviced != MR_TOO_FEW)
            status = end_link(logger, (enum link_kind)kind, &reason, error);
        if (status != MR_OK)
            return status;
    }
    return MR_OK;
}

enum mr_status logger_receive_can(struct logger *logger, struct error *error)
{
    struct link_frame frame;
    struct error reason = {0};
    logger->more[LINK_CAN] = false;
    for (int i = 0; i < FRAMES_PER_TURN; i++) {
        enum mr_status status = link_receive_frame(logger->link[LINK_CAN], &frame, &reason);
        if (status == MR_TOO_FEW)
            return MR_OK;
        if (status != MR_OK)
            return end_link(logger, LINK_CAN, &reason, error);
        status = logger_begin(logger, error);
        if (status == MR_OK)
            status = take_troubles(logger, LINK_CAN, &frame, error);
        if (status == MR_OK)
            status = collector_frame(logger->collector, &frame, error);
        if (status != MR_OK)
            return status;
    }
    logger->more[LINK_CAN] = true;
    return MR_OK;
}

enum mr_status logger_receive_serial(struct logger *logger, struct error *error)
{
    uint8_t bytes[BYTES_PER_TURN];
    size_t length;
    uint64_t host_us;
    struct error reason = {0};
    logger->more[LINK_SERIAL] = false;
    enum mr_status status =
        link_receive_bytes(logger->link[LINK_SERIAL], bytes, sizeof bytes, &length, &host_us, &reason);
    if (status == MR_TOO_FEW)
        return MR_OK;
    if (status != MR_OK)
        return end_link(logger, LINK_SERIAL, &reason, error);
    logger->more[LINK_SERIAL] = true;
    status = logger_begin(logger, error);
    return status == MR_OK ? collector_bytes(logger->collector, bytes, length, host_us, error) : status;
}

/* When both links have something, the one that is behind in board time goes first: they stay in step,
 * whatever waits in which buffer, and neither is ever waited for. */
void logger_keep_in_step(const struct logger *logger, bool ready[LINK_KINDS])
{
    if (ready[LINK_CAN] && ready[LINK_SERIAL]) {
        bool can_behind =
            collector_block(logger->collector, LINK_CAN) <= collector_block(logger->collector, LINK_SERIAL);
        ready[can_behind ? LINK_SERIAL : LINK_CAN] = false;
    }
}
