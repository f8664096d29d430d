/* Limits of a channel's gain, from the possible sensors and electronics of the rig. A gain beyond
 * these limits is due to a wrong unit or column, never to a sensor: a factor of 25.4 if millimetres
 * are entered as inches, 620 in per code for swapped columns. mr_config_check applies the limits,
 * so host and board refuse the same gains.
 *
 * The limits are properties of the rig. For other electronics, change the constants here and
 * rebuild the firmware.
 *
 * Codes: a transducer reads half the difference of the two polarities (channels.h), -2047.5 to
 * 2047.5. A gage reads 0 to 4095. The reference may correct both by up to MR_REFERENCE_TOLERANCE.
 *
 * Transducer, in per code. The built-in value (firmware/config.c) is 0.00161: 3 in of travel, 0.5
 * V/in, 3.3 V for 4096 codes.
 *     maximum  0.01368: the half range is then 28 in, four times the largest movement recorded
 *              on the rig (nearly 7 in after 15 landings).
 *     minimum  0.000214: the half range is then 7/16 in, the largest movement of one landing
 *              with bands.
 * Gage, lb per code. The built-in value is 0.161 (5 mV/lb). At 2.5 V a quarter bridge on the steel
 * bands (3/8 x 0.020 in) gives 5.56 uV/lb and takes a gain of 900; a full Poisson bridge gives 14.4
 * uV/lb and takes a gain of 346.
 *     maximum  0.635: the weaker bridge with the smaller gain gives 1.92 mV/lb, which is 1715 lb
 *              over the range of the converter; the limit of 2600 lb is 1.5 times that.
 *     minimum  0.00977: the range of the converter would be less than the 40 lb that the
 *              built-in shunt simulates.
 *
 * The range of the channel, low to high, where it is set:
 *     It must span at least 100 codes: half a code of rounding is then 0.5 % of the range, the
 *     accuracy in the transducer's data sheet. At least a quarter of it must be within the
 *     converter's range; values outside read as saturated. A wider range belongs to a different
 *     sensor.
 *
 * Gain is defined as unit_per_code times the slope of the table of points from its first to its
 * last point.
 *
 * Single precision, no library calls: host and board agree bit for bit. */
#ifndef MATRIG_COMMON_GAIN_H
#define MATRIG_COMMON_GAIN_H

#include "common/channels.h"
#include "common/config.h"

#define MR_TRANSDUCER_HALF_CODES        2047.5f
#define MR_GAGE_CODES                   4095.0f
#define MR_TRANSDUCER_HALF_RANGE_MAX_IN 28.0f
#define MR_TRANSDUCER_HALF_RANGE_MIN_IN 0.4375f
#define MR_GAGE_RANGE_MAX_LB            2600.0f
#define MR_GAGE_RANGE_MIN_LB            40.0f
#define MR_RANGE_MIN_CODES              100.0f
#define MR_RANGE_MIN_SHARE              0.25f

struct mr_gain_limits {
    float min_gain, max_gain;  /* magnitude of the gain, in or lb per code */
    float low_code, high_code; /* codes that can be read, after correction by the reference */
};

/* Limits for a channel that measures (mr_channel_is_sensor). */
struct mr_gain_limits mr_gain_limits(const struct mr_channel_config *channel);
/* Gain, in or lb per code, with the sign of unit_per_code. */
float mr_channel_gain(const struct mr_channel_config *channel);
/* Range of the channel (low to high) in codes; 0: no range is set. */
float mr_channel_range_codes(const struct mr_channel_config *channel);
/* Share of the channel's range (low to high) that is within the converter's range, 0 to 1; 1 if no
 * range is set. */
float mr_channel_range_share(const struct mr_channel_config *channel);
/* Returns MR_RULE_NONE, COARSE, FINE, NARROW or UNREACHED. The gain must not be 0, and the table of
 * points must rise. */
enum mr_config_rule mr_gain_check(const struct mr_channel_config *channel);

#endif
