/* The standard errors of measured.h. */
#include <math.h>

#include "host/analyse/measured.h"

#define BLOCKS_PER_H 3600000.0

struct mr_error_case measured_error_case(const struct measured *measured,
                                         const struct measured_channel *channel, double value,
                                         double samples)
{
    bool movement = channel->config.kind == MR_KIND_DISPLACEMENT;
    double stride = (double)channel->stride;
    return (struct mr_error_case){
        .value = (float)value,
        .noise = (float)channel->noise,
        .averaged = (float)fmax(samples / stride, 1.0),
        .baseline_blocks = movement ? (float)fmax((double)channel->rest / stride, 1.0) : 0.0f,
        /* Since power on: when the zero was taken before is in zero_error. A landing is over before
         * its baseline drifts. */
        .hours = movement ? 0.0f : (float)((double)measured->first_block / BLOCKS_PER_H),
        .reference_error = measured->channel[MR_TRANSDUCERS + MR_ADC1_REFERENCE].config.gain_error,
    };
}

double measured_error(const struct measured *measured, const struct measured_channel *channel,
                      double value, double samples)
{
    struct mr_error_case c = measured_error_case(measured, channel, value, samples);
    return (double)mr_reading_error(&channel->config, &c);
}
