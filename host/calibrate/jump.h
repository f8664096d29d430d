/* Detection of a jump of a channel's gain between two calibrations, and of the likely mistake
 * behind an impossible gain. Pure functions. */
#ifndef MATRIG_HOST_CALIBRATE_JUMP_H
#define MATRIG_HOST_CALIBRATE_JUMP_H

#include <stdbool.h>
#include <stddef.h>

#include "common/config.h"

/* Allowed ratio of a channel's gain to an earlier gain of the same channel, in either direction:
 * - JUMP_RATIO_SAME_SENSOR: the same sensor was calibrated again. The 0.5 % of the data sheet and
 * the 2 % of the reference are well within the limit; the smallest likely mistake of units (pounds
 * for kilograms) is a factor of 2.2. The sign must not change.
 * - JUMP_RATIO_TRANSDUCER: first calibration of a transducer, or a different one by its serial
 * number. Transducers differ, but have the same amplifier; centimetres for inches are a factor of
 * 2.54.
 * - JUMP_RATIO_GAGE: first calibration of a gage, or a different one. Bridges of 5.56 and 14.4
 * uV/lb with gains of 900 and 346 (common/gain.h) differ from the built-in values by a factor of up
 * to 2.6; band sections differ too. */
#define JUMP_RATIO_SAME_SENSOR 1.1
#define JUMP_RATIO_TRANSDUCER  1.5
#define JUMP_RATIO_GAGE        5.0
#define JUMP_TEXT_SIZE         160

/* Returns true if the gain jumped; `text` is then "gain 0.001611 -> 0.004093 in per code, a factor
 * of 2.54". `old` and `new` belong to the same input. Also returns false if the two cannot be
 * compared: the sensor is not fitted in one of them, or is of another kind. */
bool jump_find(const struct mr_channel_config *old, const struct mr_channel_config *new,
               char text[JUMP_TEXT_SIZE]);
/* Writes the name of a channel by its input, as in matrig calibrate: "d3", "t12". `index` is from
 * 0. */
void jump_channel_name(unsigned index, char out[8]);
/* Finds the index of a channel by its name of `length` characters; returns false if there is no
 * such channel. */
bool jump_channel_find(const char *name, size_t length, unsigned *index);

/* Writes the likely mistake behind an impossible gain, "; the unit of the values may have been
 * mm" or "; the columns may be swapped"; empty if no such mistake explains the gain of a
 * measuring channel. */
void jump_write_mistake_hint(const struct mr_channel_config *channel, char *out, size_t size);

#endif
