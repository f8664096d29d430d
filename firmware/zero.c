#include "firmware/zero.h"

#include "common/block.h"
#include "firmware/config.h"

static uint32_t measured; /* bit per channel */
static uint32_t changed;  /* likewise, and nobody has asked yet */
static float configured_code[MR_CHANNELS];

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
    if (!zero_is_measured(channel))
        configured_code[channel] = config.channel[channel].zero_code;
    measured |= 1u << channel;
    changed |= 1u << channel;
    config.channel[channel].zero_code = zero_code;
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
        float in_force = config.channel[i].zero_code;
        if (!zero_is_measured(i))
            continue;
        config.channel[i].zero_code = configured_code[i];
        configured_code[i] = in_force;
    }
}
