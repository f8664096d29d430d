/* Watch over the channels while a landing is recorded: faults that one block alone cannot show.
 *
 * Noise. Second differences of three readings in a row: a movement that is smooth over 2 ms drops
 * out, white noise of standard deviation s gives 6 s^2 (von Neumann, Ann. Math. Stat. 12, 1941, for
 * first differences). One each 8 blocks; a running mean over MR_WATCH_NOISE_COUNT of them, half a
 * second, in which a jump counts as six standard deviations at most.
 *
 * Rate. A reading that lies further from the last good one than rate_limit_per_s allows in the time
 * between them is not valid (RATE). The allowance grows with time, so a true step is believed at
 * last; a spike never is.
 *
 * Stuck. The anchor of a channel is the reading that it has not left by more than a band
 * (MR_STUCK_BAND_*, or MR_STUCK_NOISES standard deviations of its noise). When both its neighbours
 * - the next stations up- and downfield, of a gage on the same band - have moved on by
 * MR_STUCK_MOVE_* meanwhile, a mat between them cannot have stood still: the joints of a closing
 * mat follow from upfield, those of an opening one from downfield. In the standard series a healthy
 * channel's neighbours moved at most 0.010 in (3.5 lb) while it stayed inside its band. The channel
 * is STUCK from the anchor on, until it leaves the band. A neighbour that is not valid is passed
 * over for the next. The first and the last station have neighbours on one side only and are not
 * judged so. Nor is a channel that stops when the wheel is past the neighbour upfield already: that
 * has come to rest, and so may the mat between have. Also stuck is a channel whose codes no longer
 * change at all, MR_STUCK_CONSTANT_BLOCKS in a row, although they did at rest after arming (a real
 * converter's noise does not end). A channel without noise is healthy when it is quiet.
 *
 * Changes of a channel's validity are reported when MR_WATCH_SETTLE readings in a row agree (a RATE
 * at once), MR_WATCH_SETTLE_VALID when it is to be valid again, and at most every
 * MR_WATCH_PAUSE_BLOCKS per channel: no flood, however a contact flutters.
 *
 * No clock, no heap; O(1) per reading, single precision: a function of the blocks since
 * mr_watch_begin. */
#ifndef MATRIG_COMMON_WATCH_H
#define MATRIG_COMMON_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "common/channels.h"

#define MR_WATCHED               (MR_TRANSDUCERS + MR_GAGES)
#define MR_WATCH_NOISE_COUNT     64u
/* a landing is armed before the gear comes: so long it is at rest, and nothing is stuck */
#define MR_WATCH_REST_BLOCKS     512u
#define MR_WATCH_SETTLE          10u
#define MR_WATCH_SETTLE_VALID    100u
#define MR_WATCH_PAUSE_BLOCKS    500u
#define MR_STUCK_BAND_IN         0.008f
#define MR_STUCK_MOVE_IN         0.05f
#define MR_STUCK_BAND_LB         1.0f
#define MR_STUCK_MOVE_LB         8.0f
#define MR_STUCK_NOISES          6.0f
#define MR_STUCK_CONSTANT_BLOCKS 200u
/* of a block's mean at rest; less may be quantisation that comes and goes */
#define MR_STUCK_NOISE_CODES     0.2f
#define MR_WATCH_NOBODY          255u

struct mr_watch_channel {
    float last, before_last; /* readings of its turn, at most 8 blocks old; NaN: none */
    float code;              /* newest, whatever its validity */
    float variance;          /* of one reading */
    float rest_noise;        /* MR_WATCH_REST_BLOCKS after the begin; NaN: not yet */
    float good;              /* newest reading that was not too fast; NaN: none */
    uint32_t good_block;
    float anchor, anchor_up, anchor_down;
    uint32_t anchor_block;
    uint32_t told_block;  /* of the last reported change */
    uint32_t since_block; /* the run below began */
    uint16_t invalid;     /* readings that were not valid; stays at 65535 */
    uint16_t noise_count; /* second differences in the mean; stays at MR_WATCH_NOISE_COUNT */
    uint16_t constant;    /* readings in a row without any change */
    uint8_t up, down;     /* neighbours; MR_WATCH_NOBODY: none */
    /* the nearest that were valid when the anchor was dropped; likewise */
    uint8_t anchor_up_is, anchor_down_is;
    uint8_t told, seen, run; /* reported; of the newest reading; readings in a row like it */
    bool stuck, ever_told;
};

struct mr_watch {
    /* from mr_watch_begin to mr_watch_end: between landings only the wiring is looked at */
    bool recording;
    uint32_t begin_block;
    uint32_t changed; /* bit c: channel c has a change to report */
    struct mr_watch_channel channel[MR_WATCHED];
};

struct mr_watch_news {
    uint8_t validity;
    uint32_t block; /* since when */
};

/* A landing's record begins with block `index`: forgets everything, finds the neighbours. `config`:
 * MR_CHANNELS of them. */
void mr_watch_begin(struct mr_watch *watch, const struct mr_channel_config *config, uint32_t index);
void mr_watch_end(struct mr_watch *watch);

/* The next reading of channel `c`, 0..MR_WATCHED-1, of block `index`; sets RATE or STUCK in it,
 * with value NaN. Channels of a block in rising order. */
void mr_watch_reading(struct mr_watch *watch, const struct mr_channel_config *config, unsigned c,
                      uint32_t index, struct mr_reading *reading);
/* Take a change to be reported; false: none. Clears its bit. */
bool mr_watch_take(struct mr_watch *watch, unsigned c, uint32_t index, struct mr_watch_news *news);

/* Standard deviation of one reading, in or lb; NaN before three readings in a row. */
float mr_watch_noise(const struct mr_watch *watch, unsigned c);

#endif
