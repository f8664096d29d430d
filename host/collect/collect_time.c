/* Time: pairs of the board's clock and this computer's, what they come to for each landing and
 * boot, and film frames. */
#include <math.h>

#include "common/block.h"
#include "host/collect/collect.h"
#include "host/collect/collect_state.h"

/* How far two clocks may be apart: crystals by 200 ppm at most and a computer's that is being
 * slewed by 500; the board's internal oscillator by a hundredth and its drift. */
#define CRYSTAL_PPM  700.0
#define INTERNAL_PPM 20000.0

void collect_sync(struct side *side, const struct mr_sync *sync, uint64_t host_us)
{
    side->sync = *sync;
    side->sync_host_us = host_us;
}

void collect_sync_at(struct side *side, const struct mr_sync_at *sync_at)
{
    bool this_one = side->sync_host_us != 0 && (uint16_t)side->sync.block == sync_at->block16;
    if (this_one && sync_at->sent) {
        uint32_t origin = mr_boardtime_origin(side->sync.block, side->sync.tick);
        int64_t ticks = mr_boardtime_ticks(origin, side->sync.block, sync_at->tick);
        timemap_add(&side->map, (double)ticks / MR_TICKS_PER_US, (int64_t)side->sync_host_us);
    }
    side->sync_host_us = 0;
}

void collect_clock(struct side *side, const struct mr_clock *clock, uint64_t host_us)
{
    if (side->kind == LINK_SERIAL && clock->tick != 0)
        timemap_add(&side->map, 1000.0 * (double)clock->block + TIMEMAP_SERIAL_US,
                    (int64_t)host_us);
}

void collect_forget_time(struct side *side)
{
    side->map.count = 0;
    side->sync_host_us = 0;
}

enum mr_status collect_put_time_map(struct collector *collector, const struct side *side,
                                    const struct slot *slot, struct error *error)
{
    struct timemap_fit fit;
    bool crystal = collector->identity.clock_source == 0;
    if (side->map.count == 0)
        return MR_OK;
    timemap_fit(&side->map, crystal ? CRYSTAL_PPM : INTERNAL_PPM, &fit);
    struct store_time_map row = {.session = collector->session,
                                 .boot = side->boot,
                                 .link = side->kind,
                                 .run = slot ? slot->row.id : STORE_NONE,
                                 .refusal = fit.refusal,
                                 .pairs = (int64_t)fit.pairs,
                                 .from_us = llround(fit.from_us),
                                 .to_us = llround(fit.to_us),
                                 .spread_us = (double)NAN,
                                 .fast_ppm = (double)NAN,
                                 .fast_half_ppm = (double)NAN,
                                 .board_us = STORE_NONE,
                                 .host_us = STORE_NONE,
                                 .host_half_us = (double)NAN};
    if (fit.refusal == TIMEMAP_GOOD || fit.refusal == TIMEMAP_OTHER_PACE) {
        row.fast_ppm = fit.fast_ppm.value;
        row.fast_half_ppm = fit.fast_ppm.half;
    }
    if (fit.refusal == TIMEMAP_GOOD) {
        row.spread_us = fit.spread_us;
        row.board_us = llround(slot && slot->first_edge_us > 0.0 ? slot->first_edge_us : fit.to_us);
        struct timemap_value host = timemap_host_us(&fit, (double)row.board_us);
        row.host_us = llround(host.value);
        row.host_half_us = host.half;
    }
    return store_time_map_put(collector->store, &row, error);
}

enum mr_status collect_film_frame(struct collector *collector, struct side *side,
                                  const struct mr_film_frame *frame, struct error *error)
{
    struct slot *slot = side->current;
    if (!slot)
        return MR_OK;
    int64_t number = slot->film_frames +
                     (int16_t)(uint16_t)(frame->number - (uint16_t)slot->film_frames);
    if (number > slot->film_frames)
        slot->film_frames = number;
    struct store_film_frame row = {.number = number,
                                   .tick = frame->tick,
                                   .board_us = timebase_tick_us(&side->time, frame->tick),
                                   .links = 1 << side->kind};
    return store_film_frame_put(collector->store, slot->row.id, &row, error);
}

/* ---- side ----
 *
 * What a link knows of now, and the event that something makes there. All other files of the
 * collector stand on this one. */

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
