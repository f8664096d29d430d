/* The channels on the board: converts their readings, supervises them while a landing is recorded,
 * and reports changes and quality. */
#ifndef MATRIG_FIRMWARE_CHANNELS_H
#define MATRIG_FIRMWARE_CHANNELS_H

#include <stdbool.h>
#include <stdint.h>

#include "common/onboard/landing.h"
#include "common/watch.h"
#include "firmware/telemetry.h"

struct channels {
    struct mr_watch watch;
    /* block of the last zero, or 0 for power on; drift counts from this block on */
    uint32_t zero_block[MR_WATCH_CHANNELS];
};

void channels_start(struct channels *channels);
/* Call when a landing is armed: its record and the supervision of the channels begin with block
 * `index`. */
void channels_arm(struct channels *channels, uint32_t index);

/* Call after the zeros of the channels in the bit mask `which` were measured, immediately before
 * block `index`. */
void channels_on_zero_measured(struct channels *channels, uint32_t which, uint32_t index);

/* Returns the reading of channel 0..MR_WATCH_CHANNELS-1 of a block. Call for each block, with
 * channels in ascending order. */
float channels_read(struct channels *channels, const struct mr_block *block, unsigned channel,
                    float ratio);

/* Call after the readings and the landing step of a block. Sends events at once, and the quality of
 * one channel after another. `displacement_in`, `tension_lb`: the newest readings; `baseline_in`:
 * the baselines of movements, NaN: none. */
void channels_report(struct channels *channels, struct telemetry *telemetry,
                     const struct landing *landing, uint32_t index, const float *displacement_in,
                     const float *baseline_in, const float *tension_lb);

/* ---- zero ---- */

/* Measured zeros, and the configured zeros that they replace.
 *
 * A measured zero takes effect at once: it is written to config.channel[].zero_code, which all
 * users of a channel read, and the message channel_zero (with `measured`) sends it to the host and
 * into every record. config.channel[].zero_error becomes ZERO_ERROR_LB or ZERO_ERROR_IN unless the
 * configured error is smaller. A measured zero is lost at a reset: the configured zero is kept
 * here, is used again after a reset, and is the one that a stored configuration contains. */

/* Standard error of a zero measured over 256 blocks: noise, and residual movement of mat or band.
 * Boards with randomly drawn tolerances (tests/electronics) give 0.03 lb and 0.0003 in. The
 * converter's nonlinearity between the zero and a reading is part of linearity_error. */
#define ZERO_ERROR_LB 0.1f
#define ZERO_ERROR_IN 0.0005f

/* Call after each change of the configuration: discards the measured zeros and stores the
 * configured ones. */
void zero_reset(void);
/* Sets the measured zero of `channel`, 0 to MR_CHANNELS - 1. */
void zero_set_measured(unsigned channel, float zero_code);
bool zero_is_measured(unsigned channel);
/* One bit per channel: the zero has been measured since the last call, so earlier readings have a
 * different zero. */
uint32_t zero_get_changed(void);
float zero_get_configured(unsigned channel);
/* Swaps the configured zeros and errors with the measured ones; a second call swaps them back. Used
 * while the configuration is sent. */
void zero_swap(void);

#endif
