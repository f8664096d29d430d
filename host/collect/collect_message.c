/* What each message of the catalogue does to the campaign: those of a landing's state, of time and of what was lost here, the others by
 * topic: collect_identity.c, collect_gear.c, collect_health.c, collect_predict.c, collect_bands.c. */
#include "common/command.h"
#include "host/collect/collect_state.h"

int64_t collect_link_bit(const struct side *side)
{
    return 1 << side->kind;
}

enum mr_status collect_put_event(struct collector *collector, const struct side *side, const char *kind,
                                int64_t block, int64_t code, int64_t detail, int64_t value, uint64_t host_us,
                                struct error *error)
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

enum mr_status collect_state_event(struct collector *collector, const struct side *side, const struct mr_landing *message,
                                   uint64_t host_us, struct error *error)
{
    return collect_put_event(collector, side, "state", message->block, message->state, message->cause, message->landing, host_us, error);
}

static enum mr_status landing(struct collector *collector, struct side *side,
                              const struct mr_landing *message, uint64_t host_us, struct error *error)
{
    struct slot *before = side->current;
    bool believed;
    enum mr_status status = collect_landing(collector, side, message, host_us, &believed, error);
    if (status != MR_OK || !believed || message->cause == MR_LANDING_BY_NOTHING)
        return status;
    struct slot *after = side->current;
    side->current = after ? after : before; /* the message that ends a landing belongs to it */
    status = collect_state_event(collector, side, message, host_us, error);
    side->current = after;
    return status;
}

/* Frames that nobody can have sent but others: more came than the board has counted. */
static enum mr_status excess(struct collector *collector, struct side *side, struct error *error)
{
    int64_t more = side->account.excess - side->excess_told;
    side->excess_told = side->account.excess;
    return more > 0 ? collect_doubt(collector, side, DOUBT_EXCESS, 0, more, error) : MR_OK;
}

/* What the board itself dropped of serial, serial cannot witness. */
static void serial_dropped(struct collector *collector, struct side *side, const struct mr_serial_health *health, int64_t block)
{
    int64_t dropped = side->account.counts.dropped;
    int64_t from_block = side->account.dropped_block;
    account_dropped(&side->account, health->dropped, block);
    if (side->account.counts.dropped > dropped)
        witness_lost(&collector->witness, from_block, block);
}

/* Declares `m`, the message got from its payload. The length has been checked against the catalogue's. */
#define GET(name)                                      \
    struct mr_##name m;                                \
    if (mr_##name##_get(&m, payload, length) != MR_OK) \
    return MR_OK

/* Each takes the messages of its topic, and leaves the others. */
static enum mr_status by_topic(struct collector *collector, struct side *side, uint16_t id, const uint8_t *payload, size_t length,
                               uint64_t host_us, struct error *error)
{
    static collect_topic *const topics[] = {collect_identity_message, collect_gear_message, collect_health_message,
                                            collect_predict_message};
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < sizeof topics / sizeof topics[0] && status == MR_OK; i++)
        status = topics[i](collector, side, id, payload, length, host_us, error);
    return status;
}

enum mr_status collect_message(struct collector *collector, struct side *side, uint16_t id,
                               const uint8_t *payload, size_t length, uint64_t host_us, struct error *error)
{
    struct account *account = &side->account;
    int64_t block = side->time.known ? side->time.block : -1;
    unsigned pack = mr_series_pack_find(id);
    enum mr_status status = MR_OK;
    if (pack < MR_SERIES_PACKS) {
        if (side->current) /* the newest block has just been brought up to that of the readings */
            account_step(account, pack, timebase_unwrap(&side->time, (uint16_t)(payload[length - 2] | payload[length - 1] << 8)));
        return MR_OK;
    }
    switch (id) {
    case MR_ID_LANDING: {
        GET(landing);
        status = landing(collector, side, &m, host_us, error);
        break;
    }
    case MR_ID_MARK: {
        GET(mark);
        status = collect_put_event(collector, side, "mark", m.block, m.number, 0, m.landing, host_us, error);
        break;
    }
    case MR_ID_SYNC: {
        GET(sync);
        collect_sync(side, &m, host_us);
        break;
    }
    case MR_ID_SYNC_AT: {
        GET(sync_at);
        collect_sync_at(side, &m);
        break;
    }
    case MR_ID_CLOCK: {
        GET(clock);
        collect_clock(side, &m, host_us);
        break;
    }
    case MR_ID_FILM_FRAME: {
        GET(film_frame);
        status = collect_film_frame(collector, side, &m, error);
        break;
    }
    case MR_ID_CAMERA: {
        GET(camera);
        int64_t camera_block = timebase_unwrap(&side->time, m.block16);
        status = collect_put_event(collector, side, "camera", camera_block < 0 ? 0 : camera_block, m.cause, 0, m.tick, host_us, error);
        break;
    }
    case MR_ID_ACK: {
        GET(ack);
        if (m.code == MR_COMMAND_ARM || m.code == MR_COMMAND_DISARM) {
            collector->answer = m;
            collector->answer_news = true;
        }
        status = collect_put_event(collector, side, "ack", m.block, m.code, m.status, m.tag, host_us, error);
        break;
    }
    case MR_ID_CAN_HEALTH: {
        GET(can_health);
        if (side->kind == LINK_CAN) {
            account_can_health(account, &m, block);
            status = excess(collector, side, error);
        }
        break;
    }
    case MR_ID_MESSAGE_COUNT: {
        GET(message_count);
        account_message_count(account, &m);
        break;
    }
    case MR_ID_SERIAL_HEALTH: {
        GET(serial_health);
        if (side->kind == LINK_SERIAL)
            serial_dropped(collector, side, &m, block);
        break;
    }
    default: status = by_topic(collector, side, id, payload, length, host_us, error); break;
    }
    return status;
}
