/* How the board and its channels are, into the campaign: what fails, temperatures, the slow log, a
 * crash, CAN as the board sees it. */
#include <stdio.h>
#include <string.h>

#include "host/collect/collect_state.h"

/* Faults are repeated once a second; a row is made when one has counted on. */
static enum mr_status fault(struct collector *collector, const struct side *side,
                            const struct mr_fault *message, uint64_t host_us, struct error *error)
{
    if (message->code < MR_FAULT_COUNT) {
        if (collector->fault_count[message->code] == message->count)
            return MR_OK;
        collector->fault_count[message->code] = message->count;
    }
    return collect_put_event(collector, side, "fault", message->block, message->code,
                             message->detail, message->count, host_us, error);
}

static enum mr_status temperature(struct collector *collector, struct side *side,
                                  const struct mr_message *message, struct error *error)
{
    struct store_mat_temperature row = {.block = collect_block(side, message),
                                        .links = collect_link_bit(side)};
    collect_temperature_row(&row, &message->as.temperature);
    return side->current && row.block >= 0
             ? store_mat_temperature_put(collector->store, side->current->row.id, &row, error)
             : MR_OK;
}

static enum mr_status quality(struct collector *collector, const struct side *side,
                              const struct mr_channel_quality *message, struct error *error)
{
    struct store_quality row;
    collect_channel_quality_row(&row, message);
    return side->current ? store_quality_put(collector->store, side->current->row.id, &row, error)
                         : MR_OK;
}

/* A row of the slow log comes in six messages; one that is lost loses its row. */
static void slow_row(struct side *side, const struct mr_slow_row *message, uint64_t host_us)
{
    side->slow = (struct store_slow){.time_us = (int64_t)host_us,
                                     .block = message->block,
                                     .temperature_c = (double)message->temperature_c};
    side->slow_number = message->row;
    side->slow_gages = 0;
}

/* A row that is whole is stored, of one link. */
static enum mr_status slow_tension(struct collector *collector, struct side *side,
                                   const struct mr_slow_tension *message, struct error *error)
{
    const float lb[] = {message->a_lb, message->b_lb, message->c_lb};
    if (!side->slow.block || message->row != side->slow_number ||
        message->first != side->slow_gages + 1u)
        return MR_OK;
    for (unsigned k = 0; k < 3u && side->slow_gages < MR_GAGES; k++)
        side->slow.tension_lb[side->slow_gages++] = (double)lb[k];
    if (side->slow_gages < MR_GAGES || !collector->identity.board_uid[0] ||
        (side->kind == LINK_SERIAL && collector->side[LINK_CAN].spec))
        return MR_OK;
    snprintf(side->slow.board_uid, sizeof side->slow.board_uid, "%s",
             collector->identity.board_uid);
    return store_slow_put(collector->store, &side->slow, error);
}

/* What a processor fault left behind: an event for each word, once, whichever link brings it and
 * however often. */
static enum mr_status crash(struct collector *collector, const struct side *side,
                            const struct mr_crash *message, uint64_t host_us, struct error *error)
{
    struct crash_report *report = &collector->crash[side->kind];
    enum mr_status status = MR_OK;
    if (!crash_take(report, message) ||
        memcmp(report->word, collector->crashed.word, sizeof report->word) == 0)
        return MR_OK;
    collector->crashed = *report;
    collector->crash_news = true;
    for (unsigned i = 0; i < MR_CRASH_ITEMS && status == MR_OK; i++)
        status = collect_put_event(collector, side, "crash", 0, i, report->age, report->word[i],
                                   host_us, error);
    return status;
}

/* The state of CAN as the board sees it is told each second; an event is made when it, or the count
 * of outages, has changed. */
static enum mr_status can_alarm(struct collector *collector, const struct side *side,
                                const struct mr_can_alarm *message, uint64_t host_us,
                                struct error *error)
{
    int64_t block = collect_newest_block(side);
    struct mr_can_alarm *newest = &collector->alarm;
    bool same = newest->state == message->state && newest->outages == message->outages;
    /* had waited in the controller */
    bool older = side->kind == LINK_CAN && message->outages < newest->outages;
    if (same || older)
        return MR_OK;
    *newest = *message;
    collector->alarm_news = true;
    return collect_put_event(collector, side, "can-state", block < 0 ? 0 : block, message->state,
                             message->tec, message->outages, host_us, error);
}

enum mr_status collect_health_message(struct collector *collector, struct side *side,
                                      const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->place) {
    case MR_PLACE_CHANNEL_QUALITY: return quality(collector, side, &m->as.channel_quality, error);
    case MR_PLACE_FAULT: return fault(collector, side, &m->as.fault, event->host_us, error);
    case MR_PLACE_TEMPERATURE: return temperature(collector, side, m, error);
    case MR_PLACE_CRASH: return crash(collector, side, &m->as.crash, event->host_us, error);
    case MR_PLACE_CAN_ALARM:
        return can_alarm(collector, side, &m->as.can_alarm, event->host_us, error);
    case MR_PLACE_SLOW_ROW: slow_row(side, &m->as.slow_row, event->host_us); return MR_OK;
    case MR_PLACE_SLOW_TENSION: return slow_tension(collector, side, &m->as.slow_tension, error);
    default: return MR_OK;
    }
}
