/* Channels: from block records to inches and pounds, each with its validity.
 *
 *     straight     = (code * ratio - zero_code) * unit_per_code
 *     code         = (plus - minus) / 8            of a transducer; plus, minus: sums of 4 codes
 *     code         = sum / 8                       of a gage; sum: of 8 codes
 *     ratio        = MR_REFERENCE_CODE / (reference sum / 8)     while the reference is in range
 *     value        = straight through the table of points: straight lines between them, the first
 *                  and last one carried on
 *
 * The transducers are excited with alternating polarity, so half the difference of the two
 * polarities is the synchronous demodulation: offsets of amplifier and converter cancel. The
 * reference channel takes the converter's scale out of both, zero included: zero_code is what a
 * converter of the nominal scale, 3.3 V, reads. That holds on a board with another supply too; what
 * the reference itself reads there stands in its own zero_code. A reading that is not valid has
 * value NaN.
 *
 * What a reading is relative to, three rules (the circuits are built so, and the
 * emulated rig, hil/rig/rig.h, is so by itself):
 *
 *     the 2.5 V reference  transducers: their drive is supplied from it. Bridges: excited by it.
 *                          Their volts do not follow VDDA, so codes are multiplied by the
 *                          ratio; the reference's own error drops out. VDDA may be off by
 *                          MR_REFERENCE_SPAN, 3.235 to 3.367 V where it is 3.3: beyond it the
 *                          reading is missing (REFERENCE), never wrong.
 *     VDDA                 the staircase: its gates are supplied by VDDA, so its steps are codes,
 *                          taken raw, whatever VDDA is (mr_staircase_code). So is the reference.
 *     nothing              times: ticks of the crystal. No voltage enters them.
 *
 * What a fault of the wiring looks like to the two polarities: docs/explanation/errors.md.
 *
 * A bridge has one polarity: a whole block at the lower end is OPEN (the amplifier's output when
 * the bridge is off), at the upper end SHORT (which an arm that is open can do too). What needs
 * more than one block (RATE, STUCK): common/watch.h.
 *
 * Single precision, no library calls: host and board agree bit for bit. */
#ifndef MATRIG_COMMON_CHANNELS_H
#define MATRIG_COMMON_CHANNELS_H

#include <stdint.h>

#include "common/block.h"
#include "common/config.h"

#define MR_REFERENCE_CODE   3103.0f /* 2.500 V of 3.300 V, 4096 codes */
#define MR_REFERENCE_SPAN   0.02f   /* relative; beyond it nothing measured against it is valid */
/* mean of both polarities, codes: a driven transducer sits at mid-scale, 2048; */
#define MR_COMMON_MODE_LOW  1638.0f
#define MR_COMMON_MODE_HIGH 2458.0f /* beyond these (a fifth off) it is open or shorted */
/* half difference of the polarities: less is no signal, but pick-up */
#define MR_FLOATING_CODES   20.0f
/* An amplitude below this counts as none; reported only for a transducer whose zero is at least
 * MR_ZERO_OFF_CODES off mid-scale. Six standard deviations of a block's mean at 2 LSB of noise (2 /
 * sqrt(8) = 0.71). */
#define MR_UNEXCITED_CODES  4.0f
#define MR_ZERO_OFF_CODES   20.0f

/* Kinds of channels and validities of readings: enum mr_channel_kind and enum mr_validity
 * (common/catalogue_values.def). */
#define MR_VALIDITIES (MR_INVALID_EXCITATION + 1u)

struct mr_reading {
    float value; /* in or lb; NaN unless valid */
    float code;  /* as converted: before reference, zero and calibration */
    uint8_t validity;
};

/* Mean code of the staircase, relative to VDDA. */
static inline float mr_staircase_code(const struct mr_block *block)
{
    return (float)block->sum[MR_ADC1_STAIRCASE] / (float)MR_SCANS_PER_BLOCK;
}

/* Scale correction of a block, MR_REFERENCE_CODE over its reference; NaN when the reference is more
 * than MR_REFERENCE_SPAN off what it should read: the zero_code of `reference`, its channel, or
 * MR_REFERENCE_CODE where that is 0 or missing. */
float mr_channels_ratio(const struct mr_channel_config *reference, const struct mr_block *block);

/* Reading of channel 0..MR_CHANNELS-1 of a block; `ratio` from mr_channels_ratio of the same block.
 * Staircase and reference read as mean codes, without ratio. low and high are checked where low is
 * less than high. */
struct mr_reading mr_channel_read(const struct mr_channel_config *config,
                                  const struct mr_block *block, unsigned channel, float ratio);

/* The true value, in or lb, for `straight`, the value by the straight line. Fewer than two points:
 * `straight` itself. */
float mr_channel_linearise(const struct mr_channel_config *config, float straight);

/* The channel measures inches or pounds. */
static inline _Bool mr_channel_measures(const struct mr_channel_config *channel)
{
    return channel->kind == MR_KIND_DISPLACEMENT || channel->kind == MR_KIND_TENSION;
}

/* Values of a channel's calibration as the message `calibration` numbers them: enum
 * mr_calibration_item, then point_reading and point_value in turn. */
enum {
    MR_CALIBRATION_TABLE = MR_CALIBRATION_POINTS + 1,
    MR_CALIBRATION_ITEMS = MR_CALIBRATION_TABLE + 2 * MR_CONFIG_POINTS
};
float mr_channel_item(const struct mr_channel_config *config, unsigned item);
/* Items beyond the last, and more points than there is room for, are left alone. */
void mr_channel_item_set(struct mr_channel_config *config, unsigned item, float value);

/* ---- errors ---- */

/* Standard error of a reading: what the sensor, its calibration and the converter leave uncertain.
 *
 *     error^2 = noise^2 / averaged                       of the mean of so many blocks; noise: of
 *                                                        one, as running now (watch.h)
 *             + (MR_QUANTISATION_CODES * unit_per_code)^2  rounding to whole codes, where the noise
 *                                                          is too small to average it away
 *             + (linearity_error * near)^2               what the table of points leaves, relative
 *                                                        to the zero
 *             + (gain_error * value)^2                   of unit_per_code: calibration, excitation
 *             + (reference_error * (value + zero))^2     the reference's own tolerance scales every
 *                                                        code, the zero's too
 *             + (drift_error_per_h * hours)^2            since the zero was taken
 *             + zero_error^2
 *
 * near = min(1, sqrt(3/2) |value| / ((high - low) / MR_CONFIG_POINTS)): points of a table that are
 * off by s, the zero's not, leave s sqrt(2/3) in the mean between them, and s |value| over their
 * distance between the zero and the next. 1 where low and high are not set.
 *
 * A movement is the difference of a reading and the baseline, the mean at rest before it began: the
 * zero drops out, both its error and the part of it that the reference scales, hours count from the
 * baseline, and the baseline brings noise^2 / baseline blocks.
 *
 * The terms are independent of each other (Guide to the expression of uncertainty in measurement,
 * 5.1.2); gain, zero, linearity, drift and reference are one draw for a sensor and a landing, so
 * that no averaging makes them smaller. Noise of a block is taken as independent of that of the
 * next, as converter noise is. Where the numbers come from: the calibration sheet, by way of the
 * configuration (config.def); built-in ones are a data sheet's (firmware/config.c).
 *
 * Single precision, one square root: host and board agree bit for bit. */

/* A rounding error is uniform in half a code: 1 / sqrt(12) codes. Noise of s codes a conversion
 * leaves exp(-2 pi^2 s^2) of it (Widrow and Kollar, Quantization Noise, 2008): less than a
 * hundredth above half a code, 0.18 codes of a block's mean. */
#define MR_QUANTISATION_CODES       0.289f
#define MR_QUANTISATION_NOISE_CODES 0.18f

struct mr_error_case {
    float value;           /* in or lb: the reading, or the movement */
    float noise;           /* in or lb, standard deviation of one block */
    float averaged;        /* blocks in the mean */
    float baseline_blocks; /* of a movement; 0: an absolute reading */
    float hours;           /* since the zero, of a movement since the baseline */
    float reference_error; /* relative: gain_error of the reference channel */
};

/* In or lb; NaN when the noise is. */
float mr_reading_error(const struct mr_channel_config *config, const struct mr_error_case *c);

#endif
