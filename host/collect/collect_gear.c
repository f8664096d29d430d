/* The gear of a landing into the campaign: switches, motion, touchdown and stop; and the zones that
 * are found before it. */
#include <math.h>

#include "host/collect/collect_state.h"

static enum mr_status edge(struct collector *collector, struct side *side,
                           const struct mr_edge *message, struct error *error)
{
    struct slot *slot = side->current;
    if (!slot)
        return MR_OK;
    if (message->count > slot->edges)
        slot->edges = message->count;
    if (slot->first_edge_us == 0.0 && side->time.tick_known)
        slot->first_edge_us = timebase_tick_us(&side->time, message->tick);
    struct store_edge row = {.board_us = timebase_tick_us(&side->time, message->tick),
                             .links = collect_link_bit(side)};
    collect_edge_row(&row, message);
    return store_edge_put(collector->store, slot->row.id, &row, error);
}

/* An edge that the board took back is no gate for the host either. One that only the final fit left
 * out stays: the host's own fit finds it. */
static enum mr_status switch_event(struct collector *collector, const struct side *side,
                                   const struct mr_switch_event *message, struct error *error)
{
    bool refused = message->count > 0 && message->reason >= MR_SWITCH_OUT_OF_ORDER &&
                   isnan(message->late_ms);
    return side->current && refused
             ? store_edge_refuse(collector->store, side->current->row.id, message->count, error)
             : MR_OK;
}

/* Motion and its errors are two messages with the same block; the first is stored at once, the
 * second completes it. So are a zone and its lead. */
#define TWO_HALVES(name, NAME, second)                                                     \
    static enum mr_status name(struct collector *collector, struct side *side,             \
                               const struct mr_message *m, struct error *error)            \
    {                                                                                      \
        struct store_##name *row = &side->name;                                            \
        if (m->place == MR_PLACE_##NAME) {                                                 \
            *row = store_blank_##name;                                                     \
            side->name##16 = m->block16;                                                   \
            collect_##name##_row(row, &m->as.name);                                        \
        } else if (m->block16 == side->name##16) {                                         \
            collect_##second##_row(row, &m->as.second);                                    \
        } else {                                                                           \
            return MR_OK;                                                                  \
        }                                                                                  \
        row->block = collect_block(side, m);                                               \
        row->links = collect_link_bit(side);                                               \
        return side->current && row->block >= 0                                            \
                 ? store_##name##_put(collector->store, side->current->row.id, row, error) \
                 : MR_OK;                                                                  \
    }
TWO_HALVES(motion, MOTION, motion_error)
TWO_HALVES(zone, ZONE, zone_lead)

/* Touchdown and stop are of one row, and come in any order. */
static enum mr_status result(struct collector *collector, const struct side *side,
                             const struct mr_message *m, struct error *error)
{
    struct store_result row = store_blank_result;
    row.links = collect_link_bit(side);
    if (m->place == MR_PLACE_TOUCHDOWN)
        collect_touchdown_row(&row, &m->as.touchdown);
    else
        collect_stop_row(&row, &m->as.stop);
    return side->current ? store_result_put(collector->store, side->current->row.id, &row, error)
                         : MR_OK;
}

enum mr_status collect_gear_message(struct collector *collector, struct side *side,
                                    const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->place) {
    case MR_PLACE_EDGE: return edge(collector, side, &m->as.edge, error);
    case MR_PLACE_SWITCH_EVENT: return switch_event(collector, side, &m->as.switch_event, error);
    case MR_PLACE_MOTION:
    case MR_PLACE_MOTION_ERROR: return motion(collector, side, m, error);
    case MR_PLACE_ZONE:
    case MR_PLACE_ZONE_LEAD: return zone(collector, side, m, error);
    case MR_PLACE_TOUCHDOWN:
    case MR_PLACE_STOP: return result(collector, side, m, error);
    default: return MR_OK;
    }
}
