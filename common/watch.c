#include "common/watch.h"

#include <string.h>

#include "common/wire.h"

#define BLOCK_S                 0.001f
/* A squared second difference is limited to this multiple of (variance so far + one code squared),
 * because a jump is not noise. The limit applies after NOISE_LIMIT_COUNT differences. */
#define SQUARED_NOISE_RATIO_MAX 36.0f
#define NOISE_LIMIT_COUNT       8u
/* Each channel is checked once every ROTATION_BLOCKS blocks, one channel after another. The noise
 * is computed from three consecutive blocks, the comparison with the neighbours from the last of
 * them. */
#define ROTATION_BLOCKS         8u

static bool is_displacement(const struct mr_channel_config *config)
{
    return config->kind == MR_KIND_DISPLACEMENT;
}

/* ---- beginning ---- */

static bool are_neighbour_candidates(const struct mr_channel_config *a,
                                     const struct mr_channel_config *b)
{
    return mr_channel_is_sensor(a) && a->kind == b->kind && a->band == b->band;
}

static void find_neighbours(struct mr_watch_channel *channel,
                            const struct mr_channel_config *config, unsigned c)
{
    channel->upfield = channel->downfield = MR_WATCH_NO_CHANNEL;
    for (unsigned other = 0; other < MR_WATCH_CHANNELS; other++) {
        float station_ft = config[other].station_ft;
        if (!are_neighbour_candidates(&config[c], &config[other]))
            continue;
        if (station_ft < config[c].station_ft && (channel->upfield == MR_WATCH_NO_CHANNEL ||
                                                  station_ft > config[channel->upfield].station_ft))
            channel->upfield = (uint8_t)other;
        if (station_ft > config[c].station_ft &&
            (channel->downfield == MR_WATCH_NO_CHANNEL ||
             station_ft < config[channel->downfield].station_ft))
            channel->downfield = (uint8_t)other;
    }
}

void mr_watch_begin(struct mr_watch *watch, const struct mr_channel_config *config, uint32_t index)
{
    memset(watch, 0, sizeof *watch);
    watch->begin_block = index;
    watch->is_recording = true;
    for (unsigned c = 0; c < MR_WATCH_CHANNELS; c++) {
        struct mr_watch_channel *channel = &watch->channel[c];
        channel->last_reading = channel->earlier_reading = channel->good_reading =
            channel->anchor_reading = channel->rest_noise = MR_NAN;
        find_neighbours(channel, config, c);
        channel->anchor_up_channel = channel->anchor_down_channel = MR_WATCH_NO_CHANNEL;
    }
}

void mr_watch_end(struct mr_watch *watch)
{
    watch->is_recording = false;
    for (unsigned c = 0; c < MR_WATCH_CHANNELS; c++) {
        struct mr_watch_channel *channel = &watch->channel[c];
        if (channel->reported_validity == MR_INVALID_RATE ||
            channel->reported_validity == MR_INVALID_STUCK)
            /* channels are not checked between landings, so there is no change to report */
            channel->reported_validity = MR_VALID;
    }
}

/* ---- noise ---- */

float mr_watch_noise(const struct mr_watch *watch, unsigned c)
{
    const struct mr_watch_channel *channel = &watch->channel[c];
    return channel->noise_count ? __builtin_sqrtf(channel->variance) : MR_NAN;
}

/* Computes a second difference from three consecutive readings, once in eight blocks. `turn`:
 * position of the reading among these three, from 0. */
static void update_noise(struct mr_watch_channel *channel, float value, float unit, unsigned turn)
{
    float second = value - 2.0f * channel->last_reading + channel->earlier_reading;
    channel->earlier_reading = turn == 0 ? MR_NAN : channel->last_reading;
    channel->last_reading = value;
    if (turn < 2 || __builtin_isnan(second))
        return;
    float square = second * second * (1.0f / 6.0f);
    float most = SQUARED_NOISE_RATIO_MAX * channel->variance + unit * unit;
    if (square > most && channel->noise_count >= NOISE_LIMIT_COUNT)
        square = most;
    if (channel->noise_count == MR_WATCH_NOISE_COUNT)
        channel->variance += (square - channel->variance) * (1.0f / (float)MR_WATCH_NOISE_COUNT);
    else
        channel->variance += (square - channel->variance) / (float)++channel->noise_count;
}

/* ---- rate ---- */

static bool is_too_fast(struct mr_watch_channel *channel, const struct mr_channel_config *config,
                        float value, uint32_t index)
{
    float allowed = config->rate_limit_per_s * BLOCK_S * (float)(index - channel->good_block);
    if (config->rate_limit_per_s > 0.0f && __builtin_fabsf(value - channel->good_reading) > allowed)
        /* without a good reading, the comparison with NaN is false, and the reading is accepted */
        return true;
    channel->good_reading = value;
    channel->good_block = index;
    return false;
}

/* ---- stuck ---- */

/* Returns the nearest valid channel on one side, beginning with channel `next`. */
static uint8_t find_nearest_valid(const struct mr_watch *watch, uint8_t next, bool upfield)
{
    while (next != MR_WATCH_NO_CHANNEL &&
           (watch->channel[next].new_validity != MR_VALID || watch->channel[next].is_stuck))
        next = upfield ? watch->channel[next].upfield : watch->channel[next].downfield;
    return next;
}

static float get_channel_reading(const struct mr_watch *watch, uint8_t c)
{
    return c == MR_WATCH_NO_CHANNEL ? MR_NAN : watch->channel[c].last_reading;
}

static void set_anchor(struct mr_watch *watch, struct mr_watch_channel *channel, float value,
                       uint32_t index)
{
    channel->anchor_reading = value;
    channel->anchor_block = index;
    channel->anchor_up_channel = find_nearest_valid(watch, channel->upfield, true);
    channel->anchor_down_channel = find_nearest_valid(watch, channel->downfield, false);
    channel->anchor_upfield = get_channel_reading(watch, channel->anchor_up_channel);
    channel->anchor_downfield = get_channel_reading(watch, channel->anchor_down_channel);
    channel->is_stuck = false;
}

/* True if both neighbours are valid now and were valid when the anchor (watch.h) was set. */
static bool is_anchored(const struct mr_watch *watch, const struct mr_watch_channel *channel)
{
    return !__builtin_isnan(get_channel_reading(watch, channel->anchor_up_channel) -
                            channel->anchor_upfield) &&
           !__builtin_isnan(get_channel_reading(watch, channel->anchor_down_channel) -
                            channel->anchor_downfield);
}

static bool have_neighbours_moved(const struct mr_watch *watch,
                                  const struct mr_watch_channel *channel, float by)
{
    return __builtin_fabsf(get_channel_reading(watch, channel->anchor_up_channel) -
                           channel->anchor_upfield) > by &&
           __builtin_fabsf(get_channel_reading(watch, channel->anchor_down_channel) -
                           channel->anchor_downfield) > by;
}

static void compare_neighbours(struct mr_watch *watch, struct mr_watch_channel *channel,
                               const struct mr_channel_config *config, float value, uint32_t index)
{
    float band = is_displacement(config) ? MR_STUCK_SPREAD_MAX_IN : MR_STUCK_SPREAD_MAX_LB;
    float noise_band = MR_STUCK_SPREAD_SIGMA * channel->rest_noise;
    if (noise_band > band)
        band = noise_band;
    bool holds = __builtin_fabsf(value - channel->anchor_reading) <= band;
    if (!holds || (!channel->is_stuck && !is_anchored(watch, channel)))
        set_anchor(watch, channel, value, index);
    else if (have_neighbours_moved(watch, channel,
                                   is_displacement(config) ? MR_STUCK_MOVE_MIN_IN
                                                           : MR_STUCK_MOVE_MIN_LB))
        channel->is_stuck = true;
}

/* Marks a channel whose codes have been constant for too long. The check uses codes, because the
 * values still vary with the noise of the reference. */
static void mark_constant(struct mr_watch_channel *channel, const struct mr_channel_config *config,
                          float value, uint32_t index)
{
    if (!(channel->rest_noise > MR_STUCK_NOISE_MIN_CODES * __builtin_fabsf(config->unit_per_code)))
        return;
    channel->anchor_reading = value;
    channel->anchor_block = index - MR_STUCK_CONSTANT_BLOCKS;
    channel->anchor_upfield = channel->anchor_downfield = MR_NAN;
    channel->is_stuck = true;
}

/* ---- reports ---- */

static void update_validity(struct mr_watch *watch, unsigned c, uint8_t validity, uint32_t index)
{
    struct mr_watch_channel *channel = &watch->channel[c];
    if (validity != MR_VALID && channel->invalid_count < UINT16_MAX)
        channel->invalid_count++;
    if (validity != channel->new_validity || channel->repeat_count == 0) {
        channel->new_validity = validity;
        channel->since_block = validity == MR_INVALID_STUCK ? channel->anchor_block : index;
        channel->repeat_count = 0;
    }
    if (channel->repeat_count < UINT8_MAX)
        channel->repeat_count++;
    unsigned enough = validity == MR_INVALID_RATE ? 1
                    : validity == MR_VALID        ? MR_WATCH_SETTLE_VALID_COUNT
                                                  : MR_WATCH_SETTLE_COUNT;
    bool paused = channel->has_reported && index - channel->reported_block < MR_WATCH_PAUSE_BLOCKS;
    if (validity != channel->reported_validity && channel->repeat_count >= enough && !paused)
        watch->changed_channels |= 1u << c;
}

bool mr_watch_get_change(struct mr_watch *watch, unsigned c, uint32_t index,
                         struct mr_watch_change *change)
{
    struct mr_watch_channel *channel = &watch->channel[c];
    if (!(watch->changed_channels >> c & 1u))
        return false;
    watch->changed_channels &= ~(1u << c);
    channel->reported_validity = channel->new_validity;
    channel->reported_block = index;
    channel->has_reported = true;
    *change = (struct mr_watch_change){.validity = channel->new_validity,
                                       .block = channel->since_block};
    return true;
}

static void check_reading(struct mr_watch *watch, const struct mr_channel_config *config,
                          unsigned c, uint32_t index, struct mr_reading *reading)
{
    struct mr_watch_channel *channel = &watch->channel[c];
    unsigned turn = (index + c) % ROTATION_BLOCKS;
    if (turn < 3)
        update_noise(channel, reading->value, config->unit_per_code, turn);
    if (reading->code != channel->code)
        channel->constant_count = 0;
    else if (channel->constant_count < UINT16_MAX)
        channel->constant_count++;
    if (reading->validity != MR_VALID)
        return;
    if (index - watch->begin_block >= MR_WATCH_REST_BLOCKS) {
        if (__builtin_isnan(channel->rest_noise))
            channel->rest_noise = mr_watch_noise(watch, c);
        if (channel->constant_count == MR_STUCK_CONSTANT_BLOCKS)
            mark_constant(channel, config, reading->value, index);
        if (turn == 2 || channel->is_stuck)
            compare_neighbours(watch, channel, config, reading->value, index);
    }
    if (is_too_fast(channel, config, reading->value, index))
        reading->validity = MR_INVALID_RATE;
    else if (channel->is_stuck)
        reading->validity = MR_INVALID_STUCK;
    else
        return;
    reading->value = MR_NAN;
}

void mr_watch_check(struct mr_watch *watch, const struct mr_channel_config *config, unsigned c,
                    uint32_t index, struct mr_reading *reading)
{
    struct mr_watch_channel *channel = &watch->channel[c];
    if (!mr_channel_is_sensor(config))
        return;
    if (watch->is_recording)
        check_reading(watch, config, c, index, reading);
    channel->code = reading->code;
    bool has_new_validity = reading->validity != channel->new_validity ||
                            reading->validity != channel->reported_validity ||
                            channel->repeat_count == 0;
    if (has_new_validity || reading->validity != MR_VALID)
        update_validity(watch, c, reading->validity, index);
}
