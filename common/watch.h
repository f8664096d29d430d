/* Supervision of the channels while a landing is recorded: detects faults that a single block
 * cannot show.
 *
 * Noise: computed from second differences of three successive readings. A movement that is smooth
 * over 2 ms cancels, and white noise of standard deviation s gives 6 s^2 (von Neumann, Ann. Math.
 * Stat. 12, 1941, for first differences). One difference is taken every 8 blocks. The running mean
 * covers MR_WATCH_NOISE_COUNT differences, half a second; a jump is limited to six standard
 * deviations in it.
 *
 * Rate: a reading is not valid (RATE) if its distance from the last good reading exceeds
 * rate_limit_per_s times the time between them. This limit grows with time, so a true step is
 * eventually accepted; a spike never is.
 *
 * Stuck: the anchor of a channel is a reading from which the channel has not moved by more than a
 * band (MR_STUCK_BAND_*, or MR_STUCK_SPREAD_SIGMA standard deviations of its noise). The neighbours
 * of a channel are the next stations up- and downfield; for a gage, on the same tension band. If
 * both neighbours have moved by MR_STUCK_MOVE_* in the meantime, the mat between them must have
 * moved too. In the standard series the neighbours of a healthy channel moved at most 0.010 in (3.5
 * lb) while the channel stayed inside its band. The channel then counts as STUCK, from the anchor
 * until its reading leaves the band. Neighbours that are not valid are skipped. The first and the
 * last station have a neighbour on one side only and are not judged by this rule. A channel that
 * stops after the wheel has passed the upfield neighbour is not judged either: that neighbour has
 * come to rest, and so may the mat between.
 *
 * A channel is also stuck when its codes do not change for MR_STUCK_CONSTANT_BLOCKS blocks in a
 * row, provided that they changed at rest after arming (a real converter always has noise). A
 * channel without noise at rest is not judged by this rule.
 *
 * A change of a channel's validity is reported after MR_WATCH_SETTLE_COUNT equal results in a row
 * (RATE at once), or MR_WATCH_SETTLE_VALID_COUNT for a change to valid. Each channel reports at
 * most one change per MR_WATCH_PAUSE_BLOCKS, so that an intermittent contact does not flood the
 * links.
 *
 * The result is a function of the blocks since mr_watch_begin. No clock, no heap; O(1) per reading;
 * single precision. */
#ifndef MATRIG_COMMON_WATCH_H
#define MATRIG_COMMON_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "common/channels.h"

#define MR_WATCH_CHANNELS           (MR_TRANSDUCERS + MR_GAGES)
#define MR_WATCH_NOISE_COUNT        64u
/* time after arming in which the channels are assumed to be at rest; no channel counts as stuck in
 * this time */
#define MR_WATCH_REST_BLOCKS        512u
#define MR_WATCH_SETTLE_COUNT       10u
#define MR_WATCH_SETTLE_VALID_COUNT 100u
#define MR_WATCH_PAUSE_BLOCKS       500u
#define MR_STUCK_SPREAD_MAX_IN      0.008f
#define MR_STUCK_MOVE_MIN_IN        0.05f
#define MR_STUCK_SPREAD_MAX_LB      1.0f
#define MR_STUCK_MOVE_MIN_LB        8.0f
#define MR_STUCK_SPREAD_SIGMA       6.0f
#define MR_STUCK_CONSTANT_BLOCKS    200u
/* smallest noise of a block's mean at rest; smaller noise may be hidden by quantisation at times */
#define MR_STUCK_NOISE_MIN_CODES    0.2f
#define MR_WATCH_NO_CHANNEL         255u

struct mr_watch_channel {
    float last_reading,
        earlier_reading; /* readings used for the noise, at most 8 blocks old; NaN: none */
    float code;          /* newest code, valid or not */
    float variance;      /* variance of one reading's noise */
    /* noise of the channel at rest, MR_WATCH_REST_BLOCKS after the beginning; NaN: not known yet */
    float rest_noise;
    float good_reading; /* newest reading within the rate limit; NaN: none */
    uint32_t good_block;
    float anchor_reading, anchor_upfield, anchor_downfield;
    uint32_t anchor_block;
    uint32_t reported_block; /* block of the last reported change */
    uint32_t since_block;    /* block at which `repeat_count` began */
    uint16_t invalid_count;  /* number of readings that were not valid; saturates at 65535 */
    /* number of second differences in the mean; saturates at MR_WATCH_NOISE_COUNT */
    uint16_t noise_count;
    uint16_t constant_count;    /* number of consecutive readings with the same code */
    uint8_t upfield, downfield; /* next channels on either side; MR_WATCH_NO_CHANNEL: none */
    /* nearest valid neighbours when the anchor was set; MR_WATCH_NO_CHANNEL: none */
    uint8_t anchor_up_channel, anchor_down_channel;
    /* reported validity; validity of the newest reading; equal readings in a row */
    uint8_t reported_validity, new_validity, repeat_count;
    bool is_stuck, has_reported;
};

struct mr_watch {
    /* true from mr_watch_begin to mr_watch_end; between landings only the wiring is checked */
    bool is_recording;
    uint32_t begin_block;
    uint32_t changed_channels; /* bit c: channel c has a change to report */
    struct mr_watch_channel channel[MR_WATCH_CHANNELS];
};

struct mr_watch_change {
    uint8_t validity;
    uint32_t block; /* block at which the validity changed */
};

/* Begins the record of a landing with block `index`: resets the state and finds the neighbours.
 * `config`: MR_CHANNELS channels. */
void mr_watch_begin(struct mr_watch *watch, const struct mr_channel_config *config, uint32_t index);
void mr_watch_end(struct mr_watch *watch);

/* Checks the reading of channel `c`, 0..MR_WATCH_CHANNELS-1, in block `index`; on a fault, sets its
 * validity to RATE or STUCK and its value to NaN. Call for the channels of a block in rising
 * order. */
void mr_watch_check(struct mr_watch *watch, const struct mr_channel_config *config, unsigned c,
                    uint32_t index, struct mr_reading *reading);
/* Gets a change of channel c that has not been reported, and clears its bit in `changed_channels`.
 * Returns false if there is none. */
bool mr_watch_get_change(struct mr_watch *watch, unsigned c, uint32_t index,
                         struct mr_watch_change *change);

/* Standard deviation of one reading, in or lb; NaN before there have been three readings in a
 * row. */
float mr_watch_noise(const struct mr_watch *watch, unsigned c);

#endif
