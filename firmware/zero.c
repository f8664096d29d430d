#include "firmware/zero.h"

#include "common/block.h"
#include "firmware/config.h"

static uint32_t measured; /* bit per channel */
static uint32_t changed;  /* likewise, and nobody has asked yet */
static float configured_code[MR_CHANNELS], configured_error[MR_CHANNELS];

void zero_start(void)
{
    measured = 0;
    changed = 0;
}

uint32_t zero_take_changed(void)
{
    uint32_t since = changed;
    changed = 0;
    return since;
}

void zero_measure(unsigned channel, float zero_code)
{
    struct mr_channel_config *in_force = &config.channel[channel];
    float error = in_force->kind == MR_KIND_TENSION ? ZERO_ERROR_LB : ZERO_ERROR_IN;
    if (!zero_is_measured(channel)) {
        configured_code[channel] = in_force->zero_code;
        configured_error[channel] = in_force->zero_error;
    }
    measured |= 1u << channel;
    changed |= 1u << channel;
    in_force->zero_code = zero_code;
    in_force->zero_error = error < configured_error[channel] ? error : configured_error[channel];
}

bool zero_is_measured(unsigned channel)
{
    return measured >> channel & 1u;
}

float zero_configured(unsigned channel)
{
    return zero_is_measured(channel) ? configured_code[channel] : config.channel[channel].zero_code;
}

void zero_exchange(void)
{
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        float code = config.channel[i].zero_code, error = config.channel[i].zero_error;
        if (!zero_is_measured(i))
            continue;
        config.channel[i].zero_code = configured_code[i];
        config.channel[i].zero_error = configured_error[i];
        configured_code[i] = code;
        configured_error[i] = error;
    }
}
