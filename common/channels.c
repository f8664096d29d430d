#include "common/channels.h"

#include "common/wire.h"

#define CODES_PER_SUM ((float)MR_SCANS_PER_BLOCK)

float mr_channels_ratio(const struct mr_block *block)
{
    unsigned channel = MR_TRANSDUCERS + MR_ADC1_REFERENCE;
    float code = (float)block->sum[MR_ADC1_REFERENCE] / CODES_PER_SUM;
    if (block->low[channel] || block->high[channel] || code < MR_REFERENCE_CODE * (1.0f - MR_REFERENCE_SPAN) ||
        code > MR_REFERENCE_CODE * (1.0f + MR_REFERENCE_SPAN))
        return MR_NAN;
    return MR_REFERENCE_CODE / code;
}

struct mr_reading mr_channel_read(const struct mr_channel_config *config, const struct mr_block *block,
                                  unsigned channel, float ratio)
{
    struct mr_reading reading = {MR_NAN, MR_INVALID_NOT_FITTED};
    float code;

    if (config->kind == MR_KIND_NONE)
        return reading;
    if (channel < MR_TRANSDUCERS) {
        float plus = (float)block->plus[channel];
        float minus = (float)block->minus[channel];
        float common_mode = (plus + minus) / CODES_PER_SUM;
        code = (plus - minus) / CODES_PER_SUM;
        if (common_mode < MR_COMMON_MODE_LOW || common_mode > MR_COMMON_MODE_HIGH) {
            reading.validity = MR_INVALID_OPEN;
            return reading;
        }
    } else {
        code = (float)block->sum[channel - MR_TRANSDUCERS] / CODES_PER_SUM;
    }
    if (block->low[channel] || block->high[channel]) {
        reading.validity = MR_INVALID_SATURATED;
        return reading;
    }
    if (config->kind == MR_KIND_DISPLACEMENT || config->kind == MR_KIND_TENSION) {
        if (__builtin_isnan(ratio)) {
            reading.validity = MR_INVALID_REFERENCE;
            return reading;
        }
        code = (code - config->zero_code) * config->unit_per_code * ratio;
    }
    reading.value = code;
    reading.validity = MR_VALID;
    return reading;
}

const char *mr_validity_text(unsigned validity)
{
    switch (validity) {
    case MR_VALID: return "valid";
    case MR_INVALID_NOT_FITTED: return "not fitted";
    case MR_INVALID_SATURATED: return "saturated";
    case MR_INVALID_OPEN: return "open or shorted";
    case MR_INVALID_REFERENCE: return "reference";
    default: return "unknown";
    }
}
