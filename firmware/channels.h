/* The channels on the board: reads them, watches them while a landing is recorded, reports changes
 * and quality. */
#ifndef MATRIG_FIRMWARE_CHANNELS_H
#define MATRIG_FIRMWARE_CHANNELS_H

#include <stdbool.h>
#include <stdint.h>

#include "common/onboard/landing.h"
#include "common/watch.h"
#include "firmware/telemetry.h"

struct channels {
    struct mr_watch watch;
    uint32_t zero_block[MR_WATCHED]; /* hours of drift count from here: power on, or a later zero */
};

void channels_start(struct channels *channels);
/* A landing is armed: its record begins with block `index`, and with it all that is known of the
 * channels. */
void channels_arm(struct channels *channels, uint32_t index);

/* The zeros of these channels, a bit each, were measured just before block `index`. */
void channels_zeroed(struct channels *channels, uint32_t which, uint32_t index);

/* Reading of channel 0..MR_WATCHED-1 of a block; call for each block, channels rising. */
float channels_read(struct channels *channels, const struct mr_block *block, unsigned channel,
                    float ratio);

/* After a block's readings and its landing's step: events, and quality in turn. `moved_in`,
 * `tension_lb`: the newest readings (movement since `baseline_in`, NaN: none). */
void channels_tell(struct channels *channels, struct telemetry *telemetry,
                   const struct landing *landing, uint32_t index, const float *displacement_in,
                   const float *baseline_in, const float *tension_lb);

/* ---- zero ---- */

/* Measured zeros, and the configured ones that they replace.
 *
 * A measured zero is in force at once: it is config.channel[].zero_code, so that every reader of a
 * channel uses it, and the message channel_zero, with `measured`, sends it to the host and into
 * every record. Its standard error is in force with it: config.channel[].zero_error becomes
 * ZERO_ERROR_LB or ZERO_ERROR_IN, unless the configured one is less already. It is volatile: the
 * configured one is kept here, comes back with reset, and is what a stored configuration must
 * hold. */

/* What a zero measured over 256 blocks leaves: noise, and the mat or band that was not quite at
 * rest. Drawn boards (tests/electronics) leave 0.03 lb and 0.0003 in of it; what the converter's
 * curve does between the zero and a reading is linearity_error. */
#define ZERO_ERROR_LB 0.1f
#define ZERO_ERROR_IN 0.0005f

/* Nothing is measured: what the configuration holds is configured. After each change of the
 * configuration. */
void zero_start(void);
/* `channel` 0 to MR_CHANNELS - 1. */
void zero_measure(unsigned channel, float zero_code);
bool zero_is_measured(unsigned channel);
/* Bit per channel: measured since the last call. Its readings of before are of another zero. */
uint32_t zero_take_changed(void);
float zero_configured(unsigned channel);
/* Swap the configured zeros and their errors in, and at the second call out again; used when the
 * configuration is sent. */
void zero_exchange(void);

#endif
