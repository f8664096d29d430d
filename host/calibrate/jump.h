/* What a calibration jumped by, and which mistake an impossible gain looks like. Pure. */
#ifndef MATRIG_HOST_CALIBRATE_JUMP_H
#define MATRIG_HOST_CALIBRATE_JUMP_H

#include <stdbool.h>
#include <stddef.h>

#include "common/config.h"

/* A channel's gain against an earlier one of the same channel: has it jumped? Pure.
 *
 * Gain, relative to the earlier one, to either side:
 *     a tenth       of the same sensor, calibrated anew. The data sheet's 0.5 % and the 2 % of the
 *                   reference are far inside; the nearest mistake of a unit, pounds for kilograms,
 *                   is a factor of 2.2. Its sign stays as well.
 *     half          of a transducer at its first calibration, or of another one (the serial numbers
 *                   say so): cells differ, the amplifier is one; centimetres for inches are 2.54.
 *     five times    likewise of a gage: bridges of 5.56 and 14.4 uV/lb with gains of 900 and 346
 *                   (common/gain.h) differ by up to 2.6 from what is built in, band sections
 *                   besides.
 */
#define JUMP_GAIN_SAME       1.1
#define JUMP_GAIN_TRANSDUCER 1.5
#define JUMP_GAIN_GAGE       5.0
#define JUMP_TEXT            160

/* Both are of one input. True: the gain jumped, and `text` is "gain 0.001611 -> 0.004093 in per
 * code, 2.54 times". False when there is nothing to compare, too (not fitted then or now, or of
 * another kind). */
bool jump_find(const struct mr_channel_config *old, const struct mr_channel_config *new,
               char text[JUMP_TEXT]);
/* "d3", "t12", by the input, as matrig calibrate has it: index from 0. */
void jump_channel(unsigned index, char out[8]);
/* The index of such a name that ends at `length`; false: no channel. */
bool jump_channel_read(const char *name, size_t length, unsigned *index);

/* What mistake an impossible gain looks like: values in another unit, or swapped columns. Pure. */
/* "; were the values mm?", "; are the columns swapped?"; empty when no such mistake explains the
 * gain of a channel that measures. */
void mistake_text(const struct mr_channel_config *channel, char *out, size_t size);

#endif
