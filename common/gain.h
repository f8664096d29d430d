/* Gain of a channel against what the rig's sensors and electronics can be. A gain beyond these
 * limits is a mistake of a unit or of a column, never a sensor: 25.4 for millimetres taken as
 * inches, 620 in per code for swapped columns. mr_config_check applies them, so host and board
 * refuse the same gains.
 *
 * Facts of the rig. Who builds other electronics changes the constants here, and the firmware with
 * them.
 *
 * Codes. A transducer reads half the difference of two polarities (channels.h): -2047.5 to 2047.5.
 * A gage reads 0 to 4095. The reference may correct both by MR_REFERENCE_SPAN.
 *
 * Transducer, in per code. Built in: 3 in of travel, 0.5 V/in, 3.3 V of 4096 codes: 0.00161
 * (firmware/config.c).
 *     most   0.01368: the half range would be 28 in, four times the largest movement that the rig
 *            saw: nearly 7 in, after 15 landings.
 *     least  0.000214: the half range would be 7/16 in, the largest movement of one landing with
 *            bands.
 * Gage, lb per code. Built in: 5 mV/lb: 0.161. At 2.5 V a quarter bridge on the steel bands (3/8 x
 * 0.020 in) gives 5.56 uV/lb and takes a gain of 900; a full Poisson bridge gives 14.4 uV/lb and
 * takes 346.
 *     most   0.635: the weaker bridge with the smaller gain gives 1.92 mV/lb, 1715 lb over the
 *            converter; half as much again is 2600 lb.
 *     least  0.00977: the converter would end within the 40 lb that the built-in shunt stands for.
 *
 * The channel's own range, low to high, where it is set:
 *     at least 100 codes: half a code of rounding is then 0.5 % of the range, what the transducer's
 *     data sheet promises; a quarter of it at least lies on the converter: the rest reads as
 *     saturated. Stated more generously it is another sensor's range.
 *
 * Gain means: unit_per_code times the slope of the table of points from its first to its last.
 *
 * Single precision, no library calls: host and board agree bit for bit. */
#ifndef MATRIG_COMMON_GAIN_H
#define MATRIG_COMMON_GAIN_H

#include "common/channels.h"
#include "common/config.h"

#define MR_TRANSDUCER_HALF_CODES          2047.5f
#define MR_GAGE_CODES                     4095.0f
#define MR_TRANSDUCER_HALF_RANGE_MOST_IN  28.0f
#define MR_TRANSDUCER_HALF_RANGE_LEAST_IN 0.4375f
#define MR_GAGE_RANGE_MOST_LB             2600.0f
#define MR_GAGE_RANGE_LEAST_LB            40.0f
#define MR_RANGE_LEAST_CODES              100.0f
#define MR_RANGE_REACHED                  0.25f

struct mr_gain_limits {
    float least, most;         /* in or lb per code, in size */
    float low_code, high_code; /* what the channel can read, code times the reference's ratio */
};

/* Of a channel that measures (mr_channel_measures). */
struct mr_gain_limits mr_gain_limits(const struct mr_channel_config *channel);
/* In or lb per code, with the sign of unit_per_code. */
float mr_channel_gain(const struct mr_channel_config *channel);
/* Codes from low to high; 0: no range is set. */
float mr_channel_range_codes(const struct mr_channel_config *channel);
/* What part of low to high lies on the converter, 0 to 1; 1: no range is set. */
float mr_channel_reached(const struct mr_channel_config *channel);
/* MR_RULE_NONE, COARSE, FINE, NARROW or UNREACHED. The gain is not 0, and the table of points
 * rises. */
enum mr_config_rule mr_gain_check(const struct mr_channel_config *channel);

#endif
