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
#ifndef MATRIG_COMMON_MEASURE_H
#define MATRIG_COMMON_MEASURE_H

#include "common/config.h"

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
