#include "common/channels.h"

#include <stddef.h>
#include <string.h>

#include "common/wire.h"

#define CODES_PER_SUM ((float)MR_SCANS_PER_BLOCK)

float mr_reference_ratio(const struct mr_channel_config *reference, const struct mr_block *block)
{
    unsigned channel = MR_TRANSDUCERS + MR_ADC1_REFERENCE;
    float wanted = reference->zero_code > 0.0f ? reference->zero_code : MR_REFERENCE_CODE;
    float code = (float)block->sum[MR_ADC1_REFERENCE] / CODES_PER_SUM;
    if (block->low_count[channel] || block->high_count[channel] ||
        code < wanted * (1.0f - MR_REFERENCE_TOLERANCE) ||
        code > wanted * (1.0f + MR_REFERENCE_TOLERANCE))
        return MR_NAN;
    return MR_REFERENCE_CODE / code;
}

static uint8_t find_saturated_ends(const struct mr_block *block, unsigned channel)
{
    if (block->low_count[channel] == MR_SCANS_PER_BLOCK)
        return MR_INVALID_OPEN;
    if (block->high_count[channel] == MR_SCANS_PER_BLOCK)
        return MR_INVALID_SHORTED;
    return block->low_count[channel] || block->high_count[channel] ? MR_INVALID_SATURATED
                                                                   : MR_VALID;
}

/* Detects, from the common mode and the amplitude, a transducer that is not connected or not
 * excited. */
static uint8_t check_wiring(const struct mr_channel_config *config, float common_mode, float code)
{
    if (common_mode < MR_COMMON_MODE_MIN_CODE || common_mode > MR_COMMON_MODE_MAX_CODE)
        return __builtin_fabsf(code) < MR_SIGNAL_MIN_CODES ? MR_INVALID_OPEN : MR_INVALID_SHORTED;
    if (__builtin_fabsf(code) < MR_EXCITED_MIN_CODES &&
        __builtin_fabsf(config->zero_code) >= MR_ZERO_OFFSET_MIN_CODES)
        return MR_INVALID_EXCITATION;
    return MR_VALID;
}

float mr_channel_linearise(const struct mr_channel_config *config, float linear_value)
{
    unsigned last = config->points < MR_CONFIG_POINTS ? config->points : MR_CONFIG_POINTS;
    if (last < 2)
        return linear_value;
    unsigned to = 1;
    while (to < last - 1 && linear_value > config->point_reading[to])
        to++;
    float from_reading = config->point_reading[to - 1], from_value = config->point_value[to - 1];
    float slope = (config->point_value[to] - from_value) /
                  (config->point_reading[to] - from_reading);
    return from_value + slope * (linear_value - from_reading);
}

struct mr_reading mr_channel_read(const struct mr_channel_config *config,
                                  const struct mr_block *block, unsigned channel, float ratio)
{
    struct mr_reading reading = {MR_NAN, MR_NAN, MR_INVALID_NOT_FITTED};

    if (config->kind == MR_KIND_NONE)
        return reading;
    reading.validity = find_saturated_ends(block, channel);
    if (channel < MR_TRANSDUCERS) {
        float plus = (float)block->forward_sum[channel];
        float minus = (float)block->reversed_sum[channel];
        reading.code = (plus - minus) / CODES_PER_SUM;
        if (reading.validity == MR_VALID)
            reading.validity = check_wiring(config, (plus + minus) / CODES_PER_SUM, reading.code);
    } else {
        reading.code = (float)block->sum[channel - MR_TRANSDUCERS] / CODES_PER_SUM;
    }
    if (reading.validity != MR_VALID)
        return reading;
    float value = reading.code;
    if (mr_channel_is_sensor(config)) {
        if (__builtin_isnan(ratio)) {
            reading.validity = MR_INVALID_REFERENCE;
            return reading;
        }
        value = mr_channel_linearise(config, (reading.code * ratio - config->zero_code) *
                                                 config->unit_per_code);
        if (config->low < config->high && !(value >= config->low && value <= config->high)) {
            reading.validity = MR_INVALID_RANGE;
            return reading;
        }
    }
    reading.value = value;
    return reading;
}

/* Returns the offset of an item in the struct; 0 if the item is not a real. */
static size_t get_item_offset(unsigned item)
{
    static const size_t single[] = {
        [MR_CALIBRATION_GAIN_ERROR] = offsetof(struct mr_channel_config, gain_error),
        [MR_CALIBRATION_ZERO_ERROR] = offsetof(struct mr_channel_config, zero_error),
        [MR_CALIBRATION_LINEARITY_ERROR] = offsetof(struct mr_channel_config, linearity_error),
        [MR_CALIBRATION_DRIFT_ERROR] = offsetof(struct mr_channel_config, drift_error_per_h),
        [MR_CALIBRATION_LOW] = offsetof(struct mr_channel_config, low),
        [MR_CALIBRATION_HIGH] = offsetof(struct mr_channel_config, high),
        [MR_CALIBRATION_RATE_LIMIT] = offsetof(struct mr_channel_config, rate_limit_per_s),
        [MR_CALIBRATION_POINTS] = 0,
    };
    if (item < MR_CALIBRATION_FIRST_POINT_ITEM)
        return single[item];
    if (item >= MR_CALIBRATION_ITEM_COUNT)
        return 0;
    size_t table = (item - MR_CALIBRATION_FIRST_POINT_ITEM) % 2
                     ? offsetof(struct mr_channel_config, point_value)
                     : offsetof(struct mr_channel_config, point_reading);
    return table + (item - MR_CALIBRATION_FIRST_POINT_ITEM) / 2 * sizeof(float);
}

float mr_channel_get_item(const struct mr_channel_config *config, unsigned item)
{
    size_t offset = get_item_offset(item);
    float value = item == MR_CALIBRATION_POINTS ? (float)config->points : MR_NAN;
    if (offset)
        memcpy(&value, (const uint8_t *)config + offset, sizeof value);
    return value;
}

void mr_channel_set_item(struct mr_channel_config *config, unsigned item, float value)
{
    size_t offset = get_item_offset(item);
    if (offset)
        memcpy((uint8_t *)config + offset, &value, sizeof value);
    else if (item == MR_CALIBRATION_POINTS && value >= 0.0f && value <= (float)MR_CONFIG_POINTS)
        config->points = (uint8_t)value;
}

/* ---- errors ---- */

static float square(float x)
{
    return x * x;
}

static float compute_linearity_share(const struct mr_channel_config *config, float value)
{
    /* 0.816497 = sqrt(2 / 3) */
    float segment = (config->high - config->low) * (0.816497f / (float)MR_CONFIG_POINTS);
    float size = value < 0.0f ? -value : value;
    return size < segment ? size / segment : 1.0f;
}

float mr_reading_error(const struct mr_channel_config *config, const struct mr_error_conditions *c)
{
    float variance = square(c->noise) / c->averaged_blocks;
    float scaled = c->value;
    if (square(c->noise) < square(MR_QUANTISATION_NOISE_CODES * config->unit_per_code))
        variance += square(MR_QUANTISATION_CODES * config->unit_per_code);
    variance += square(config->linearity_error * compute_linearity_share(config, c->value)) +
                square(config->gain_error * c->value);
    variance += square(config->drift_error_per_h * c->hours);
    if (c->baseline_blocks > 0.0f) {
        variance += square(c->noise) / c->baseline_blocks;
    } else {
        variance += square(config->zero_error);
        scaled += config->zero_code * config->unit_per_code;
    }
    variance += square(c->reference_error * scaled);
    return __builtin_sqrtf(variance);
}
