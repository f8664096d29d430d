/* The gear of a landing into the campaign: switches, motion, touchdown and stop; and the zones that are found before it. */
#include <math.h>

#include "common/switches.h"
#include "host/collect/collect_state.h"

#define MISSING ((double)NAN)

static enum mr_status edge(struct collector *collector, struct side *side, const struct mr_edge *message,
                           struct error *error)
{
    struct slot *slot = side->current;
    if (!slot)
        return MR_OK;
    if (message->count > slot->edges)
        slot->edges = message->count;
    if (slot->first_edge_us == 0.0 && side->time.tick_known)
        slot->first_edge_us = timebase_tick_us(&side->time, message->tick);
    struct store_edge row = {.count = message->count,
                             .position = message->position,
                             .step_codes = (double)message->step_codes,
                             .tick = message->tick,
                             .board_us = timebase_tick_us(&side->time, message->tick),
                             .links = collect_link_bit(side)};
    return store_edge_put(collector->store, slot->row.id, &row, error);
}

/* An edge that the board took back is no gate for the host either. One that only the final fit left out stays: the host's own fit finds
 * it. */
static enum mr_status switch_event(struct collector *collector, const struct side *side, const struct mr_switch_event *message,
                                   struct error *error)
{
    bool refused = message->count > 0 && message->reason >= MR_SWITCH_OUT_OF_ORDER && isnan(message->late_ms);
    return side->current && refused ? store_edge_refuse(collector->store, side->current->row.id, message->count, error) : MR_OK;
}

/* Motion and its errors are two messages with the same block; the first is stored at once, the second
 * completes it. */
static enum mr_status put_motion(struct collector *collector, struct side *side,
                                 const struct mr_motion_error *errors, struct error *error)
{
    const struct mr_motion *motion = &side->motion;
    int64_t block = timebase_unwrap(&side->time, motion->block16);
    if (!side->current || block < 0)
        return MR_OK;
    struct store_motion row = {
        .block = block,
        .position_ft = (double)motion->position_ft,
        .speed_ft_s = (double)motion->speed_ft_s,
        .deceleration_ft_s2 = (double)motion->deceleration_ft_s2,
        .position_error_ft = errors ? (double)errors->position_ft : MISSING,
        .speed_error_ft_s = errors ? (double)errors->speed_ft_s : MISSING,
        .deceleration_error_ft_s2 = errors ? (double)errors->deceleration_ft_s2 : MISSING,
        .links = collect_link_bit(side),
    };
    return store_motion_put(collector->store, side->current->row.id, &row, error);
}

static enum mr_status put_zone(struct collector *collector, struct side *side,
                               const struct mr_zone_lead *lead, struct error *error)
{
    const struct mr_zone *zone = &side->zone;
    int64_t block = timebase_unwrap(&side->time, zone->block16);
    if (!side->current || block < 0)
        return MR_OK;
    struct store_zone row = {
        .block = block,
        .mats = zone->mats,
        .start_ft = (double)zone->start_ft,
        .end_ft = (double)zone->end_ft,
        .lead_s = lead ? (double)lead->lead_s : MISSING,
        .wheel_ft = lead ? (double)lead->wheel_ft : MISSING,
        .warning = lead ? lead->warning : STORE_NONE,
        .inferred_percent = lead ? lead->inferred_percent : STORE_NONE,
        .links = collect_link_bit(side),
    };
    return store_zone_put(collector->store, side->current->row.id, &row, error);
}

static enum mr_status put_result(struct collector *collector, const struct side *side,
                                 struct store_result *row, struct error *error)
{
    row->links = collect_link_bit(side);
    return side->current ? store_result_put(collector->store, side->current->row.id, row, error) : MR_OK;
}

static enum mr_status touchdown(struct collector *collector, const struct side *side,
                                const struct mr_touchdown *message, struct error *error)
{
    struct store_result row = {
        .speed_ft_s = (double)message->speed_ft_s,
        .speed_error_ft_s = (double)message->speed_error_ft_s,
        .deceleration_ft_s2 = (double)message->deceleration_ft_s2,
        .deceleration_error_ft_s2 = (double)message->deceleration_error_ft_s2,
        .stop_station_ft = MISSING,
        .stop_station_error_ft = MISSING,
        .after_touchdown_s = MISSING,
        .switches = STORE_NONE,
        .used = STORE_NONE,
    };
    return put_result(collector, side, &row, error);
}

static enum mr_status stop(struct collector *collector, const struct side *side,
                           const struct mr_stop *message, struct error *error)
{
    struct store_result row = {
        .speed_ft_s = MISSING,
        .speed_error_ft_s = MISSING,
        .deceleration_ft_s2 = MISSING,
        .deceleration_error_ft_s2 = MISSING,
        .stop_station_ft = (double)message->station_ft,
        .stop_station_error_ft = (double)message->station_error_ft,
        .after_touchdown_s = (double)message->after_touchdown_s,
        .switches = message->switches,
        .used = message->used,
    };
    return put_result(collector, side, &row, error);
}

enum mr_status collect_gear_message(struct collector *collector, struct side *side, const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->place) {
    case MR_PLACE_EDGE: return edge(collector, side, &m->as.edge, error);
    case MR_PLACE_SWITCH_EVENT: return switch_event(collector, side, &m->as.switch_event, error);
    case MR_PLACE_MOTION: side->motion = m->as.motion; return put_motion(collector, side, NULL, error);
    case MR_PLACE_MOTION_ERROR:
        return m->block16 == side->motion.block16 ? put_motion(collector, side, &m->as.motion_error, error) : MR_OK;
    case MR_PLACE_ZONE: side->zone = m->as.zone; return put_zone(collector, side, NULL, error);
    case MR_PLACE_ZONE_LEAD:
        return m->block16 == side->zone.block16 ? put_zone(collector, side, &m->as.zone_lead, error) : MR_OK;
    case MR_PLACE_TOUCHDOWN: return touchdown(collector, side, &m->as.touchdown, error);
    case MR_PLACE_STOP: return stop(collector, side, &m->as.stop, error);
    default: return MR_OK;
    }
}
