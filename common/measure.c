#include "common/measure.h"

static float square(float x)
{
    return x * x;
}

static float near_the_zero(const struct mr_channel_config *config, float value)
{
    /* sqrt(2 / 3) */
    float segment = (config->high - config->low) * (0.816497f / (float)MR_CONFIG_POINTS);
    float size = value < 0.0f ? -value : value;
    return size < segment ? size / segment : 1.0f;
}

float mr_reading_error(const struct mr_channel_config *config, const struct mr_error_case *c)
{
    float variance = square(c->noise) / c->averaged;
    float scaled = c->value;
    if (square(c->noise) < square(MR_QUANTISATION_NOISE_CODES * config->unit_per_code))
        variance += square(MR_QUANTISATION_CODES * config->unit_per_code);
    variance += square(config->linearity_error * near_the_zero(config, c->value)) +
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
