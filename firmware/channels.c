#include "firmware/channels.h"

#include <string.h>

#include "common/block.h"
#include "common/channels.h"
#include "common/wire.h"
#include "common/onboard/predict_feed.h"
#include "firmware/config.h"
#include "firmware/health.h"
#include "firmware/schedule.h"

#define BLOCKS_PER_H         3600000.0f
/* number of blocks in which the quality of each channel is reported once */
#define QUALITY_ROUND_BLOCKS 1000u
_Static_assert(QUALITY_ROUND_BLOCKS / SCHEDULE_QUALITY_PERIOD >= MR_WATCH_CHANNELS,
               "the rotation has one turn for each channel");

void channels_start(struct channels *channels)
{
    memset(channels, 0, sizeof *channels);
}

void channels_arm(struct channels *channels, uint32_t index)
{
    mr_watch_begin(&channels->watch, config.channel, index);
}

void channels_on_zero_measured(struct channels *channels, uint32_t which, uint32_t index)
{
    for (unsigned c = 0; c < MR_WATCH_CHANNELS; c++) {
        if (which >> c & 1u)
            channels->zero_block[c] = index;
    }
}

float channels_read(struct channels *channels, const struct mr_block *block, unsigned channel,
                    float ratio)
{
    struct mr_reading reading = mr_channel_read(&config.channel[channel], block, channel, ratio);
    mr_watch_check(&channels->watch, &config.channel[channel], channel, block->index, &reading);
    return reading.value;
}

static void report_change(struct channels *channels, struct telemetry *telemetry, unsigned c,
                          uint32_t index)
{
    struct mr_watch_change change;
    if (!mr_watch_get_change(&channels->watch, c, index, &change))
        return;
    if (change.validity != MR_VALID)
        health_count_fault(MR_FAULT_CHANNEL, (uint8_t)c);
    TELEMETRY_SEND(telemetry, TO_RECORD, channel_event, CHANNEL_EVENT, .index = (uint8_t)c,
                   .validity = change.validity, .code = channels->watch.channel[c].code,
                   .block = change.block);
}

static void report_quality(const struct channels *channels, struct telemetry *telemetry, unsigned c,
                           uint32_t index, float value, float baseline)
{
    const struct mr_channel_config *channel = &config.channel[c];
    const struct mr_watch_channel *watched = &channels->watch.channel[c];
    if (!mr_channel_is_sensor(channel))
        return;
    bool movement = !__builtin_isnan(baseline);
    struct mr_error_conditions c_now = {
        .value = movement ? value - baseline : value,
        .noise = mr_watch_noise(&channels->watch, c),
        .averaged_blocks = 1.0f,
        .baseline_blocks = movement ? (float)BASELINE_BLOCKS : 0.0f,
        .hours = movement ? 0.0f : (float)(index - channels->zero_block[c]) / BLOCKS_PER_H,
        .reference_error = config.channel[MR_TRANSDUCERS + MR_ADC1_REFERENCE].gain_error,
    };
    float unit = __builtin_fabsf(channel->unit_per_code);
    TELEMETRY_SEND(telemetry, TO_RECORD, channel_quality, CHANNEL_QUALITY, .index = (uint8_t)c,
                   .validity = watched->reported_validity, .noise_codes = c_now.noise / unit,
                   .error_codes = mr_reading_error(channel, &c_now) / unit,
                   .invalid = watched->invalid_count);
}

void channels_report(struct channels *channels, struct telemetry *telemetry,
                     const struct landing *landing, uint32_t index, const float *displacement_in,
                     const float *baseline_in, const float *tension_lb)
{
    struct mr_watch *watch = &channels->watch;
    for (unsigned c = 0; watch->changed_channels && c < MR_WATCH_CHANNELS; c++)
        report_change(channels, telemetry, c, index);
    if (watch->is_recording && !landing_is_recording(landing))
        mr_watch_end(watch);
    unsigned c = index % QUALITY_ROUND_BLOCKS / SCHEDULE_QUALITY_PERIOD;
    if (!watch->is_recording || !DUE(QUALITY, index) || c >= MR_WATCH_CHANNELS)
        return;
    bool moves = c < MR_TRANSDUCERS;
    report_quality(channels, telemetry, c, index,
                   moves ? displacement_in[c] : tension_lb[c - MR_TRANSDUCERS],
                   moves ? baseline_in[c] : MR_NAN);
}

/* ---- zero ---- */

static uint32_t measured_channels; /* bit mask of channels whose zero was measured */
/* bit mask of channels whose zero was changed since the last zero_get_changed */
static uint32_t changed_channels;
static float configured_code[MR_CHANNELS], configured_error[MR_CHANNELS];

void zero_reset(void)
{
    measured_channels = 0;
    changed_channels = 0;
}

uint32_t zero_get_changed(void)
{
    uint32_t since = changed_channels;
    changed_channels = 0;
    return since;
}

void zero_set_measured(unsigned channel, float zero_code)
{
    struct mr_channel_config *in_force = &config.channel[channel];
    float error = in_force->kind == MR_KIND_TENSION ? ZERO_ERROR_LB : ZERO_ERROR_IN;
    if (!zero_is_measured(channel)) {
        configured_code[channel] = in_force->zero_code;
        configured_error[channel] = in_force->zero_error;
    }
    measured_channels |= 1u << channel;
    changed_channels |= 1u << channel;
    in_force->zero_code = zero_code;
    in_force->zero_error = error < configured_error[channel] ? error : configured_error[channel];
}

bool zero_is_measured(unsigned channel)
{
    return measured_channels >> channel & 1u;
}

float zero_get_configured(unsigned channel)
{
    return zero_is_measured(channel) ? configured_code[channel] : config.channel[channel].zero_code;
}

void zero_swap(void)
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
