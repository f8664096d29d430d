/* What each message of the catalogue does to the campaign: those of a landing's state, of time and
 * of what was lost here, the others in the file of their topic. */
#include "common/command.h"
#include "host/collect/collect_state.h"

enum mr_status collect_state_event(struct collector *collector, const struct side *side,
                                   const struct mr_landing *message, uint64_t host_us,
                                   struct error *error)
{
    return collect_put_event(collector, side, "state", message->block, message->state,
                             message->cause, message->landing, host_us, error);
}

static enum mr_status landing(struct collector *collector, struct side *side,
                              const struct mr_landing *message, uint64_t host_us,
                              struct error *error)
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

/* Loss accounting. The newest block has just been brought up to that of the readings. */
static enum mr_status count_message(struct collector *collector, struct side *side,
                                    const struct collector_event *event, struct error *error)
{
    (void)collector, (void)error;
    const struct mr_message *m = event->message;
    unsigned pack = mr_series_pack_find(m->info->id);
    if (pack < MR_SERIES_PACKS) {
        if (side->current)
            account_step(&side->account, pack, timebase_unwrap(&side->time, (uint16_t)m->block16));
    } else if (m->place == MR_PLACE_MESSAGE_COUNT) {
        account_message_count(&side->account, &m->as.message_count);
    } else if (m->place == MR_PLACE_CAN_HEALTH && side->kind == LINK_CAN) {
        account_can_health(&side->account, &m->as.can_health, collect_newest_block(side));
    } else if (m->place == MR_PLACE_SERIAL_HEALTH && side->kind == LINK_SERIAL) {
        account_dropped(&side->account, m->as.serial_health.dropped, collect_newest_block(side));
    }
    return MR_OK;
}

/* What is kept as an event, as the rows of the catalogue have it. */
static bool event_of(const struct mr_message *message, struct store_event *event)
{
    switch (message->place) {
/* clang-format off */
#define EVENT(name, NAME, kind_, code_, detail_, value_)                               \
    case MR_PLACE_##NAME: {                                                            \
        const struct mr_##name *m = &message->as.name;                                 \
        *event = (struct store_event){.kind = kind_, .code = code_, .detail = detail_, \
            .value = value_};                                                          \
        break;                                                                         \
    }
/* clang-format on */
#include "common/catalogue.def"
    default: return false;
    }
    return true;
}

static enum mr_status keep_event(struct collector *collector, struct side *side,
                                 const struct collector_event *heard, struct error *error)
{
    struct store_event event;
    if (!event_of(heard->message, &event))
        return MR_OK;
    int64_t block = collect_block(side, heard->message);
    return collect_put_event(collector, side, event.kind, block < 0 ? 0 : block, event.code,
                             event.detail, event.value, heard->host_us, error);
}

static void take_answer(struct collector *collector, const struct mr_ack *message)
{
    if (message->code != MR_COMMAND_ARM && message->code != MR_COMMAND_DISARM)
        return;
    collector->answer = *message;
    collector->answer_news = true;
}

/* The landing's state, its film, answers to commands, and the board's time. */
static enum mr_status state_message(struct collector *collector, struct side *side,
                                    const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    uint64_t host_us = event->host_us;
    switch (m->place) {
    case MR_PLACE_LANDING: return landing(collector, side, &m->as.landing, host_us, error);
    case MR_PLACE_FILM_FRAME: return collect_film_frame(collector, side, &m->as.film_frame, error);
    case MR_PLACE_ACK: take_answer(collector, &m->as.ack); return MR_OK;
    case MR_PLACE_SYNC: collect_sync(side, &m->as.sync, host_us); return MR_OK;
    case MR_PLACE_SYNC_AT: collect_sync_at(side, &m->as.sync_at); return MR_OK;
    case MR_PLACE_CLOCK: collect_clock(side, &m->as.clock, host_us); return MR_OK;
    default: return MR_OK;
    }
}

/* Who takes which message, beside the event that it may be; the others are kept as frames alone. */
static collect_topic *const topics[MR_PLACES] = {
#define PACK(SERIES_NAME, name, NAME, id, first, count) [MR_PLACE_##NAME] = count_message,
#include "common/catalogue.def"
    [MR_PLACE_MESSAGE_COUNT] = count_message,
    [MR_PLACE_CAN_HEALTH] = count_message,
    [MR_PLACE_SERIAL_HEALTH] = count_message,
    [MR_PLACE_LANDING] = state_message,
    [MR_PLACE_FILM_FRAME] = state_message,
    [MR_PLACE_ACK] = state_message,
    [MR_PLACE_SYNC] = state_message,
    [MR_PLACE_SYNC_AT] = state_message,
    [MR_PLACE_CLOCK] = state_message,
    [MR_PLACE_HELLO] = collect_identity_message,
    [MR_PLACE_BOARD_UID] = collect_identity_message,
    [MR_PLACE_BOARD_IMAGE] = collect_identity_message,
    [MR_PLACE_IMAGE_COMMIT] = collect_identity_message,
    [MR_PLACE_BOARD_CONFIG] = collect_identity_message,
    [MR_PLACE_CONFIG_IMAGE] = collect_identity_message,
    [MR_PLACE_SITE] = collect_identity_message,
    [MR_PLACE_CHANNEL] = collect_identity_message,
    [MR_PLACE_CHANNEL_ZERO] = collect_identity_message,
    [MR_PLACE_CALIBRATION] = collect_identity_message,
    [MR_PLACE_SWITCH_PLACE] = collect_identity_message,
    [MR_PLACE_SLACK] = collect_identity_message,
    [MR_PLACE_EDGE] = collect_gear_message,
    [MR_PLACE_SWITCH_EVENT] = collect_gear_message,
    [MR_PLACE_MOTION] = collect_gear_message,
    [MR_PLACE_MOTION_ERROR] = collect_gear_message,
    [MR_PLACE_ZONE] = collect_gear_message,
    [MR_PLACE_ZONE_LEAD] = collect_gear_message,
    [MR_PLACE_TOUCHDOWN] = collect_gear_message,
    [MR_PLACE_STOP] = collect_gear_message,
    [MR_PLACE_ZONE_ERROR] = collect_predict_message,
    [MR_PLACE_ZONE_COMING] = collect_predict_message,
    [MR_PLACE_ZONE_PRESS] = collect_predict_message,
    [MR_PLACE_VERDICT] = collect_predict_message,
    [MR_PLACE_RISK] = collect_predict_message,
    [MR_PLACE_RISK_LEAD] = collect_predict_message,
    [MR_PLACE_RISK_ITEM] = collect_predict_message,
    [MR_PLACE_TRUST] = collect_predict_message,
    [MR_PLACE_RUNWAY] = collect_predict_message,
    [MR_PLACE_RUNWAY_JOINTS] = collect_predict_message,
    [MR_PLACE_RUNWAY_STORE] = collect_predict_message,
    [MR_PLACE_PREDICT_ITEM] = collect_predict_message,
    [MR_PLACE_BAND_EVENT] = collect_band_message,
    [MR_PLACE_BAND_BEFORE] = collect_band_message,
    [MR_PLACE_BAND_LEAST] = collect_band_message,
    [MR_PLACE_BAND_MOST] = collect_band_message,
    [MR_PLACE_BAND_AFTER] = collect_band_message,
    [MR_PLACE_SHUNT] = collect_band_message,
    [MR_PLACE_SHUNT_RESULT] = collect_band_message,
    [MR_PLACE_SHUNT_CHECK] = collect_band_message,
    [MR_PLACE_CHANNEL_QUALITY] = collect_health_message,
    [MR_PLACE_FAULT] = collect_health_message,
    [MR_PLACE_TEMPERATURE] = collect_health_message,
    [MR_PLACE_CRASH] = collect_health_message,
    [MR_PLACE_CAN_ALARM] = collect_health_message,
    [MR_PLACE_SLOW_ROW] = collect_health_message,
    [MR_PLACE_SLOW_TENSION] = collect_health_message,
};

enum mr_status collect_message(struct collector *collector, struct side *side,
                               const struct collector_event *event, struct error *error)
{
    collect_topic *topic = topics[event->message->place];
    enum mr_status status = keep_event(collector, side, event, error);
    return status == MR_OK && topic ? topic(collector, side, event, error) : status;
}

enum mr_status collect_message_again(struct collector *collector, struct side *side,
                                     const struct collector_event *event, struct error *error)
{
    collect_topic *topic = topics[event->message->place];
    bool of_landing = topic == collect_gear_message || topic == collect_predict_message ||
                      topic == collect_band_message;
    enum mr_status status = keep_event(collector, side, event, error);
    return status == MR_OK && of_landing ? topic(collector, side, event, error) : status;
}
