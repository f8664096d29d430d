#include "common/gain.h"

struct mr_gain_limits mr_gain_limits(const struct mr_channel_config *channel)
{
    const float corrected = 1.0f + MR_REFERENCE_TOLERANCE;
    if (channel->kind == MR_KIND_DISPLACEMENT)
        return (struct mr_gain_limits){MR_TRANSDUCER_HALF_RANGE_MIN_IN / MR_TRANSDUCER_HALF_CODES,
                                       MR_TRANSDUCER_HALF_RANGE_MAX_IN / MR_TRANSDUCER_HALF_CODES,
                                       -MR_TRANSDUCER_HALF_CODES * corrected,
                                       MR_TRANSDUCER_HALF_CODES * corrected};
    return (struct mr_gain_limits){MR_GAGE_RANGE_MIN_LB / MR_GAGE_CODES,
                                   MR_GAGE_RANGE_MAX_LB / MR_GAGE_CODES, 0.0f,
                                   MR_GAGE_CODES * corrected};
}

float mr_channel_gain(const struct mr_channel_config *channel)
{
    unsigned last = channel->points < MR_CONFIG_POINTS ? channel->points : MR_CONFIG_POINTS;
    if (last < 2)
        return channel->unit_per_code;
    return channel->unit_per_code *
           ((channel->point_value[last - 1] - channel->point_value[0]) /
            (channel->point_reading[last - 1] - channel->point_reading[0]));
}

float mr_channel_range_codes(const struct mr_channel_config *channel)
{
    return channel->low < channel->high
             ? (channel->high - channel->low) / __builtin_fabsf(mr_channel_gain(channel))
             : 0.0f;
}

static float get_value_at_code(const struct mr_channel_config *channel, float code)
{
    return mr_channel_linearise(channel, (code - channel->zero_code) * channel->unit_per_code);
}

float mr_channel_range_share(const struct mr_channel_config *channel)
{
    struct mr_gain_limits limits = mr_gain_limits(channel);
    float one = get_value_at_code(channel, limits.low_code),
          other = get_value_at_code(channel, limits.high_code);
    if (!(channel->low < channel->high))
        return 1.0f;
    float from = one < other ? one : other, to = one < other ? other : one;
    from = from > channel->low ? from : channel->low;
    to = to < channel->high ? to : channel->high;
    return to > from ? (to - from) / (channel->high - channel->low) : 0.0f;
}

enum mr_config_rule mr_gain_check(const struct mr_channel_config *channel)
{
    struct mr_gain_limits limits = mr_gain_limits(channel);
    float gain = __builtin_fabsf(mr_channel_gain(channel)), codes = mr_channel_range_codes(channel);
    if (!(gain <= limits.max_gain))
        return MR_RULE_CODE_TOO_COARSE;
    if (!(gain >= limits.min_gain))
        return MR_RULE_CODE_TOO_FINE;
    if (codes > 0.0f && codes < MR_RANGE_MIN_CODES)
        return MR_RULE_RANGE_TOO_NARROW;
    return mr_channel_range_share(channel) < MR_RANGE_MIN_SHARE ? MR_RULE_RANGE_UNREACHABLE
                                                                : MR_RULE_NONE;
}
