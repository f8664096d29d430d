/* What a calibration jumped by, and which mistake an impossible gain looks like. Pure. */
#ifndef MATRIG_HOST_CALIBRATE_JUMP_H
#define MATRIG_HOST_CALIBRATE_JUMP_H

#include <stdbool.h>
#include <stddef.h>

#include "common/config.h"

/* A channel's calibration against an earlier one of the same channel: has it jumped? Pure.
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
 * Zero of the same sensor, where the earlier one is known: 0.25 in, as of a mat at rest
 * (READY_ZERO_IN); 10 lb, a tenth of the usual pretension. At a first calibration, and of another
 * sensor, a zero may be anything. */
#define JUMP_GAIN_SAME       1.1
#define JUMP_GAIN_TRANSDUCER 1.5
#define JUMP_GAIN_GAGE       5.0
#define JUMP_ZERO_IN         0.25
#define JUMP_ZERO_LB         10.0

struct jump {
    bool gain, zero;           /* it jumped */
    bool turned;               /* the gain has the other sign */
    bool another;              /* sensor: both have serial numbers, which differ */
    double old_gain, gain_now; /* in or lb per code, tables included */
    double ratio, most;        /* of the gains, in size; most to either side */
    double shift, shift_most;  /* of the zero, in or lb; NaN: an earlier one is not known */
};

/* Both are of one input. False when there is nothing to compare (not fitted then or now, or of
 * another kind), or nothing jumped. */
bool jump_find(const struct mr_channel_config *old, const struct mr_channel_config *new,
               struct jump *jump);
/* "gain 0.001611 -> 0.004093 in per code, 2.54 times" and, or, "zero moved by +0.35 in". */
void jump_text(const struct jump *jump, const struct mr_channel_config *channel, char *out,
               size_t size);
/* "d3", "t12", by the input, as matrig calibrate has it: index from 0. */
void jump_channel(unsigned index, char out[8]);
/* The index of such a name that ends at `length`; false: no channel. */
bool jump_channel_read(const char *name, size_t length, unsigned *index);

/* What mistake an impossible gain looks like: values in another unit, or swapped columns. Pure. */
/* "; were the values mm?", "; are the columns swapped?"; empty when no such mistake explains the
 * gain of a channel that measures. */
void mistake_text(const struct mr_channel_config *channel, char *out, size_t size);

#endif
