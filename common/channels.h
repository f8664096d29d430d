/* Channels: conversion of block records to inches and pounds, each reading with its validity.
 *
 *     linear value = (code * ratio - zero_code) * unit_per_code
 *     code         = (forward - reversed) / 8      transducer; forward, reversed: sums of 4 codes
 *     code         = sum / 8                       gage; sum: of 8 codes
 *     ratio        = MR_REFERENCE_CODE / (reference sum / 8)     while the reference is in range
 *     value        = linear value, corrected by the table of points: linear between points, the
 *                    first and last segments extended
 *
 * The transducers are excited with alternating polarity, so half the difference of the two
 * polarities is the synchronous demodulation: offsets of amplifier and converter cancel. The
 * reference channel removes the converter's scale from both kinds, zero included: zero_code is the
 * reading of a converter with the nominal scale of 3.3 V. This applies to a board with a different
 * supply too; there the zero_code of the reference channel is the reading of the reference itself.
 * A reading that is not valid has the value NaN.
 *
 * Each reading is relative to one of three quantities. The circuits are built this way, and the
 * emulated rig (hil/rig/rig.h) behaves the same:
 *
 *     the 2.5 V reference  transducers, which are driven from it, and bridges, excited by it.
 *                          Their voltages do not follow VDDA, so codes are multiplied by the
 *                          ratio; the error of the reference cancels. VDDA may be off by
 *                          MR_REFERENCE_TOLERANCE (3.235 to 3.367 V at 3.3 V nominal): beyond it,
 *                          the reading is missing (REFERENCE), never wrong.
 *     VDDA                 the staircase: its gates are supplied by VDDA, so its raw codes are
 *                          used at any VDDA (mr_staircase_code). The reference is read raw too.
 *     nothing              times: they are ticks of the crystal, independent of any voltage.
 *
 * docs/explanation/errors.md describes how wiring faults affect the two polarities.
 *
 * A bridge has only one polarity. A whole block at the lower end of the range is OPEN (the
 * amplifier's output with the bridge disconnected); a whole block at the upper end is SHORT (an
 * open arm of the bridge can cause that too). Faults that need more than one block (RATE, STUCK)
 * are in common/watch.h.
 *
 * Single precision, no library calls: host and board agree bit for bit. */
#ifndef MATRIG_COMMON_CHANNELS_H
#define MATRIG_COMMON_CHANNELS_H

#include <stdint.h>

#include "common/block.h"
#include "common/config.h"

/* code of 2.500 V at a full scale of 3.300 V and 4096 codes */
#define MR_REFERENCE_CODE        3103.0f
/* relative tolerance of the reference; if it is exceeded, channels that depend on the reference are
 * not valid */
#define MR_REFERENCE_TOLERANCE   0.02f
/* Limits of the mean of both polarities, codes. A transducer with excitation is at mid-scale, 2048;
 * if it deviates by more than a fifth, it is open or shorted. */
#define MR_COMMON_MODE_MIN_CODE  1638.0f
#define MR_COMMON_MODE_MAX_CODE  2458.0f
/* smallest half difference of the polarities that is a signal; below it, it is noise pick-up */
#define MR_SIGNAL_MIN_CODES      20.0f
/* An amplitude below this counts as missing excitation. This is reported only for a transducer
 * whose zero is at least MR_ZERO_OFFSET_MIN_CODES from mid-scale. The limit is six standard
 * deviations of a block's mean at 2 LSB of noise (2 / sqrt(8) = 0.71). */
#define MR_EXCITED_MIN_CODES     4.0f
#define MR_ZERO_OFFSET_MIN_CODES 20.0f

/* common/catalogue_values.def has the kinds of channels (enum mr_channel_kind) and the validities
 * of readings (enum mr_validity). */
#define MR_VALIDITY_COUNT (MR_INVALID_EXCITATION + 1u)

struct mr_reading {
    float value; /* reading in inches or pounds; NaN unless it is valid */
    float code;  /* raw code, before reference, zero and calibration are applied */
    uint8_t validity;
};

/* Returns the mean code of the staircase, relative to VDDA. */
static inline float mr_staircase_code(const struct mr_block *block)
{
    return (float)block->sum[MR_ADC1_STAIRCASE] / (float)MR_SCANS_PER_BLOCK;
}

/* Returns the scale correction of a block: MR_REFERENCE_CODE divided by the code of the reference.
 * NaN if the reference deviates from its nominal code by more than MR_REFERENCE_TOLERANCE. The
 * nominal code is the zero_code of the reference channel `reference`, or MR_REFERENCE_CODE if
 * zero_code is 0 or missing. */
float mr_reference_ratio(const struct mr_channel_config *reference, const struct mr_block *block);

/* Returns the reading of channel 0..MR_CHANNELS-1 of a block; `ratio` is from mr_reference_ratio
 * for this block. Staircase and reference are returned as mean codes, without the ratio. The range
 * of the channel is checked if low is less than high. */
struct mr_reading mr_channel_read(const struct mr_channel_config *config,
                                  const struct mr_block *block, unsigned channel, float ratio);

/* Corrects the linear value (see above), in inches or pounds, with the table of points. With fewer
 * than two points, returns it unchanged. */
float mr_channel_linearise(const struct mr_channel_config *config, float linear_value);

/* True if the channel measures inches or pounds. */
static inline _Bool mr_channel_is_sensor(const struct mr_channel_config *channel)
{
    return channel->kind == MR_KIND_DISPLACEMENT || channel->kind == MR_KIND_TENSION;
}

/* Number of values in a channel's calibration, as in the message `calibration`: those of enum
 * mr_calibration_item, then point_reading and point_value alternately. */
enum {
    MR_CALIBRATION_FIRST_POINT_ITEM = MR_CALIBRATION_POINTS + 1,
    MR_CALIBRATION_ITEM_COUNT = MR_CALIBRATION_FIRST_POINT_ITEM + 2 * MR_CONFIG_POINTS
};
float mr_channel_get_item(const struct mr_channel_config *config, unsigned item);
/* Sets an item. Ignores items that do not exist, and points beyond the capacity of the table. */
void mr_channel_set_item(struct mr_channel_config *config, unsigned item, float value);

/* ---- errors ---- */

/* Standard error of a reading: the uncertainty from the sensor, its calibration and the converter.
 *
 *     error^2 = noise^2 / averaged                       mean of that many blocks; noise: of
 *                                                        one block, current (watch.h)
 *             + (MR_QUANTISATION_CODES * unit_per_code)^2  rounding to whole codes, where the noise
 *                                                          is too small to average it away
 *             + (linearity_error * near)^2               error left by the table of points,
 *                                                        relative to the zero
 *             + (gain_error * value)^2                   error of unit_per_code: calibration,
 *                                                        excitation
 *             + (reference_error * (value + zero))^2     the reference's tolerance scales every
 *                                                        code, also that of the zero
 *             + (drift_error_per_h * hours)^2            since the zero was taken
 *             + zero_error^2
 *
 * near = min(1, sqrt(3/2) |value| / ((high - low) / MR_CONFIG_POINTS)), or 1 where low and high are
 * not set. Let the points of the table have the error s, except the point at zero, which has none.
 * The mean error between two points is then s sqrt(2/3). Between the zero and the next point, it is
 * s |value| divided by their distance.
 *
 * A movement is a reading minus the baseline, the mean at rest before the movement began. In this
 * difference the zero cancels: both its error and the part of it that the reference scales. Hours
 * count from the baseline, and the baseline adds noise^2 / baseline blocks.
 *
 * The terms are independent of each other (Guide to the expression of uncertainty in measurement,
 * 5.1.2). The errors of gain, zero, linearity, drift and reference are constant for one sensor
 * during one landing, so averaging does not reduce them. The noise is independent from block to
 * block, as converter noise is. The numbers are from the calibration sheet, through the
 * configuration (config.def); the built-in ones are from a data sheet (firmware/config.c).
 *
 * Single precision, one square root: host and board agree bit for bit. */

/* A rounding error is uniform within +-half a code: standard deviation 1 / sqrt(12) codes. Noise of
 * s codes per conversion reduces it by the factor exp(-2 pi^2 s^2) (Widrow and Kollar, Quantization
 * Noise, 2008). The factor is below 0.01 for noise above half a code, which is 0.18 codes in the
 * mean of a block. */
#define MR_QUANTISATION_CODES       0.289f
#define MR_QUANTISATION_NOISE_CODES 0.18f

struct mr_error_conditions {
    float value;           /* the reading or the movement, in inches or pounds */
    float noise;           /* standard deviation of one block, in inches or pounds */
    float averaged_blocks; /* number of blocks averaged in the reading */
    /* number of blocks in the baseline of a movement; 0: an absolute reading */
    float baseline_blocks;
    /* hours since the zero was measured; for a movement, since the baseline */
    float hours;
    float reference_error; /* relative error: gain_error of the reference channel */
};

/* Returns the standard error in inches or pounds; NaN if `noise` is NaN. */
float mr_reading_error(const struct mr_channel_config *config, const struct mr_error_conditions *c);

#endif
