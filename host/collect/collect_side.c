/* What a link knows of now, and the event that something makes there. All other files of the
 * collector stand on this one. */
#include "host/collect/collect_state.h"

int64_t collect_newest_block(const struct side *side)
{
    return side->time.known ? side->time.block : -1;
}

int64_t collect_board_time(const struct side *side, const struct mr_message *message)
{
    struct timebase copy = side->time;
    if (!copy.known)
        return STORE_NONE;
    if (message && message->block16 >= 0) {
        int64_t block = timebase_unwrap(&copy, (uint16_t)message->block16);
        return block < 0 ? STORE_NONE : 1000 * block;
    }
    return timebase_now_us(&side->time);
}

int64_t collect_block(struct side *side, const struct mr_message *message)
{
    return message->block16 >= 0 ? timebase_unwrap(&side->time, (uint16_t)message->block16)
                                 : message->block;
}

int64_t collect_link_bit(const struct side *side)
{
    return 1 << side->kind;
}

enum mr_status collect_put_event(struct collector *collector, const struct side *side,
                                 const char *kind, int64_t block, int64_t code, int64_t detail,
                                 int64_t value, uint64_t host_us, struct error *error)
{
    struct store_event event = {
        .session = collector->session,
        .boot = side->boot,
        .run = side->current ? side->current->row.id : STORE_NONE,
        .board_us = 1000 * block,
        .host_us = (int64_t)host_us,
        .kind = kind,
        .code = code,
        .detail = detail,
        .value = value,
        .links = collect_link_bit(side),
    };
    return store_event_put(collector->store, &event, error);
}
